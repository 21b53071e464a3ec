"""The plain evaluator, of what needs no beliefs: constants, functions of t, events over latents,
conditions of a first picture."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from i2pdsl.language import typed as ty
from i2pdsl.language.typed import is_pure
from i2pdsl.language.vocabulary import Value

Row = Mapping[str, Value]
"""A hypothesis: the values of the latents that play a part in it."""


def _power(a: float, b: float) -> float:
    result = a**b
    if isinstance(result, complex):
        raise ValueError("a root of a negative number")
    return result


OPERATIONS: dict[str, Callable[..., Any]] = {
    "add": lambda *xs: sum(xs),
    "multiply": lambda *xs: math.prod(xs),
    "divide": lambda a, b: a / b,
    "negate": lambda a: -a,
    "power": _power,
    "sin": math.sin,
    "cos": math.cos,
    "exp": math.exp,
    "log": math.log,
    "sqrt": math.sqrt,
    "abs": abs,
    "min": min,
    "max": max,
}
COMPARISONS: dict[str, tuple[str, Callable[[Any, Any], bool]]] = {
    "<": ("less", lambda a, b: a < b),
    "<=": ("less_equal", lambda a, b: a <= b),
    "=": ("equal", lambda a, b: a == b),
    "!=": ("not_equal", lambda a, b: a != b),
    ">=": ("greater_equal", lambda a, b: a >= b),
    ">": ("greater", lambda a, b: a > b),
}
_COMPARE = dict(COMPARISONS.values())
_FUNCTIONS = {**OPERATIONS, **_COMPARE}


class Open:
    """The value of what is not known yet: the predicate of an entity that has no place so far."""


OPEN = Open()
Leaf = Callable[[ty.Feature, Any], Any]


def evaluate(node: Any, point: Any = None, leaf: Leaf | None = None) -> Any:
    """The value of an expression at one point; see `values`."""
    return values(node, (point,), leaf)[0]


def values(node: Any, points: Sequence[Any], leaf: Leaf | None = None) -> list[Any]:
    """The values at each of `points` of an expression that asks for no belief.

    A point is a frame's number t, a hypothesis (the values of its latents), or a first picture;
    of that `leaf` tells the predicates. What an `if`, `and` or `or` does not reach at a point is
    not evaluated there.

    A latent that plays no part is None; so is arithmetic with it, and every comparison with it is
    false (language.md). What is OPEN leaves open what depends on it, unless the rest decides
    (Kleene's three values).

    Arrays have their own evaluator, objective/compile.py: JAX must trace it and can neither leave
    out what is not reached nor raise at a division by 0, as the checker has to; and the checker
    loads no array library.
    """
    match node:
        case ty.Constant(value=value) | ty.Symbol(value=value):
            return [value] * len(points)
        case ty.TimeIndex():
            return list(points)
        case ty.TimeTable(first=first, values=table):
            return [table[t - first] for t in points]
        case ty.LatentValue(latent=latent):
            return [row.get(latent) for row in points]
        case ty.Feature() if leaf is not None:
            return [leaf(node, point) for point in points]
        case ty.Points():
            ats = values(node.at, points, leaf)
            return [None if x is None else interpolate(x, node.xs, node.ys) for x in ats]
        case ty.Apply(operation="choose", arguments=(condition, then, otherwise)):
            taken = _truths(condition, points, leaf)
            yes = iter(values(then, _where(points, taken, True), leaf))
            no = iter(values(otherwise, _where(points, taken, False), leaf))
            return [x if x is OPEN else next(yes) if x else next(no) for x in taken]
        case ty.Apply(operation="and" | "or"):
            decides = node.operation == "or"
            truths = _truths(node.arguments[0], points, leaf)
            for argument in node.arguments[1:]:
                undecided = [p for p, x in zip(points, truths, strict=True) if x is not decides]
                more = iter(_truths(argument, undecided, leaf))
                truths = [x if x is decides else _joined(x, next(more), decides) for x in truths]
            return truths
        case ty.Apply(operation="not"):
            return [x if x is OPEN else not x for x in _truths(node.arguments[0], points, leaf)]
        case ty.Apply():
            columns = [values(a, points, leaf) for a in node.arguments]
            if node.axes.hypothesis or leaf is not None:
                return _lifted(node.operation, columns)
            return list(map(_FUNCTIONS[node.operation], *columns))
    raise TypeError(f"{type(node).__name__} has no value here")


def _truths(node: Any, points: Sequence[Any], leaf: Leaf | None) -> list[Any]:
    return [x if x is OPEN else bool(x) for x in values(node, points, leaf)]


def _joined(truth: Any, other: Any, decides: bool) -> Any:
    """`and` or `or` of two truths, the first of which does not decide."""
    return OPEN if truth is OPEN and other is not decides else other


def _lifted(operation: str, columns: list[list[Any]]) -> list[Any]:
    """An operation at each point on operands that may be OPEN or None, one list for each."""
    found: list[Any] = []
    for parts in zip(*columns, strict=True):
        if any(part is OPEN for part in parts):
            found.append(OPEN)
        elif any(part is None for part in parts):
            found.append(False if operation in _COMPARE else None)
        else:
            found.append(_FUNCTIONS[operation](*parts))
    return found


def interpolate(x: float, xs: tuple[float, ...], ys: tuple[float, ...]) -> float:
    """Piecewise linear through (xs, ys), constant beyond the ends."""
    right = bisect_left(xs, x)
    if right == 0:
        return ys[0]
    if right == len(xs):
        return ys[-1]
    share = (x - xs[right - 1]) / (xs[right] - xs[right - 1])
    return ys[right - 1] + share * (ys[right] - ys[right - 1])


def _where(points: Sequence[Any], truths: Sequence[object], wanted: bool) -> list[Any]:
    return [point for point, truth in zip(points, truths, strict=True) if truth is wanted]


def may_be(node: Any, ts: Sequence[int], wanted: bool) -> list[int]:
    """Those of `ts` at which a condition may be `wanted`; what beliefs decide may be either."""
    if is_pure(node) and not node.axes.hypothesis:
        return _where(ts, _truths(node, ts, None), wanted)
    match node:
        case ty.Apply(operation="not"):
            return may_be(node.arguments[0], ts, not wanted)
        case ty.Apply(operation="and" | "or"):
            if (node.operation == "and") == wanted:  # every part must be as wanted
                for argument in node.arguments:
                    ts = may_be(argument, ts, wanted)
                return list(ts)
            one = {t for argument in node.arguments for t in may_be(argument, ts, wanted)}
            return [t for t in ts if t in one]
    return list(ts)


def affine(node: Any) -> tuple[float, float] | None:
    """(a, b) where an expression is a t + b for every t, else None."""
    match node:
        case ty.Constant(value=value):
            return 0.0, value
        case ty.TimeIndex():
            return 1.0, 0.0
        case ty.Apply(operation="add" | "negate" | "multiply" | "divide"):
            lines = [affine(a) for a in node.arguments]
            return None if None in lines else _combine(node.operation, lines)
    return None


def _combine(operation: str, lines: list[Any]) -> tuple[float, float] | None:
    (a, b), (c, d) = lines[0], lines[-1]
    if operation == "add":
        return sum(slope for slope, _ in lines), sum(height for _, height in lines)
    if operation == "negate":
        return -a, -b
    if operation == "multiply" and 0 in (a, c):
        return a * d + c * b, b * d
    if operation == "divide" and c == 0 and d != 0:
        return a / d, b / d
    return None


class NotFiniteError(ArithmeticError):
    """A part of an expression, `node`, has no finite value at a point: a frame or a hypothesis."""

    def __init__(self, node: Any, point: Any):
        super().__init__()
        self.node = node
        self.point = point


def finite_values(node: Any, points: Sequence[Any]) -> list[Any]:
    """The values at each of `points`, None where a latent plays no part. Raises NotFiniteError."""
    try:
        found = values(node, points)
        if all(map(_is_finite, found)):
            return found
    except (ArithmeticError, ValueError):
        pass
    point = next(point for point in points if not _has_value(node, point))
    raise NotFiniteError(_culprit(node, point), point)


def _is_finite(value: Any) -> bool:
    return value is None or isinstance(value, str) or math.isfinite(value)


def _has_value(node: Any, point: Any) -> bool:
    try:
        return _is_finite(evaluate(node, point))
    except (ArithmeticError, ValueError):
        return False


def _culprit(node: Any, point: Any) -> Any:
    """The innermost part of an expression that has no finite value at a point."""
    parts: tuple[Any, ...] = node.arguments if isinstance(node, ty.Apply) else ()
    if isinstance(node, ty.Apply) and node.operation == "choose" and _has_value(parts[0], point):
        parts = (parts[1] if evaluate(parts[0], point) else parts[2],)
    return next((_culprit(p, point) for p in parts if not _has_value(p, point)), node)


def fold_time(node: Any, times: range, reached: Sequence[int] | None = None) -> Any:
    """Replaces what depends on t alone by tables, so that such stories share one program.

    `reached` are the t at which the expression counts; elsewhere the tables hold 0.
    Raises NotFiniteError where a value is not a finite number.
    """
    if not hasattr(node, "axes") or isinstance(node, ty.Reduction | ty.Given | ty.Moment):
        return node
    ts = times if reached is None else reached
    if is_pure(node) and node.axes == ty.TIME:
        numbers = list(map(float, finite_values(node, ts)))
        if reached is not None:
            known = dict(zip(ts, numbers, strict=True))
            numbers = [known.get(t, 0.0) for t in times]
        return ty.TimeTable(times.start, tuple(numbers))
    if isinstance(node, ty.Apply) and node.operation == "choose":
        condition, then, otherwise = node.arguments
        folded = (
            fold_time(condition, times, reached),
            fold_time(then, times, may_be(condition, ts, True)),
            fold_time(otherwise, times, may_be(condition, ts, False)),
        )
        return replace(node, arguments=folded)
    if isinstance(node, ty.Apply):
        return replace(node, arguments=tuple(fold_time(a, times, reached) for a in node.arguments))
    if isinstance(node, ty.Expectation):
        return replace(node, quantity=fold_time(node.quantity, times, reached))
    if isinstance(node, ty.Points):
        return replace(node, at=fold_time(node.at, times, reached))
    return node


def fold_hypotheses(node: Any, rows: tuple[Row, ...], mask: ty.Mask) -> Any:
    """Replaces what depends on the hypothesis alone by one number for each hypothesis.

    Where a latent plays no part, and outside the expectation's mask, the number is 0.
    Raises NotFiniteError.
    """
    if is_pure(node) and node.axes == ty.HYPOTHESIS:
        taken = [row for row, holds in zip(rows, mask, strict=True) if holds]
        known = iter(finite_values(node, taken))
        numbers = [next(known) if holds else 0.0 for holds in mask]
        return ty.PerHypothesis(tuple(0.0 if v is None else float(v) for v in numbers))
    if isinstance(node, ty.Apply):
        folded = tuple(fold_hypotheses(a, rows, mask) for a in node.arguments)
        return replace(node, arguments=folded)
    if isinstance(node, ty.Points):
        return replace(node, at=fold_hypotheses(node.at, rows, mask))
    return node
