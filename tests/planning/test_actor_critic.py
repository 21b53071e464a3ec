"""Short-horizon actor-critic: its pieces against plain loops, and whether it learns."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import hill_reference as reference
from hill_for_tests import BRIEFLY
from i2pdsl.planning import actor_critic, store
from i2pdsl.planning.actor_critic import Environment, Recipe, Segment, begin
from i2pdsl.planning.networks import apply_network, random_network
from i2pdsl.worlds.hill import training
from i2pdsl.worlds.hill.spec import HillSpec

SMALL = Recipe(environments=4, horizon=5, iterations=6, hidden=(8, 6), value_steps=2, value_batch=5)


def test_networks_agree_with_the_reference() -> None:
    generator = np.random.default_rng(0)
    layers = random_network(generator, (5, 7, 4, 2))
    layers = tuple((m, generator.normal(size=b.shape)) for m, b in layers)
    inputs = generator.normal(size=(5, 3))
    found = apply_network(layers, inputs)
    for column in range(3):
        expected = reference.network(
            [(m.tolist(), b.tolist()) for m, b in layers], list(inputs[:, column])
        )
        np.testing.assert_allclose(found[:, column], expected, rtol=1e-6)


def test_random_networks_are_orthogonal() -> None:
    first, second = random_network(np.random.default_rng(1), (6, 4, 9), 0.1)
    np.testing.assert_allclose(first[0] @ first[0].T, 2 * np.eye(4), atol=1e-5)
    np.testing.assert_allclose(second[0].T @ second[0], 0.01 * np.eye(4), atol=1e-6)


def test_td_lambda_is_the_mixture_of_all_n_step_returns() -> None:
    """Transcribed from the definition (Sutton and Barto 2018, equation 12.3), with ends."""
    generator = np.random.default_rng(2)
    horizon, gamma, trace = 6, 0.9, 0.7
    reward = generator.normal(size=(horizon, 2))
    value = generator.normal(size=(horizon, 2))
    done = np.zeros((horizon, 2), dtype=bool)
    done[3, 1] = True
    value[done] = 0.0

    def returns(t: int, n: int, b: int) -> float:
        total, discount = 0.0, 1.0
        for k in range(t, t + n):
            total += discount * reward[k, b]
            discount *= gamma
            if done[k, b]:
                return total
        return total + discount * value[t + n - 1, b]

    expected = np.zeros((horizon, 2))
    for b in range(2):
        for t in range(horizon):
            longest = horizon - t
            mixed = sum(
                (1 - trace) * trace ** (n - 1) * returns(t, n, b) for n in range(1, longest)
            )
            expected[t, b] = mixed + trace ** (longest - 1) * returns(t, longest, b)
    segment = Segment(jnp.zeros((horizon, 1, 2)), *map(jnp.asarray, (reward, done, value)))
    recipe = Recipe(gamma=gamma, trace=trace)
    np.testing.assert_allclose(actor_critic.td_lambda(recipe, segment), expected, atol=1e-5)


def point_mass() -> Environment:
    """A point that is paid for being near 0 and pushed where the action says."""

    def step(state: jax.Array, action: jax.Array) -> tuple[jax.Array, jax.Array, jax.Array]:
        after = state + 0.1 * jnp.tanh(action[0])
        return after, 1 - after**2, jnp.abs(after) > 3

    return Environment(lambda n: jnp.linspace(-1.0, 1.0, n), lambda s: s[None], step, 1)


def test_it_learns_to_go_where_it_is_paid() -> None:
    recipe = Recipe(
        environments=16,
        horizon=8,
        iterations=300,
        hidden=(16, 16),
        value_batch=16,
        value_scale=10.0,
        policy_rate=1e-2,
        noise=(0.1, 0.1),
    )
    environment = point_mass()
    before = begin(environment, recipe, 0)
    after, _ = BRIEFLY(environment, recipe, 300, before)
    places = jnp.linspace(-1.0, 1.0, 9)[None]
    push = np.asarray(apply_network(after.policy, places))[0]
    assert (push[:3] > 0.5).all()
    assert (push[-3:] < -0.5).all()
    worth = np.asarray(actor_critic.estimate(recipe, after.value, places))
    assert worth[4] > worth[0]
    assert worth[4] > worth[-1]


@pytest.mark.slow  # a training that is interrupted, below, is one in pieces
def test_all_of_it_is_the_same_for_the_same_seed_and_for_pieces() -> None:
    environment = point_mass()
    whole, _ = BRIEFLY(environment, SMALL, 6, begin(environment, SMALL, 3))
    half, _ = BRIEFLY(environment, SMALL, 3, begin(environment, SMALL, 3))
    both, _ = BRIEFLY(environment, SMALL, 3, half)
    for a, b in zip(jax.tree.leaves(whole), jax.tree.leaves(both), strict=True):
        np.testing.assert_allclose(a, b, atol=1e-6)


# Training the hill.


# One hill for all trainings that follow: its programs are compiled once.
SAME_HILL, SAME_LOOKER = cache(training.hill_environment), cache(training.looker)


@pytest.fixture
def quick(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("I2PDSL_CACHE", str(tmp_path))
    monkeypatch.setattr(training, "FRAMES", 12)
    monkeypatch.setattr(training, "ROLLOUTS", 6)
    monkeypatch.setattr(training, "CHUNK", 2)
    monkeypatch.setattr(training, "improve_often", BRIEFLY)
    monkeypatch.setattr(training, "hill_environment", SAME_HILL)
    monkeypatch.setattr(training, "looker", SAME_LOOKER)
    return tmp_path


def test_an_interrupted_training_goes_on_to_the_same_end(quick: Path) -> None:
    spec = HillSpec()
    whole = training.train_hill(spec, 1, quick / "whole", SMALL)
    assert whole.finished

    def report(done: int, total: int, figures: dict[str, float]) -> None:
        if done == 4:
            raise KeyboardInterrupt

    part = training.train_hill(spec, 1, quick / "part", SMALL, report=report)
    assert not part.finished
    assert part.path is not None
    rest = training.train_hill(spec, 1, quick / "rest", SMALL)
    assert rest.finished
    assert rest.controllers.about == whole.controllers.about
    for a, b in zip(
        jax.tree.leaves(whole.controllers.policy),
        jax.tree.leaves(rest.controllers.policy),
        strict=True,
    ):
        np.testing.assert_allclose(a, b, atol=1e-6)
    name = f"training-{spec.training_key}-6-seed1"
    assert store.load(name) is None, "what is finished needs no state any more"


@pytest.mark.parametrize("damage", ["cut", "other"])
def test_a_damaged_state_of_training_begins_anew(quick: Path, damage: str) -> None:
    spec = HillSpec()
    name = f"training-{spec.training_key}-6-seed1"
    store.save(name, {"numbers": np.zeros(3)})
    path = quick / "plans" / f"{name}-v{store.VERSION}.npz"
    if damage == "cut":
        path.write_bytes(path.read_bytes()[:50])
    said: list[str] = []
    done = training.train_hill(spec, 1, quick / "out", SMALL, say=said.append)
    assert done.finished
    assert said


def test_interrupted_before_anything_was_learnt_there_is_nothing_to_keep(
    quick: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(training, "improve_often", interrupted)
    with pytest.raises(KeyboardInterrupt):
        training.train_hill(HillSpec(), 1, quick / "out", SMALL)


@pytest.mark.slow
def test_the_whole_recipe_trains_controllers_that_could_ship(tmp_path: Path) -> None:
    done = training.train_hill(HillSpec(), 2, tmp_path, resume=False)
    light, heavy = done.look.climbs
    assert min(light, heavy) >= 15
    assert done.look.falls <= 0.05
    assert light > heavy
