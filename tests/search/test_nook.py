"""The search reaches the best of all scripts that there are, with its default settings, in a world
so small that all of them can be scored."""

from __future__ import annotations

from dataclasses import replace

import pytest
from brute_force import nook, optimum, story_in
from search_objectives import NOOK_OBJECTIVES

from fuzz_for_tests import FULL
from i2pdsl.computing import computing
from i2pdsl.language.story import TypedStory
from i2pdsl.objective.fold import Objective
from i2pdsl.objective.replay import replay
from i2pdsl.objective.terms import score_script, story_objective
from i2pdsl.search.searches import SEARCHES
from i2pdsl.search.task import Task
from i2pdsl.worlds.grid.world import GridWorld
from i2pdsl.worlds.kind import Watch

LENGTH, SEED = 3, 77
UNSEEN = "naturalness 0\nluck 0\nliveliness 0\n"  # terms that take time to compile
QUICK = {"late": 6.862, "KL from the prior": 9.720}
"""What the best of all scripts is worth without these terms; a single pass reaches none."""


@pytest.fixture(scope="module")
def world() -> GridWorld:
    with computing():
        return nook()


def reached(world: GridWorld, story: TypedStory, objective: Objective | None = None) -> float:
    """What the default search finds, for an objective of the same meaning if there is one."""
    found = SEARCHES["beam"].solve(Task(story, world, Watch(), whole=objective), SEED, 1)
    frames = (replay(world, path.states, path.actions) for path in found.paths)
    return max(score_script(story, world, each) for each in frames)


def test_the_default_search_reaches_the_optimum(world: GridWorld) -> None:
    """One compiled program for all: the objective of a story that wants them all, in which the
    others weigh nothing."""
    with computing():
        wanted = "\n".join(NOOK_OBJECTIVES[name] for name in QUICK)
        objective = story_objective(story_in(world, LENGTH, UNSEEN + wanted), world)
        for number, (name, best) in enumerate(QUICK.items() if FULL else [*QUICK.items()][:1]):
            numbers = objective.params.numbers.copy()
            numbers[[w for i, w in enumerate(objective.weights[: len(QUICK)]) if i != number]] = 0.0
            one = replace(objective, params=objective.params._replace(numbers=numbers))
            story = story_in(world, LENGTH, UNSEEN + NOOK_OBJECTIVES[name])
            assert reached(world, story, one) == pytest.approx(best, abs=1e-3), name


@pytest.mark.slow
@pytest.mark.parametrize("name", QUICK)
def test_the_optimum_of_the_quick_test_is_that_of_all_scripts(world: GridWorld, name: str) -> None:
    with computing():
        best = optimum(world, story_in(world, LENGTH, UNSEEN + NOOK_OBJECTIVES[name]))
    assert QUICK[name] == pytest.approx(best, abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("name", NOOK_OBJECTIVES)
def test_no_script_is_better_with_all_terms(world: GridWorld, name: str) -> None:
    with computing():
        story = story_in(world, LENGTH, NOOK_OBJECTIVES[name])
        assert reached(world, story) == pytest.approx(optimum(world, story), abs=1e-3)
