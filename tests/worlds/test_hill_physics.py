"""The simulator against an independent transcription, against energy and momentum, and its
gradients against finite differences."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import hill_reference as reference
from hill_for_tests import as_reference, from_reference
from i2pdsl.programs import BRIEF, once
from i2pdsl.worlds.hill import hopper, springs
from i2pdsl.worlds.hill.spec import HillSpec

SPEC = HillSpec()
BODY = hopper.build_body(SPEC)


def moving_states(count: int, weight: float, seed: int = 0, every: int = 7) -> list[np.ndarray]:
    """States of a rollout with random actuation: on the ground, in the air, stretched."""
    generator = np.random.default_rng(seed)
    mass = hopper.masses(SPEC, weight)
    motion = springs.motion_of(hopper.initial_state()[None])
    found = []
    for number in range(count * every):
        actuation = 1.5 * generator.normal(size=(6, 1))
        motion, _ = springs.step(BODY, mass, motion, actuation)
        if number % every == every - 1:
            found.append(springs.state_of(motion, (1,))[0])
    return found


def test_the_body_is_the_one_described() -> None:
    assert [tuple(s) for s in hopper.SPRINGS] == [tuple(s) for s in reference.SPRINGS]
    np.testing.assert_allclose(hopper.initial_state(), from_reference(reference.initial()))
    for weight in (0.1, 0.5, 0.27):
        np.testing.assert_allclose(hopper.masses(SPEC, weight), reference.masses(weight))
    np.testing.assert_allclose(BODY.friction, reference.frictions())
    lengths = [reference.REST_LENGTHS[s] for s in reference.SPRINGS]
    np.testing.assert_allclose(BODY.rest, lengths)
    stiffness = [reference.stiffness_of(s) for s in reference.SPRINGS]
    np.testing.assert_allclose(BODY.stiffness, stiffness)


@pytest.mark.parametrize("weight", [0.1, 0.5])
def test_a_frame_agrees_with_the_reference(weight: float) -> None:
    generator = np.random.default_rng(1)
    for state in moving_states(12, weight):
        actuation = 2 * generator.normal(size=6)
        motion, power = springs.step(
            BODY, hopper.masses(SPEC, weight), springs.motion_of(state[None]), actuation[:, None]
        )
        expected, expected_power = reference.step(as_reference(state), list(actuation), weight)
        found = springs.state_of(motion, (1,))[0]
        np.testing.assert_allclose(found, from_reference(expected), atol=1e-8)
        assert power[0] == pytest.approx(expected_power, abs=1e-7)
        seen = springs.observation(BODY, motion)[:, 0]
        np.testing.assert_allclose(seen, reference.observation(expected), atol=1e-8)
        assert springs.head_height(BODY, motion.position)[0] == pytest.approx(
            reference.head_height(expected)
        )
        paid = springs.reward(
            BODY, hopper.masses(SPEC, weight), motion, actuation[:, None], power, 9 / 100
        )
        assert paid[0] == pytest.approx(
            reference.reward(expected, list(actuation), expected_power, weight)
        )


def test_other_numbers_of_the_world_agree_with_the_reference() -> None:
    numbers = {
        "slope": 0.3,
        "gravity": 2.0,
        "friction": 0.7,
        "box_friction": 0.2,
        "node_mass": 8.0,
        "foot_mass": 30.0,
    }
    spec = SPEC.with_settings(numbers)
    body, mass = hopper.build_body(spec), hopper.masses(spec, 0.4)
    for state in moving_states(4, 0.5):
        motion, _ = springs.step(body, mass, springs.motion_of(state[None]), np.zeros((6, 1)))
        expected, _ = reference.step(as_reference(state), [0.0] * 6, 0.4, **numbers)
        found = springs.state_of(motion, (1,))[0]
        np.testing.assert_allclose(found, from_reference(expected), atol=1e-8)


def test_states_and_motions_are_the_same_thing() -> None:
    states = np.random.default_rng(0).normal(size=(3, 2, 76))
    motion = springs.motion_of(states)
    assert motion.position.shape == (2, 19, 6)
    np.testing.assert_array_equal(springs.state_of(motion, (3, 2)), states)


def test_a_batch_is_its_rollouts() -> None:
    states = np.stack(moving_states(5, 0.1))
    actuation = np.random.default_rng(2).normal(size=(6, 5))
    mass = hopper.masses(SPEC, 0.1)
    together, power = springs.step(BODY, mass, springs.motion_of(states), actuation)
    for i in range(5):
        alone, own = springs.step(
            BODY, mass, springs.motion_of(states[i][None]), actuation[:, i : i + 1]
        )
        np.testing.assert_allclose(together.position[..., i], alone.position[..., 0], atol=1e-12)
        assert power[i] == pytest.approx(own[0])


def test_bodies_at_rest_in_the_air_fall_freely() -> None:
    """Nothing but gravity: all nodes share one motion, y'' = -g."""
    state = hopper.initial_state()
    state[19:38] += 100
    motion = springs.motion_of(state[None])
    for _ in range(10):
        motion, _ = springs.step(BODY, hopper.masses(SPEC, 0.5), motion, np.zeros((6, 1)))
    seconds = 10 * springs.FRAME_SECONDS
    np.testing.assert_allclose(motion.velocity[1], -1.2 * seconds, atol=1e-9)
    np.testing.assert_allclose(motion.velocity[0], 0.0, atol=1e-9)
    fallen = state[19:38] - motion.position[1, :, 0]
    steps = 10 * springs.SUBSTEPS
    np.testing.assert_allclose(fallen, 1.2 * springs.DT**2 * steps * (steps + 1) / 2)


def test_without_actuation_energy_is_lost() -> None:
    """Damping, friction and a fixed floor take energy away; nothing gives any."""
    motion = springs.motion_of(moving_states(3, 0.5)[-1][None])
    energies = []
    for _ in range(200):
        motion, _ = springs.step(BODY, hopper.masses(SPEC, 0.5), motion, np.zeros((6, 1)))
        energies.append(reference.energy(as_reference(springs.state_of(motion, (1,))[0]), 0.5))
    # The integrator's own error lets it swing by a little from frame to frame.
    assert max(np.diff(energies)) < 0.02 * (max(energies) - min(energies))
    assert energies[-1] < energies[0]


def test_contact_pushes_out_of_the_slope_and_friction_never_pulls_backwards() -> None:
    state = hopper.initial_state()
    for _ in range(3):
        motion = springs.motion_of(state[None])
        motion, _ = springs.step(BODY, hopper.masses(SPEC, 0.1), motion, np.zeros((6, 1)))
        state = springs.state_of(motion, (1,))[0]
    # A hopper that slides without bound would show that friction has the wrong sign.
    for _ in range(400):
        motion, _ = springs.step(BODY, hopper.masses(SPEC, 0.1), motion, np.zeros((6, 1)))
    sine, cosine = np.sin(0.1), np.cos(0.1)
    x, y = motion.position[:, :, 0]
    assert (cosine * y - sine * x > -1.0).all()
    assert np.abs(motion.velocity).max() < 0.5


def test_springs_pull_no_harder_than_at_one_unit() -> None:
    state = hopper.initial_state()
    state[19:38] += 100
    near, far = state.copy(), state.copy()
    near[list(hopper.HOPPER)] += 1.5  # away from the box: the rope is longer than one unit more
    far[list(hopper.HOPPER)] += 6.0
    mass = hopper.masses(SPEC, 0.5)
    pulled = []
    for each in (near, far):
        motion, _ = springs._substep(
            BODY, mass[:, None], BODY.rest[:, None], springs.motion_of(each[None])
        )
        pulled.append(np.hypot(*(motion.velocity[:, hopper.HOOK, 0] + [0, 1.2 * springs.DT])))
    assert pulled[0] == pytest.approx(pulled[1], rel=1e-9)
    assert pulled[0] == pytest.approx(100 * springs.DT / 5)


def test_gradients_are_finite_differences() -> None:
    """Of where the box is after six frames, by the actuation of the first; where the motion is
    smooth, in doubles."""
    with jax.enable_x64(True):
        body = jax.tree.map(jnp.asarray, BODY)
        mass = hopper.masses(SPEC, 0.1)
        start = springs.motion_of(moving_states(9, 0.1)[-1][None])
        rest = 0.3 * np.random.default_rng(3).normal(size=(6, 6, 1))

        def climbed(actuation: jax.Array) -> jax.Array:
            frames = jnp.asarray(rest).at[0, :, 0].set(actuation)
            step = lambda motion, frame: springs.step(body, mass, motion, frame)
            motion, power = jax.lax.scan(step, start, frames)
            end = springs.ascent(0.1, start.position, motion.position, hopper.BOX)
            return end[0] + power[-1, 0]

        both = jax.jit(jax.value_and_grad(climbed), compiler_options=BRIEF)
        point = np.random.default_rng(4).normal(size=6)
        found = np.asarray(both(point)[1])
        value = lambda i, change: both(point + change * np.eye(6)[i])[0]
        expected = [(value(i, 1e-6) - value(i, -1e-6)) / 2e-6 for i in range(6)]
        np.testing.assert_allclose(found, np.array(expected), rtol=1e-4, atol=1e-7)
        assert np.abs(found).max() > 1e-6


CORNERS = [
    {"weight": weight, "slope": slope, "gravity": gravity, "node_mass": mass, "friction": friction}
    for weight in (0.1, 2.0)
    for slope in (-0.3, 0.0, 0.6)
    for gravity in (0.0, 10.0)
    for mass in (10.0, 100.0)
    for friction in (0.0, 10.0)
]


@pytest.mark.parametrize("settings", CORNERS, ids=lambda s: "-".join(f"{v:g}" for v in s.values()))
def test_what_the_settings_allow_is_stable(settings: dict[str, float]) -> None:
    """The corners of what stories may set: nothing starts below the slope, nothing blows up."""
    spec = SPEC.with_settings({**settings, "foot_mass": 10.0})
    body, mass = hopper.build_body(spec), hopper.masses(spec, settings["weight"])
    motion = springs.motion_of(hopper.initial_state(settings["slope"])[None])
    generator = np.random.default_rng(0)
    motion, _ = springs.step(body, mass, motion, np.zeros((6, 1)))
    assert np.abs(motion.velocity).max() < 2.5
    for _ in range(150):
        motion, _ = springs.step(body, mass, motion, generator.normal(size=(6, 1)))
    # From the steepest slope things slide far, but no faster than they can fall.
    assert np.abs(motion.velocity).max() < 30 + settings["gravity"] * 150 * springs.FRAME_SECONDS


def test_jax_and_numpy_agree() -> None:
    state = moving_states(3, 0.5)[-1]
    actuation = np.random.default_rng(5).normal(size=(6, 1))
    mass = hopper.masses(SPEC, 0.5)
    here, power = springs.step(BODY, mass, springs.motion_of(state[None]), actuation)
    with jax.enable_x64(True):
        motion = springs.motion_of(state[None])
        there, other = once(springs.step, BODY, mass, motion, actuation)
        np.testing.assert_allclose(here.position, np.asarray(there.position), atol=1e-10)
        np.testing.assert_allclose(power, np.asarray(other), atol=1e-10)
