"""The audience's belief, in logs: Bayes' rule, normalisation, forgetting (paper, section 2)."""

from __future__ import annotations

from typing import Any

Array = Any


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
    return xp.where(total > 0, xp.log(xp.where(total > 0, total, 1.0)), -xp.inf) + top[..., 0]


def update(log_belief: Array, log_likelihood: Array, forgetting: Array) -> Array:
    """One observed action: P(H | a) ~ P(a | H) P(H), then p <- p (1 - e) + (1 - p) e / (N - 1).

    Args:
        log_belief: log P(H), [..., O, H], normalised over H.
        log_likelihood: log P(a | H), broadcastable to it.
        forgetting: e for each observer, [O]; or [O, H], where some know more than others: e under
            the hypotheses that an observer thinks possible, among which he forgets, else 0.
    """
    xp = log_belief.__array_namespace__()
    joint = log_belief + log_likelihood
    log_posterior = joint - log_sum(joint)[..., None]
    each = forgetting[:, None] if forgetting.ndim == 1 else forgetting
    count: Any = log_belief.shape[-1]
    if forgetting.ndim == 2:
        count = (forgetting > 0).sum(-1, keepdims=True)
        each, count = xp.where(count > 1, each, 0.0), xp.maximum(count, 2)
    elif count == 1:
        return log_posterior
    share = each / (count - 1)
    mixed = share + (1 - each - share) * xp.exp(log_posterior)
    # Without forgetting the logs are kept exactly: exp would lose what is far below the rest.
    positive = each > 0
    return xp.where(positive, xp.log(xp.where(positive, mixed, 1.0)), log_posterior)
