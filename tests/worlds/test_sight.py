"""Ways and lines of sight on a map, and between points of a plane."""

from __future__ import annotations

from random import Random

import jax
import numpy as np

import reference
from i2pdsl.programs import once
from i2pdsl.worlds.grid.sight import in_sight, walking
from i2pdsl.worlds.plane.features import feature
from plane_for_tests import DESK, WALLED, build_plane


def test_ways_and_sight_on_random_maps() -> None:
    random = Random(3)
    for _ in range(6):
        columns, rows = random.randint(3, 7), random.randint(2, 6)
        drawn = ["".join(random.choice(".#..") for _ in range(columns)) for _ in range(rows)]
        drawn[0] = "." + drawn[0][1:]
        one = reference.Character("one", goals=("a",))
        world = reference.World(drawn, {"a": (0, 0)}, [one], [reference.Object("box")])
        cells = np.array(sorted(world.free))
        steps, seen = walking(cells), in_sight(cells)
        assert (steps[-1] == len(cells)).all()
        assert not seen[-1].any()
        for i, here in enumerate(map(tuple, cells.tolist())):
            for j, there in enumerate(map(tuple, cells.tolist())):
                if here == there:
                    assert steps[i, j] == 0
                    assert seen[i, j]
                    continue
                state = (here, there)
                assert steps[i, j] == reference.distance(world, state, "one", "box")
                assert seen[i, j] == reference.sees(world, state, "one", "box"), (drawn, state)


def test_sight_in_the_plane_is_that_of_points_along_the_line() -> None:
    world = build_plane(WALLED)
    places = np.random.default_rng(0).uniform((0, 0) * 2, (12, 8) * 2, (60, 4))
    states = np.concatenate([places, 0 * places], axis=1)
    tables, walls = world.tables, world.tables.walls
    seen = np.array([feature(tables, "sees", (0, 1), s, None, None) for s in states])
    for state, found in zip(states, seen, strict=True):
        here, there = state[:2], state[2:4]
        crossed = False
        for first, second in walls:  # solve here + a (there - here) = first + b (second - first)
            matrix = np.stack([there - here, first - second], axis=-1)
            if abs(np.linalg.det(matrix)) > 1e-12:
                a, b = np.linalg.solve(matrix, first - here)
                crossed |= bool(0 < a < 1 and 0 < b < 1)
        assert found == (not crossed)
    assert 0 < seen.mean() < 1
    place = feature(tables, "sees", (0, np.array([0])), states, None, None)
    assert place.shape == (60,)


def test_facing_and_idling_in_the_plane() -> None:
    world = build_plane(DESK)
    tables = world.tables
    before = np.array([6.0, 1.0, 0.0, 0.0])
    ask = lambda name, *velocity: feature(
        tables, name, (0, np.array([0])), np.array([*(before[:2] + velocity), *velocity]), before,
        np.array(velocity),
    )  # fmt: skip
    toward = np.array([4.0, 7.0]) - before[:2]
    toward = 0.05 * toward / np.hypot(*toward)
    turned = lambda degrees: (
        np.array([[np.cos(r := np.radians(degrees)), -np.sin(r)], [np.sin(r), np.cos(r)]]) @ toward
    )
    assert [ask("faces", *turned(d)) for d in (0, 44, -44, 46, 90, 180)] == [1, 1, 1, 0, 0, 0]
    assert ask("faces", *(0.01 * toward)) == 0  # nobody sees it move
    assert ask("idle", *(0.01 * toward)) == 1
    assert ask("idle", *toward) == 0


def test_a_descent_feels_where_to_go_to_be_unseen() -> None:
    world = build_plane(WALLED)
    state = np.array([3.0, 4.0, 6.0, 4.0, 0, 0, 0, 0])  # a wall at x = 4 is between them
    sees = lambda s: feature(world.search_tables, "sees", (0, 1), s, None, None)
    value, gradient = once(jax.value_and_grad(sees), state.astype(np.float32))
    assert value == 0
    assert np.isfinite(gradient).all()
