"""Tiles that cost, and tiles that one gets onto and off in some directions only, by loops."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from i2pdsl.errors import Source, StoryError
from i2pdsl.worlds.grid.dynamics import Dynamics, build_dynamics
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.grid.policy import action_values
from i2pdsl.worlds.grid.script import state_as_json
from i2pdsl.worlds.grid.spec import ACTIONS, OFFSETS, GridSpec
from i2pdsl.worlds.grid.world import GridWorld, build_world
from worlds_for_tests import as_computed

TEXT = """
map
    A>.
    .~<
tile a
    symbol = A
tile over
    symbol = ">"
    one_way = {east, south}
tile back
    symbol = "<"
    one_way = west
tile mud
    symbol = "~"
    cost = 0.75
character ann
    success = 0.8
    goals = a
character bob
    pushes = ann
    pulls = ann
    toward = ann
    attitude = {-1, 2}
planning
    gamma = 0.8
"""
ONE_WAY = {(1, 0): ("east", "south"), (2, 1): ("west",)}


@cache
def spec() -> GridSpec:
    return parse_world(Source("lane.world", TEXT), "lane")


@cache
def world() -> GridWorld:
    return build_world(spec())


def goes(cell: tuple[int, int], way: str) -> tuple[int, int] | None:
    """The cell that a step leads to."""
    dx, dy = OFFSETS[ACTIONS.index(way)]
    there = cell[0] + dx, cell[1] + dy
    open_ = all(way in ONE_WAY.get(c, ACTIONS) for c in (cell, there))
    return there if there in spec().free_cells and open_ else None


def moved(ann: tuple[int, int], bob: tuple[int, int], who: str, action: str):
    """Where the two are after an action that succeeds."""
    me, other = (ann, bob) if who == "ann" else (bob, ann)
    way, pulls = action.removeprefix("pull_"), action.startswith("pull_")
    if way == "stay" or (target := goes(me, way)) is None:
        return ann, bob
    if pulls:
        if target == other or goes(other, way) != me:
            return ann, bob
        return me, target  # only bob pulls
    if target == other:
        if who == "ann" or (beyond := goes(other, way)) is None:
            return ann, bob
        return beyond, target
    return (target, bob) if who == "ann" else (ann, target)


@pytest.mark.parametrize("listed_by", [build_dynamics, as_computed])
def test_all_moves_are_those_of_the_rules(listed_by: Callable[[GridSpec], Dynamics]) -> None:
    dynamics = listed_by(spec())
    places = [state_as_json(spec(), dynamics, s) for s in range(dynamics.state_count)]
    states = [(tuple(p["ann"]), tuple(p["bob"])) for p in places]
    for number, state in enumerate(states):
        for who, c in enumerate(spec().characters):
            for a, action in enumerate(c.actions):
                after = states[dynamics.successor[who][a, number]]
                assert after == moved(*state, c.name, action), (state, c.name, action)


def test_values_count_what_the_ground_costs() -> None:
    """Ann's values by loops: what she gets, and what comes after bob's uniform answer."""
    dynamics = build_dynamics(spec())
    places = [state_as_json(spec(), dynamics, s) for s in range(dynamics.state_count)]
    states = [(tuple(p["ann"]), tuple(p["bob"])) for p in places]
    value = dict.fromkeys(states, 0.0)
    answers = spec().characters[1].actions

    def q(state, action: str) -> float:
        reward = (state[0] == (0, 0)) - (0.1 if action == "stay" else 1.0)
        reward -= 0.75 * (state[0] == (1, 1))
        total = 0.0
        for p, middle in ((0.8, moved(*state, "ann", action)), (0.2, state)):
            total += p * sum(value[moved(*middle, "bob", b)] for b in answers) / len(answers)
        return reward + 0.8 * total

    for _ in range(120):
        value = {state: max(q(state, a) for a in ACTIONS) for state in states}
    found = action_values(world().tables, 0, np.arange(len(states)))[..., 0]
    expected = [[q(state, a) for a in ACTIONS] for state in states]
    np.testing.assert_allclose(found, expected, atol=1e-5)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("one_way = west", "one_way = up", "there is no direction `up`"),
        ("one_way = west", "one_way = stay", "there is no direction `stay`"),
        ("cost = 0.75", "cost = much", "`cost` must be a number"),
        ("cost = 0.75", "cost = 1e9", "between -1e6 and 1e6"),
    ],
)
def test_what_cannot_be_is_said(old: str, new: str, message: str) -> None:
    with pytest.raises(StoryError, match=message):
        parse_world(Source("lane.world", TEXT.replace(old, new)), "lane")


def test_arrows_are_drawn() -> None:
    from i2pdsl.render.grid.pictures import stage_of
    from i2pdsl.render.grid.scene import stage_background

    arrows = stage_background(stage_of(spec())).count("rotate(")
    two_ways = Source("lane.world", TEXT.replace("    one_way = west\n", ""))
    plain = stage_background(stage_of(parse_world(two_ways, "lane")))
    assert arrows - plain.count("rotate(") == 1
