"""Somebody who wants to have been somewhere before it is at its goal: hypotheses, states and plans
against value iteration with dictionaries over where one is and where one has been."""

from __future__ import annotations

import math
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from i2pdsl.errors import Source, StoryError
from i2pdsl.scripts import Script
from i2pdsl.stories import Story
from i2pdsl.worlds.grid.hypotheses import grid_hypotheses
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.grid.policy import log_policy, value
from i2pdsl.worlds.grid.spec import GridSpec
from i2pdsl.worlds.grid.world import build_world

ALONE = """
map
    A..B
    .#..
    ..CD
tile a
    symbol = A
tile b
    symbol = B
tile c
    symbol = C
tile d
    symbol = D
    cost = 0.3
character ann
    success = 0.7
    goals = {a, c, none}
    via = {b, c}
rewards
    goal = 2
planning
    gamma = 0.9
    beta = 1.5
"""
PAIR = """
map
    A.B.
    ..#.
tile a
    symbol = A
tile b
    symbol = B
character ann
    success = 0.8
    goals = {a, b}
    via = b
character bob
    pushes = ann
    toward = ann
    attitude = {-1, 2}
"""
WAYS = {"north": (0, -1), "south": (0, 1), "east": (1, 0), "west": (-1, 0), "stay": (0, 0)}


def spec_of(text: str) -> GridSpec:
    return parse_world(Source("cell.world", text), "cell")


def test_the_hypotheses() -> None:
    rows = grid_hypotheses(spec_of(ALONE))
    found = {(row["G_ann"], row.get("via_ann")) for row in rows if row["R_ann"]}
    assert found == {
        *(("a", via) for via in ("none", "b", "c")),
        *(("c", via) for via in ("none", "b")),
        ("none", None),
    }
    assert len(rows) == 7


def plan(goal: str, via: str | None) -> tuple[dict, dict]:
    """V and the policy of who wants to be at a goal, having been somewhere."""
    spec = spec_of(ALONE)
    at = {tile.name: tile.cells[0] for tile in spec.tiles}
    states = list(product(spec.free_cells, (False, True)))

    def step(cell, way):
        there = cell[0] + WAYS[way][0], cell[1] + WAYS[way][1]
        return there if there in spec.free_cells else cell

    def quality(values, state, way):
        cell, been = state
        paid = 2.0 if goal != "none" and cell == at[goal] and (been or via is None) else 0.0
        now = paid + (-0.1 if way == "stay" else -1.0) - (0.3 if cell == at["d"] else 0.0)
        then = 0.0
        for p, there in ((0.7, step(cell, way)), (0.3, cell)):
            then += p * values[there, been or (via is not None and there == at[via])]
        return now + 0.9 * then

    values = dict.fromkeys(states, 0.0)
    for _ in range(300):
        values = {s: max(quality(values, s, way) for way in WAYS) for s in states}
    policy = {}
    for s in states:
        weights = {way: math.exp(1.5 * quality(values, s, way)) for way in WAYS}
        policy |= {(s, way): w / sum(weights.values()) for way, w in weights.items()}
    return values, policy


def test_plans_are_those_of_the_product() -> None:
    world = build_world(spec_of(ALONE))
    states = np.arange(world.dynamics.state_count)
    assert len(states) == world.spec.state_count == 11 * 2**2
    found = np.exp(log_policy(world.tables, 0, states)[..., 0, :])
    worth = value(world.tables, 0, states)[..., 0, :]
    for number, row in enumerate(grid_hypotheses(world.spec)):
        if not row["R_ann"]:
            continue
        via = None if row.get("via_ann", "none") == "none" else row["via_ann"]
        values, policy = plan(row["G_ann"], via)
        for state in states:
            cell, *marks = world.dynamics.cells[state][:3]
            been = bool(marks[("b", "c").index(via)] > world.dynamics.absent) if via else False
            key = tuple(world.dynamics.coordinates[cell].tolist()), been
            if via and key == (world.spec.tiles["abcd".index(via)].cells[0], False):
                continue  # who is there has been there
            assert worth[state, number] == pytest.approx(values[key], abs=1e-4)
            for a, way in enumerate(WAYS):
                assert found[state, a, number] == pytest.approx(policy[key, way], abs=1e-4)


def test_where_one_has_been_is_kept_also_by_a_push() -> None:
    world = build_world(spec_of(PAIR))
    dynamics, absent = world.dynamics, world.dynamics.absent
    tile = dynamics.coordinates.tolist().index([2, 0])
    pushed = 0
    for who, action in product((0, 1), range(5)):
        after = dynamics.successor[who][action]
        there, before = dynamics.cells[after], dynamics.cells
        been = (before[:, 2] > absent) | (there[:, 0] == tile)
        assert ((there[:, 2] > absent) == been).all()
        pushed += int(((there[:, 0] == tile) & (before[:, 0] != tile)).sum()) if who else 0
    assert pushed
    marks = dynamics.cells[world.starts()]
    assert ((marks[:, 2] > absent) == (marks[:, 0] == tile)).all()
    assert len(marks) * 2 == world.spec.state_count


@pytest.mark.parametrize("horizon", [0, 14])
def test_viewers_see_the_detour(horizon: int, tmp_path: Path) -> None:
    limit = f"\n    horizon = {horizon}" if horizon else ""
    text = ALONE.replace("    beta = 1.5", f"    beta = 4{limit}")
    text = text.replace("via = {b, c}", "via = {b, c}\n    cell = (2, 2)")
    (tmp_path / "walk.world").write_text(text.replace("success = 0.7", "success = 1"))
    told = "world walk\nlength 8\nmaximize depict(G_ann = a and via_ann = b)\n"
    story = Story.from_text(told, folder=tmp_path)
    script = story.solve(0).script
    ends = [tuple(frame["state"]["ann"]) for frame in script.record.frames]
    assert (3, 0) in ends
    assert ends[-1] == (0, 0)
    assert script.query("P(via_ann = b | script[:T])") > 0.9
    read = Script.load(script.save(tmp_path / "script.json"))
    assert (read.trajectory.states == script.trajectory.states).all()
    assert set(script.record.start) == {"ann"}
    rows = [
        {"who": "ann", "frame": t, "x": x, "y": y}
        for t, (x, y) in enumerate([script.record.start["ann"], *ends])
    ]
    again = Script.from_positions("walk", rows, tmp_path)
    assert (again.trajectory.states == script.trajectory.states).all()


def test_what_cannot_be_is_said() -> None:
    with pytest.raises(StoryError, match="no tile `e`"):
        spec_of(ALONE.replace("via = {b, c}", "via = {b, e}"))
    with pytest.raises(StoryError, match="where `ann` wants to have been"):
        spec_of(ALONE.replace("tile d", "tile via_ann"))
