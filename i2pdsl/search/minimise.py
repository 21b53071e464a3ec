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
Loss = Callable[[Array], tuple[Array, Any]]

WORST = 1e30  # stands for a loss that is not finite: even that of the first point counts


def minimise(
    loss: Loss, start: Array, optimiser: str, steps: int, rate: float, bound: float | None
) -> tuple[Array, Any, Array]:
    """The best point that a minimiser saw, what the loss said of it, and how many gradients were
    seen not to be finite.

    Args:
        loss: of one array, with a tree of arrays that comes along; finite, or NaN and infinite
            where it means nothing.
        optimiser: adam, lbfgs or ncg (nonlinear conjugate gradients), for a free variable.
        steps: of the optimiser.
        rate: of adam.
        bound: each number stays within [-bound, bound]; None for a free variable.
    """

    def safe(point: Array) -> tuple[Array, Any]:
        value, along = loss(point)
        return jnp.where(jnp.isfinite(value), value, WORST), along

    if bound is not None:
        return _in_box(safe, start, steps, bound)
    return _free(safe, start, optimiser, steps, rate)


def _free(
    loss: Loss, start: Array, optimiser: str, steps: int, rate: float
) -> tuple[Array, Any, Array]:
    """By optimistix. Its tolerances are 0, so that all steps are taken."""
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
        lambda point, _: loss(point),
        optimistix.BestSoFarMinimiser(solver),
        start,
        has_aux=True,
        max_steps=steps + 1,
        throw=False,
    )
    end = found.state.state
    if optimiser == "adam":
        return found.value, found.aux, end.opt_state.total_notfinite
    # Where a gradient is not finite, these stop: it is the last one that they took.
    return found.value, found.aux, (~jnp.isfinite(end.f_info.grad).all()).astype(jnp.int32)


def _in_box(loss: Loss, start: Array, steps: int, bound: float) -> tuple[Array, Any, Array]:
    """By jaxopt, which is no longer maintained: optimistix has nothing for boxes yet.

    Its steps can lead uphill, so that the best point is kept here.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        import jaxopt
        from jaxopt.projection import projection_box

    solver = jaxopt.ProjectedGradient(
        fun=lambda point: loss(point)[0],
        projection=projection_box,
        maxiter=steps,
        maxls=6,
        tol=0.0,
        implicit_diff=False,
    )
    limits = (jnp.full_like(start, -bound), jnp.full_like(start, bound))
    start = jnp.clip(start, *limits)

    def step(carry: Any, _: None) -> tuple[Any, None]:
        point, state, *best = carry
        point, state = solver.update(point, state, hyperparams_proj=limits)
        value, along = loss(point)
        now = (point, value, along)
        best = jax.tree.map(lambda a, b: jnp.where(value < best[1], a, b), now, tuple(best))
        return (point, state, *best), None

    state = solver.init_state(start, hyperparams_proj=limits)
    (value, along), gradient = jax.value_and_grad(loss, has_aux=True)(start)
    carry = (start, state, start, value, along)
    (_, _, best, _, along), _ = jax.lax.scan(step, carry, None, length=steps)
    return best, along, (~jnp.isfinite(gradient).all()).astype(jnp.int32)
