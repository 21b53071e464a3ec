"""Gradients of beliefs by all velocities, against finite differences, and where they could fail."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from i2pdsl.audience.filter import update
from plane_for_tests import DESK, PAIR, WALLED, build_plane, wandered


def total_belief(world, tables, start):
    """The sum over frames of the belief in the first hypothesis, as a function of all actions."""

    def loss(actions):
        def frame(carry, action):
            state, belief = carry
            after = world.transition(tables, state, action)
            for row in world.log_rows(tables, state, action, after):
                belief = update(belief, row, world.forgetting(tables))
            return (after, belief), jnp.exp(belief[0, 0])

        begun = (start, world.log_prior(tables))
        return jax.lax.scan(frame, begun, actions)[1].sum()

    return loss


@pytest.mark.parametrize("observer", ["step", "path"])
@pytest.mark.parametrize("spec", [DESK, PAIR, WALLED])
def test_gradients_are_those_of_finite_differences(spec, observer):
    with jax.enable_x64(True):
        world = build_plane(spec.with_settings({"observer": observer, "beta": 2.0}))
        tables = jax.tree.map(jnp.asarray, world.tables)
        start = jnp.asarray(world.starts()[0])
        _, actions = wandered(world, 8, spread=0.4)
        run = jax.jit(total_belief(world, tables, start))
        gradient = jax.jit(jax.grad(run))(jnp.asarray(actions))
        generator = np.random.default_rng(0)
        for _ in range(4):
            way = generator.normal(size=actions.shape)
            step = 1e-6
            slope = (run(actions + step * way) - run(actions - step * way)) / (2 * step)
            assert float((gradient * way).sum()) == pytest.approx(float(slope), rel=1e-3, abs=1e-6)


@pytest.mark.parametrize("spec", [DESK, PAIR, WALLED])
@pytest.mark.parametrize("observer", ["step", "path"])
def test_gradients_are_finite_where_nothing_moves_or_everything_touches(spec, observer):
    world = build_plane(spec.with_settings({"observer": observer}))
    count = world.cast.count
    at_goal = np.concatenate([np.array(spec.places[0].at), [4.0, 6.4]])[: 2 * count]
    touching = np.array([6.0, 5.6, 6.0, 4.7])[: 2 * count]
    for places in (world.starts()[0][: 2 * count], at_goal, touching):
        start = jnp.asarray(np.concatenate([places, 0 * places]), jnp.float32)
        loss = total_belief(world, world.search_tables, start)
        for actions in (np.zeros((3, 2 * count)), np.full((3, 2 * count), 5.0)):
            gradient = jax.grad(loss)(jnp.asarray(actions, jnp.float32))
            assert np.isfinite(gradient).all()


@pytest.mark.parametrize("spec", [DESK, PAIR, WALLED])
def test_single_precision_believes_the_same(spec):
    world = build_plane(spec)
    states, actions = wandered(world, 20, spread=0.5)
    exact = world.log_rows(world.tables, states[:-1], actions, states[1:])
    single = world.log_rows(
        world.search_tables,
        *(jnp.asarray(a, jnp.float32) for a in (states[:-1], actions, states[1:])),
    )
    for a, b in zip(exact, single, strict=True):
        assert np.allclose(a, b, atol=5e-3)
