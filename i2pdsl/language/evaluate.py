"""Plain evaluation of what needs no beliefs: constants, functions of t, events over latents."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from i2pdsl.language import typed as ty
from i2pdsl.language.vocabulary import Value

_PURE = (ty.Constant, ty.TimeIndex, ty.TimeTable, ty.Symbol, ty.LatentValue, ty.PerHypothesis)


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


def is_pure(node: object) -> bool:
    """Whether an expression needs neither frames nor beliefs."""
    return all(isinstance(n, (*_PURE, ty.Apply, ty.Points)) for n in ty.walk(node))


def evaluate(node: Any, t: int | None = None, row: Mapping[str, Value] | None = None) -> Any:
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
            values = [evaluate(a, t, row) for a in node.arguments]
            missing = any(v is None for v in values)
            if node.operation in _COMPARE:
                return not missing and _COMPARE[node.operation](*values)
            return None if missing else OPERATIONS[node.operation](*values)
    raise TypeError(f"{type(node).__name__} is not pure")


def interpolate(x: float, xs: tuple[float, ...], ys: tuple[float, ...]) -> float:
    """Piecewise linear through (xs, ys), constant beyond the ends."""
    if x <= xs[0]:
        return ys[0]
    for left in range(len(xs) - 1):
        if x <= xs[left + 1]:
            share = (x - xs[left]) / (xs[left + 1] - xs[left])
            return ys[left] + share * (ys[left + 1] - ys[left])
    return ys[-1]


def fold_time(node: Any, times: range) -> Any:
    """Replaces what depends on t alone by tables, so that such stories share one program.

    Raises ArithmeticError or ValueError where a value is not a finite number.
    """
    if not hasattr(node, "axes") or isinstance(node, ty.Reduction | ty.Given | ty.Moment):
        return node
    if is_pure(node) and node.axes == ty.TIME:
        values = tuple(float(evaluate(node, t)) for t in times)
        if not all(math.isfinite(v) for v in values):
            raise ArithmeticError("not a finite number")
        return ty.TimeTable(times.start, values)
    if isinstance(node, ty.Apply):
        return replace(node, arguments=tuple(fold_time(a, times) for a in node.arguments))
    if isinstance(node, ty.Expectation):
        return replace(node, quantity=fold_time(node.quantity, times))
    if isinstance(node, ty.Points):
        return replace(node, at=fold_time(node.at, times))
    return node


def fold_hypotheses(node: Any, rows: tuple[dict[str, Value], ...]) -> Any:
    """Replaces what depends on the hypothesis alone by one number for each hypothesis.

    Where a latent plays no part the number is 0; the expectation's mask excludes it.
    """
    if is_pure(node) and node.axes == ty.HYPOTHESIS:
        values = [evaluate(node, None, row) for row in rows]
        return ty.PerHypothesis(tuple(0.0 if v is None else float(v) for v in values))
    if isinstance(node, ty.Apply):
        return replace(node, arguments=tuple(fold_hypotheses(a, rows) for a in node.arguments))
    if isinstance(node, ty.Points):
        return replace(node, at=fold_hypotheses(node.at, rows))
    return node
