"""Shortest ways among walls, and what bodies do at walls and at each other."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from i2pdsl.worlds.plane.geometry import Ways, clearance, in_sight
from i2pdsl.worlds.plane.ways import ways_to_places
from plane_for_tests import DESK, PAIR, ROOM, WALLED, build_plane, wandered

WALL = np.array([[[6.0, 0.0], [6.0, 5.0]]])
RADIUS = 0.4


def over_the_top(reach, below, radius):
    """The way from one side of a wall to the other over its upper end, in plain Python: a tangent,
    an arc, a tangent. Both ends lie `reach` beside and `below` under the wall's end."""
    away = math.hypot(reach, below)
    tangent = math.sqrt(away**2 - radius**2)
    arc = 2 * math.pi - 2 * math.atan2(reach, below) - 2 * math.acos(radius / away)
    return 2 * tangent + radius * arc


@pytest.mark.parametrize("height", [1.0, 2.5, 4.0])
@pytest.mark.parametrize("reach", [1.0, 3.0])
def test_ways_around_a_corner(height, reach):
    start, goal = (6.0 - reach, height), (6.0 + reach, height)
    ways = Ways(WALL, RADIUS, 12.0, 8.0)
    found = ways.lengths(np.array([start]), np.array([goal]))[0, 0]
    expected = over_the_top(reach, 5.0 - height, RADIUS)
    assert expected <= found <= expected + 0.03 * math.pi * RADIUS


def test_tables_of_ways_are_true_between_their_nodes():
    world = build_plane(replace(DESK, walls=ROOM))
    ways = Ways(world.tables.walls, RADIUS, 12.0, 8.0)
    generator = np.random.default_rng(0)
    points = generator.uniform((0.5, 0.5), (11.5, 7.5), (300, 2))
    points = points[clearance(world.tables.walls, points) > RADIUS]
    exact = ways.lengths(points, world.tables.places)
    found = ways_to_places(world.tables, 0, points)
    assert np.abs(found - exact).max() < 0.1
    assert np.abs(found - exact).mean() < 0.005


def test_what_is_in_sight_is_straight_ahead():
    world = build_plane(replace(DESK, walls=ROOM))
    points = np.array([[2.0, 7.0], [10.5, 7.2], [1.0, 1.0]])
    seen = in_sight(world.tables.walls, RADIUS, points, world.tables.places)
    straight = np.hypot(*np.moveaxis(points[:, None] - world.tables.places, -1, 0))
    found = ways_to_places(world.tables, 0, points)
    assert seen.sum() >= 5
    assert np.allclose(found[seen], straight[seen], atol=1e-9)


def test_a_gap_that_is_too_narrow_is_none():
    walls = np.array([[[6.0, 0.0], [6.0, 3.7]], [[6.0, 4.3], [6.0, 8.0]]])
    start, goal = np.array([[3.0, 4.0]]), np.array([[9.0, 4.0]])
    assert Ways(walls, 0.25, 12.0, 8.0).lengths(start, goal)[0, 0] == pytest.approx(6.0)
    wide = Ways(walls, 0.35, 12.0, 8.0)
    assert wide.lengths(start, goal)[0, 0] == pytest.approx(wide.far)


def steps_through_walls(walls, places):
    """How many steps [T + 1, 2] cross a wall's line."""
    cross = lambda u, v: u[0] * v[1] - u[1] * v[0]
    found = 0
    for first, second in walls:
        for a, b in itertools.pairwise(places):
            wall, way = second - first, b - a
            apart = cross(wall, a - first) * cross(wall, b - first)
            found += apart < 0 and cross(way, first - a) * cross(way, second - a) < 0
    return found


@pytest.mark.parametrize("mass", [2.0, 20.0])
@pytest.mark.parametrize("corner", [(7.6, 5.6), (4.4, 5.6), (7.6, 4.0)])
def test_nobody_is_pressed_through_walls(corner, mass):
    """By who is heavier, from all sides, as fast as he can; nor squeezed: the wall holds."""
    cat = replace(PAIR.characters[1], mass=mass)
    world = build_plane(replace(WALLED, characters=(PAIR.characters[0], cat)))
    fastest = world.tables.fastest
    for angle in np.linspace(0, 2 * np.pi, 9)[:-1]:
        way = np.array([np.cos(angle), np.sin(angle)])
        state = np.array([*corner, *(corner - 0.95 * way), 0, 0, 0, 0])
        places = [state[:2]]
        for _ in range(40):
            toward = state[:2] - state[2:4]
            toward = toward / np.hypot(*toward)
            action = np.concatenate([fastest[0] * way, fastest[1] * toward])
            state = world.transition(world.tables, state, action)
            places.append(state[:2])
            assert np.hypot(*(state[:2] - state[2:4])) > 0.95 * world.tables.radius.sum()
        assert not steps_through_walls(world.tables.walls, np.array(places)), angle


@pytest.mark.parametrize("seed", range(6))
def test_nobody_walks_through_walls(seed):
    """Whatever they try, and however they push each other."""
    world = build_plane(WALLED)
    states, _ = wandered(world, 300, seed, 4.0)
    places = states[:, :4].reshape(-1, 2, 2)
    for who in range(2):
        radius = world.tables.radius[who]
        assert clearance(world.tables.walls, places[:, who]).min() > 0.8 * radius
        assert not steps_through_walls(world.tables.walls, places[:, who])
        assert (places[:, who] >= radius - 1e-9).all()
    apart = np.hypot(*np.moveaxis(places[:, 0] - places[:, 1], -1, 0))
    assert apart.min() > 0.9 * world.tables.radius.sum()


def test_who_pushes_moves_the_other_and_the_heavier_more():
    world = build_plane(PAIR)
    state = np.array([6.0, 4.0, 5.05, 4.0, 0, 0, 0, 0])  # the cat stands to the west
    for _ in range(10):
        state = world.transition(world.tables, state, np.array([0, 0, 0.1, 0]))
    pushed, pushing = state[0] - 6.0, state[2] - 5.05
    assert pushed > 0.4
    assert pushing == pytest.approx(pushed, abs=0.1)
    alone = world.transition(world.tables, np.array([6.0, 4.0, 2, 2, 0, 0, 0, 0]), np.zeros(4))
    assert np.allclose(alone[:4], [6.0, 4.0, 2, 2])


def test_speed_is_limited():
    world = build_plane(DESK)
    after = world.transition(world.tables, world.starts()[0], np.array([3.0, 4.0]))
    assert np.allclose(after, [6.12, 1.16, 0.12, 0.16])
