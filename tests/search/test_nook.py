"""The search reaches the best of all scripts that there are, with its default settings, in a world
so small that all of them can be scored."""

from __future__ import annotations

from dataclasses import replace

import pytest
from brute_force import nook, optimum, story_in
from search_objectives import NOOK_OBJECTIVES

from i2pdsl.computing import computing
from i2pdsl.objective.fold import Objective
from i2pdsl.objective.replay import replay
from i2pdsl.objective.terms import score_script, story_objective
from i2pdsl.search.searches import SEARCHES
from i2pdsl.search.task import Task
from i2pdsl.worlds.grid.world import GridWorld
from i2pdsl.worlds.kind import Watch

LENGTH, SEED = 3, 77
QUICK = {"late": 6.846, "KL from the prior": 9.616, "surprise at the end": 55.133}
"""What the best of all scripts is worth, automatic terms included; a single pass misses each by 0.5
at least."""


@pytest.fixture(scope="module")
def world() -> GridWorld:
    with computing():
        return nook()


def reached(world: GridWorld, name: str, objective: Objective | None = None) -> float:
    """What the default search finds, for an objective of the same meaning if there is one."""
    story = story_in(world, LENGTH, NOOK_OBJECTIVES[name])
    found = SEARCHES["beam"].solve(Task(story, world, Watch(), whole=objective), SEED, 1)
    frames = (replay(world, path.states, path.actions) for path in found.paths)
    return max(score_script(story, world, each) for each in frames)


def test_the_default_search_reaches_the_optimum(world: GridWorld) -> None:
    """One compiled program for all: the objective of a story that wants them all, in which the
    others weigh nothing."""
    with computing():
        whole = story_in(world, LENGTH, "\n".join(NOOK_OBJECTIVES[name] for name in QUICK))
        objective = story_objective(whole, world)
        for number, (name, best) in enumerate(QUICK.items()):
            numbers = objective.params.numbers.copy()
            numbers[[w for i, w in enumerate(objective.weights[: len(QUICK)]) if i != number]] = 0.0
            one = replace(objective, params=objective.params._replace(numbers=numbers))
            assert reached(world, name, one) == pytest.approx(best, abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("name", NOOK_OBJECTIVES)
def test_no_script_is_better(world: GridWorld, name: str) -> None:
    with computing():
        best = optimum(world, story_in(world, LENGTH, NOOK_OBJECTIVES[name]))
        assert QUICK.get(name, best) == pytest.approx(best, abs=1e-3)
        assert reached(world, name) == pytest.approx(best, abs=1e-3)
