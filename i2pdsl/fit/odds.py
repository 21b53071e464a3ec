"""Log odds, and sums over what is normal: of arrays of NumPy and of JAX."""

from __future__ import annotations

from typing import Any

import numpy as np

Array = Any


def log_odds(p: Array, surest: float = 0.0) -> Array:
    """Of probabilities, none of which counts as nearer to 0 or 1 than `surest`."""
    xp = p.__array_namespace__()
    p = xp.clip(p, surest, 1 - surest) if surest else p
    return xp.log(p) - xp.log1p(-p)


def logistic(x: Array) -> Array:
    """The inverse of log odds."""
    return 0.5 * (1 + x.__array_namespace__().tanh(x / 2))


def normal_points(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Places and weights of Gauss-Hermite quadrature over a standard normal, [count] each: the
    mean of f is about sum(weights * f(places))."""
    places, weights = np.polynomial.hermite_e.hermegauss(count)
    return places, weights / weights.sum()
