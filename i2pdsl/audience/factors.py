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

e' = e H / (H - 1). Each of m and h_i is then forgotten as fast as `filter.update` would have it;
what is known of them together a bit faster. Without forgetting it is the same belief, but for a
share of LEAST that is forgotten all the same, so that no factor gets too improbable to be held.
Products of factors may be: they are taken in logs, which takes longer, where too little is
forgotten for them to be held (FactorTables.doubts).

What is asked is asked of *points*: m, and of each h_i only its class, which is what expressions
tell apart (or h_i itself, where a question is about its values). NumPy and JAX arrays alike;
leading axes are free. M values of m in G classes, K values of an h_i in C classes, H rows, U
observed actions in a frame, Q problems of who acts.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Collection
from typing import Any, NamedTuple

from i2pdsl.audience.filter import log_of, log_sum

Array = Any

LEAST = {"float32": 1e-30, "float64": 1e-200}  # of a factor, whoever forgets however little
UNLIKELY = {"float32": -60.0, "float64": -600.0}  # log of the probability that any action has


class Factors(NamedTuple):
    """P(m), [..., M], and P(h_i | m), [..., M, K] for each i."""

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


class FactorTables(NamedTuple):
    """The numbers of one observer who holds factors.

    Attributes:
        common: P(m) before anything moved, [M].
        own: P(h_i | m), [M, K] for each i; 0 of what cannot be beside m.
        even: U(m), [M], and U(h_i | m), [M, K] each.
        anew: e', [].
        problems: for each observation the problem that who acts solves: [M] of who is modelled,
            else [M, K].
        columns: for each of them where the world's likelihoods have the problems, [Q].
        class_of: the class of each h_i, [K] each.
        classes: the same one-hot, [K, C] each.
        groups: the class of each m, one-hot [M, G].
        members: the m of each class, [G, L]; M where there are fewer.
        rows: the place of each row among the C_1 x ... x C_k x G combinations of classes, [H].
        row_of: the row of each point, [C_1, ..., C_k, M]; H where there is none.
    """

    common: Array
    own: tuple[Array, ...]
    even: Factors
    anew: Array
    problems: tuple[Array, ...]
    columns: tuple[Array, ...]
    class_of: tuple[Array, ...]
    classes: tuple[Array, ...]
    groups: Array
    members: Array
    rows: Array
    row_of: Array

    @property
    def size(self) -> int:
        """How many probabilities are held."""
        return int(self.common.size + sum(own.size for own in self.own))

    @property
    def doubts(self) -> bool:
        """Whether everything is forgotten so fast that, in single precision, no hypothesis gets too
        improbable: of H or fewer, each is as probable as (e' to the power of k + 1) / H."""
        most = self.common.size * math.prod(own.shape[-1] for own in self.own)
        return bool(self.anew ** (1 + len(self.own)) / most >= LEAST["float32"])

    def points(self, told: Collection[int | None]) -> int:
        """How many a question looks at that tells all h_i of some apart."""
        sizes = zip(self.class_of, self.row_of.shape, strict=False)
        each = [len(own) if i in told else classes for i, (own, classes) in enumerate(sizes)]
        return self.common.shape[-1] * math.prod(each)

    def factor(self, u: int) -> int | None:
        """Which h_i the u-th observed action of a frame depends on; None where on m alone."""
        own = [n for n, problem in enumerate(self.problems) if problem.ndim == 2]
        return own.index(u) if u in own else None


def begun(tables: FactorTables) -> Factors:
    """The factors before anything moved."""
    return Factors(tables.common, tables.own)


def seen_by(tables: FactorTables, held: Factors, u: int, row: Array) -> Factors:
    """The factors once an action was observed, the u-th of a frame.

    Args:
        row: the world's log-likelihoods of it, [..., Q'].
    """
    xp = row.__array_namespace__()
    joint, anew = _joint(tables, held, u, row), xp.maximum(tables.anew, LEAST[str(row.dtype)])
    common, own, i = joint.common, list(joint.own), tables.factor(u)
    if i is not None:
        total = own[i].sum(-1)
        common, own[i] = common * total, own[i] / total[..., None]
    common = common / common.sum(-1, keepdims=True)
    mixed = lambda share, even: (1 - anew) * share + anew * even
    return Factors(common, tuple(own)).each(mixed, tables.even)


def _joint(tables: FactorTables, held: Factors, u: int, row: Array) -> Factors:
    """The factors, not normalised, together with what was observed u-th."""
    likely, i = _probability(tables, u, row), tables.factor(u)
    if i is None:
        return held._replace(common=held.common * likely)
    own = list(held.own)
    own[i] = own[i] * likely
    return held._replace(own=tuple(own))


def _probability(tables: FactorTables, u: int, row: Array) -> Array:
    """P of what was observed u-th of each m, or of each h_i beside it: [..., M] or [..., M, K]."""
    xp = row.__array_namespace__()
    return xp.exp(xp.maximum(_of_problems(tables, u, row), UNLIKELY[str(row.dtype)]))


def _of_points(tables: FactorTables, held: Factors, u: int, row: Array) -> Array:
    """P of what was observed u-th of each point, broadcastable to [..., C_1, ..., C_k, M]. It is
    not a quotient of two products: these may be too small to be held where it is not."""
    likely, i, count = _probability(tables, u, row), tables.factor(u), len(held.own)
    if i is None:
        return likely[(..., *(None,) * count, slice(None))]
    inner = _within(tables, i, held.own[i], _by_class(tables, i, held.own[i]))
    return _along(_by_class(tables, i, inner * likely), i, count)


def _of_problems(tables: FactorTables, u: int, values: Array) -> Array:
    """Of what is known of the problems of who acts u-th, [..., Q'], that of each m, or of each h_i
    beside it: [..., M] or [..., M, K]."""
    return values[..., tables.columns[u]][..., tables.problems[u]]


def _by_class(tables: FactorTables, i: int, own: Array) -> Array:
    """The sum over each class of [..., M, K]: [..., M, C]."""
    classes = tables.classes[i]
    return own if classes.shape[0] == classes.shape[1] else own @ classes


def _classes(tables: FactorTables, held: Factors) -> tuple[Array, ...]:
    """P(class of h_i | m), [..., M, C] for each i."""
    return tuple(_by_class(tables, i, own) for i, own in enumerate(held.own))


def _products(common: Array, parts: tuple[Array, ...]) -> Array:
    """P of each point, [..., X_1, ..., X_k, M], of parts [..., M, X_i]."""
    return _joined(operator.mul, common, parts)


def _points(common: Array, parts: tuple[Array, ...]) -> Array:
    """log P of each point, [..., X_1, ..., X_k, M], of parts [..., M, X_i]."""
    return _joined(operator.add, log_of(common), tuple(map(log_of, parts)))


def _joined(
    join: Callable[[Array, Array], Array], common: Array, parts: tuple[Array, ...]
) -> Array:
    """What is known of each point, of what is known of m, [..., M], and of each part beside it."""
    found = common[(..., *(None,) * len(parts), slice(None))]
    for i, part in enumerate(parts):
        found = join(found, _along(part, i, len(parts)))
    return found


def _along(part: Array, i: int, count: int) -> Array:
    """What is known of each m and h_i, [..., M, X_i], with an axis for each of `count` of these."""
    swapped = part.__array_namespace__().swapaxes(part, -1, -2)
    before, after = (None,) * i, (None,) * (count - i - 1)
    return swapped[(..., *before, slice(None), *after, slice(None))]


def belief(tables: FactorTables, held: Factors) -> Array:
    """P of each row, the sum over its points: [..., H]."""
    points = _products(held.common, _classes(tables, held))
    lead = points.shape[: points.ndim - tables.row_of.ndim]
    groups, flat = tables.groups, points.reshape(*lead, -1, len(tables.groups))
    if groups.shape[0] != groups.shape[1]:
        flat = flat @ groups
    return points.__array_namespace__().take(flat.reshape(*lead, -1), tables.rows, axis=-1)


def log_belief(tables: FactorTables, held: Factors) -> Array:
    """The logarithm of it, also where it is too improbable for a number, [..., H]."""
    return _rows(tables, _points(held.common, _classes(tables, held)))


def _rows(tables: FactorTables, points: Array) -> Array:
    """log P of each row, [..., H], of that of points."""
    xp = points.__array_namespace__()
    lead, count = points.shape[: points.ndim - tables.row_of.ndim], points.shape[-1]
    if tables.members.shape != (count, 1):
        nothing = xp.full((*points.shape[:-1], 1), -xp.inf, points.dtype)
        padded = xp.concatenate([points, nothing], axis=-1)
        points = log_sum(xp.take(padded, tables.members, axis=-1))
    return xp.take(points.reshape(*lead, -1), tables.rows, axis=-1)


def likely(tables: FactorTables, held: Factors, u: int, row: Array, doubts: bool = False) -> Array:
    """log P(what is observed u-th | row) of each row, [..., H]; of an impossible one what is
    expected without it.

    Args:
        doubts: whether no row is too improbable to be held.
    """
    if doubts:
        of = belief(tables, held), belief(tables, _joint(tables, held, u, row))
        xp, there = row.__array_namespace__(), of[0] > 0
        ratio = xp.where(there, of[1], 0.0) / xp.where(there, of[0], 1.0)
        return log_of(xp.where(there, ratio, of[1].sum(-1, keepdims=True)))
    points, each = _points(held.common, _classes(tables, held)), _of_points(tables, held, u, row)
    xp, joint = points.__array_namespace__(), points + log_of(each)
    before, after = _rows(tables, points), _rows(tables, joint)
    possible = before > -xp.inf
    ratio = xp.where(possible, after, 0.0) - xp.where(possible, before, 0.0)
    expected = log_sum(joint.reshape(*joint.shape[: joint.ndim - tables.row_of.ndim], -1))
    return xp.where(possible, ratio, expected[..., None])


def _inside(points: Array, within: Array, row: Array) -> Array:
    """log P of each of the points that are in some rows [H], given that one of these holds."""
    xp = points.__array_namespace__()
    held = xp.where(_are_in(within, row), points, -xp.inf)
    total = log_sum(held.reshape(*held.shape[: held.ndim - row.ndim], -1))
    return held - total[(..., *(None,) * row.ndim)]


def _are_in(within: Array, row: Array) -> Array:
    """Which points are in some rows [H]: those that are none are not."""
    xp = within.__array_namespace__()
    return xp.concatenate([within, xp.zeros((1,), dtype=bool)])[row]


def mean(
    tables: FactorTables,
    held: Factors,
    u: int,
    values: Array,
    within: Array,
    doubts: bool = False,
) -> Array:
    """The expectation of what is known of each problem of who acts u-th, [..., Q'], within some
    rows [H]: [...]; `doubts` as of `likely`."""
    xp, i = values.__array_namespace__(), tables.factor(u)
    parts, found = _classes(tables, held), _of_problems(tables, u, values)
    if doubts:
        points, row = _products(held.common, parts), tables.row_of
        points = xp.where(_are_in(within, row), points, 0.0)
        weights = points / points.sum(tuple(range(-row.ndim, 0)), keepdims=True)
    else:
        weights = xp.exp(_inside(_points(held.common, parts), within, tables.row_of))
    if i is None:
        return (weights.sum(_but(len(parts))) * found).sum(-1)
    inner = _within(tables, i, held.own[i], parts[i])
    in_class = xp.where(inner > 0, inner * found, 0.0) @ tables.classes[i]
    return (weights.sum(_but(len(parts), i)) * xp.swapaxes(in_class, -1, -2)).sum((-2, -1))


def _but(count: int, i: int | None = None) -> tuple[int, ...]:
    """The axes of all classes of points, or of all but those of h_i."""
    return tuple(n - count - 1 for n in range(count) if n != i)


def _within(tables: FactorTables, i: int, own: Array, by_class: Array) -> Array:
    """P(h_i | m, its class), [..., M, K]; 0 where that is impossible."""
    xp = own.__array_namespace__()
    whole = xp.take(by_class, tables.class_of[i], axis=-1)
    return xp.where(whole > 0, own / xp.where(whole > 0, whole, 1.0), 0.0)


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
    xp = mask.__array_namespace__()
    total: Any = 0.0
    for u, row in enumerate(log_rows):
        inside = _inside(_points(held.common, _classes(tables, held)), mask, tables.row_of)
        found = xp.exp(inside) * _of_points(tables, held, u, row)
        total = total + log_of(found.sum(tuple(range(-tables.row_of.ndim, 0))))
        held = seen_by(tables, held, u, row)
    after = log_belief(tables, held)
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
            row = xp.take(row, tables.class_of[i], axis=i)
    weights = xp.exp(_inside(_points(held.common, tuple(parts)), mask, row))
    weights = weights.reshape(*weights.shape[: weights.ndim - row.ndim], -1)
    values = quantity(Points(tables, row))
    found: Array = (weights * xp.where(weights > 0, values, 0.0)).sum(-1)
    return found


class Points:
    """Points, to be asked what is known of them; `row` is the row of each, [X_1, ..., X_k, M]."""

    def __init__(self, tables: FactorTables, row: Array) -> None:
        self._tables, self._row = tables, row

    def of_rows(self, values: Array) -> Array:
        """Of what is known of rows, [H], each point's, [N]."""
        xp = self._row.__array_namespace__()
        return values[xp.minimum(self._row.reshape(-1), len(values) - 1)]

    def of_problems(self, who: int, values: Array) -> Array:
        """Of what is known of a character's problems, [..., Q'], each point's, [..., N]."""
        xp, i = self._row.__array_namespace__(), self._tables.factor(who)
        found, count = _of_problems(self._tables, who, values), self._row.ndim - 1
        if i is None:
            found = found[(..., *(None,) * count, slice(None))]
        else:
            found = _along(found, i, count)
        lead = found.shape[: found.ndim - self._row.ndim]
        return xp.broadcast_to(found, (*lead, *self._row.shape)).reshape(*lead, -1)


def entropy(tables: FactorTables, held: Factors, mask: Array) -> Array:
    """The entropy of all hypotheses given a mask, in nats, [...]: that of the points, and what is
    left to know within classes."""
    return -_expected_log(tables, held, held, mask)


def divergence(tables: FactorTables, first: Factors, second: Factors, mask: Array) -> Array:
    """KL(first || second) of all hypotheses given a mask, in nats, [...]; as `entropy`."""
    own = _expected_log(tables, first, first, mask)
    return own - _expected_log(tables, first, second, mask)


def _expected_log(tables: FactorTables, held: Factors, other: Factors, mask: Array) -> Array:
    """E[log P(hypothesis | mask)] of another belief, [...]."""
    parts, others = _classes(tables, held), _classes(tables, other)
    log_share, log_other = (
        _inside(_points(each.common, classes), mask, tables.row_of)
        for each, classes in ((held, parts), (other, others))
    )
    xp = log_share.__array_namespace__()
    share = xp.exp(log_share)
    each = share * xp.where(share > 0, log_other, 0.0)
    found = each.sum(tuple(range(-tables.row_of.ndim, 0)))
    for i in range(len(parts)):
        inner = _within(tables, i, held.own[i], parts[i])
        left = _times_log(inner, _within(tables, i, other.own[i], others[i])) @ tables.classes[i]
        swapped = xp.swapaxes(left, -1, -2)
        found = found + (share.sum(_but(len(parts), i)) * swapped).sum((-2, -1))
    return found


def _times_log(weights: Array, of: Array) -> Array:
    """weights * log(of), 0 where the weight is 0."""
    xp = weights.__array_namespace__()
    return weights * xp.log(xp.where(weights > 0, of, 1.0))
