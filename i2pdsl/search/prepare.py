"""Compiling a story's search without running it: the next story of its shape starts at once."""

from __future__ import annotations

from typing import TYPE_CHECKING

from i2pdsl.objective.terms import story_objective
from i2pdsl.programs import Program
from i2pdsl.search.beam import prepare_beam
from i2pdsl.search.descent import prepare_descent
from i2pdsl.worlds.grid.world import GridWorld
from i2pdsl.worlds.hill.world import HillWorld

if TYPE_CHECKING:
    from i2pdsl.pipeline import Story
    from i2pdsl.worlds.ready import Watch


def prepare(story: Story, watch: Watch | None = None) -> Program | None:
    """Puts the program of a story's search into the cache of compiled programs.

    The world is planned, and the program that the cache then holds is the one that `story.solve`
    runs. None where nothing is compiled (`search naive`).

    Raises StoryError as `story.solve` does.
    """
    typed, say = story.typed, None if watch is None else watch.say
    if typed.search.method == "naive":
        return None
    world = story.world(watch)
    objective, plan = story_objective(typed, world), typed.search
    if isinstance(world, HillWorld):
        return prepare_descent(world, objective, typed.length, plan, say).program
    assert isinstance(world, GridWorld)
    count = min(plan.starts, len(story.allowed_starts(world)))
    events = story.events(world)
    return prepare_beam(world, objective, typed.length, count, plan.width, events, say).program
