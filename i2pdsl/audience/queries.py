"""What can be asked of a belief. [O, H] log-beliefs in, one number out: the observers' mean.

All functions accept leading axes (time, candidates). A mask [H] holds the conditions; the
functions never see a mask that no hypothesis fulfils (the checker refuses it). A `share` is the
belief as probabilities, where none is too small for them: it saves the exponentials; or, as a
product, most of the sums.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from i2pdsl.audience.filter import Switching, log_sum, summed, update
from i2pdsl.audience.product import Product, multiplied

Array = Any

LEAST = 2e-6  # of the belief of who holds particles: below, none need be there (particles.FLOOR)


Share = Array | Product


def _namespace(array: Array) -> Any:
    return array.__array_namespace__()


def probability(log_belief: Array, event: Array, mask: Array, share: Share | None = None) -> Array:
    """P(event | mask) = P(event and mask) / P(mask), [...]."""
    if share is not None:
        return (_within(share, event & mask) / _within(share, mask)).mean(-1)
    xp = _namespace(log_belief)
    if xp is np:  # what is left out is known, and need not be read
        held = log_belief.compress(mask, axis=-1)
        weights = np.exp(held - held.max(-1, keepdims=True))
        within = weights.compress(event[mask], axis=-1)
        return (within.sum(-1) / weights.sum(-1)).mean(-1)
    return xp.where(event, conditioned(log_belief, mask), 0.0).sum(-1).mean(-1)


def conditioned(log_belief: Array, mask: Array, share: Share | None = None) -> Array:
    """The belief given a mask: probabilities [..., O, H], 0 outside the mask."""
    xp = _namespace(log_belief)
    if share is not None:
        share = multiplied(share)
        return xp.where(mask, share, 0.0) / summed(share, mask)[..., None]
    weights = _scaled(log_belief, mask)
    return weights / weights.sum(-1, keepdims=True)


def _scaled(log_belief: Array, mask: Array) -> Array:
    """P(H) within a mask, so many times as large that the largest is 1; 0 outside."""
    xp = _namespace(log_belief)
    held = xp.where(mask, log_belief, -xp.inf)
    top = xp.max(held, axis=-1, keepdims=True)
    return xp.exp(held - xp.where(top > -xp.inf, top, 0.0))


def expectation(
    log_belief: Array, quantity: Array, mask: Array, share: Share | None = None
) -> Array:
    """E[quantity | mask]; the quantity is broadcastable to [..., O, H]."""
    return each_expects(log_belief, quantity, mask, share).mean(-1)


def each_expects(
    log_belief: Array, quantity: Array, mask: Array, share: Share | None = None
) -> Array:
    """E[quantity | mask] of each observer, [..., O]; 0 of one who takes the mask for impossible:
    only what is expected of the rational is asked of such (film.py, naturalness)."""
    xp = _namespace(log_belief)
    if isinstance(share, Product) and xp.ndim(quantity) == 1:
        held, within = share.summed(xp.where(mask, quantity, 0.0)), _within(share, mask)
    elif share is not None:
        share = multiplied(share)
        held, within = summed(xp.where(mask, share * quantity, 0.0)), summed(share, mask)
    else:
        weights = _scaled(log_belief, mask)
        held, within = (weights * xp.where(mask, quantity, 0.0)).sum(-1), weights.sum(-1)
    return ratio(held, within)


def ratio(part: Array, whole: Array) -> Array:
    """What part something is of a whole, 0 of nothing."""
    return part / _namespace(whole).where(whole > 0, whole, 1.0)


def marginal(log_belief: Array, groups: Array, mask: Array, share: Share | None = None) -> Array:
    """The probability of each value of a latent; groups is one-hot [H, V]. [..., O, V]."""
    if isinstance(share, Product):
        xp, whole = _namespace(log_belief), _within(share, mask)
        each = [share.summed(xp.where(mask, groups[:, v], 0.0)) for v in range(groups.shape[1])]
        return xp.stack(each, axis=-1) / whole[..., None]
    return conditioned(log_belief, mask, share) @ groups


def _within(share: Share, mask: Array) -> Array:
    """P(mask), [..., O]."""
    if isinstance(share, Product):
        return share.summed(_namespace(share.before).where(mask, 1.0, 0.0))
    return summed(share, mask)


def _weighted_log(xp: Any, weights: Array, of: Array) -> Array:
    """weights * log(of), 0 where the weight is 0."""
    positive = weights > 0
    return xp.where(positive, weights * xp.log(xp.where(positive & (of > 0), of, 1.0)), 0.0)


def entropy(
    log_belief: Array,
    groups: Array | None,
    mask: Array,
    share: Share | None = None,
    counts: Array | None = None,
) -> Array:
    """- sum p log p in nats, of one latent's marginal or of the whole hypothesis.

    Args:
        counts: how many particles each observer holds, [O]; infinity of one who holds all
            hypotheses. Frequencies of n particles in k values have (k - 1) / 2n too little entropy,
            which is added (Miller's correction; Zhang and Grabchak 2013, DOI 10.3390/e15061999).
    """
    xp = _namespace(log_belief)
    if groups is None:
        p = conditioned(log_belief, mask, share)
    else:
        p = marginal(log_belief, groups, mask, share)
    each = -_weighted_log(xp, p, p).sum(-1)
    if counts is not None:
        within = xp.exp(log_sum(log_belief, mask))
        values = (p * within[..., None] > LEAST).sum(-1)
        possible = mask.sum() if groups is None else ((mask[:, None] * groups).sum(0) > 0).sum()
        missing = xp.maximum(values - 1, 0) / (2 * counts * xp.maximum(within, LEAST))
        # Never more than that of values which are all alike, but of what it is already.
        most = xp.maximum(xp.log(possible * 1.0), each)
        each = xp.minimum(each + missing, most)
    return each.mean(-1)


def divergence(first: Array, second: Array, groups: Array | None, mask: Array) -> Array:
    """KL(first || second) = sum p_a log(p_a / p_b) in nats."""
    xp = _namespace(first)
    if groups is None:
        p = conditioned(first, mask)
        ratio = (first - log_sum(first, mask)[..., None]) - (
            second - log_sum(second, mask)[..., None]
        )
        return xp.where(p > 0, p * xp.where(p > 0, ratio, 0.0), 0.0).sum(-1).mean(-1)
    p, q = marginal(first, groups, mask), marginal(second, groups, mask)
    held = xp.where(mask & (second > -xp.inf), 1.0, 0.0) @ groups  # 0 where all are impossible
    apart = xp.where((p > 0) & (held <= 0), xp.inf, 0.0)
    return (_weighted_log(xp, p, p) - _weighted_log(xp, p, q) + apart).sum(-1).mean(-1)


def surprise(beliefs: Array, log_rows: Array, mask: Array) -> Array:
    """- log of the product of the predictive probabilities of a frame's actions, in nats.

    Args:
        beliefs: the belief just before each observed action, [..., U, O, H].
        log_rows: log P(action | H) of each, [..., U, O, H].
    """
    predicted = log_sum(beliefs + log_rows, mask) - log_sum(beliefs, mask)
    return -predicted.sum(-2).mean(-1)


def suspense(weight: Array, belief: Array, turns: int, groups: Array, mask: Array) -> Array:
    """The variance of the belief about a latent after the next frame, summed over its values.

    The next frame is drawn from the audience's own predictions (Ely, Frankel and Kamenica 2015,
    DOI 10.1086/677350): each action from its predictive probability just before it, outcomes
    from the characters' chances.

    Args:
        weight, belief: of each next frame; see `ahead`.
        turns: how many characters act in one.
        groups: one-hot [H, V].
    """
    shares = marginal(belief, groups, mask)  # [..., n_1, n_2, ..., O, V]
    axes = tuple(range(-2 - turns, -2))
    mean = (weight[..., None] * shares).sum(axes, keepdims=True)
    spread = (shares - mean) ** 2
    return (weight[..., None] * spread).sum(axes).sum(-1).mean(-1)


def prediction(weight: Array, turns: int, who: int, actions: tuple[int, ...]) -> Array:
    """The probability of each next action of a character, as the audience predicts it: the
    mixture of the policies under all hypotheses, and over what those do who act before. [..., A].

    Args:
        weight: of each next frame; see `ahead`.
        turns: how many characters act in one.
        who: the number of the character, in the order of acting.
        actions: the action of each of the n_who branches.
    """
    xp = _namespace(weight)
    others = tuple(n - turns - 1 for n in range(turns) if n != who)
    own = weight.sum(others).mean(-1)  # [..., n_who]
    kinds = max(actions) + 1
    return own @ ((xp.asarray(actions)[:, None] == xp.arange(kinds)) * 1.0)


def ahead(
    log_belief: Array,
    log_rows: tuple[Array, ...],
    mask: Array,
    forgetting: Array,
    switching: Sequence[Switching | None],
) -> tuple[Array, Array]:
    """log of the probability of what is done next as the audience predicts it,
    [..., n_1, n_2, ..., O], and the belief after it, [..., n_1, n_2, ..., O, H].

    Args:
        log_belief: [..., O, H].
        log_rows: as in worlds' turns, broadcastable to [..., n_1, n_2, ..., O, H].
        forgetting, switching: of each observer, and of each who acts; see filter.py.
    """
    belief = log_belief[(..., *(None,) * len(log_rows), slice(None), slice(None))]
    log_weight: Any = 0.0
    for row, changes in zip(log_rows, switching, strict=True):
        predicted = log_sum(belief + row, mask) - log_sum(belief, mask)
        log_weight = log_weight + predicted
        belief = update(belief, row, forgetting, changes)
    return log_weight, belief
