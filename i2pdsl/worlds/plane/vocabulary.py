"""The words of a plane."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields

from i2pdsl.language.vocabulary import Predicate, Setting, Vocabulary, Weights
from i2pdsl.worlds.hypotheses import latents_of, rationality_of
from i2pdsl.worlds.plane.hypotheses import plane_hypotheses
from i2pdsl.worlds.plane.spec import PlaneSpec

MISSED = "missed"  # by how many units `at` misses
ALONE = (
    Predicate(
        "at",
        ("character", "place"),
        "its middle is within the place, or within a quarter of its radius of the point",
        takes_points=True,
        missed_by=MISSED,
    ),
    Predicate("moved", ("character",), "it was seen to move in that frame", True),
    Predicate("idle", ("character",), "it was not seen to move in that frame", True),
    Predicate(
        "faces",
        ("character", "spot"),
        "it was seen to move, within 45 degrees of the way straight to the place or to the other",
        True,
        takes_points=True,
    ),
    Predicate(
        "sees",
        ("character", "spot"),
        "no wall is between the middles of the two",
        takes_points=True,
    ),
    Predicate(
        "distance",
        ("character", "spot"),
        "units from middle to middle, or to the point",
        is_number=True,
        takes_points=True,
    ),
    Predicate("speed", ("character",), "units that it moved in that frame", True, True),
    Predicate(
        "effort",
        ("character",),
        "the square of its speed, 1 for the speed that it likes, also where it is stopped",
        True,
        True,
    ),
    Predicate(
        "heads",
        ("character", "spot"),
        "how fast it tries to go straight there, 1 at the speed that it likes, also where it is "
        "stopped; below 0 away from it",
        True,
        True,
        takes_points=True,
    ),
    Predicate(
        "acceleration",
        ("character",),
        "the square of the change of its velocity since the frame before, in the same units",
        True,
        True,
    ),
    Predicate(
        "progress",
        ("character", "place"),
        "units by which its way to the place became shorter in that frame",
        True,
        True,
    ),
)
TOGETHER = (Predicate("touching", ("character", "character"), "the two touch each other"),)
WORDS = {"observer": ("step", "path")}
RANGES: dict[str, tuple[Callable[[float], bool], str]] = {
    "beta": (lambda x: 0 < x <= 1e3, "above 0 and at most 1000"),
    "safe": (lambda x: 0 < x <= 1e4, "above 0 and at most 10000"),
    "forgetting": (lambda x: 0 <= x <= 0.5, "between 0 and 0.5"),
    "switching": (lambda x: 0 <= x <= 1, "between 0 and 1"),
}
# Where two push each other gradients grow with every frame (docs/plane.md, "Searching").
SEARCH = (
    *(("damping", 0.95), ("lookahead", 20), ("noise", 0.3), ("rate", 0.004), ("steps", 150)),
    ("window", 60),
)
# Chosen by looking at the films (docs/plane.md): regret parts who push each other, and somebody
# alone has nothing to do but to arrive, and would tremble there.
TWO = Weights(naturalness=0.0, liveliness=0.5)
ONE = Weights(naturalness=0.0, liveliness=0.0)
_DOCUMENTATION = {
    "beta": "inverse temperature: how sharply characters prefer what costs least, per unit of way",
    "safe": "the distance at which who avoids the other is content",
    "observer": "step: viewers weigh each move against all others; path: the way so far and the "
    "way that is left against the shortest one (Dragan, Lee and Srinivasa 2013)",
    "forgetting": "share of the belief that is reassigned after each move",
    "switching": "the chance, after each move, that who moved draws its goal anew, for all that "
    "viewers know",
}


def plane_vocabulary(spec: PlaneSpec) -> Vocabulary:
    """The vocabulary of a plane, from its .world file alone."""
    predicates = ALONE + (TOGETHER if len(spec.characters) == 2 else ())
    return Vocabulary(
        world=spec.name,
        latents=latents_of(spec.characters),
        hypotheses=plane_hypotheses(spec),
        characters=tuple(c.name for c in spec.characters),
        rational={c.name: rationality_of(c.name) for c in spec.characters},
        actions=(),
        can_fail=frozenset(),
        things=(),
        may_be_absent=frozenset(),
        places={place.name: ((number, 0),) for number, place in enumerate(spec.places)},
        columns=0,
        rows=0,
        size=(spec.width, spec.height),
        events={},
        predicates={p.name: p for p in predicates},
        settings={
            f.name: _setting(f.name, getattr(spec.settings, f.name)) for f in fields(spec.settings)
        },
        observer_settings=("beta", "forgetting", "observer", "switching"),
        automatic=frozenset({"rationality", "naturalness", "liveliness"}),
        weights=TWO if len(spec.characters) == 2 else ONE,
        enumerable=False,
        holds_particles=False,
        search_settings=SEARCH,
        documentation=spec.documentation,
        shares={name: dict(weights) for name, weights in spec.shares},
    )


def _setting(name: str, default: float | str) -> Setting:
    about = _DOCUMENTATION[name]
    if name in WORDS:
        return Setting(name, default, about, WORDS[name])
    accepts, range_ = RANGES[name]
    return Setting(name, default, about, (), range_, accepts)
