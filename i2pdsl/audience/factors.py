"""An audience that holds every hypothesis, where there are too many to be listed: by factors.

Let m be all that is hidden about the characters whom others model, and h_1, ..., h_k what is hidden
about each of the others, the i-th of whom acts by m and h_i alone. If that is so before anything
moved, then after any actions

    P(m, h_1, ..., h_k) = P(m) prod_i P(h_i | m),

since an action a of the i-th of these has

    P(m) <- P(m) sum_h P(h | m) P(a | m, h) / Z,    P(h_i | m) <- P(h_i | m) P(a | m, h_i) / Z_m,

and one of somebody who is modelled P(m) <- P(m) P(a | m) / Z (variable elimination in a tree:
Pearl, Probabilistic Reasoning in Intelligent Systems, 1988). Who forgets mixes each factor with its
own share of an even belief U over all H hypotheses that he thinks possible,

    P(m) <- (1 - e') P(m) + e' U(m),   P(h_i | m) <- (1 - e') P(h_i | m) + e' U(h_i | m),

e' = e H / (H - 1). Each of m and h_i is then forgotten as fast as `filter.update` would have
it; what is known of them together a bit faster. Without forgetting it is the same belief.

What is asked is asked of *points*: m, and of each h_i only its class, which is what expressions
tell apart (or h_i itself, where a question is about its values). NumPy and JAX arrays alike;
leading axes are free. M values of m in G classes, K values of an h_i in C classes, H rows, U
observed actions in a frame, Q problems of who acts.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import Any, NamedTuple

from i2pdsl.audience.filter import log_sum

Array = Any

LEAST = -80.0  # log of the share of a class, below which it is not 0 in single precision


class FactorTables(NamedTuple):
    """The numbers of one observer who holds factors.

    Attributes:
        common: log P(m) before anything moved, [M].
        own: log P(h_i | m), [M, K] for each i; -inf for what cannot be beside m.
        even: U(m), [M], and U(h_i | m), [M, K] each; empty where nobody forgets.
        anew: e', [].
        problems: for each observation the problem that who acts solves: [M] of who is modelled,
            else [M, K].
        columns: for each of them where the world's likelihoods have the problems, [Q].
        class_of: the class of each h_i, [K] each.
        classes: the same one-hot, [K, C] each.
        groups: the class of each m, one-hot [M, G].
        rows: the place of each row among the G x C_1 x ... x C_k combinations of classes, [H].
        row_of: the row of each point, [M, C_1, ..., C_k]; H where there is none.
    """

    common: Array
    own: tuple[Array, ...]
    even: tuple[Array, ...]
    anew: Array
    problems: tuple[Array, ...]
    columns: tuple[Array, ...]
    class_of: tuple[Array, ...]
    classes: tuple[Array, ...]
    groups: Array
    rows: Array
    row_of: Array

    @property
    def size(self) -> int:
        """How many probabilities are held."""
        return int(self.common.size + sum(own.size for own in self.own))

    def factor(self, u: int) -> int | None:
        """Which h_i the u-th observed action of a frame depends on; None where on m alone."""
        own = [n for n, problem in enumerate(self.problems) if problem.ndim == 2]
        return own.index(u) if u in own else None


class Factors(NamedTuple):
    """log P(m), [..., M], and log P(h_i | m), [..., M, K] for each i."""

    common: Array
    own: tuple[Array, ...]

    def each(self, change: Any, *others: Any) -> Factors:
        """The factors with each of their arrays changed, given the same ones of others."""
        owns = zip(self.own, *(other.own for other in others), strict=True)
        common = change(self.common, *(other.common for other in others))
        return Factors(common, tuple(change(*parts) for parts in owns))

    @property
    def remembered(self) -> Factors:
        """What questions need of them."""
        return self


def begun(tables: FactorTables) -> Factors:
    """The factors before anything moved."""
    return Factors(tables.common, tables.own)


def seen_by(tables: FactorTables, held: Factors, u: int, row: Array) -> Factors:
    """The factors once an action was observed, the u-th of a frame.

    Args:
        row: the world's log-likelihoods of it, [..., Q'].
    """
    common, own, i = held.common, list(held.own), tables.factor(u)
    likely = _of_problems(tables, u, row)
    if i is None:
        common = common + likely
    else:
        joint = own[i] + likely
        total = log_sum(joint)
        common, own[i] = common + total, joint - total[..., None]
    common = common - log_sum(common)[..., None]
    if not tables.even:
        return Factors(common, tuple(own))
    common, *own = (
        _mixed(each, even, tables.anew)
        for each, even in zip((common, *own), tables.even, strict=True)
    )
    return Factors(common, tuple(own))


def _of_problems(tables: FactorTables, u: int, values: Array) -> Array:
    """Of what is known of the problems of who acts u-th, [..., Q'], that of each m, or of each h_i
    beside it: [..., M] or [..., M, K]."""
    return values[..., tables.columns[u]][..., tables.problems[u]]


def _mixed(log_share: Array, even: Array, anew: Array) -> Array:
    xp = log_share.__array_namespace__()
    mixed = (1 - anew) * xp.exp(log_share) + anew * even
    return _log(xp, mixed)


def _log(xp: Any, share: Array) -> Array:
    """The logarithm, -inf of 0."""
    return xp.where(share > 0, xp.log(xp.where(share > 0, share, 1.0)), -xp.inf)


def _by_class(tables: FactorTables, i: int, own: Array) -> Array:
    """log of the sum over each class of [..., M, K]: [..., M, C]."""
    xp, classes = own.__array_namespace__(), tables.classes[i]
    if classes.shape[0] == classes.shape[1]:  # each is a class of its own
        return own
    top = xp.max(own, axis=-1, keepdims=True)
    share = xp.where(own > -xp.inf, xp.exp(xp.maximum(own - top, LEAST)), 0.0)
    return _log(xp, share @ classes) + top


def _points(common: Array, parts: tuple[Array, ...]) -> Array:
    """log P of each point, [..., M, X_1, ..., X_k], of parts [..., M, X_i]."""
    found = common[(..., *(None,) * len(parts))]
    for i, part in enumerate(parts):
        before, after = (None,) * i, (None,) * (len(parts) - i - 1)
        found = found + part[(..., *before, slice(None), *after)]
    return found


def _classes(tables: FactorTables, held: Factors) -> tuple[Array, ...]:
    """log P(class of h_i | m), [..., M, C] for each i."""
    return tuple(_by_class(tables, i, own) for i, own in enumerate(held.own))


def _as_rows(tables: FactorTables, held: Factors) -> Array:
    """log of the sum over the points of each row, [..., H]."""
    parts = _classes(tables, held)
    points = _points(held.common, parts)
    xp, lead = points.__array_namespace__(), points.shape[: points.ndim - len(parts) - 1]
    groups = tables.groups
    flat = points.reshape(*lead, groups.shape[0], -1)
    if groups.shape[0] != groups.shape[1]:
        top = xp.max(flat, axis=-2, keepdims=True)
        top = xp.where(top > -xp.inf, top, 0.0)
        weights = xp.where(flat > -xp.inf, xp.exp(xp.maximum(flat - top, LEAST)), 0.0)
        flat = _log(xp, groups.T @ weights) + top
    return xp.take(flat.reshape(*lead, -1), tables.rows, axis=-1)


def belief(tables: FactorTables, held: Factors) -> Array:
    """log P of each row, [..., H]."""
    return _as_rows(tables, held)


def likely(tables: FactorTables, held: Factors, u: int, row: Array) -> Array:
    """log P(what is observed u-th | row) of each row, [..., H]; for an impossible row what is
    expected without it."""
    found = _of_problems(tables, u, row)
    i = tables.factor(u)
    if i is None:
        joint = held._replace(common=held.common + found)
    else:
        own = list(held.own)
        own[i] = own[i] + found
        joint = held._replace(own=tuple(own))
    before, after = _as_rows(tables, held), _as_rows(tables, joint)
    xp = before.__array_namespace__()
    possible = before > -xp.inf
    ratio = xp.where(possible, after, 0.0) - xp.where(possible, before, 0.0)
    return xp.where(possible, ratio, log_sum(after)[..., None])


def _log_inside(points: Array, within: Array, row: Array) -> Array:
    """log P of each of the points that are in some rows [H], given that one of these holds."""
    xp = points.__array_namespace__()
    there = xp.concatenate([within, xp.zeros((1,), dtype=bool)])[row]
    held = xp.where(there, points, -xp.inf)
    flat = held.reshape(*held.shape[: held.ndim - row.ndim], -1)
    total = log_sum(flat)
    return held - total[(..., *(None,) * row.ndim)]


def mean(tables: FactorTables, held: Factors, u: int, values: Array, within: Array) -> Array:
    """The expectation of what is known of each problem of who acts u-th, [..., Q'], within some
    rows [H]: [...]."""
    xp, i = values.__array_namespace__(), tables.factor(u)
    parts = _classes(tables, held)
    weights = xp.exp(_log_inside(_points(held.common, parts), within, tables.row_of))
    count, found = len(parts), _of_problems(tables, u, values)
    if i is not None:  # the mean in each class
        share = xp.exp(_log_within(tables, i, held.own[i], parts[i]))
        found = xp.where(share > 0, share * found, 0.0) @ tables.classes[i]
    others = tuple(range(-count, 0)) if i is None else _but(count, i)
    total: Array = (weights.sum(others) * found).sum(-1)
    return total if i is None else total.sum(-1)


def _but(count: int, i: int) -> tuple[int, ...]:
    """The axes of all classes of points but those of h_i."""
    return tuple(n - count for n in range(count) if n != i)


def _log_within(tables: FactorTables, i: int, own: Array, by_class: Array) -> Array:
    """log P(h_i | m, its class), [..., M, K]; -inf where that is impossible."""
    xp = own.__array_namespace__()
    whole = xp.take(by_class, tables.class_of[i], axis=-1)
    return own - xp.where(whole > -xp.inf, whole, 0.0)


def ahead(
    tables: FactorTables, held: Factors, log_rows: tuple[Array, ...], mask: Array
) -> tuple[Array, Array]:
    """log of the probability of what is done next, [..., n_1, n_2, ...], and the belief after it,
    log P of each row [..., n_1, n_2, ..., H]. As `queries.ahead` has it of listed hypotheses.

    Args:
        log_rows: of one observer, of all problems: broadcastable to [..., n_1, n_2, ..., Q'].
        mask: the conditions, [H].
    """
    turns = (None,) * len(log_rows)
    held = Factors(
        held.common[(..., *turns, slice(None))],
        tuple(own[(..., *turns, slice(None), slice(None))] for own in held.own),
    )
    total: Any = 0.0
    for u, row in enumerate(log_rows):
        now = _as_rows(tables, held)
        seen = now + likely(tables, held, u, row)
        total = total + log_sum(seen, mask) - log_sum(now, mask)
        held = seen_by(tables, held, u, row)
    after = _as_rows(tables, held)
    xp = after.__array_namespace__()
    shape = xp.broadcast_shapes(total.shape, after.shape[:-1])
    return xp.broadcast_to(total, shape), xp.broadcast_to(after, (*shape, after.shape[-1]))


def expectation(
    tables: FactorTables,
    held: Factors,
    mask: Array,
    quantity: Callable[[Points], Array],
    whose: Collection[int],
) -> Array:
    """E[quantity | mask], of a quantity that is known of each point where the h_i of some are told
    apart: [...].

    Args:
        whose: those who act u-th, of whose problems it asks.
    """
    xp = held.common.__array_namespace__()
    told = {tables.factor(u) for u in whose}
    parts, row = [], tables.row_of
    for i, own in enumerate(held.own):
        parts.append(own if i in told else _by_class(tables, i, own))
        if i in told:
            row = xp.take(row, tables.class_of[i], axis=i + 1)
    weights = xp.exp(_log_inside(_points(held.common, tuple(parts)), mask, row))
    weights = weights.reshape(*weights.shape[: weights.ndim - row.ndim], -1)
    values = quantity(Points(tables, row))
    found: Array = (weights * xp.where(weights > 0, values, 0.0)).sum(-1)
    return found


class Points:
    """Points, to be asked what is known of them; `row` is the row of each, [M, X_1, ..., X_k]."""

    def __init__(self, tables: FactorTables, row: Array) -> None:
        self._tables, self._row = tables, row

    def of_rows(self, values: Array) -> Array:
        """Of what is known of rows, [H], each point's, [N]."""
        xp = self._row.__array_namespace__()
        return values[xp.minimum(self._row.reshape(-1), len(values) - 1)]

    def of_problems(self, who: int, values: Array) -> Array:
        """Of what is known of a character's problems, [..., Q'], each point's, [..., N]."""
        xp, i = self._row.__array_namespace__(), self._tables.factor(who)
        found = _of_problems(self._tables, who, values)
        count = self._row.ndim - 1
        if i is None:
            found = found[(..., *(None,) * count)]
        else:
            found = found[(..., *(None,) * i, slice(None), *(None,) * (count - i - 1))]
        lead = found.shape[: found.ndim - self._row.ndim]
        return xp.broadcast_to(found, (*lead, *self._row.shape)).reshape(*lead, -1)


def entropy(tables: FactorTables, held: Factors, mask: Array) -> Array:
    """The entropy of all hypotheses given a mask, in nats, [...]: that of the points, and what is
    left to know within classes."""
    parts, xp = _classes(tables, held), held.common.__array_namespace__()
    log_share = _log_inside(_points(held.common, parts), mask, tables.row_of)
    share = xp.exp(log_share)
    found = -_weighed(share, log_share).sum(tuple(range(-tables.row_of.ndim, 0)))
    for i, own in enumerate(held.own):
        inner = _log_within(tables, i, own, parts[i])
        left = -_weighed(xp.exp(inner), inner) @ tables.classes[i]
        found = found + (share.sum(_but(len(parts), i)) * left).sum((-2, -1))
    return found


def divergence(tables: FactorTables, first: Factors, second: Factors, mask: Array) -> Array:
    """KL(first || second) of all hypotheses given a mask, in nats, [...]; as `entropy`."""
    xp = first.common.__array_namespace__()
    parts, others = _classes(tables, first), _classes(tables, second)
    one, two = (
        _log_inside(_points(held.common, each), mask, tables.row_of)
        for held, each in ((first, parts), (second, others))
    )
    share = xp.exp(one)
    found = _weighed(share, _less(one, two)).sum(tuple(range(-tables.row_of.ndim, 0)))
    for i in range(len(parts)):
        inner = _log_within(tables, i, first.own[i], parts[i])
        other = _log_within(tables, i, second.own[i], others[i])
        left = _weighed(xp.exp(inner), _less(inner, other)) @ tables.classes[i]
        found = found + (share.sum(_but(len(parts), i)) * left).sum((-2, -1))
    return found


def _less(log_value: Array, other: Array) -> Array:
    """The difference of two logarithms, 0 where both are -inf."""
    xp = log_value.__array_namespace__()
    possible = log_value > -xp.inf
    return xp.where(possible, log_value, 0.0) - xp.where(possible, other, 0.0)


def _weighed(weights: Array, values: Array) -> Array:
    """weights * values, 0 where the weight is 0."""
    xp = weights.__array_namespace__()
    return weights * xp.where(weights > 0, values, 0.0)
