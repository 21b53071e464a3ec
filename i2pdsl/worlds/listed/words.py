"""Worlds whose states and actions are listed, as data: their numbers and their words."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from itertools import product
from typing import Any, ClassVar, Self

from i2pdsl.language.vocabulary import Latent, Predicate, Setting, Value, Vocabulary, Weights

Cell = tuple[int, int]  # (column, row)

OF_CELLS = (
    Predicate("at", ("thing", "place"), "it stands on the place or cell"),
    Predicate("moved", ("character",), "the character's own action changed its cell", True),
    Predicate("idle", ("character",), "the character did not choose to move", True),
    Predicate("touching", ("thing", "thing"), "the two stand on neighbouring cells"),
)
"""What can be asked of every listed world (world.py)."""

RANGES: dict[str, tuple[Callable[[float], bool], str]] = {
    "beta": (lambda x: 0 <= x <= 1e3, "between 0 and 1000"),
    "forgetting": (lambda x: 0 <= x <= 0.5, "between 0 and 0.5"),
    "switching": (lambda x: 0 <= x <= 1, "between 0 and 1"),
}
_DOCUMENTATION = {
    "beta": "inverse temperature: how sharply the characters prefer what they like best",
    "forgetting": "share of the belief that is reassigned after each action",
    "switching": "the chance, after each action, that who acted draws its goal anew, for all that "
    "viewers know",
}


@dataclass(frozen=True)
class ListedSettings:
    """The numbers of a listed world that a story may replace: `world hall(beta = 1)`."""

    beta: float = 2.0
    forgetting: float = 0.0
    switching: float = 0.0


@dataclass(frozen=True)
class ListedSpec:
    """A listed world as data (worlds/kind.py:Spec); `kind` is its name in worlds/kinds.py, and
    `shares` what viewers think of latents at first: pairs of a value and its weight."""

    kind: ClassVar[str]
    name: str
    source: str = ""
    documentation: str = ""
    settings: ListedSettings = field(default_factory=ListedSettings)
    shares: tuple[tuple[str, tuple[tuple[Any, float], ...]], ...] = ()

    def with_settings(self, changes: dict[str, Any]) -> Self:
        """The same world with some of its numbers replaced."""
        return replace(self, settings=replace(self.settings, **changes))


def listed_vocabulary(
    spec: ListedSpec,
    latents: Iterable[Latent],
    actions: Mapping[str, Sequence[str]],
    places: Mapping[str, Sequence[Cell]],
    cells: Iterable[Cell],
    things: Sequence[str] = (),
    predicates: Iterable[Predicate] = (),
    hypotheses: Iterable[dict[str, Value]] | None = None,
    rational: Mapping[str, str] | None = None,
) -> Vocabulary:
    """The vocabulary of a listed world.

    Args:
        actions: those of each character, in the order of acting.
        places: the cells of each place.
        cells: where somebody can stand.
        predicates: those of its own (ListedWorld.feature), besides what is true of all cells.
        hypotheses: all that viewers think possible; without it every combination of values.
        rational: for each character the latent that says whether it is rational, if one does.
    """
    known, free = {latent.name: latent for latent in latents}, frozenset(cells)
    every = tuple(dict.fromkeys(action for own in actions.values() for action in own))
    if hypotheses is None:
        values = product(*(latent.values for latent in known.values()))
        hypotheses = (dict(zip(known, each, strict=True)) for each in values)
    several = len(actions) + len(things) > 1
    of_cells = [p for p in OF_CELLS if several or p.name != "touching"]
    lacking = {"plausibility", "luck"} | (set() if rational else {"rationality"})
    return Vocabulary(
        world=spec.name,
        latents=known,
        hypotheses=tuple(hypotheses),
        characters=tuple(actions),
        rational=dict(rational or {}),
        actions=every,
        can_fail=frozenset(),
        things=tuple(things),
        may_be_absent=frozenset(),
        places={name: tuple(of) for name, of in places.items()},
        columns=1 + max(column for column, _ in free),
        rows=1 + max(row for _, row in free),
        events={},
        predicates={p.name: p for p in (*of_cells, *predicates)},
        settings={
            f.name: _setting(f.name, getattr(spec.settings, f.name)) for f in fields(spec.settings)
        },
        observer_settings=tuple(RANGES),
        free=free,
        automatic=frozenset(Weights._fields) - lacking,
        holds_particles=False,
        limited_to={who: tuple(own) for who, own in actions.items() if tuple(own) != every},
        documentation=spec.documentation,
        shares={name: dict(weights) for name, weights in spec.shares},
    )


def _setting(name: str, default: float) -> Setting:
    accepts, range_ = RANGES[name]
    return Setting(name, default, _DOCUMENTATION[name], (), range_, accepts)
