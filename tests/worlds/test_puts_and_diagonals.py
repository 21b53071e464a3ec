"""What is put down and handed over, and moves aslant, against the rules in docs/worlds.md."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from i2pdsl.errors import Source, StoryError
from i2pdsl.explain import explain, questions_of
from i2pdsl.render.grid.choreography import choreograph
from i2pdsl.render.grid.pictures import stage_of
from i2pdsl.render.grid.stage import describe
from i2pdsl.scripts import Script
from i2pdsl.stories import Story
from i2pdsl.worlds.grid.dynamics import Dynamics, build_dynamics
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.grid.script import state_as_json
from i2pdsl.worlds.grid.spec import GridSpec
from searches_for_tests import compiling_briefly
from worlds_for_tests import as_computed

TEXT = """
map
    . .|W
        -
    . . .
    . # D
tile way
    symbol = W
    one_way = {east, south, west}
tile goal
    cell = (0, 0)
character ann
    goals = {goal, none}
    carries = {key, nut}
character bob
    pushes = ann
    carries = {key, nut}
    puts_down = {nut, key}
    diagonals = yes
    toward = ann
    attitude = {-2, 2}
object key
object nut
    cell = (0, 1)
object door
    symbol = D
    opened_by = key
"""
WAYS = {"north": (0, -1), "south": (0, 1), "east": (1, 0), "west": (-1, 0)}
WALLS = [{(1, 0), (2, 0)}, {(2, 0), (2, 1)}]
FREE = {(c, r) for c in range(3) for r in range(3)} - {(1, 2)}


def spec_of(text: str = TEXT) -> GridSpec:
    return parse_world(Source("cell.world", text), "cell")


def step(cell: tuple[int, int], way: str) -> tuple[int, int] | None:
    """The next cell straight on, if nothing on the ground is in the way."""
    there = cell[0] + WAYS[way][0], cell[1] + WAYS[way][1]
    wrong = way == "north" and (2, 0) in (cell, there)
    return None if there not in FREE or {cell, there} in WALLS or wrong else there


def moved(state: dict, who: str, action: str) -> dict:
    """What a successful action makes of a state of script.json."""
    after, here = dict(state), tuple(state[who])
    at = lambda cell: next((n for n, place in state.items() if place == list(cell)), None)
    if action.startswith("put_"):
        there = step(here, action.removeprefix("put_"))
        for thing in ("nut", "key") if there else ():
            if state[thing] == "bob":
                other = at(there)
                if other is None:
                    return after | {thing: list(there)}
                if other == "ann":
                    return after | {thing: "ann"}
        return state
    if action == "stay":
        return state
    if "_" in action:
        one, two = action.split("_")
        corners = [step(here, one), step(here, two)]
        if None in corners:
            return state
        ends = {step(corners[0], two), step(corners[1], one)}
        there = ends.pop() if len(ends) == 1 else None
    else:
        there = step(here, action)
    if there is None:
        return state
    thing = at(there)
    if thing in ("key", "nut"):
        after[thing] = who
    elif thing == "door" and state["key"] == who:
        after["door"] = None
    elif thing == "ann" and action in WAYS:
        beyond = step(there, action)
        if beyond is None or at(beyond) is not None:
            return state
        after["ann"] = list(beyond)
    elif thing is not None:
        return state
    return after | {who: list(there)}


@pytest.mark.parametrize("listed_by", [build_dynamics, as_computed])
def test_all_moves_are_those_of_the_rules(listed_by: Callable[[GridSpec], Dynamics]) -> None:
    spec = spec_of()
    dynamics = listed_by(spec)
    states = [state_as_json(spec, dynamics, s) for s in range(dynamics.state_count)]
    cells = [list(cell) for cell in spec.free_cells]
    hands = ["ann", "bob"]
    listed = [
        {"ann": ann, "bob": bob, "key": key, "nut": nut, "door": door}
        for ann, bob, key, nut, door in product(
            cells, cells, cells + hands, cells + hands, ([2, 2], None)
        )
        if len({str(p) for p in (ann, bob, key, nut, door) if isinstance(p, list)})
        == sum(isinstance(p, list) for p in (ann, bob, key, nut, door))
    ]
    assert sorted(map(str, states)) == sorted(map(str, listed))
    assert spec.state_count == len(listed)
    changed: dict[str, int] = {}
    for who, character in enumerate(spec.characters):
        for a, action in enumerate(character.actions):
            for number, state in enumerate(states):
                after = states[dynamics.successor[who][a, number]]
                assert after == moved(state, character.name, action), (state, action)
                changed[action] = changed.get(action, 0) + (after != state)
    assert spec.characters[0].actions == (*WAYS, "stay")
    aslant = [f"{one}_{two}" for one in ("north", "south") for two in ("east", "west")]
    assert set(changed) == {*WAYS, "stay", *aslant, *(f"put_{way}" for way in WAYS)}
    assert [name for name, n in changed.items() if not n] == ["stay"]


YARD = """
map
    ....
    ....
    ..GH
tile green
    symbol = G
tile hut
    symbol = H
character ann
    goals = {green, hut}
    carries = key
character bob
    carries = key
    puts_down = key
    diagonals = yes
    pulls = box
    toward = ann
    attitude = {-2, 2}
object key
    cell = (1, 1)
object box
"""


@pytest.fixture(scope="module")
def told(tmp_path_factory: pytest.TempPathFactory) -> Script:
    folder = tmp_path_factory.mktemp("puts")
    (folder / "yard.world").write_text(YARD)
    text = """world yard
length 6
start at(ann, (0, 2)) and at(bob, (2, 1)) and at(box, (3, 0))
pin script[1] = [ann: stay, bob: west]
pin script[2] = [ann: north, bob: put_north]
pin script[3] = [ann: stay, bob: north]
pin script[4] = [ann: east, bob: put_south]
pin script[5] = [ann: stay, bob: south_east]
maximize depict(G_ann = hut)
"""
    with compiling_briefly(places=8):
        return Story.from_text(text, folder=folder).solve(0).script


def test_what_is_asked_of_it(told: Script) -> None:
    at = lambda question: np.flatnonzero(np.asarray(told.query(question))) + 1
    assert at("[takes(bob, key) @ script[t]]").tolist() == [1, 3]
    assert at("[puts(bob, key) @ script[t]]").tolist() == [2]
    assert at("[gives(bob, key) @ script[t]]").tolist() == [4]
    assert at("[holds(ann, key) @ script[t]]").tolist() == [4, 5, 6]
    assert not at("[takes(ann, key) @ script[t]]").size
    assert not at("[pushes(bob, key) @ script[t]]").size
    assert at("[moved(bob) @ script[t]]").tolist()[:3] == [1, 3, 5]
    assert 5 in at("[faces(bob, (3, 2)) @ script[t]]")


def test_it_is_written_read_and_drawn(told: Script, tmp_path: Path) -> None:
    document = told.record.as_json()
    assert document["frames"][4]["bob"] == {"action": "south_east", "moved": True}
    read = Script.load(told.save(tmp_path / "script.json"))
    assert (read.trajectory.actions == told.trajectory.actions).all()
    film = choreograph(stage_of(told.world.spec), document)
    beats = [describe(b) for b in film.beats if b.actor == "key"]
    assert beats == ["bob takes key", "bob puts key down", "bob takes key", "bob hands key to ann"]
    assert "bob goes south east" in map(describe, film.beats)
    times = [key.time for key in film.tracks["key"]]
    assert times == sorted(times)
    lying = [key for key in film.tracks["key"] if key.time <= 2][-1]
    assert (lying.x, lying.y, lying.scale_x) == (1, 0, 1.0)
    last, holder = film.tracks["key"][-1], document["frames"][-1]["state"]["ann"]
    assert abs(last.x - holder[0]) < 0.5 > abs(last.y - holder[1])


def test_the_reason_of_a_frame_names_what_was_done(told: Script) -> None:
    """One's actions are not those of the other: `south_east` is bob's sixth."""
    reasons = explain(told, questions_of(told))
    named = {(r.first, r.who): r.taken.action for r in reasons if r.taken is not None}
    assert len(named) == 12
    for (frame, who), action in named.items():
        assert told.record.frames[frame - 1][who]["action"] == action


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("puts_down = {nut, key}", "puts_down = {nut, kex}", "no object `kex`"),
        ("puts_down = {nut, key}", "puts_down = {nut, door}", "does not carry `door`"),
        ("diagonals = yes", "diagonals = maybe", "`diagonals` cannot be `maybe`"),
        ("puts_down = {nut, key}\n", "\n", "`key` is carried, but has no place at first"),
    ],
)
def test_what_cannot_be_is_said(old: str, new: str, message: str) -> None:
    with pytest.raises(StoryError) as caught:
        spec_of(TEXT.replace(old, new))
    assert any(message in d.message for d in caught.value.diagnostics)
