"""The hand-written versions that `benchmarks/peers.py` measures do the same work as we do."""

from __future__ import annotations

from functools import cache
from random import Random

import numpy as np
import peer_numpy
import pytest
from brute_force import nook, story_in
from peer_arrays import Arrays, arrays_of
from peer_plain import plain_state, plain_world
from peer_report import values_of

import reference
from i2pdsl.audience.queries import probability
from i2pdsl.objective.replay import replay, replay_all
from i2pdsl.objective.terms import score_script
from i2pdsl.worlds.grid.world import GridWorld
from worlds_for_tests import trajectory

LENGTH, SCRIPTS = 4, 30
OBJECTIVE = """rationality 1
plausibility 1
naturalness 0
luck 0
liveliness 0
maximize sum_t P(rho > 0 | script[:t])"""


@cache
def planned() -> tuple[GridWorld, Arrays, tuple[np.ndarray, np.ndarray]]:
    """The nook, its arrays, and the policies that follow from our values."""
    world = nook()
    a, order = arrays_of(world)
    values = values_of(a, world.tables.continuation, order)
    weak = peer_numpy.softmax(a, peer_numpy.q_weak(a, values[0]))
    return world, a, (weak, peer_numpy.softmax(a, peer_numpy.q_strong(a, weak, values[1])))


def scripts(world: GridWorld) -> tuple[np.ndarray, np.ndarray]:
    """Starts [N] and actions [N, T] of random scripts."""
    random, found = Random(5), []
    for start in random.choices(range(len(world.dynamics.cells)), k=SCRIPTS):
        state, actions = np.int64(start), []
        for _ in range(LENGTH):
            turns = world.turns(world.tables, state)
            actions.append(random.choice(np.flatnonzero(turns.valid).tolist()))
            state = turns.state[actions[-1]]
        found.append((start, actions))
    return np.array([s for s, _ in found]), np.array([actions for _, actions in found])


def test_plans_agree() -> None:
    world, a, _ = planned()
    _, order = arrays_of(world)
    ours = values_of(a, world.tables.continuation, order)
    assert max(peer_numpy.residuals(a, *ours)) < 1e-8
    weak, strong, _ = peer_numpy.planned(a, 1e-4)
    # The residual over 1 - gamma; the strong one also faces a policy that is not exact.
    assert np.abs(weak - ours[0]).max() < 1e-2
    assert np.abs(strong - ours[1]).max() < 0.1


def test_beliefs_and_scores_agree() -> None:
    world, a, policies = planned()
    starts, actions = scripts(world)
    paths = [trajectory(world, s, one) for s, one in zip(starts, actions, strict=True)]
    frames = replay_all(world, np.array([p.states for p in paths]), actions)
    ours = probability(frames.log_belief, a.helps, a.rational)
    assert peer_numpy.posterior(a, *policies, starts, actions) == pytest.approx(ours, abs=1e-7)
    story = story_in(world, LENGTH, OBJECTIVE)
    scores = [score_script(story, world, replay(world, p.states, p.actions)) for p in paths]
    assert peer_numpy.scores(a, *policies, starts, actions) == pytest.approx(scores, abs=1e-6)


def test_searches_agree(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reference, "TOLERANCE", 1e-5)
    world, a, policies = planned()
    plain, starts = plain_world(world.spec), np.array([3, 40])
    found, actions = peer_numpy.search(a, *policies, starts, 2, 1, 60)
    assert peer_numpy.scores(a, *policies, starts, actions) == pytest.approx(found, abs=1e-9)

    def score(world: reference.World, script: dict) -> float:
        beliefs = reference.depict(world, script, reference.HELPS)
        return (
            beliefs + reference.rationality(world, script) + reference.plausibility(world, script)
        )

    for start, best in zip(starts, found, strict=True):
        placed = [plain_state(world, int(start))]
        assert reference.beam(plain, placed, 2, score)[0] == pytest.approx(best, abs=1e-4)
