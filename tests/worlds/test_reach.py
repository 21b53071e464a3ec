"""Warnings of goals that cannot be reached, or are not worth the way."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from commands_for_tests import Run
from i2pdsl.errors import Source
from i2pdsl.worlds.find import find_spec
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.grid.policy import action_values
from i2pdsl.worlds.grid.reach import goal_warnings, worthwhile_steps
from i2pdsl.worlds.grid.spec import STAY, Settings
from worlds_for_tests import STORIES, planned


def world(rows: tuple[str, ...], extra: str = "", goals: str = "near, far") -> str:
    drawn = "".join(f"    {row}\n" for row in rows)
    tiles = "tile near\n    symbol = A\ntile far\n    symbol = B\n"
    return f"map\n{drawn}{tiles}character bob\n    goals = {{{goals}}}\n{extra}"


def told(text: str) -> list[str]:
    spec = parse_world(Source("w.world", text), "w")
    return [d.render() for d in goal_warnings(spec, "w.world")]


@pytest.mark.parametrize("name", ["fork", "kitchen", "maze", "porters"])
def test_nothing_is_said_of_the_worlds_that_ship(name: str) -> None:
    path = STORIES / "worlds" / f"{name}.world"
    assert goal_warnings(find_spec(name), str(path)) == ()


def test_a_goal_that_nobody_can_reach() -> None:
    (one,) = told(world(("A....#B",)))
    assert one.splitlines()[0] == (
        "w.world:8:20: warning[world-goal]: bob can never get to `far`: no way leads there"
    )
    assert "hint: open a way" in one


def test_two_rooms_without_a_door_and_a_small_pocket() -> None:
    both = told(world(("A..#..B",)))
    assert len(both) == 2
    assert "`near`" in both[0]
    assert "from 3 of 6 cells" in both[1]
    assert told(world(("A.........B#.", "..........." + "#."))) == []


@pytest.mark.parametrize(("gamma", "success"), [(0.9, 1.0), (0.9, 0.5), (0.95, 0.7), (0.8, 1.0)])
def test_ways_that_do_not_pay_are_those_that_planning_does_not_walk(
    gamma: float, success: float
) -> None:
    cells = 40
    text = world(("A" + "." * (cells - 2) + "B",), f"planning\n    gamma = {gamma}\n", "near")
    text = text.replace("goals", f"success = {success}\n    goals")
    built = planned(text)
    best = action_values(built.tables, 0, np.arange(cells)).argmax(1)[:, 0]
    walked = int((best[1:] != STAY).sum())
    assert 0 < walked < cells - 1
    assert worthwhile_steps(built.spec.settings, success, cells - 1) == walked
    (one,) = told(text)
    assert f"from {walked + 1} steps on it does not pay for bob to walk to `near`" in one
    assert f"staying is better on {cells - 1 - walked} of {cells} cells" in one
    wanted = float(one.partition("`goal = ")[2].partition("`")[0])
    assert told(f"{text}rewards\n    goal = {wanted}\n") == []
    assert told(f"{text}rewards\n    goal = {wanted * 0.8}\n") != []


@pytest.mark.parametrize("extra", ["rewards\n    goal = -1\n", "planning\n    gamma = 0\n"])
def test_a_goal_that_is_never_worth_it(extra: str) -> None:
    assert (
        "it never pays for bob to go to `near`: staying is better"
        in told(world(("A...B",), extra))[0]
    )


def test_numbers_of_all_kinds_have_an_answer() -> None:
    for goal in (-1e6, 0.0, 1e-9, 1.0, 1e6):
        for move, stay in ((-1.0, -0.1), (0.0, 0.0), (-1e6, 1e6), (1e6, -1e6), (-0.1, -1.0)):
            for gamma in (0.0, 0.5, 1 - 1e-9):
                numbers = Settings(goal=goal, move=move, stay=stay, gamma=gamma)
                for success in (1e-9, 0.5, 1.0):
                    assert 0 <= worthwhile_steps(numbers, success, 50) <= 50
                extra = f"rewards\n    goal = {goal}\n    move = {move}\n    stay = {stay}\n"
                told(world(("A" + "." * 30 + "B",), f"{extra}planning\n    gamma = {gamma}\n"))


def test_stories_are_told_what_matters_where_they_play(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, i2p: Run
) -> None:
    monkeypatch.chdir(tmp_path)
    rows = ("A" + "." * 79 + "B", "#" * 78 + "...", "#" * 78 + "...")
    Path("w.world").write_text(world(rows), encoding="utf-8")
    text = "world w\nlength 4\n{start}maximize depict(G_bob = far)\nsearch beam(starts = 2)\n"
    Path("s.story").write_text(text.format(start="start at(bob, (2, 0))\n"), encoding="utf-8")
    said = i2p("check", "s.story")
    assert said.status == 0
    assert said.err.count("warning[world-goal]") == 1
    assert "w.world:10:20: warning[world-goal]: from 75 steps on" in said.err
    assert "for bob to walk to `far`" in said.err
    Path("s.story").write_text(text.format(start=""), encoding="utf-8")
    assert i2p("check", "s.story").err.count("warning[world-goal]") == 2
    assert i2p("check", "w.world").err.count("warning[world-goal]") == 2
    near = text.format(start="start at(bob, (40, 0))\n")
    Path("s.story").write_text(near, encoding="utf-8")
    assert "warning" not in i2p("check", "s.story").err
    cheap = near.replace("world w", "world w(move = -2)")
    Path("s.story").write_text(cheap, encoding="utf-8")
    assert i2p("run", "s.story", "--out", "o", "--format", "svg").err.count("world-goal") == 2
