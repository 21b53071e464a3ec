"""The audience's belief, in logs: Bayes' rule, normalisation, forgetting (paper, section 2), and
goals that change.

What viewers hold hidden is a Markov chain: after each observed action they lose track of it a
little (forgetting), and whoever acted may want something else from then on (switching).
"""

from __future__ import annotations

from typing import Any, NamedTuple

Array = Any
Spread = tuple[Array, Array]

LEAST = -60.0  # log of a likelihood which, times a belief, is not 0 in single precision


def summed(weights: Array, over: Array | None = None) -> Array:
    """The sum over the last axis, of the hypotheses in a mask only: as a product of matrices,
    which compilers make more of than of a sum."""
    xp = weights.__array_namespace__()
    ones = xp.ones(weights.shape[-1:], weights.dtype)
    return weights @ (ones if over is None else xp.where(over, ones, 0))


def log_of(share: Array) -> Array:
    """The logarithm, -inf of 0."""
    xp = share.__array_namespace__()
    return xp.where(share > 0, xp.log(xp.where(share > 0, share, 1.0)), -xp.inf)


def log_sum(log_values: Array, mask: Array | None = None) -> Array:
    """log of the sum of exp over the last axis, over the hypotheses of a mask only.

    An empty mask gives -inf.
    """
    xp = log_values.__array_namespace__()
    if mask is not None:
        log_values = xp.where(mask, log_values, -xp.inf)
    top = xp.max(log_values, axis=-1, keepdims=True)
    top = xp.where(top > -xp.inf, top, 0.0)
    total = xp.sum(xp.exp(log_values - top), axis=-1)
    return log_of(total) + top[..., 0]


class Switching(NamedTuple):
    """That a character may want something else after its action: with probability g the goal is
    drawn anew from the prior, given all else, so it may be the same again (model M2 of Baker, Saxe
    and Tenenbaum 2009, DOI 10.1016/j.cognition.2009.07.005).

    Attributes:
        share: g of each observer, [O].
        members: the hypotheses of each group that differ in this goal alone, [R, M]; H where a
            group has fewer.
        group: the group of each hypothesis, [H].
        log_prior: log P(H | its group), [O, H].
    """

    share: Array
    members: Array
    group: Array
    log_prior: Array

    def given(self, log_prior: Array) -> Switching:
        """The same of viewers with such a prior, [O, H]."""
        of_group = _of_groups(log_prior, self)
        xp = log_prior.__array_namespace__()
        possible = of_group > -xp.inf
        shares = xp.where(possible, log_prior - xp.where(possible, of_group, 0.0), -xp.inf)
        return self._replace(log_prior=shares)

    def of(self, viewers: slice) -> Switching:
        """The same of some of the observers."""
        return self._replace(share=self.share[viewers], log_prior=self.log_prior[viewers])


def update(
    log_belief: Array,
    log_likelihood: Array,
    forgetting: Array,
    switching: Switching | None = None,
) -> Array:
    """One observed action: P(H | a) ~ P(a | H) P(H), and what is left of it when the next one
    comes.

    Args:
        log_belief: log P(H), [..., O, H], normalised over H.
        log_likelihood: log P(a | H), broadcastable to it.
        forgetting: e for each observer, [O]; or [O, H], where some know more than others: e under
            the hypotheses that an observer thinks possible, among which he forgets, else 0.
        switching: of who acted; None if nobody's goal changes.
    """
    joint = log_belief + log_likelihood
    xp = joint.__array_namespace__()
    top = xp.max(joint, axis=-1, keepdims=True)
    weights = xp.exp(joint - xp.where(top > -xp.inf, top, 0.0))
    total = weights.sum(-1, keepdims=True)
    # A sum of 0 is that of a belief which thinks nothing possible, and stays so.
    after = joint - (top + xp.log(xp.where(total > 0, total, 1.0)))
    return _after_chain(after, weights / total, forgetting, switching)


def updated_share(share: Array, log_likelihood: Array, forgetting: Array) -> Array:
    """`update` of a belief that is held as probabilities, [..., O, H]: for viewers who forget,
    which keeps each of them from 0, and who do not think that goals change.

    In single precision: what is less likely than LEAST is taken to be so likely.
    """
    xp = share.__array_namespace__()
    likelihood = xp.exp(xp.maximum(log_likelihood, LEAST))
    return share_after(share, likelihood, spread_of(forgetting, share.shape[-1]))


def share_after(share: Array, likelihood: Array, spread: Spread | None) -> Array:
    """`updated_share` by likelihoods, [..., O, H], which may all be so many times as large."""
    joint = share * likelihood
    belief = joint / summed(joint)[..., None]
    if spread is None:
        return belief
    each, other = spread
    return other + (1 - each - other) * belief


def later(log_belief: Array, forgetting: Array, switching: Switching | None = None) -> Array:
    """The belief after one step of the hidden chain: first p <- p (1 - e) + (1 - p) e / (N - 1),
    then p <- (1 - g) p + g P(H | its group) P(its group)."""
    xp = log_belief.__array_namespace__()
    return _after_chain(log_belief, xp.exp(log_belief), forgetting, switching)


def _after_chain(
    log_belief: Array, belief: Array, forgetting: Array, switching: Switching | None
) -> Array:
    """`later`, of a belief that is known both ways."""
    xp = log_belief.__array_namespace__()
    spread = spread_of(forgetting, log_belief.shape[-1])
    if spread is not None:
        each, share = spread
        mixed = share + (1 - each - share) * belief
        # Without forgetting the logs are kept exactly: exp would lose what is far below the rest.
        positive = each > 0
        log_belief = xp.where(positive, xp.log(xp.where(positive, mixed, 1.0)), log_belief)
    if switching is None:
        return log_belief
    drawn = switching.log_prior + _of_groups(log_belief, switching)
    return _mixed(xp, switching.share, log_belief, drawn)


def earlier(log_message: Array, forgetting: Array, switching: Switching | None = None) -> Array:
    """The transpose of `later`: log of the mean, over where a hypothesis goes in one step of the
    chain, of exp(message), [..., O, H]. What comes after tells of what was before."""
    xp = log_message.__array_namespace__()
    if switching is not None:
        drawn = _of_groups(log_message + switching.log_prior, switching)
        log_message = _mixed(xp, switching.share, log_message, drawn)
    spread = spread_of(forgetting, log_message.shape[-1])
    if spread is None:
        return log_message
    each, share = spread
    top = xp.max(log_message, axis=-1, keepdims=True)
    likely = xp.exp(log_message - top)
    mixed = (1 - each - share) * likely + (share * likely).sum(-1, keepdims=True)
    positive = each > 0
    return xp.where(positive, xp.log(xp.where(positive, mixed, 1.0)) + top, log_message)


def spread_of(forgetting: Array, hypotheses: int) -> Spread | None:
    """e, and e / (N - 1), of each observer [O, 1], or under each hypothesis [O, H]; None where
    there is nothing else to believe."""
    xp = forgetting.__array_namespace__()
    if forgetting.ndim == 1:
        each = forgetting[:, None]
        return None if hypotheses == 1 else (each, each / (hypotheses - 1))
    count = (forgetting > 0).sum(-1, keepdims=True)
    each = xp.where(count > 1, forgetting, 0.0)
    return each, each / (xp.maximum(count, 2) - 1)


def _of_groups(log_values: Array, switching: Switching) -> Array:
    """log of the sum of exp over the group of each hypothesis, [..., O, H]."""
    xp = log_values.__array_namespace__()
    none = xp.full_like(log_values[..., :1], -xp.inf)
    padded = xp.concatenate([log_values, none], axis=-1)
    return log_sum(padded[..., switching.members])[..., switching.group]


def _mixed(xp: Any, share: Array, stays: Array, drawn: Array) -> Array:
    """log((1 - g) exp(stays) + g exp(drawn)), of each observer."""
    g = share[:, None]
    return xp.where(g > 0, xp.logaddexp(log_of(1 - g) + stays, log_of(g) + drawn), stays)
