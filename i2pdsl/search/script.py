"""Scripts between a file and a world: one way for each kind of world."""

from __future__ import annotations

from typing import Any

from i2pdsl.search.grid_script import GridReader, frames_as_json, state_as_json
from i2pdsl.search.hill_script import hill_frames, hill_state, read_hill
from i2pdsl.search.record import Record, Trajectory
from i2pdsl.worlds.grid.world import GridWorld
from i2pdsl.worlds.hill.world import HillWorld
from i2pdsl.worlds.world import World


def read_path(world: World, record: Record) -> Trajectory:
    """The script in the world's numbers, validated frame by frame. Raises StoryError."""
    if isinstance(world, HillWorld):
        return read_hill(world, record)
    assert isinstance(world, GridWorld)
    return GridReader(world, record).read()


def make_record(
    world: World,
    path: Trajectory,
    story: dict[str, Any],
    settings: dict[str, Any],
    score: float | None,
) -> Record:
    """A script file's content from a script in the world's numbers."""
    about = {"name": world.name, "source": world.spec.source or None, "settings": settings}
    if isinstance(world, HillWorld):
        return Record(story, about, score, hill_state(path.start), hill_frames(path))
    assert isinstance(world, GridWorld)
    start = state_as_json(world.spec, world.dynamics, int(path.start))
    return Record(story, about, score, start, frames_as_json(world, path))
