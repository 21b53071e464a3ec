"""How a belief becomes an answer.

A viewer's probability p is placed on the slider where the log odds are bias + slope logit p (linear
in log odds: Gonzalez and Wu 1999, DOI 10.1006/cogp.1998.0710) plus logistic noise, so that people
differ most where they are unsure, in steps of RESOLUTION; or, with the lapse's probability,
anywhere. A choice among events is made with probabilities proportional to p ** slope; of two films
the one of which p says more, with odds that are those of p to the power of slope, one divided by
the other (Luce 1959, Individual Choice Behavior).
"""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp
import numpy as np
from jax.nn import log_sigmoid, logsumexp, sigmoid

from i2pdsl.fit.odds import log_odds

Array = Any

RESOLUTION = 0.01  # of a slider
_SURE = 1e-6  # no viewer is surer
SD = np.pi / np.sqrt(3)  # of the standard logistic distribution


def log_slider(answer: Array, p: Array, own: dict[str, Array]) -> Array:
    """log of the probability of a slider's position."""
    middle, width = placed(p, own), own["noise"] / SD
    half = RESOLUTION / 2
    up, down = jnp.clip(answer + half, half, 1 - half), jnp.clip(answer - half, half, 1 - half)
    # Of what lies beyond the ends there is no more than one side.
    up = jnp.where(answer > 1 - half, down + half / 2, up)
    down = jnp.where(answer < half, up - half / 2, down)
    high, low = (log_odds(up) - middle) / width, (log_odds(down) - middle) / width
    inside = log_sigmoid(high) + log_sigmoid(-low) + jnp.log(-jnp.expm1(low - high))
    at = jnp.where(answer > 1 - half, log_sigmoid(-low), inside)
    at = jnp.where(answer < half, log_sigmoid(high), at)
    anywhere = jnp.log(own["lapse"]) + np.log(RESOLUTION / (1 + RESOLUTION))
    return jnp.logaddexp(jnp.log1p(-own["lapse"]) + at, anywhere)


def slider_mean(p: Array, own: dict[str, Array]) -> Array:
    """The mean of a slider's position."""
    middle, width = placed(p, own), own["noise"] / SD
    marks = np.arange(RESOLUTION / 2, 1, RESOLUTION)
    above = sigmoid((middle[..., None] - log_odds(marks)) / width[..., None]).sum(-1) * RESOLUTION
    return (1 - own["lapse"]) * above + own["lapse"] / 2


def placed(p: Array, own: dict[str, Array]) -> Array:
    """Where a belief is placed on the slider, in log odds."""
    return own["bias"] + own["slope"] * log_odds(p, _SURE)


def log_choice(chosen: Array, p: Array, options: Array, own: dict[str, Array]) -> Array:
    """log of the probability of a choice among the first `options` of K events."""
    there = jnp.arange(p.shape[1]) < jnp.maximum(options, 1)[:, None]
    worth = own["slope"][:, None] * jnp.log(jnp.clip(p, _SURE, 1.0))
    worth = jnp.where(there, worth, -jnp.inf)
    made = jnp.take_along_axis(worth, chosen[:, None], 1)[:, 0] - logsumexp(worth, axis=1)
    anywhere = jnp.log(own["lapse"]) - jnp.log(jnp.maximum(options, 1))
    return jnp.logaddexp(jnp.log1p(-own["lapse"]) + made, anywhere)


def log_pair(first: Array | float, p: Array, own: dict[str, Array]) -> Array:
    """log of the probability that the first of two films is chosen, or the other."""
    one, other = (log_odds(p[:, k], _SURE) for k in (0, 1))
    odds = own["slope"] * (one - other) + own["apart"]
    made = log_sigmoid(jnp.where(jnp.asarray(first) > 0.5, odds, -odds))
    return jnp.logaddexp(jnp.log1p(-own["lapse"]) + made, jnp.log(own["lapse"] / 2))
