"""Where a model's posterior is highest, and draws from it by NUTS (Hoffman and Gelman 2014,
arXiv:1111.4246), in pieces, so that it can be watched and interrupted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from numpyro.infer import NUTS, init_to_value

from i2pdsl.fit.model import MISFIT, Asked, Model
from i2pdsl.programs import BRIEF, LASTING, compiled, once
from i2pdsl.search.minimise import minimise

Array = Any
Report = Callable[[int, int], None]

PIECE = 20  # draws between two looks at the clock and the keyboard
STEPS = 60  # of the minimiser
FEW = 1000  # rows, of all fits and ways of planning, below which a slower program is there sooner


@dataclass(frozen=True)
class Draws:
    """Draws of every site of a model, [chains, draws, ...], and which of them diverged,
    [chains, draws]; fewer than asked for where somebody interrupted."""

    sites: dict[str, np.ndarray]
    diverging: np.ndarray
    finished: bool


def modes(model: Model, nodes: Any, asked: Asked, weights: np.ndarray) -> np.ndarray:
    """Where the posterior is highest if all people are alike and questions lie apart by MISFIT: the
    group's means and the questions' deviations, [M, D + C], of several fits at once.

    Args:
        nodes: what is seen in each fit, [M, N, ...].
        weights: of the rows in each, [M, R]; 0 for those that are left out.
    """
    own = np.array([(scale.mean, scale.sd) for scale in model.scales.values()])
    mean, sd = np.concatenate([own, np.tile((0.0, 1.0), (model.cells, 1))]).T

    def one(fit: tuple[Any, Array]) -> Array:
        seen, counted = fit

        def loss(point: Array) -> tuple[Array, None]:
            total = model.log_answers(alike(model, point), seen, asked, counted)
            return 0.5 * (((point - mean) / sd) ** 2).sum() - total, None

        return minimise(loss, jnp.asarray(mean, float), "lbfgs", STEPS, 0.0, None)[0]

    several = lambda fits: jax.lax.map(one, fits)
    size = weights.size * jax.tree.leaves(nodes)[0].shape[1]
    options = BRIEF if size < FEW else LASTING
    return np.asarray(once(several, (nodes, jnp.asarray(weights)), options=options))


def alike(model: Model, point: Array) -> dict[str, Array]:
    """The parameters of people who do not differ, from a point of `modes`, [D + C]."""
    count = len(model.scales)
    values = dict(zip(model.scales, point[:count], strict=True))
    values |= {name: jnp.broadcast_to(values[name], model.people) for name in model.differing}
    if model.cells:
        values |= {"misfit": jnp.asarray(MISFIT), "deviation": MISFIT * point[count:]}
    return values


def draw(
    model: Model,
    nodes: Any,
    asked: Asked,
    chains: int,
    warmup: int,
    draws: int,
    seed: int,
    report: Report | None = None,
) -> Draws:
    """Runs the chains, each from the mode. Ctrl-C ends it early with what was drawn.

    Raises KeyboardInterrupt while the chains still find their way.
    """
    every = np.ones((1, len(asked.answer)))
    (point,) = modes(model, jax.tree.map(lambda part: part[None], nodes), asked, every)
    count = len(model.scales)
    begin = {"mean": jnp.asarray(point[:count], float)}
    if model.cells:
        begin |= {"misfit": jnp.asarray(MISFIT), "deviation": jnp.asarray(point[count:], float)}
    if model.differing:
        begin["own"] = jnp.zeros((model.people, len(model.differing)))
    kernel = NUTS(
        model.program,
        dense_mass=[("mean",)],
        init_strategy=init_to_value(values=begin),
        max_tree_depth=8,
    )
    warmup = -(-warmup // PIECE) * PIECE
    keys = jax.random.split(jax.random.PRNGKey(seed), chains)
    arguments = (nodes, asked)
    begun = lambda key: kernel.init(key, warmup, None, arguments, {})
    state = once(lambda keys: jax.lax.map(begun, keys), keys)

    def step(state: Any, _: Any) -> tuple[Any, tuple[Any, Array]]:
        state = kernel.sample(state, arguments, {})
        return state, (state.z, state.diverging)

    # One after the other: side by side they would all wait for who takes most steps.
    chain = lambda state: jax.lax.scan(step, state, None, PIECE)
    several = jax.jit(lambda states: jax.lax.map(chain, states))
    run = compiled(several.lower(state))
    total, finished = warmup + draws, True
    found: list[tuple[dict[str, np.ndarray], np.ndarray]] = []
    try:
        for done in range(0, total, PIECE):
            state, (sites, diverging) = jax.block_until_ready(run(state))
            if done >= warmup:
                found.append((jax.tree.map(np.asarray, sites), np.asarray(diverging)))
            if report is not None:
                report(min(done + PIECE, total), total)
    except KeyboardInterrupt:
        if not found:
            raise
        finished = False
    places = kernel.postprocess_fn(arguments, {})
    drawn = {name: np.concatenate([s[name] for s, _ in found], axis=1) for name in found[0][0]}
    sites = once(jax.vmap(jax.vmap(places)), drawn)
    diverging = np.concatenate([d for _, d in found], axis=1)
    return Draws({name: np.asarray(array) for name, array in sites.items()}, diverging, finished)
