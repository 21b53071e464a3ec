"""What could come next: continuations of a script that is there already."""

from __future__ import annotations

import numpy as np
import pytest

from fuzz_for_tests import FULL
from i2pdsl.errors import Source
from i2pdsl.objective.replay import replay
from i2pdsl.objective.terms import score_script, story_objective
from i2pdsl.search.onward import continuations, descents
from i2pdsl.stories import Story, story_from
from i2pdsl.worlds.grid.world import GridWorld
from i2pdsl.worlds.hill.world import HillWorld
from i2pdsl.worlds.record import Trajectory


def story(text: str, length: int) -> Story:
    return story_from(Source("test.story", text.format(length)))


HILL = (
    "world hill(weight = 0.1)\nlength {}\nmaximize depict(weight = 0.5)\n"
    "search descend(seeds = 3, window = 8, lookahead = 4, steps = 4)\n"
)


def test_a_descent_goes_on_from_a_script() -> None:
    made = story(HILL, 30)
    world = made.world()
    assert isinstance(world, HillWorld)
    honest = made.solve(naive=True).script.trajectory
    path = Trajectory(honest.actions[:10], honest.states[:11])
    objective, plan = story_objective(made.typed, world), made.typed.search
    found = descents(world, objective, 30, plan, path, 15)
    assert len(found) == 3
    worth = [score for _, score in found]
    assert worth == sorted(worth, reverse=True)
    shorter = story(HILL, 25).typed
    for longer, score in found:
        assert longer.actions.shape == (25, 6)
        assert longer.states.shape == (26, 76)
        np.testing.assert_allclose(longer.actions[:10], path.actions, atol=1e-6)
        np.testing.assert_allclose(longer.states[:11], path.states, atol=1e-4)
        for t in range(10, 25):
            after = world.transition(world.tables, longer.states[t], longer.actions[t])
            np.testing.assert_allclose(after, longer.states[t + 1], atol=2e-3)
        # A sum over frames is worth the same whatever T is.
        frames = replay(world, longer.states, longer.actions)
        assert score == pytest.approx(score_script(shorter, world, frames), abs=0.01)
    honest_frames = replay(world, honest.states[:26], honest.actions[:25])
    assert worth[0] > score_script(shorter, world, honest_frames)


def test_what_is_missing_can_be_less_than_a_window() -> None:
    made = story(HILL, 30)
    world = made.world()
    assert isinstance(world, HillWorld)
    honest = made.solve(naive=True).script.trajectory
    path = Trajectory(honest.actions[:28], honest.states[:29])
    objective = story_objective(made.typed, world)
    for frames in (1, 2, 5) if FULL else (5,):  # the story ends at 30
        found = descents(world, objective, 30, made.typed.search, path, frames)
        assert {len(longer.actions) for longer, _ in found} == {min(30, 28 + frames)}


def test_two_frames_on_a_map_are_the_best_of_all_pairs() -> None:
    text = "world fork\nlength {}\nstart at(robot, (4, 4))\nmaximize legible(G_robot = left)\n"
    made = story(text, 4)
    world = made.world()
    assert isinstance(world, GridWorld)
    start = int(made.task().starts[0])
    step = lambda state, action: int(
        world.transition(world.tables, np.asarray(state), np.asarray(action))
    )
    path = Trajectory(np.array([0, 3]), np.array([start, step(start, 0), step(step(start, 0), 3)]))
    objective = story_objective(made.typed, world)
    found = continuations(world, objective, 4, path, 2, ())
    best = -np.inf
    count = world.moves.turn_count
    for first in range(count):
        for second in range(count):
            middle = step(path.states[-1], first)
            states = np.array([*path.states, middle, step(middle, second)])
            actions = np.array([*path.actions, first, second])
            frames = replay(world, states, actions)
            best = max(best, score_script(made.typed, world, frames))
    assert found[0].score == pytest.approx(best, abs=1e-4)
    assert len({int(each.actions[0]) for each in found}) == len(found)
