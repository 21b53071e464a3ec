"""Candidates: two scripts count as different where a viewer would tell them apart."""

from __future__ import annotations

from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from i2pdsl.errors import Source
from i2pdsl.search.candidates import select_different
from i2pdsl.worlds.grid.dynamics import build_dynamics
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.grid.script import APART, distance
from i2pdsl.worlds.grid.symmetry import symmetries
from worlds_for_tests import kitchen_text

ROOM = ("P......", ".......", "......G")

Cell = tuple[int, int] | None


@cache
def room() -> Any:
    """What `distance` needs of a world: nothing is planned."""
    spec = parse_world(Source("room.world", kitchen_text(ROOM)), "room")
    dynamics = build_dynamics(spec)
    coordinates = np.vstack([dynamics.coordinates, [[-9, -9]]])
    tables = SimpleNamespace(coordinates=coordinates)
    return SimpleNamespace(spec=spec, dynamics=dynamics, tables=tables)


def states(cheese: list[Cell], robot: list[Cell], table: Cell | list[Cell] = None) -> np.ndarray:
    """The states [T + 1] of a script, from where everyone stands."""
    dynamics = room().dynamics
    number = {tuple(c): i for i, c in enumerate(dynamics.coordinates.tolist())}
    tables = table if isinstance(table, list) else [table] * len(cheese)
    found = []
    for cells in zip(cheese, robot, tables, strict=True):
        places = [dynamics.absent if c is None else number[c] for c in cells]
        found.append(int(dynamics.lookup[int(np.dot(places, dynamics.strides))]))
    assert min(found) >= 0
    return np.array(found)


def walk(row: int, first: int, last: int) -> list[Cell]:
    step = 1 if last > first else -1
    return [(c, row) for c in range(first, last + step, step)]


STORY = states(walk(0, 1, 4), walk(1, 1, 4))


def test_the_same_story_is_no_distance_away() -> None:
    assert distance(room(), STORY, STORY) == 0


@pytest.mark.parametrize(
    "other",
    [
        states(walk(0, 2, 5), walk(1, 2, 5)),  # one column to the right
        states(walk(1, 1, 4), walk(2, 1, 4)),  # one row down
        states([(1, 0), *walk(0, 1, 3)], [(1, 1), *walk(1, 1, 3)]),  # a turn later
        states(walk(0, 1, 4), walk(1, 1, 4), (6, 2)),  # a table that nobody moves
        states(walk(0, 1, 4), walk(1, 1, 4), (0, 2)),
    ],
)
def test_the_same_story_a_little_aside_is_the_same(other: np.ndarray) -> None:
    assert 0 <= distance(room(), STORY, other) < APART
    assert distance(room(), STORY, other) == distance(room(), other, STORY)
    assert select_different(room(), [STORY, other], 5) == [0]


@pytest.mark.parametrize(
    "other",
    [
        states(walk(0, 4, 1), walk(1, 4, 1)),  # the other way round
        states(walk(2, 1, 4), walk(1, 1, 4)),  # the cheese elsewhere
        states(walk(0, 1, 4), [(6, 2)] * 4),  # a robot that stays away
        states(walk(0, 1, 4), walk(1, 1, 4), [None, (6, 2), (6, 2), (6, 2)]),  # a table falls
    ],
)
def test_another_story_is_different(other: np.ndarray) -> None:
    assert distance(room(), STORY, other) >= APART
    assert distance(room(), STORY, other) == distance(room(), other, STORY)
    assert select_different(room(), [STORY, other], 5) == [0, 1]


MIRRORED = states(walk(2, 5, 2), walk(1, 5, 2))  # the room half turned: P and G change places


def test_a_mirror_image_is_the_same() -> None:
    assert distance(room(), STORY, MIRRORED) == distance(room(), MIRRORED, STORY) == 0
    assert select_different(room(), [STORY, MIRRORED], 5) == [0]
    aside = states(walk(2, 4, 1), walk(1, 4, 1), (0, 0))
    assert 0 < distance(room(), STORY, aside) < APART


def spec_of(rows: tuple[str, ...], goals: str = "{pink, green}") -> Any:
    """A kitchen whose cheese has other goals than usual."""
    text = kitchen_text(rows).replace("goals = {pink, green}", f"goals = {goals}", 1)
    return parse_world(Source("w.world", text), "w")


@pytest.mark.parametrize(
    ("rows", "count"),
    [
        (("P.G",), 2),
        (("P..", "...", "..G"), 4),  # both diagonals, and half a turn
        (("P..", ".#.", "..G"), 4),
        (("P..", ".#.", ".G."), 1),
        (("P.#", "...", "..G"), 2),
        (("P..#", "...#", "..G#"), 4),  # the wall is outside
        (("P.P", "...", "G.G"), 4),
        (("P.P", "...", "G.."), 1),
    ],
)
def test_symmetries_are_those_of_walls_and_tiles(rows: tuple[str, ...], count: int) -> None:
    found = symmetries(spec_of(rows))
    assert len(found) == len(set(found)) == count
    assert found[0] == tuple(range(len(found[0])))
    for one in found:  # a group
        assert all(tuple(one[i] for i in other) in found for other in found)


def test_tiles_change_places_only_where_they_are_wanted_alike() -> None:
    assert len(symmetries(spec_of(("P..", "...", "..G"), "{pink}"))) == 2  # the diagonal stays


def test_the_best_are_chosen_in_their_order() -> None:
    away = states(walk(0, 1, 4), [(6, 2)] * 4)
    back = states(walk(0, 4, 1), walk(1, 4, 1))
    aside = states(walk(0, 2, 5), walk(1, 2, 5))
    paths = [STORY, aside, STORY, away, back, away]
    assert select_different(room(), paths, 3) == [0, 3, 4]
    assert select_different(room(), paths, 9) == [0, 3, 4]
    assert select_different(room(), paths, 2) == [0, 3]
    assert select_different(room(), paths, 1) == [0]
    assert select_different(room(), [], 1) == []
