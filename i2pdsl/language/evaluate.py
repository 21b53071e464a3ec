"""Plain evaluation of what needs no beliefs: constants, functions of t, events over latents."""

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


def evaluate(node: Any, t: int | None = None, row: Row | None = None) -> Any:
    """The value of a pure expression at frame t under the hypothesis `row`.

    A latent that plays no part is None; so is arithmetic with it, and every comparison with it
    is false (language.md).
    """
    match node:
        case ty.Constant(value=value) | ty.Symbol(value=value):
            return value
        case ty.TimeIndex():
            return t
        case ty.TimeTable(first=first, values=values):
            assert t is not None
            return values[t - first]
        case ty.LatentValue(latent=latent):
            assert row is not None
            return row.get(latent)
        case ty.Points():
            at = evaluate(node.at, t, row)
            return None if at is None else interpolate(at, node.xs, node.ys)
        case ty.Apply(operation="choose", arguments=(condition, then, otherwise)):
            return evaluate(then if evaluate(condition, t, row) else otherwise, t, row)
        case ty.Apply(operation="and"):
            return all(evaluate(a, t, row) for a in node.arguments)
        case ty.Apply(operation="or"):
            return any(evaluate(a, t, row) for a in node.arguments)
        case ty.Apply(operation="not"):
            return not evaluate(node.arguments[0], t, row)
        case ty.Apply():
            parts = [evaluate(a, t, row) for a in node.arguments]
            missing = any(v is None for v in parts)
            if node.operation in _COMPARE:
                return not missing and _COMPARE[node.operation](*parts)
            return None if missing else OPERATIONS[node.operation](*parts)
    raise TypeError(f"{type(node).__name__} is not pure")


def interpolate(x: float, xs: tuple[float, ...], ys: tuple[float, ...]) -> float:
    """Piecewise linear through (xs, ys), constant beyond the ends."""
    right = bisect_left(xs, x)
    if right == 0:
        return ys[0]
    if right == len(xs):
        return ys[-1]
    share = (x - xs[right - 1]) / (xs[right] - xs[right - 1])
    return ys[right - 1] + share * (ys[right] - ys[right - 1])


def series(node: Any, ts: Sequence[int]) -> list[Any]:
    """The values at each of `ts` of a pure expression without latents.

    What an `if`, `and` or `or` does not reach at some t is not evaluated there.
    """
    match node:
        case ty.Constant(value=value) | ty.Symbol(value=value):
            return [value] * len(ts)
        case ty.TimeIndex():
            return list(ts)
        case ty.TimeTable(first=first, values=values):
            return [values[t - first] for t in ts]
        case ty.Points():
            return [interpolate(x, node.xs, node.ys) for x in series(node.at, ts)]
        case ty.Apply(operation="choose", arguments=(condition, then, otherwise)):
            taken = series(condition, ts)
            yes = iter(series(then, _where(ts, taken, True)))
            no = iter(series(otherwise, _where(ts, taken, False)))
            return [next(yes) if x else next(no) for x in taken]
        case ty.Apply(operation="and" | "or"):
            undecided = node.operation == "and"
            truths = [bool(x) for x in series(node.arguments[0], ts)]
            for argument in node.arguments[1:]:
                more = iter(series(argument, _where(ts, truths, undecided)))
                truths = [bool(next(more)) if x == undecided else x for x in truths]
            return truths
        case ty.Apply(operation="not"):
            return [not x for x in series(node.arguments[0], ts)]
        case ty.Apply():
            operation = _COMPARE.get(node.operation) or OPERATIONS[node.operation]
            return list(map(operation, *(series(a, ts) for a in node.arguments)))
    raise TypeError(f"{type(node).__name__} does not depend on t alone")


def _where(ts: Sequence[int], truths: Sequence[object], wanted: bool) -> list[int]:
    return [t for t, truth in zip(ts, truths, strict=True) if bool(truth) == wanted]


def may_be(node: Any, ts: Sequence[int], wanted: bool) -> list[int]:
    """Those of `ts` at which a condition may be `wanted`; what beliefs decide may be either."""
    if is_pure(node) and not node.axes.hypothesis:
        return _where(ts, series(node, ts), wanted)
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
    """A part of an expression, `node`, has no finite value at frame `t`, or under the hypothesis
    `row`."""

    def __init__(self, node: Any, t: int | None, row: Row | None = None):
        super().__init__()
        self.node = node
        self.t = t
        self.row = row


def table(node: Any, ts: Sequence[int]) -> list[float]:
    """The values of an expression of t, as numbers. Raises NotFiniteError."""
    try:
        values = [float(v) for v in series(node, ts)]
    except (ArithmeticError, ValueError):
        values = [math.nan]
    if not all(map(math.isfinite, values)):
        t = next(t for t in ts if not _is_finite(node, t))
        raise NotFiniteError(_culprit(node, t), t)
    return values


def by_hypothesis(node: Any, rows: Sequence[Row]) -> list[Any]:
    """The values of an expression of latents, None where one plays no part. Raises
    NotFiniteError."""
    for row in rows:
        if not _is_finite(node, None, row):
            raise NotFiniteError(_culprit(node, None, row), None, row)
    return [evaluate(node, None, row) for row in rows]


def _is_finite(node: Any, t: int | None, row: Row | None = None) -> bool:
    try:
        value = evaluate(node, t, row)
        return value is None or isinstance(value, str) or math.isfinite(float(value))
    except (ArithmeticError, ValueError):
        return False


def _culprit(node: Any, t: int | None, row: Row | None = None) -> Any:
    """The innermost part of an expression that has no finite value at t."""
    parts: tuple[Any, ...] = node.arguments if isinstance(node, ty.Apply) else ()
    if isinstance(node, ty.Apply) and node.operation == "choose" and _is_finite(parts[0], t, row):
        parts = (parts[1] if evaluate(parts[0], t, row) else parts[2],)
    return next((_culprit(p, t, row) for p in parts if not _is_finite(p, t, row)), node)


def fold_time(node: Any, times: range, reached: Sequence[int] | None = None) -> Any:
    """Replaces what depends on t alone by tables, so that such stories share one program.

    `reached` are the t at which the expression counts; elsewhere the tables hold 0.
    Raises NotFiniteError where a value is not a finite number.
    """
    if not hasattr(node, "axes") or isinstance(node, ty.Reduction | ty.Given | ty.Moment):
        return node
    ts = times if reached is None else reached
    if is_pure(node) and node.axes == ty.TIME:
        values = table(node, ts)
        if reached is not None:
            known = dict(zip(ts, values, strict=True))
            values = [known.get(t, 0.0) for t in times]
        return ty.TimeTable(times.start, tuple(values))
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
        values = iter(by_hypothesis(node, taken))
        numbers = [next(values) if holds else 0.0 for holds in mask]
        return ty.PerHypothesis(tuple(0.0 if v is None else float(v) for v in numbers))
    if isinstance(node, ty.Apply):
        folded = tuple(fold_hypotheses(a, rows, mask) for a in node.arguments)
        return replace(node, arguments=folded)
    if isinstance(node, ty.Points):
        return replace(node, at=fold_hypotheses(node.at, rows, mask))
    return node
