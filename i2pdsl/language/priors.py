"""Priors that are told latent by latent: `prior(rho) = {-1: 0.2, 1: 0.5, others: 0.3}`.

Hypotheses fall into groups in which the same characters are rational and the same latents play a
part. Within each group every latent that is told, and is free there, gets its shares; how probable
a group is does not change, unless it is told who is rational. Of all such priors it is the one that
is closest to what is believed otherwise (iterative proportional fitting: Deming and Stephan 1940,
DOI 10.1214/aoms/1177731829).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from i2pdsl.language.vocabulary import Value

Shares: TypeAlias = "Mapping[str, Mapping[Value, float]]"
"""latent -> value -> weight; what is left out has none."""

_ROUNDS, _NEAR = 2000, 1e-9


def fitted(
    rows: Sequence[Mapping[str, Value]], base: Sequence[float], shares: Shares
) -> tuple[float, ...] | None:
    """The probabilities of hypotheses, of which `base` are the weights otherwise; None where the
    shares contradict each other or what is possible at all."""
    weights = [weight / sum(base) for weight in base]
    wanted = [part for latent in shares for part in _parts(rows, weights, latent, shares[latent])]
    for part in wanted:
        if not any(share for _, share in part):  # none of the values that this group has
            for numbers, _ in part:
                for number in numbers:
                    weights[number] = 0.0
    alive = lambda part: any(weights[number] for numbers, _ in part for number in numbers)
    wanted = [part for part in wanted if alive(part)]
    for _ in range(_ROUNDS):
        furthest = 0.0
        for part in wanted:
            whole = sum(weights[number] for numbers, _ in part for number in numbers)
            if not whole > 0:
                return None
            for numbers, share in part:
                now = sum(weights[number] for number in numbers)
                furthest = max(furthest, abs(now - share * whole))
                if now > 0:
                    for number in numbers:
                        weights[number] *= share * whole / now
        total = sum(weights)
        if not total > 0:
            return None
        weights = [weight / total for weight in weights]
        if furthest <= _NEAR:
            return tuple(weights)
    return None


def _parts(
    rows: Sequence[Mapping[str, Value]],
    weights: Sequence[float],
    latent: str,
    shares: Mapping[Value, float],
) -> list[list[tuple[list[int], float]]]:
    """For each group of hypotheses in which a latent plays a part, those of each of its values,
    and which share of the group they shall have."""
    is_truth = any(isinstance(row.get(latent), bool) for row in rows)
    groups: dict[object, dict[Value, list[int]]] = {}
    for number, row in enumerate(rows):
        if latent in row:
            group = frozenset((x, v if isinstance(v, bool) else None) for x, v in row.items())
            values = groups.setdefault(None if is_truth else group, {})
            values.setdefault(row[latent], []).append(number)
    found = []
    for values in groups.values():
        left = {v: numbers for v, numbers in values.items() if any(weights[n] for n in numbers)}
        total = math.fsum(shares.get(value, 0.0) for value in left) or 1.0
        if len(values) > 1:
            found.append([(left[value], shares.get(value, 0.0) / total) for value in left])
    return found


_ALIKE = 1e-6  # of two products of weights, relative to their size


def factorises(
    rows: Sequence[Mapping[str, Value]], parts: Sequence[frozenset[str]], weights: Sequence[float]
) -> bool:
    """Whether weights of hypotheses are products: beside each value of the first part, of one
    weight for each value of every other part.

    Args:
        parts: the latents of each part.
    """
    of = lambda row, part: frozenset((x, v) for x, v in row.items() if x in part)
    groups: dict[object, dict[tuple[object, ...], float]] = {}
    for row, weight in zip(rows, weights, strict=True):
        others = tuple(of(row, part) for part in parts[1:])
        groups.setdefault(of(row, parts[0]), {})[others] = weight
    return all(map(_is_product, groups.values()))


def _is_product(cells: Mapping[tuple[object, ...], float]) -> bool:
    """Whether the numbers of some combinations are products of one for each of their values."""
    first = max(cells, key=lambda cell: cells[cell])
    if not cells[first] > 0:
        return True
    # Relative to the largest: what differs from it, or from what is known, in one value tells of
    # that value.
    known: list[dict[object, float]] = [{value: 1.0} for value in first]
    for i, values in enumerate(zip(*cells, strict=True)):
        for value in set(values):
            mine = [weight for cell, weight in cells.items() if cell[i] == value]
            if not any(mine):
                known[i][value] = 0.0
    waiting, left = dict(cells), len(cells) + 1
    while len(waiting) < left:
        left = len(waiting)
        for cell, weight in list(waiting.items()):
            unknown = [i for i, value in enumerate(cell) if value not in known[i]]
            if len(unknown) > 1 or (unknown and not weight):
                continue
            product = cells[first] * math.prod(
                known[i][value] for i, value in enumerate(cell) if i not in unknown
            )
            if unknown and product > 0:
                known[unknown[0]][cell[unknown[0]]] = weight / product
            elif unknown or abs(weight - product) > _ALIKE * max(weight, product):
                return False
            del waiting[cell]
    return not waiting
