"""The checked form of an expression: names resolved, patterns put in, events folded to masks.

A type is a value and its axes: the hypothesis axis, which `P`, `E`, `KL` and `entropy` remove,
and the time axis, which `sum_t` removes. This one rule is the checker's and the compiler's.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

Mask = tuple[bool, ...]
"""One truth value for each hypothesis: an event or a condition."""


Viewers = tuple[int, int]
"""Some of the observers of a story: from the first to before the second."""


@dataclass(frozen=True)
class Axes:
    """The axes along which an expression varies."""

    hypothesis: bool = False
    time: bool = False

    def __or__(self, other: Axes) -> Axes:
        return Axes(self.hypothesis or other.hypothesis, self.time or other.time)


NO_AXES = Axes()
HYPOTHESIS = Axes(hypothesis=True)
TIME = Axes(time=True)


@dataclass(frozen=True)
class Constant:
    value: float
    axes = NO_AXES


@dataclass(frozen=True)
class TimeIndex:
    """`t`."""

    axes = TIME


@dataclass(frozen=True)
class LatentValue:
    """A latent inside an event or a quantity; None where it plays no part."""

    latent: str
    axes = HYPOTHESIS


@dataclass(frozen=True)
class Symbol:
    """A latent's value that is no number: pink, none."""

    value: str
    axes = NO_AXES


@dataclass(frozen=True)
class Apply:
    """An operation on numbers and truth values: add, multiply, less, and, choose, sin, ..."""

    operation: str
    arguments: tuple[Typed, ...]

    @cached_property
    def axes(self) -> Axes:
        every = [argument.axes for argument in self.arguments]
        return Axes(any(a.hypothesis for a in every), any(a.time for a in every))

    @cached_property
    def is_pure(self) -> bool:
        """Whether it needs neither frames nor beliefs."""
        return all(is_pure(argument) for argument in self.arguments)

    @cached_property
    def height(self) -> int:
        """How deep its operations are nested."""
        return 1 + max((getattr(a, "height", 0) for a in self.arguments), default=0)


@dataclass(frozen=True)
class Points:
    """A drawn arc: piecewise linear in `at`, constant beyond its ends."""

    xs: tuple[float, ...]
    ys: tuple[float, ...]
    at: Typed

    @property
    def axes(self) -> Axes:
        return self.at.axes


@dataclass(frozen=True)
class TimeTable:
    """A number that depends on t alone: `values[t - first]`."""

    first: int
    values: tuple[float, ...]
    axes = TIME


@dataclass(frozen=True)
class Act:
    """What a character does in an appended turn: the action's number, and whether it fails."""

    action: int
    fails: bool


@dataclass(frozen=True)
class Drop:
    """An event in an appended turn: the object falls onto the cell (column, row)."""

    event: str
    thing: str
    cell: tuple[int, int]


Turn = tuple[Act, ...] | Drop
"""One act for each character in the order of acting, or an event."""


@dataclass(frozen=True)
class Moment:
    """A frame of a script: `turns` are appended to the story's script.

    `frames` lists the frame's number for each t from `first` on (as a range where it is a line
    in t); with a single entry and `first` None it does not depend on t. `seen` counts the
    observed actions of the frame after which viewers are asked; None is after all of them.
    """

    turns: tuple[Turn, ...]
    frames: tuple[int, ...] | range
    first: int | None
    seen: int | None = None

    @property
    def axes(self) -> Axes:
        return NO_AXES if self.first is None else TIME

    @property
    def offset(self) -> int | None:
        """c where the frame is t + c for all t, else None."""
        if self.first is None or not self.frames:
            return None
        c = self.frames[0] - self.first
        if isinstance(self.frames, range):
            return c if self.frames.step == 1 or len(self.frames) == 1 else None
        same = all(f == self.first + i + c for i, f in enumerate(self.frames))
        return c if same else None


@dataclass(frozen=True)
class Given:
    """What a belief is conditioned on: the first frames of a script, and a mask."""

    moment: Moment
    mask: Mask

    @property
    def axes(self) -> Axes:
        return self.moment.axes


@dataclass(frozen=True)
class ValueAt:
    """V(who) at the state that the script of the enclosing expectation ends in."""

    who: int
    axes = HYPOTHESIS


@dataclass(frozen=True)
class PerHypothesis:
    """A constant number for each hypothesis."""

    values: tuple[float, ...]
    axes = HYPOTHESIS


@dataclass(frozen=True)
class Labels:
    """What an axis of a table is called, and its values' names; that of a latent ends in
    `unknown`, for the hypotheses in which it plays no part."""

    name: str
    values: tuple[str, ...]


@dataclass(frozen=True)
class Partition:
    """Which value of a latent (or of several together) each hypothesis has: an index; the last
    label of a latent is `unknown`."""

    labels: tuple[str, ...]
    index: tuple[int, ...]


@dataclass(frozen=True)
class Belief:
    """A form about what viewers believe; `form` is its name in the table of forms.

    Attributes:
        about: an event's mask, a partition, a quantity, the number of a character, or None.
        given: what it is conditioned on; of a divergence the first and the second belief. For an
            expectation the mask excludes already where the quantity means nothing.
        labels: of a table its axes: what each is called and its values' names; () for a number.
        viewers: whose belief it is; None where there is only one audience.
        moment: the frame whose hypothesis is asked for in hindsight; None is the last one that
            is given.
    """

    form: str
    about: Any
    given: tuple[Given, ...]
    labels: tuple[Labels, ...] = ()
    viewers: Viewers | None = None
    moment: Moment | None = None

    @cached_property
    def axes(self) -> Axes:
        """The axes of its scripts and of a quantity, without the hypotheses'."""
        parts: list[Any] = [*self.given]
        parts += [part for part in (self.about, self.moment) if hasattr(part, "axes")]
        return Axes(False, any(part.axes.time for part in parts))


@dataclass(frozen=True)
class Point:
    """A place of a world in which bodies move, in its units."""

    x: float
    y: float


@dataclass(frozen=True)
class Feature:
    """A predicate or quantity of a frame, or of the initial state where `moment` is None.

    Arguments are indices of entities, (column, row) cells, or points.
    """

    predicate: str
    arguments: tuple[int | tuple[tuple[int, int], ...] | Point, ...]
    moment: Moment | None

    @property
    def axes(self) -> Axes:
        return self.moment.axes if self.moment else NO_AXES


@dataclass(frozen=True)
class Acted:
    """Whether a frame's turn is this one: of a character with None anything is."""

    turn: tuple[Act | None, ...] | Drop
    moment: Moment

    @property
    def axes(self) -> Axes:
        return self.moment.axes


@dataclass(frozen=True)
class When:
    """The first t of 1..last in which `body`, asked of frame t, holds; last + 1 where none does.

    The number is told less `before`, the frames before the story begins (objective/late.py).
    """

    body: Typed
    last: int
    before: int = 0
    axes = NO_AXES


@dataclass(frozen=True)
class FrameCount:
    """How many frames there are so far, less `before` (objective/late.py)."""

    before: int | None = None
    axes = NO_AXES


@dataclass(frozen=True)
class Away:
    """How many more frames it takes at least until `body`, asked of the last of them, holds.

    `events` are those that may happen, in the world's numbers.
    """

    body: Typed
    events: tuple[int, ...]
    axes = NO_AXES


@dataclass(frozen=True)
class Reduction:
    """sum, mean, min or max of `body` over t = first..last."""

    kind: str
    first: int
    last: int
    body: Typed
    axes = NO_AXES


@dataclass(frozen=True)
class Beats:
    """The greatest sum over t = 1..last of one of `parts` at a time, each in its turn: the first
    for some frames, then the second, and so on, none for fewer than `least`."""

    parts: tuple[Typed, ...]
    least: int
    last: int
    axes = NO_AXES


Typed = (
    Constant
    | TimeIndex
    | TimeTable
    | LatentValue
    | Symbol
    | Apply
    | Points
    | ValueAt
    | PerHypothesis
    | Belief
    | Feature
    | Acted
    | When
    | FrameCount
    | Away
    | Reduction
    | Beats
)


_PURE = (Constant, TimeIndex, TimeTable, Symbol, LatentValue, PerHypothesis)


def is_pure(node: object) -> bool:
    """Whether an expression needs neither frames nor beliefs."""
    if isinstance(node, Apply):
        return node.is_pure
    return isinstance(node, _PURE) or (isinstance(node, Points) and is_pure(node.at))


def children(node: object) -> Iterator[object]:
    """The typed nodes, givens and moments directly below a node."""
    for name in _field_names(node.__class__):
        value = getattr(node, name)
        if isinstance(value, tuple) and value and hasattr(value[0], "axes"):
            yield from value
        elif hasattr(value, "axes"):
            yield value


_fields: dict[type, tuple[str, ...]] = {}


def _field_names(kind: type[Any]) -> tuple[str, ...]:
    if kind not in _fields:
        _fields[kind] = tuple(f.name for f in fields(kind))
    return _fields[kind]


def walk(node: object) -> Iterator[object]:
    """A node and everything below it."""
    yield node
    for child in children(node):
        yield from walk(child)
