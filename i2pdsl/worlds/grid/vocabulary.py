"""The words of a grid world."""

from __future__ import annotations

from dataclasses import fields

from i2pdsl.language.vocabulary import ASKED, Predicate, Setting, Vocabulary, Weights
from i2pdsl.worlds.grid.hypotheses import apart, factor_sizes, factors, grid_hypotheses
from i2pdsl.worlds.grid.parse import SETTING_RANGES, SETTING_WORDS
from i2pdsl.worlds.grid.spec import ACTIONS, ALL_ACTIONS, MOST_SEEN, GridSpec
from i2pdsl.worlds.hypotheses import latents_of, rationality_of, readings_of

PREDICATES = (
    Predicate("at", ("thing", "place"), "it stands on the tile or cell"),
    Predicate("absent", ("object",), "the object is not in the world"),
    Predicate("adjacent", ("thing", "thing"), "the two stand on neighbouring cells"),
    Predicate("pushes", ("character", "thing"), "the action of the first moved the second", True),
    Predicate("moved", ("character",), "the character's own action changed its cell", True),
    Predicate(
        "tried", ("character",), "the character chose to move, whether it could or not", True
    ),
    Predicate("fell", ("object",), "an event brought the object in this frame", True),
    Predicate("touching", ("thing", "thing"), "as `adjacent`, for patterns of all worlds"),
    Predicate("idle", ("character",), "the character did not choose to move", True),
    Predicate(
        "faces",
        ("character", "spot"),
        "the character chose to move, and in the direction of the place or of whom it stands for",
        True,
    ),
    Predicate("sees", ("thing", "spot"), "no wall is between the two"),
    Predicate(
        "distance",
        ("thing", "spot"),
        "the fewest steps from one to the other; as many as there are cells where no way leads",
        is_number=True,
    ),
)
_BY_PAIRS = ("sees", "distance")
OF_CARRYING = (
    Predicate("holds", ("character", "object"), "the character carries the object"),
    Predicate("takes", ("character", "object"), "the action of the first took the second", True),
    Predicate("opens", ("character", "object"), "the action of the first opened the second", True),
)
OF_PUTTING = (
    Predicate("puts", ("character", "object"), "the action of the first put the second down", True),
    Predicate(
        "gives",
        ("character", "object"),
        "the action of the first handed the second over to another, who holds it then",
        True,
    ),
)
_DOCUMENTATION = {
    "goal": "reward for acting on one's own goal tile",
    "move": "reward of a move",
    "stay": "reward of staying",
    "end": "reward for standing on one's own goal tile when the last frame of the horizon is over",
    "horizon": "how many frames there are, for which characters plan; 0: without end",
    "method": "how planning goes: exactly; or additively, where values are sums of those in worlds "
    "with fewer entities; or exactly where that fits in memory and time, else additively",
    "at_once": "how many characters and objects additive planning plans for together",
    "states": "whether additive planning lists all states, or computes those that it meets; or "
    "lists them where they are at most a million",
    "gamma": "discount factor",
    "beta": "inverse temperature: how sharply the characters prefer their best actions",
    "level0": "how the character who is modelled believes that the other acts",
    "forgetting": "share of the belief that is reassigned after each action",
    "switching": "the chance, after each action, that who acted draws its goal anew, for all that "
    "viewers know",
}


def grid_vocabulary(spec: GridSpec) -> Vocabulary:
    """The vocabulary of a grid world, from its .world file alone."""
    characters = tuple(c.name for c in spec.characters)
    used = {action for c in spec.characters for action in c.actions}
    actions = tuple(action for action in ALL_ACTIONS if action in used) or ACTIONS
    of_things = [*(OF_CARRYING if any(c.carries for c in spec.characters) else ())]
    of_things += OF_PUTTING if any(c.puts_down for c in spec.characters) else ()
    columns = len(spec.rows[0]) if spec.rows else 0
    held = factors(spec) if spec.is_sampled else ()
    return Vocabulary(
        world=spec.name,
        latents=latents_of(spec.characters),
        hypotheses=grid_hypotheses(spec),
        characters=characters,
        rational={name: rationality_of(name) for name in characters},
        actions=actions,
        can_fail=frozenset(c.name for c in spec.characters if c.is_weak),
        things=tuple(name for t in spec.things for name in t.names),
        may_be_absent=frozenset(t.name for t in spec.things if t.may_be_absent or t.opened_by),
        places={t.name: t.cells for t in spec.tiles},
        columns=columns,
        rows=len(spec.rows),
        events=dict(spec.events),
        predicates={
            p.name: p
            for p in (*PREDICATES, *of_things)
            if p.name not in _BY_PAIRS or len(spec.free_cells) <= MOST_SEEN
        },
        settings={
            f.name: _setting(f.name, getattr(spec.settings, f.name), spec)
            for f in fields(spec.settings)
            if f.name != ASKED or spec.is_sampled
        },
        observer_settings=("beta", "forgetting", "level0", "switching"),
        free=frozenset(spec.free_cells),
        automatic=_automatic(spec),
        usual_length=min(15, spec.settings.horizon or 15),
        longest=spec.settings.horizon or None,
        limited_to={c.name: c.actions for c in spec.characters if c.actions != actions},
        documentation=spec.documentation,
        readings=readings_of(spec.characters),
        shares={name: dict(weights) for name, weights in spec.shares},
        counts=apart(spec)[1] if spec.is_sampled else (),
        kept=apart(spec)[2] if spec.is_sampled else frozenset(),
        factors=held,
        factor_sizes=factor_sizes(spec) if held else None,
    )


def _automatic(spec: GridSpec) -> frozenset[str]:
    """The automatic terms: where nobody is weak, there is no luck."""
    of_luck = {"plausibility", "luck"}
    weak = any(c.is_weak for c in spec.characters)
    return frozenset(Weights._fields) - (set() if weak else of_luck)


def _setting(name: str, default: float | str, spec: GridSpec) -> Setting:
    if name == ASKED:
        about = "which latents viewers keep apart; those that a story names are added"
        return Setting(name, default, about, names=frozenset(latents_of(spec.characters)))
    if name == "hypotheses" and spec.is_sampled:
        return Setting(name, default, "each distinct hypothesis once", ("merged",))
    if name == "hypotheses":
        counts = [len(grid_hypotheses(spec.with_settings({name: x}))) for x in SETTING_WORDS[name]]
        about = f"merged: each distinct hypothesis once ({counts[0]}); "
        about += f"literal: the paper's tuple ({counts[1]})"
        return Setting(name, default, about, SETTING_WORDS[name], reshapes=True)
    if name in SETTING_WORDS:
        return Setting(name, default, _DOCUMENTATION[name], SETTING_WORDS[name])
    accepts, range_ = SETTING_RANGES[name]
    about = _DOCUMENTATION[name]
    return Setting(name, default, about, (), range_, accepts, reshapes=name == "horizon")
