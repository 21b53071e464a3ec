"""Numbers and truth values: what each operation of an expression does, in NumPy or JAX."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

Array = Any


def _fold(operation: str) -> Callable[..., Array]:
    def apply(xp: Any, first: Array, *rest: Array) -> Array:
        for other in rest:
            first = getattr(xp, operation)(first, other)
        return first

    return apply


def _truth(operation: str) -> Callable[..., Array]:
    def apply(xp: Any, first: Array, *rest: Array) -> Array:
        result = xp.asarray(first) != 0
        for other in rest:
            result = getattr(xp, operation)(result, xp.asarray(other) != 0)
        return result

    return apply


OPERATIONS: dict[str, Callable[..., Array]] = {
    "add": _fold("add"),
    "multiply": _fold("multiply"),
    "divide": _fold("divide"),
    "power": _fold("power"),
    "min": _fold("minimum"),
    "max": _fold("maximum"),
    "negate": lambda xp, a: -a,
    "and": _truth("logical_and"),
    "or": _truth("logical_or"),
    "not": lambda xp, a: xp.asarray(a) == 0,
    "choose": lambda xp, c, a, b: xp.where(xp.asarray(c) != 0, a, b),
    **{name: _fold(name) for name in ("less", "less_equal", "equal", "not_equal")},
    **{name: _fold(name) for name in ("greater_equal", "greater")},
    **{
        name: (lambda f: lambda xp, a: getattr(xp, f)(a))(name)
        for name in ("sin", "cos", "exp", "log", "sqrt", "abs")
    },
}
