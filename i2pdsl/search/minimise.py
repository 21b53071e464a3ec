"""Gradient-based minimisers behind one function: optimistix where a variable is free, jaxopt
where it lies in a box."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import optax
import optimistix

Array = Any
Loss = Callable[[Array], Array]


def minimise(
    loss: Loss, start: Array, optimiser: str, steps: int, rate: float, bound: float | None
) -> tuple[Array, Array]:
    """The best point that a minimiser saw, and how many gradients were seen not to be finite.

    Args:
        loss: of one array; finite, or NaN and infinite where it means nothing.
        optimiser: adam, lbfgs or ncg (nonlinear conjugate gradients), for a free variable.
        steps: of the optimiser.
        rate: of adam.
        bound: each number stays within [-bound, bound]; None for a free variable.
    """
    if bound is not None:
        return _in_box(loss, start, steps, bound)
    return _free(loss, start, optimiser, steps, rate)


def _free(loss: Loss, start: Array, optimiser: str, steps: int, rate: float) -> tuple[Array, Array]:
    """By optimistix. Its tolerances are 0, so that all steps are taken."""

    def safe(point: Array, _: None) -> Array:
        value = loss(point)
        return jnp.where(jnp.isfinite(value), value, jnp.inf)

    solver: Any
    if optimiser == "adam":
        guarded = optax.apply_if_finite(optax.adam(rate), max_consecutive_errors=steps)
        solver = optimistix.OptaxMinimiser(guarded, rtol=0.0, atol=0.0)
    elif optimiser == "lbfgs":
        solver = optimistix.LBFGS(rtol=0.0, atol=0.0)
    else:
        solver = optimistix.NonlinearCG(rtol=0.0, atol=0.0)
    # The last point is judged too, which takes a step more.
    found: Any = optimistix.minimise(
        safe, optimistix.BestSoFarMinimiser(solver), start, max_steps=steps + 1, throw=False
    )
    if optimiser == "adam":
        return found.value, found.state.state.opt_state.total_notfinite
    return found.value, _spoilt(loss, start)


def _spoilt(loss: Loss, start: Array) -> Array:
    """1 where the first gradient is not finite, and no step can be taken."""
    return (~jnp.isfinite(jax.grad(loss)(start)).all()).astype(jnp.int32)


def _in_box(loss: Loss, start: Array, steps: int, bound: float) -> tuple[Array, Array]:
    """By jaxopt, which is no longer maintained: optimistix has nothing for boxes yet.

    Its steps can lead uphill, so that the best point is kept here.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        import jaxopt
        from jaxopt.projection import projection_box

    def safe(point: Array) -> Array:
        value = loss(point)
        return jnp.where(jnp.isfinite(value), value, 1e30)

    solver = jaxopt.ProjectedGradient(
        fun=safe, projection=projection_box, maxiter=steps, maxls=6, tol=0.0, implicit_diff=False
    )
    limits = (jnp.full_like(start, -bound), jnp.full_like(start, bound))
    start = jnp.clip(start, *limits)

    def step(carry: Any, _: None) -> tuple[Any, None]:
        point, state, best, least = carry
        point, state = solver.update(point, state, hyperparams_proj=limits)
        value = safe(point)
        better = value < least
        best = jnp.where(better, point, best)
        return (point, state, best, jnp.where(better, value, least)), None

    state = solver.init_state(start, hyperparams_proj=limits)
    carry = (start, state, start, safe(start))
    (_, _, best, _), _ = jax.lax.scan(step, carry, None, length=steps)
    return best, _spoilt(loss, start)
