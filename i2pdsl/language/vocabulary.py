"""What a world tells the language: its names, without arrays, planning or JAX."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

from i2pdsl.language.priors import Shares, fitted

ASKED = "asked"  # the setting of which latents are kept apart, where not all can be
UNKNOWN = "unknown"  # what stands for a latent's value where it plays no part; no name is this
Value = float | str | bool
SettingValue = float | str | tuple[float, ...]
Settings = tuple[tuple[str, SettingValue], ...]
"""Settings with their values, sorted by name."""


STAY = "stay"  # an action that moves nobody, and never fails


@dataclass(frozen=True)
class Latent:
    """Something hidden that viewers infer. `kind` is number, symbol or truth. A `forced` value is
    had only where no other is possible, so that nobody wonders how probable it is."""

    name: str
    kind: str
    values: tuple[Value, ...]
    documentation: str = ""
    forced: tuple[Value, ...] = ()

    @property
    def domain(self) -> str:
        """The values in words, for messages."""
        return ", ".join(show_value(v) for v in self.values)


@dataclass(frozen=True)
class Predicate:
    """Something that can be asked of a frame: `[name(arguments) @ script[k]]`.

    Each parameter is `character`, `thing` (an object or a character), `place` (a tile or a
    cell) or `spot` (any of these). `needs_action` tells predicates of frames from predicates of
    states; `is_number` tells quantities (progress, effort) from predicates.

    Attributes:
        takes_points: whether a place may be any point (x, y) of a world that has a `size`.
        missed_by: what the world calls the quantity by which it misses, of the same arguments: 0
            where it holds. Without it there is nothing but that it does not hold.
    """

    name: str
    parameters: tuple[str, ...]
    documentation: str
    needs_action: bool = False
    is_number: bool = False
    takes_points: bool = False
    missed_by: str = ""


@dataclass(frozen=True)
class Setting:
    """A number, a word or a set of numbers of the world that a story may replace.

    `choices` for words, `names` for a text of several; for numbers `accepts`, for a set
    `accepts_all` says which are valid, and `valid_range` says it in words. One that `reshapes`
    changes the hypotheses, or other words.
    """

    name: str
    default: SettingValue
    documentation: str
    choices: tuple[str, ...] = ()
    valid_range: str = ""
    accepts: Callable[[float], bool] = field(default=lambda _: False, compare=False)
    accepts_all: Callable[[tuple[float, ...]], bool] | None = field(default=None, compare=False)
    reshapes: bool = False
    names: frozenset[str] = frozenset()

    @property
    def possible(self) -> str:
        """What it can be, in words."""
        if self.names:
            return f"names in quotes, of {', '.join(sorted(self.names))}"
        return ", ".join(self.choices) or self.valid_range or "a number"

    def holds(self, value: object) -> bool:
        """Whether plain data (of a script file) is a valid value."""
        if self.names:
            return isinstance(value, str) and self.names >= set(re.findall(r"\w+", value))
        if self.choices:
            return value in self.choices
        if self.accepts_all is not None:
            if not isinstance(value, list | tuple):
                return False
            numbers = [_number(item) for item in value]
            known = tuple(n for n in numbers if n is not None)
            return len(known) == len(value) and self.accepts_all(known)
        number = _number(value)
        return number is not None and self.accepts(number)


def _number(value: object) -> float | None:
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < 1e300:
        return None
    return float(value)


def whole(name: str, default: float, about: str, low: int, high: int) -> Setting:
    """A setting that is a whole number within bounds."""
    accepts = lambda x: x == int(x) and low <= x <= high
    return Setting(name, default, about, (), f"a whole number from {low:,} to {high:,}", accepts)


def between(name: str, default: float, about: str, low: float, high: float) -> Setting:
    """A setting that is a number within bounds."""
    accepts = lambda x: low <= x <= high
    return Setting(name, default, about, (), f"between {low:g} and {high:g}", accepts)


class Weights(NamedTuple):
    """How much the automatic terms of an objective count (objective/terms.py, film.py); as they
    are on maps unless a story sets them. The first two are the paper's; the others were chosen by
    looking at the films (docs/stories.md)."""

    rationality: float = 1.0
    plausibility: float = 1.0
    naturalness: float = 0.2
    luck: float = 0.5
    liveliness: float = 0.2

    @property
    def sees_frames(self) -> bool:
        """Whether any term counts that looks at frames, not only at beliefs."""
        return any(self[1:])


ON_MAPS = Weights()


class FactorSizes(NamedTuple):
    """How large the factors of a belief are (audience/factors.py).

    Attributes:
        common: how many ways those whom others model may be.
        minds: how many each other character may be.
        classes: how many of these expressions tell apart.
    """

    common: int
    minds: tuple[int, ...]
    classes: tuple[int, ...]

    @property
    def probabilities(self) -> int:
        """How many are held."""
        return self.common * (1 + sum(self.minds))

    def points(self, told: Collection[int | None] = ()) -> int:
        """How many a question looks at that tells all minds of some factors apart."""
        both = enumerate(zip(self.minds, self.classes, strict=True))
        return self.common * math.prod(m if i in told else c for i, (m, c) in both)


@dataclass(frozen=True)
class Vocabulary:
    """Everything the checker needs to know of a world.

    Attributes:
        hypotheses: one dict for each hypothesis; a latent that plays no part is missing.
        rational: for each character the latent that says whether he is rational.
        can_fail: the characters whose moves can fail.
        events: event -> the objects that it can bring.
        places: tile -> its cells (column, row); `columns` x `rows` is the map's size.
        size: of a world without a map whose points (x, y) can be named: its width and height.
        automatic: the automatic terms that the world has; `weights`: how much each counts there.
        observer_settings: the settings in which a viewer may differ from the world.
        enumerable: whether actions can be enumerated (beam search) or are continuous (descent).
        search_settings: of its usual search, where they differ from those of every world.
        usual_length: the frames of a story that nobody has written yet.
        longest: the frames after which the time is up, or None.
        limited_to: the actions of each character that has not all of them.
        preposition: what stands before its name: a story happens `in the` kitchen.
        shares: what viewers think of a latent's values at first, latent by latent.
        readings: for each character who may be wrong, what it may be wrong about, a latent or an
            object, and the latent that holds what it takes that to be, or where.
        counts: where all hypotheses are too many to be listed, those of them that each of
            `hypotheses` stands for: all in which the latents of `kept` have these values.
        holds_particles: whether viewers may hold some hypotheses instead of all.
        factors: where viewers can hold all of these by factors, the latents of those whom others
            model, and of each other character (audience/factors.py); `factor_sizes` are theirs.
    """

    world: str
    latents: dict[str, Latent]
    hypotheses: tuple[dict[str, Value], ...]
    characters: tuple[str, ...]
    rational: dict[str, str]
    actions: tuple[str, ...]
    can_fail: frozenset[str]
    things: tuple[str, ...]
    may_be_absent: frozenset[str]
    places: dict[str, tuple[tuple[int, int], ...]]
    columns: int
    rows: int
    events: dict[str, tuple[str, ...]]
    predicates: dict[str, Predicate]
    settings: dict[str, Setting] = field(default_factory=dict)
    observer_settings: tuple[str, ...] = ()
    free: frozenset[tuple[int, int]] = frozenset()
    automatic: frozenset[str] = frozenset(Weights._fields)
    weights: Weights = ON_MAPS
    enumerable: bool = True
    search_settings: Settings = ()
    usual_length: int = 15
    longest: int | None = None
    size: tuple[float, float] | None = None
    limited_to: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    preposition: str = "in the"
    documentation: str = ""
    shares: Shares = field(default_factory=dict)
    readings: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    counts: tuple[float, ...] = ()
    kept: frozenset[str] = frozenset()
    factors: tuple[frozenset[str], ...] = ()
    factor_sizes: FactorSizes | None = None
    holds_particles: bool = True

    @cached_property
    def even(self) -> tuple[float, ...]:
        """The weight of each of `hypotheses` where all that it stands for are alike."""
        return self.counts or (1.0,) * len(self.hypotheses)

    @property
    def apart(self) -> tuple[str, ...]:
        """The latents whose values viewers keep apart: all where hypotheses can be listed."""
        return tuple(x for x in self.latents if not self.counts or x in self.kept)

    @cached_property
    def prior(self) -> tuple[float, ...] | None:
        """The probabilities of the hypotheses at first; None where all are alike."""
        if self.shares:
            return fitted(self.hypotheses, self.even, self.shares)
        total = math.fsum(self.counts)
        return tuple(count / total for count in self.counts) if self.counts else None

    @property
    def where(self) -> str:
        return f"{self.preposition} {self.world}"

    def actions_of(self, who: str) -> tuple[str, ...]:
        """The actions of a character, in its own order."""
        return self.limited_to.get(who, self.actions)

    @cached_property
    def words(self) -> frozenset[str]:
        """Every name that means something in this world."""
        values = (str(v) for latent in self.latents.values() for v in latent.values)
        names = (*self.latents, *values, *self.places, *self.predicates, *self.characters)
        return frozenset((*names, *self.things, *self.actions, *self.events))


def show_value(value: Value) -> str:
    """A latent's value as it is written in a story."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if not isinstance(value, float):
        return str(value)
    short = f"{value:g}"
    return short if float(short) == value else repr(value)  # no two values are shown alike
