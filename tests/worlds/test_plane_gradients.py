"""Gradients of beliefs, regrets and stillness by all velocities, against finite differences, and
where they could fail."""

from functools import cache

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from i2pdsl.objective.belief import first_belief
from i2pdsl.objective.film import seen
from i2pdsl.objective.frame import observe
from i2pdsl.programs import BRIEF
from plane_for_tests import DESK, PAIR, WALLED, build_plane, wandered

FRAMES = 6
SPECS = {spec.name: spec for spec in (DESK, PAIR, WALLED)}
LONG = [  # take long to compile
    pytest.param(*case, marks=pytest.mark.slow) for case in (("pair", "path"), ("walled", "step"))
]
CASES = [("desk", "step"), ("desk", "path"), *LONG]


@cache
def believing(name, observer):
    """A world, and the sum over frames of the belief in its first hypothesis, of the regret and of
    stillness with its gradient, as a compiled function of the start and of all actions, in
    doubles."""
    world = build_plane(SPECS[name].with_settings({"observer": observer, "beta": 2.0}))

    def total(start, actions):
        tables = jax.tree.map(jnp.asarray, world.tables)

        def frame(carry, action):
            state, belief = carry
            now = observe(world, tables, jnp.int32(1), state, action, belief)
            film = seen(world, tables, now, None)
            total = jnp.exp(now.log_belief[0, 0]) + film.regret + film.still
            return (now.state, now.belief), total

        return jax.lax.scan(frame, (start, first_belief(world, tables)), actions)[1].sum()

    return world, jax.jit(jax.value_and_grad(total, argnums=1), compiler_options=BRIEF)


@pytest.mark.parametrize(("name", "observer"), CASES)
def test_gradients_are_those_of_finite_differences(name, observer):
    with jax.enable_x64(True):
        world, run = believing(name, observer)
        start = world.starts()[0]
        _, actions = wandered(world, FRAMES, spread=0.4)
        gradient = np.asarray(run(start, actions)[1])
        generator = np.random.default_rng(0)
        for _ in range(6):
            way = generator.normal(size=actions.shape)
            ahead, behind = (float(run(start, actions + step * way)[0]) for step in (1e-6, -1e-6))
            slope = (ahead - behind) / 2e-6
            assert (gradient * way).sum() == pytest.approx(slope, rel=1e-3, abs=1e-6)


@pytest.mark.parametrize(("name", "observer"), CASES)
def test_gradients_are_finite_where_nothing_moves_or_everything_touches(name, observer):
    with jax.enable_x64(True):
        world, run = believing(name, observer)
        count = world.cast.count
        at_goal = np.concatenate([world.tables.places[0], [4.0, 6.4]])[: 2 * count]
        touching = np.array([6.0, 5.6, 6.0, 4.7])[: 2 * count]
        for places in (world.starts()[0][: 2 * count], at_goal, touching):
            start = np.concatenate([places, 0 * places])
            for speed in (0.0, 5.0):
                value, gradient = run(start, np.full((FRAMES, 2 * count), speed))
                assert np.isfinite(value)
                assert np.isfinite(gradient).all()


@pytest.mark.parametrize("name", list(SPECS))
def test_single_precision_believes_the_same(name):
    world = build_plane(SPECS[name])
    states, actions = wandered(world, 20, spread=0.5)
    frames = (states[:-1], actions, states[1:])
    exact = world.log_rows(world.tables, *frames)
    rows = jax.jit(world.log_rows, compiler_options=BRIEF)
    single = rows(world.search_tables, *(jnp.asarray(a, jnp.float32) for a in frames))
    for a, b in zip(exact, single, strict=True):
        assert np.allclose(a, b, atol=5e-3)
