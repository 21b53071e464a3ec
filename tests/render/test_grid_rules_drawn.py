"""Walls between cells, pulls, like boxes and moves at the same time, as they are drawn."""

from __future__ import annotations

import re
from functools import cache
from typing import Any

import numpy as np
import pytest

from i2pdsl.errors import Source
from i2pdsl.render.characters import Ink
from i2pdsl.render.grid.characters import map_in_characters
from i2pdsl.render.grid.choreography import choreograph
from i2pdsl.render.grid.pictures import stage_of
from i2pdsl.render.grid.scene import scene_svg, stage_background
from i2pdsl.render.grid.stage import break_down, describe, followed
from i2pdsl.render.grid.tracks import sample
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.grid.script import GridReader, frames_as_json, state_as_json
from i2pdsl.worlds.grid.world import GridWorld, unplanned_world
from i2pdsl.worlds.record import Record, empty, extended

YARD = """
map
    . . .|.
    . . x .
    -   -
    b x r .
character blue
    symbol = b
    success = 0.8
    pushes = box
    pulls = box
character red
    symbol = r
object box
    symbol = x
planning
    order = together
    horizon = 9
"""


@cache
def yard() -> GridWorld:
    return unplanned_world(parse_world(Source("yard.world", YARD), "yard"))


def told(world: GridWorld, seed: int) -> tuple[Any, dict[str, Any]]:
    """A random script, in which blue mostly pulls and pushes, and its document."""
    random, tables = np.random.default_rng(seed), world.tables
    path = empty(world, np.int64(world.starts()[0]))
    for _ in range(world.spec.settings.horizon):
        here = np.asarray(path.states[-1])
        actions = np.arange(world.turn_count)
        valid = _valid(world, here)
        moves = np.zeros(len(actions), bool)
        for box in (2, 3):
            moves |= world.feature(tables, "pushes", (0, box), here, here + 0 * actions, actions)
        some = np.flatnonzero(valid & moves if (valid & moves).any() else valid)
        path = extended(world, path, [int(random.choice(some))])
    start = state_as_json(world.spec, world.dynamics, int(path.start))
    return path, {"start": start, "frames": frames_as_json(world, path)}


def _valid(world: GridWorld, here: np.ndarray) -> np.ndarray:
    """The turns that are no second copies of others (World.turns needs plans)."""
    from i2pdsl.worlds.grid import model

    found = []
    for action in range(world.turn_count):
        steps, _ = model.steps(world.tables, world.moves, here, np.asarray(action))
        _, success = model.decode(world.moves, 0, np.asarray(action), np)
        found.append(bool(success) or bool(steps[0].would))
    return np.array(found)


@pytest.mark.parametrize("seed", range(4))
def test_a_script_is_read_again_and_drawn_where_everyone_is(seed: int) -> None:
    world = yard()
    path, document = told(world, seed)
    record = Record({}, {"name": "yard"}, None, document["start"], tuple(document["frames"]))
    again = GridReader(world, record).read()
    np.testing.assert_array_equal(again.states, path.states)
    stage = stage_of(world.spec)
    film = choreograph(stage, document)
    shown = followed(stage, document)
    for name, track in film.tracks.items():
        times = [key.time for key in track]
        assert times == sorted(times), name
        for t, state in enumerate([shown["start"], *(f["state"] for f in shown["frames"])]):
            key = sample(track, t)
            assert [key.x, key.y] == state[name], (name, t)
    for before, after in zip(
        [shown["start"], *(f["state"] for f in shown["frames"])],
        [frame["state"] for frame in shown["frames"]],
        strict=False,
    ):
        for box in ("box_1", "box_2"):  # each goes its way, one cell at a time
            assert sum(abs(a - b) for a, b in zip(before[box], after[box], strict=True)) <= 1
    assert any(beat.verb in ("push", "pull") for beat in film.beats)


def test_both_act_in_the_same_time_and_a_pull_is_held() -> None:
    world = yard()
    stage = stage_of(world.spec)
    start = {"blue": [1, 2], "red": [2, 2], "box_1": [2, 1], "box_2": [0, 2]}
    # Blue can only go where red was once red has left; the box comes along.
    frame = {
        "blue": {"action": "pull_east", "moved": True},
        "red": {"action": "east", "moved": True},
        "event": None,
        "state": {"blue": [2, 2], "red": [3, 2], "box_1": [2, 1], "box_2": [1, 2]},
    }
    beats = break_down(stage, {"start": start, "frames": [frame]})
    assert {describe(beat) for beat in beats} == {"blue pulls box_2 east", "red goes east"}
    assert len({(beat.start, beat.end) for beat in beats}) == 1
    film = choreograph(stage, {"start": start, "frames": [frame]})
    (grip,) = film.marks
    assert grip.kind == "grip"
    picture = scene_svg(stage, film, 0.4)
    assert 'id="mark--grip"' in picture
    assert 'href="#mark--grip"' in picture


def test_walls_between_cells_are_lines() -> None:
    world = yard()
    lines = re.findall(
        r'd="((?:M[\d.]+ [\d.]+ [hv]10)+)"', stage_background(stage_of(world.spec), 10)
    )
    assert set(lines) == {"M0 20 h10M30 0 v10M20 20 h10"}
    shown = map_in_characters(world, int(world.starts()[0]), Ink(False, False, 80)).splitlines()
    assert [line[4:] for line in shown[:4]] == [
        ". . .|.",
        ". . O .",
        "-   -",
        "B X R .",
    ]
