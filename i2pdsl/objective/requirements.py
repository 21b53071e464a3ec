"""What a script must fulfil: which requirements a prefix has broken for good, and which one the
finished script does not meet.

A condition of the finished script is not decided before the last frame that it asks about. A
prefix has broken it where it is false whatever follows: an `and` as soon as one of its parts is, an
`or` as soon as all are, `never [..]` as soon as it holds once; what is asked of a frame to come,
as soon as no turns lead there in time (reach.py). What may still be fulfilled is no violation.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from i2pdsl.language import typed as ty
from i2pdsl.language.story import Requirement, TypedStory
from i2pdsl.objective.frame import Frame
from i2pdsl.objective.replay import evaluate
from i2pdsl.worlds.world import World

VIOLATION = 1e4
"""What a broken requirement costs a script while it is searched for, in units of the score.

More than scores differ by, and little enough for single precision to tell 0.01 apart beside it.
The scores of finished scripts are told without it."""


SHORTFALL = 100.0
"""What a descent loses for each unit by which a requirement is missed: enough to matter more than
beliefs do, and little enough for its steps."""


def violations(story: TypedStory, world: World) -> list[tuple[float, ty.Typed]]:
    """A term for each requirement: 1 from where on a script has broken it for good.

    Where bodies move, which is searched along gradients, how much it misses it by. And the pins,
    where there are no tables for them (pins.py).
    """
    conditions = [r.condition for r in story.requirements]
    if not world.lists_states:
        conditions += [pin.condition for pin in story.pins]
    if not story.vocabulary.enumerable:
        missed_by = {p.name: p.missed_by for p in story.vocabulary.predicates.values()}
        verdicts = _Verdicts(story.length, None, missed_by)
        return [(-SHORTFALL, verdicts.shortfall(c, True)) for c in conditions]
    verdicts = _Verdicts(story.length, world.events(story.allow))
    one, zero = ty.Constant(1.0), ty.Constant(0.0)
    return [(-VIOLATION, ty.Apply("choose", (verdicts.broken(c), one, zero))) for c in conditions]


def unmet(story: TypedStory, world: World, frames: Frame) -> tuple[Requirement, ...]:
    """The requirements and pins that a finished script does not meet."""
    length = len(frames.state) - 1
    asked = (*story.requirements, *(pin for pin in story.pins if pin.frame <= length))
    with np.errstate(all="ignore"):
        return tuple(r for r in asked if not evaluate(world, frames, r.condition, None))


_COUNT = ty.FrameCount()
_FLIPPED = {
    "less": "greater",
    "less_equal": "greater_equal",
    "greater": "less",
    "greater_equal": "less_equal",
}


def _number(value: float) -> ty.Constant:
    return ty.Constant(float(value))


def _is(left: ty.Typed, relation: str, right: ty.Typed) -> ty.Typed:
    return ty.Apply(relation, (left, right))


def _both(*parts: ty.Typed) -> ty.Typed:
    return ty.Apply("and", parts)


def _any(*parts: ty.Typed) -> ty.Typed:
    return ty.Apply("or", parts)


def _minus(part: ty.Typed) -> ty.Typed:
    return ty.Apply("negate", (part,))


def _not(part: ty.Typed) -> ty.Typed:
    return ty.Apply("not", (part,))


@dataclass(frozen=True)
class _Verdicts:
    """Reads conditions of a script of `length` frames as conditions of its prefixes.

    `events` are those that may happen, in the world's numbers; None where states cannot be listed,
    and only the end tells what was not reached. `missed_by` names, for a predicate, the quantity
    by which it misses.
    """

    length: int
    events: tuple[int, ...] | None
    missed_by: Mapping[str, str] = field(default_factory=dict)

    def broken(self, node: ty.Typed) -> ty.Typed:
        """Whether a condition can no longer hold."""
        return self._read(node)[0]

    def shortfall(self, node: ty.Typed, wanted: bool) -> ty.Typed:
        """By how much a condition misses being true (or false) once that is decided, 0 where it
        does not: smooth where predicates are, by as much as predicates say that they miss, as far
        as comparisons go, and else 1."""
        match node:
            case ty.Apply(operation="not", arguments=(part,)):
                return self.shortfall(part, not wanted)
            case ty.Apply(operation="choose", arguments=(part, ty.Constant(), ty.Constant())):
                return self.shortfall(part, wanted)
            case ty.Apply(operation="and" | "or", arguments=parts):
                misses = tuple(self.shortfall(part, wanted) for part in parts)
                return ty.Apply("add" if (node.operation == "and") == wanted else "min", misses)
        last = self._decided(node)
        if wanted and isinstance(node, ty.Feature) and self.missed_by.get(node.predicate):
            gap = replace(node, predicate=self.missed_by[node.predicate])
            return self._once(last, self._fixed(gap))
        value = self._fixed(node)
        missed = value if not wanted else ty.Apply("add", (_number(1), _minus(value)))
        if isinstance(node, ty.Reduction) and not wanted:  # never [...]
            return missed
        if isinstance(value, ty.Apply):
            missed = self._gap(value, wanted)
        return self._once(last, missed)

    @staticmethod
    def _once(last: int, value: ty.Typed) -> ty.Typed:
        """A number from frame `last` on, and 0 before."""
        there = _is(_COUNT, "greater_equal", _number(last))
        return ty.Apply("choose", (there, value, _number(0)))

    def _gap(self, node: ty.Apply, wanted: bool) -> ty.Typed:
        """By how much a comparison misses."""
        falls = node.operation in ("less", "less_equal")
        if node.operation in _FLIPPED and not any(isinstance(a, ty.When) for a in node.arguments):
            left, right = node.arguments
            more = ty.Apply("add", (left, _minus(right)))
            return ty.Apply("max", (_number(0), more if falls == wanted else _minus(more)))
        misses = _not(node) if wanted else node
        return ty.Apply("choose", (misses, _number(1), _number(0)))

    def _read(self, node: ty.Typed) -> tuple[ty.Typed, ty.Typed]:
        """Whether a condition can no longer hold, and whether it holds whatever follows."""
        frame = _only_frame(node)
        if frame is not None and 0 < frame <= self.length:
            held, late = self._one_frame(node, frame), _is(_COUNT, "less", _number(frame))
            missed = _both(late, self._too_far(_at_t(node, frame), _number(frame)))
            return _any(_both(_not(late), _not(held)), missed), _both(_not(late), held)
        match node:
            case ty.Apply(
                operation=relation, arguments=(ty.Constant() as bound, ty.When() as when)
            ):
                if relation in _FLIPPED:
                    return self._read(_is(when, _FLIPPED[relation], bound))
            case ty.Apply(operation="not", arguments=(part,)):
                return self._read(part)[::-1]
            case ty.Apply(operation="and" | "or", arguments=parts):
                lost, sure = zip(*map(self._read, parts), strict=True)
                if node.operation == "and":
                    return _any(*lost), _both(*sure)
                return _both(*lost), _any(*sure)
            case ty.Reduction(kind="max", body=body):  # eventually [...]
                return _both(_not(node), self._too_far(body, _number(self.length))), node
            case ty.Apply(operation="less", arguments=(ty.When() as first, ty.When() as second)):
                earlier = ty.Apply("min", (first, second))
                happened = _is(earlier, "less_equal", _COUNT)
                late = self._too_far(first.body, _number(self.length))
                return _both(_not(node), _any(happened, late)), node
            case ty.Apply(
                operation="less" | "less_equal",
                arguments=(ty.When() as when, ty.Constant(value=bound)),
            ):
                last = np.ceil(bound) - 1 if node.operation == "less" else np.floor(bound)
                return _both(_not(node), self._too_far(when.body, _number(last))), node
            case ty.Apply(
                operation="greater" | "greater_equal",
                arguments=(ty.When(), ty.Constant() as least),
            ):
                return _not(node), _both(_is(_COUNT, "greater_equal", least), node)
        value = self._fixed(node)
        over = _is(_COUNT, "greater_equal", _number(self._decided(node)))
        return _both(over, _not(value)), _both(over, value)

    def _too_far(self, body: ty.Typed, last: ty.Constant) -> ty.Typed:
        """Whether what has not been seen yet cannot be seen up to frame `last` either."""
        away = _number(1) if self.events is None else ty.Away(body, self.events)
        return _is(ty.Apply("add", (_COUNT, away)), "greater", last)

    def _decided(self, node: object) -> int:
        """The last frame that an expression asks about."""
        lasts = [
            max(n.frames, default=0) if isinstance(n, ty.Moment) else n.last
            for n in ty.walk(node)
            if isinstance(n, ty.Moment | ty.Reduction | ty.Beats | ty.When)
        ]
        return min(max(lasts, default=0), self.length)

    def _one_frame(self, node: ty.Typed, frame: int) -> ty.Typed:
        """A condition of one frame, kept when the frame is there."""
        if frame == self.length:
            return node
        return ty.Reduction("sum", frame, frame, _at_t(node, frame))

    def _fixed(self, node: ty.Typed) -> ty.Typed:
        """The same, with what is asked about single frames kept when they are there, so that a
        search need not keep all frames."""
        if isinstance(node, ty.Apply):
            return replace(node, arguments=tuple(self._fixed(a) for a in node.arguments))
        if not isinstance(node, ty.Belief | ty.Feature):
            return node
        if isinstance(node, ty.Belief) and node.moment is not None:
            return node  # hindsight needs all frames between the two
        moments = [n for n in ty.walk(node) if isinstance(n, ty.Moment)]
        frame = max((n.frames[0] for n in moments), default=0)
        near = (0, frame) if isinstance(node, ty.Feature) else (0, frame - 1, frame)
        plain = all(m.first is None and not m.turns and m.frames[0] in near for m in moments)
        whole = all(m.seen is None or m.frames[0] == frame for m in moments)
        if not (plain and whole and frame > 0):
            return node
        if self.events is None and isinstance(node, ty.Feature) and frame <= self.length:
            return self._of_any_frame(node, frame)
        if frame >= self.length:
            return node
        return ty.Reduction("sum", frame, frame, _at_t(node, frame))

    def _of_any_frame(self, node: ty.Feature, frame: int) -> ty.Typed:
        """What is seen in a frame whose number the compiled search is given, so that moving a pin
        needs no other search."""
        chosen = tuple(float(t == frame) for t in range(1, self.length + 1))
        at_t = replace(node, moment=ty.Moment((), range(1, self.length + 1), 1))
        body = ty.Apply("choose", (ty.TimeTable(1, chosen), at_t, _number(0)))
        return ty.Reduction("sum", 1, self.length, body)


def _only_frame(node: ty.Typed) -> int | None:
    """The frame k of a condition on what is seen in `script[k]` alone."""
    parts = [n for n in ty.walk(node) if not isinstance(n, ty.Apply | ty.Constant)]
    moments = {n for n in parts if isinstance(n, ty.Moment)}
    if len(moments) != 1 or not all(isinstance(n, ty.Moment | ty.Feature) for n in parts):
        return None
    (moment,) = moments
    return moment.frames[0] if moment.first is None and not moment.turns else None


def _at_t(node: ty.Typed, frame: int) -> ty.Typed:
    """An expression about `script[frame]` as one about frame t, at t = frame."""
    match node:
        case ty.Apply(arguments=arguments):
            return replace(node, arguments=tuple(_at_t(a, frame) for a in arguments))
        case ty.Feature(moment=ty.Moment() as moment):
            return replace(node, moment=_moment_at_t(moment, frame))
        case ty.Belief(given=given):
            moved = tuple(replace(g, moment=_moment_at_t(g.moment, frame)) for g in given)
            return replace(node, given=moved)
    return node


def _moment_at_t(moment: ty.Moment, frame: int) -> ty.Moment:
    number = moment.frames[0]
    if number == 0:
        return moment
    return replace(moment, frames=range(number, number + 1), first=frame)
