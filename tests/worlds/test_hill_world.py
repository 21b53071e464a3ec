"""What viewers make of the hill, against the independent transcription."""

from __future__ import annotations

import json
import math
from functools import partial
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import hill_reference as reference
from hill_for_tests import as_reference, from_reference
from i2pdsl import StoryError
from i2pdsl.objective.film import film_of
from i2pdsl.objective.replay import replay
from i2pdsl.programs import BRIEF, once
from i2pdsl.worlds.hill import controllers as files
from i2pdsl.worlds.hill import hopper
from i2pdsl.worlds.hill.spec import HillSpec
from i2pdsl.worlds.hill.training import looker
from i2pdsl.worlds.hill.world import HillWorld, build_hill, hill_rollout
from i2pdsl.worlds.world import Viewer

WEIGHTS = (0.1, 0.5)
SHIPPED = (0, 1, 2, 3, 4)
SHIPPED_ZERO = files.SHIPPED / files.file_name(HillSpec(), 0)


def world(**settings: float | str) -> HillWorld:
    return build_hill(HillSpec().with_settings(settings))


def reference_network(kind: str) -> list[reference.Layer]:
    """A shipped network as the reference has it, the weight being its 77th input."""
    found = files.find_controllers(HillSpec(), HillSpec().settings.controller)
    layers = found.policy if kind == "policy" else found.value
    return [(matrix.tolist(), bias.tolist()) for matrix, bias in layers]


def reference_inputs(state: reference.State, weight: float) -> list[float]:
    """(observation - observation at rest without speeds) / 5, and -1 or +1."""
    at_rest = reference.observation(reference.initial())
    seen = reference.observation(state)
    scaled = [
        (a - (b if i < 38 else 0.0)) / 5 for i, (a, b) in enumerate(zip(seen, at_rest, strict=True))
    ]
    return [*scaled, -1.0 if weight == 0.1 else 1.0]


def test_what_was_climbed_is_what_progress_adds_up_to() -> None:
    steep = world()
    for slope in (0.1, 0.25):
        tables = steep.tables._replace(body=steep.tables.body._replace(slope=np.array(slope)))
        state, total = hopper.initial_state(slope), {"hopper": 0.0, "box": 0.0}
        for frame in range(30):
            action = 0.2 * np.sin(np.arange(6) + frame)
            after = steep.transition(tables, state, action)
            for who in total:
                asked = lambda name, w=who, s=state, a=after, d=action: float(
                    steep.feature(tables, name, (w,), a, s, d)  # noqa: B023
                )
                total[who] += asked("progress")
                assert asked("climbed") == pytest.approx(total[who], abs=1e-9)
            state = after


@pytest.mark.parametrize(
    ("truth", "will", "lazy"), [(0.1, "eager", 1), (0.5, "eager", 0.3), (0.1, "lazy", 0.15)]
)
def test_beliefs_and_values_agree_with_the_reference(truth: float, will: str, lazy: float) -> None:
    """Policies, one imagined frame for each hypothesis, Bayes and forgetting; and V.

    A lazy hopper does what an eager one would do, with a share of the actuation.
    """
    hill = world(weight=truth, will=will, lazy=lazy, sigma=0.7, forgetting=1e-3)
    path = hill_rollout(hill, 6, 0.5, seed=3)
    frames = replay(hill, path.states, path.actions)
    shares = {"eager": 1.0} if lazy == 1 else {"eager": 1.0, "lazy": lazy}
    rows = [(weight, share) for weight in WEIGHTS for share in shares.values()]
    belief = [1 / len(rows)] * len(rows)
    for t in range(6):
        before, after = as_reference(path.states[t]), as_reference(path.states[t + 1])
        own = reference.network(reference_network("policy"), reference_inputs(before, truth))
        used = [shares[will] * a + b for a, b in zip(own, path.actions[t], strict=True)]
        np.testing.assert_allclose(hill.actuation(path.states[t], path.actions[t]), used)
        follows, _ = reference.step(before, used, truth)
        np.testing.assert_allclose(from_reference(follows), path.states[t + 1], atol=1e-7)
        logs = []
        for weight, share in rows:
            imagined = reference.network(
                reference_network("policy"), reference_inputs(before, weight)
            )
            imagined = [share * a for a in imagined]
            predicted, _ = reference.step(before, imagined, weight)
            logs.append(reference.log_likelihood(after, predicted, 0.7))
        np.testing.assert_allclose(frames.log_rows[t + 1, 0, 0], logs, atol=1e-7)
        belief = reference.update(belief, logs, 1e-3)
        np.testing.assert_allclose(np.exp(frames.log_belief[t + 1, 0]), belief, atol=1e-7)
        values = [
            100 * reference.network(reference_network("value"), reference_inputs(after, w))[0]
            for w, _ in rows
        ]
        np.testing.assert_allclose(hill.value(hill.tables, 0, path.states[t + 1])[0], values)


def test_who_knows_the_muscles_is_never_persuaded() -> None:
    """The true mass explains each frame exactly, whatever the muscles do (model.md)."""
    hill = world(weight=0.1, evidence="mass")
    path = hill_rollout(hill, 40, 2.0, seed=0)
    frames = replay(hill, path.states, path.actions)
    np.testing.assert_allclose(frames.log_rows[1:, 0, 0, 0], 0.0, atol=1e-12)
    assert (frames.log_belief[1:, 0, 1] < np.log(0.5)).all()


def test_viewers_stand_side_by_side() -> None:
    """Two observers together believe what each believes alone."""
    spec = HillSpec()
    one = Viewer(spec.with_settings({"controller": 1}))
    other = Viewer(spec.with_settings({"sigma": 2.0, "forgetting": 0.01}), (0.9, 0.1))
    path = hill_rollout(world(), 10, 0.3, seed=1)
    both = replay(build_hill(spec, (one, other)), path.states, path.actions)
    for i, viewer in enumerate((one, other)):
        alone = replay(build_hill(spec, (viewer,)), path.states, path.actions)
        np.testing.assert_allclose(both.log_belief[:, i], alone.log_belief[:, 0], atol=1e-9)


def test_beliefs_sum_to_one_and_hypotheses_can_be_renamed() -> None:
    path = hill_rollout(world(), 20, 0.3, seed=2)
    frames = replay(world(), path.states, path.actions)
    np.testing.assert_allclose(np.exp(frames.log_belief).sum(-1), 1.0)
    hill = world()
    swapped = hill.tables._replace(
        masses=hill.tables.masses[::-1],
        policies=_reversed(hill.tables.policies),
        values=_reversed(hill.tables.values),
    )
    again = replay(HillWorld(hill.spec, swapped), path.states, path.actions)
    np.testing.assert_allclose(again.log_belief[..., ::-1], frames.log_belief, atol=1e-9)


def _reversed(layers: files.Layers) -> files.Layers:
    (matrix, bias), *rest = layers
    return ((matrix, bias[:, ::-1]), *rest)


def test_features_of_a_frame() -> None:
    hill = world(weight=0.5)
    path = hill_rollout(hill, 12, 0.2, seed=4)
    before, after = path.states[:-1], path.states[1:]
    ask = lambda name, group: hill.feature(
        hill.tables, name, hill.feature_arguments(name, (group,)), after, before, path.actions
    )
    box = np.stack([s.reshape(4, 19)[:2, 11:].mean(-1) for s in path.states])
    along = np.diff(box, axis=0) @ [np.cos(0.1), np.sin(0.1)]
    np.testing.assert_allclose(ask("progress", 1), along, atol=1e-12)
    used = hill.actuation(before, path.actions)
    np.testing.assert_allclose(ask("effort", 0), (used**2).mean(-1))
    np.testing.assert_array_equal(ask("fallen", 0), 0.0)
    hand, hook = (after.reshape(-1, 4, 19)[:, :2, node] for node in (6, 12))
    length = np.linalg.norm(hand - hook, axis=1)
    taut = length > reference.rest_length(reference.ROPE, [])
    assert 0 < taut.sum() < len(taut)
    np.testing.assert_array_equal(ask("taut", 0), taut)
    lying = path.states[-1].reshape(4, 19).copy()
    lying[1, 9] -= 9.5  # the head alone
    fallen = hill.feature(hill.tables, "fallen", (0,), lying.reshape(-1))
    assert fallen == 1.0


def test_regret_and_stillness_of_a_film() -> None:
    """What is missed of the frame that one imagines; how far the node goes that goes farthest."""
    hill = world(weight=0.5)
    path = hill_rollout(hill, 12, 0.5, seed=4)
    frames = replay(hill, path.states, path.actions)
    regret = still = 0.0
    for t in range(1, 13):
        believed = np.exp(frames.log_belief[t, 0]).tolist()
        missed = (-frames.log_rows[t, 0, 0]).tolist()
        regret += sum(p * m for p, m in zip(believed, missed, strict=True))
        x, y = (path.states[t].reshape(4, 19) - path.states[t - 1].reshape(4, 19))[:2].tolist()
        still += 1 / (1 + (max(map(math.hypot, x, y)) / 0.05) ** 2)
    film = film_of(hill, frames)
    assert float(film.regret) == pytest.approx(regret)
    assert float(film.still) == pytest.approx(still)
    before, after = path.states[3:5]
    way = np.random.default_rng(0).normal(size=after.shape)
    with jax.enable_x64(True):
        of_after = jax.grad(partial(hill.stillness, None), argnums=1)
        gradient = np.asarray(once(of_after, before, after))
    ahead, behind = (hill.stillness(None, before, after + e * way) for e in (1e-6, -1e-6))
    assert gradient @ way == pytest.approx((ahead - behind) / 2e-6, rel=1e-4)


def test_fallen_has_a_direction_but_is_exact() -> None:
    """A descent feels where up is; the value is 0 or 1 all the same."""
    hill = world()
    tables = jax.tree.map(lambda a: np.asarray(a, np.float32), hill.tables)

    @partial(jax.jit, compiler_options=BRIEF)
    @jax.value_and_grad
    def fallen(lower: jax.Array) -> jax.Array:
        state = jnp.asarray(hopper.initial_state(), jnp.float32)
        return hill.feature(tables, "fallen", ("hopper",), state.at[19:30].add(-lower))

    for lower, expected in ((8.5, 0.0), (9.5, 1.0)):
        found, slope = fallen(np.float32(lower))
        assert found == expected
        assert slope > 0.01


def test_taut_has_a_direction_but_is_exact() -> None:
    """Of the rope too: a descent feels that it should be pulled."""
    hill = world()
    tables = jax.tree.map(lambda a: np.asarray(a, np.float32), hill.tables)

    @partial(jax.jit, compiler_options=BRIEF)
    @jax.value_and_grad
    def taut(back: jax.Array) -> jax.Array:
        state = jnp.asarray(hopper.initial_state(), jnp.float32)
        return hill.feature(tables, "taut", ("hopper",), state.at[11:19].add(-back), state)

    for back, expected in ((-0.1, 0.0), (0.1, 1.0)):
        found, slope = taut(np.float32(back))
        assert found == expected
        assert slope > 0.1


@pytest.mark.parametrize("will", ["eager", "lazy"])
def test_who_does_its_best_is_told_from_who_does_not(will: str) -> None:
    """The weight too, though where little moves there is less to see of it."""
    hill = world(weight=0.5, will=will, lazy=0.15)
    path = hill_rollout(hill, 60, 0.0, seed=0)
    belief = np.exp(replay(hill, path.states, path.actions).log_belief[-1, 0])
    rows = hill.spec.hypotheses
    assert sum(p for p, row in zip(belief, rows, strict=True) if row[1] == will) > 0.9
    assert rows[belief.argmax()] == (0.5, will)


@pytest.mark.parametrize("truth", WEIGHTS)
def test_honest_motion_is_recognised_within_forty_frames(truth: float) -> None:
    hill = world(weight=truth)
    path = hill_rollout(hill, 40, 0.0, seed=0)
    heavy = np.exp(replay(hill, path.states, path.actions).log_belief[:, 0, 1])
    right = heavy < 0.05 if truth == 0.1 else heavy > 0.95
    assert right[10:].any(), heavy


# Controllers and their files.


def test_what_ships_says_how_it_was_made() -> None:
    """And the figures that were measured then, on noise of their own."""
    for seed in SHIPPED:
        about = files.find_controllers(HillSpec(), seed).about
        assert about["seed"] == seed
        assert about["command"].startswith("i2p train hill")
        light, heavy = about["climbs"]
        assert min(light, heavy) >= 15
        assert about["falls"] <= 0.05


@pytest.mark.parametrize(
    "seed", [pytest.param(s, marks=() if s == 2 else pytest.mark.slow) for s in SHIPPED]
)
def test_what_ships_does_what_it_says(seed: int) -> None:
    """64 rollouts of 800 frames on fresh noise."""
    found = files.find_controllers(HillSpec(), seed)
    policy = jax.tree.map(lambda a: jnp.asarray(a, jnp.float32), found.policy)
    look = looker(HillSpec(), WEIGHTS)(policy, 1234, 0.2)
    light, heavy = look.climbs
    assert min(light, heavy) >= 15
    assert look.falls <= 0.05
    assert light >= (1.5 if seed == HillSpec().settings.controller else 1.3) * heavy
    np.testing.assert_allclose(look.climbs, found.about["climbs"], rtol=0.25)


def test_what_is_not_trained_is_said_with_the_command(tmp_path: Path) -> None:
    spec = HillSpec().with_settings({"slope": 0.2, "weights": (0.3, 0.1), "controller": 3})
    with pytest.raises(StoryError) as caught:
        build_hill(spec)
    hint = caught.value.diagnostics[0].hint
    assert hint is not None
    assert "`i2p train hill --set slope=0.2 --set 'weights={0.1,0.3}' --seed 3`" in hint


@pytest.mark.parametrize("damage", ["cut", "empty", "noise", "other", "version", "nan"])
def test_damaged_files_are_said_and_passed_over(
    damage: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("I2PDSL_CACHE", str(tmp_path))
    spec = HillSpec()
    good = files.find_controllers(spec, 0)
    monkeypatch.setattr(files, "places", lambda *_: [tmp_path / "spoilt.npz", SHIPPED_ZERO])
    path = tmp_path / "spoilt.npz"
    files.save_controllers(path, good)
    content = path.read_bytes()
    if damage == "cut":
        path.write_bytes(content[: len(content) // 2])
    elif damage == "empty":
        path.write_bytes(b"")
    elif damage == "noise":
        path.write_bytes(bytes(range(256)) * 40)
    elif damage == "other":
        np.savez(path, allow_pickle=False, numbers=np.zeros(3))
    elif damage == "version":
        with np.load(path) as archive:
            arrays = dict(archive)
        arrays["about"] = np.array(json.dumps({**json.loads(str(arrays["about"])), "version": 99}))
        np.savez(path, allow_pickle=False, **arrays)
    else:
        spoilt = good.policy[0][0].copy()
        spoilt[0, 0] = np.nan
        broken = files.Controllers(
            ((spoilt, good.policy[0][1]), *good.policy[1:]), good.value, good.weights, good.about
        )
        files.save_controllers(path, broken)
    said: list[str] = []
    found = files.find_controllers(spec, 0, said.append)
    assert said
    assert str(path) in said[0]
    np.testing.assert_array_equal(found.policy[0][0], good.policy[0][0])
