"""An expectation of a sum is the sum of expectations: what can be asked for by itself.

What needs the values of several characters at once must be told of all that these may have in
mind together; of a sum, each may be asked about alone.
"""

from __future__ import annotations

from dataclasses import replace

from i2pdsl.language import typed as ty


def addends(quantity: ty.Typed) -> dict[frozenset[int], ty.Typed]:
    """The parts of a quantity that add up to it, by the characters whose values each needs."""
    found: dict[frozenset[int], list[ty.Typed]] = {}
    for term in _terms(quantity):
        found.setdefault(whose(term), []).append(term)
    return {who: _sum(terms) for who, terms in found.items()}


def whose(node: ty.Typed) -> frozenset[int]:
    """The characters whose values are asked for."""
    return frozenset(part.who for part in ty.walk(node) if isinstance(part, ty.ValueAt))


def _sum(terms: list[ty.Typed]) -> ty.Typed:
    return terms[0] if len(terms) == 1 else ty.Apply("add", tuple(terms))


def _terms(node: ty.Typed) -> list[ty.Typed]:
    """Those of a sum, and of its multiples."""
    if not isinstance(node, ty.Apply) or len(whose(node)) < 2:
        return [node]
    if node.operation == "add":
        return [term for part in node.arguments for term in _terms(part)]
    depends = [i for i, part in enumerate(node.arguments) if whose(part)]
    linear = {"negate": depends, "multiply": depends, "divide": [0]}.get(node.operation)
    if linear is None or linear != depends or len(depends) > 1:
        return [node]
    (i,) = depends
    before, after = node.arguments[:i], node.arguments[i + 1 :]
    return [replace(node, arguments=(*before, term, *after)) for term in _terms(node.arguments[i])]
