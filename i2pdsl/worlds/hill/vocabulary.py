"""The words of a hill."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields

from i2pdsl.language.vocabulary import Latent, Predicate, Setting, Vocabulary, Weights
from i2pdsl.worlds.hill.spec import EAGER, LAZY, HillSpec

WEIGHT, WILL = "weight", "will"
HOPPER, BOX = "hopper", "box"
PREDICATES = (
    Predicate("fallen", ("character",), "its head is below 5 units above the slope", True),
    Predicate("taut", ("character",), "its rope is stretched: longer than it is at rest", True),
    Predicate("climbed", ("thing",), "units up the slope from where it began", True, True),
    Predicate("progress", ("thing",), "units that it went up the slope in that frame", True, True),
    Predicate("effort", ("character",), "the mean square of its muscles' actuation", True, True),
)

_Number = tuple[Callable[[float], bool], str]
# A node of the box below a mass of 1 is too light for explicit steps of this size.
_LIGHTEST, _HEAVIEST = 0.1, 2.0


def _between(low: float, high: float) -> _Number:
    return lambda x: low <= x <= high, f"between {low:g} and {high:g}"


_RANGES: dict[str, _Number] = {
    "weight": _between(_LIGHTEST, _HEAVIEST),
    "slope": _between(-0.3, 0.6),
    "gravity": _between(0.0, 10.0),
    "friction": _between(0.0, 10.0),
    "box_friction": _between(0.0, 10.0),
    "node_mass": _between(10.0, 100.0),
    "foot_mass": _between(10.0, 1000.0),
    "lazy": _between(0.0, 1.0),
    "controller": (lambda x: x == int(x) and 0 <= x < 2**31, "a training seed, a whole number"),
    "sigma": _between(0.01, 1000.0),
    "forgetting": _between(0.0, 0.5),
}
_WORDS = {"evidence": ("motion", "mass"), "will": (EAGER, LAZY)}
# Chosen by looking at the films (docs/hill.md): a hopper never stands still, and viewers who
# imagine other controllers find what is natural to one of them no better than what is not.
WEIGHTS = Weights(naturalness=0.0, liveliness=0.0)
_DOCUMENTATION = {
    "weight": "the weight of the box, as it is",
    "weights": "what viewers think it could be, as in {0.1, 0.3, 0.5}",
    "will": "eager or lazy, of the hopper as it is; viewers wonder about it if `lazy` is below 1",
    "lazy": "the share of its controller's actuation that a lazy hopper uses; 1: nobody is lazy",
    "slope": "angle of the slope, in radians",
    "gravity": "acceleration of falling bodies",
    "friction": "Coulomb's coefficient of the hopper on the slope",
    "box_friction": "Coulomb's coefficient of the box on the slope",
    "node_mass": "mass of a node of the hopper; a node of the box has this times the weight",
    "foot_mass": "mass of each foot",
    "controller": "the training seed of the networks that act (and that viewers imagine)",
    "sigma": "how exactly viewers compare what they see with what they imagine",
    "forgetting": "share of the belief that is reassigned after each frame",
    "evidence": "motion: viewers imagine how the hopper would pull each weight; mass: they know "
    "what its muscles do and compare only how the box follows",
}


def _weights(values: tuple[float, ...]) -> bool:
    inside = all(_LIGHTEST <= v <= _HEAVIEST for v in values)
    return 2 <= len(values) <= 16 and len(set(values)) == len(values) and inside


def hill_vocabulary(spec: HillSpec) -> Vocabulary:
    """The vocabulary of a hill, without arrays."""
    latents = {WEIGHT: Latent(WEIGHT, "number", spec.settings.weights, "the weight of the box")}
    if len(spec.wills) > 1:
        latents[WILL] = Latent(WILL, "symbol", spec.wills, "whether the hopper does its best")
    return Vocabulary(
        world=spec.name,
        latents=latents,
        hypotheses=tuple(
            {name: v for name, v in ((WEIGHT, weight), (WILL, will)) if name in latents}
            for weight, will in spec.hypotheses
        ),
        characters=(HOPPER,),
        rational={},
        actions=(),
        can_fail=frozenset(),
        things=(BOX,),
        may_be_absent=frozenset(),
        places={},
        columns=0,
        rows=0,
        events={},
        predicates={p.name: p for p in PREDICATES},
        settings={
            f.name: _setting(f.name, getattr(spec.settings, f.name)) for f in fields(spec.settings)
        },
        observer_settings=("controller", "evidence", "forgetting", "sigma"),
        automatic=frozenset({"naturalness", "liveliness"}),
        weights=WEIGHTS,
        enumerable=False,
        holds_particles=False,
        usual_length=400,
        preposition="on the",
        documentation=spec.documentation,
    )


def _setting(name: str, default: float | str | tuple[float, ...]) -> Setting:
    about = _DOCUMENTATION[name]
    if name in _WORDS:
        return Setting(name, default, about, _WORDS[name])
    if name == "weights":
        range_ = f"2 to 16 different numbers between {_LIGHTEST:g} and {_HEAVIEST:g}"
        return Setting(name, default, about, (), range_, accepts_all=_weights, reshapes=True)
    accepts, range_ = _RANGES[name]
    return Setting(name, default, about, (), range_, accepts, reshapes=name == "lazy")
