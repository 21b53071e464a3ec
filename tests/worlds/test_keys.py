"""Keys that are carried and doors that they open, against the rules in words of docs/worlds.md."""

from __future__ import annotations

import json
from collections.abc import Callable
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from i2pdsl.errors import Source, StoryError
from i2pdsl.render.grid.stage import describe
from i2pdsl.scripts import Script
from i2pdsl.stories import Story
from i2pdsl.worlds.grid.dynamics import Dynamics, build_dynamics
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.grid.script import state_as_json
from i2pdsl.worlds.grid.spec import ACTIONS, OFFSETS, GridSpec
from searches_for_tests import compiling_briefly
from worlds_for_tests import as_computed

TEXT = """
map
    .G#.
    k.D.
tile goal
    symbol = G
tile far
    cell = (3, 0)
character ann
    success = 0.7
    goals = {goal, far}
character bob
    pushes = ann
    carries = key
    toward = ann
    attitude = {-2, 2}
object key
    symbol = k
object door
    symbol = D
    opened_by = key
"""


def spec_of(text: str = TEXT) -> GridSpec:
    return parse_world(Source("cell.world", text), "cell")


def moved(spec: GridSpec, state: dict, who: str, action: str) -> dict:
    """What a successful action makes of a state of script.json."""
    (dx, dy), after = OFFSETS[ACTIONS.index(action)], dict(state)
    (x, y), free = state[who], {tuple(cell) for cell in spec.free_cells}
    target, beyond = [x + dx, y + dy], [x + 2 * dx, y + 2 * dy]
    if tuple(target) not in free or action == "stay":
        return state
    there = next((name for name, place in state.items() if place == target), None)
    if there == "key" and who == "bob":
        after["key"] = "bob"
    elif there == "door" and who == "bob" and state["key"] == "bob":
        after["door"] = None
    elif there == "ann" and who == "bob":
        if tuple(beyond) not in free or beyond in state.values():
            return state
        after["ann"] = beyond
    elif there is not None:
        return state
    after[who] = target
    return after


@pytest.mark.parametrize("listed_by", [build_dynamics, as_computed])
def test_all_moves_are_those_of_the_rules(listed_by: Callable[[GridSpec], Dynamics]) -> None:
    spec = spec_of()
    dynamics = listed_by(spec)
    states = [state_as_json(spec, dynamics, s) for s in range(dynamics.state_count)]
    cells = [list(cell) for cell in spec.free_cells]
    listed = [
        {"ann": ann, "bob": bob, "key": key, "door": door}
        for ann, bob, key, door in product(cells, cells, ([0, 1], "bob"), ([2, 1], None))
        if len({str(p) for p in (ann, bob, key, door) if isinstance(p, list)})
        == sum(isinstance(p, list) for p in (ann, bob, key, door))
    ]
    assert sorted(map(str, states)) == sorted(map(str, listed))
    assert spec.state_count == len(listed)
    for number, state in enumerate(states):
        for (who, name), (a, action) in product(enumerate(("ann", "bob")), enumerate(ACTIONS)):
            after = states[dynamics.successor[who][a, number]]
            assert after == moved(spec, state, name, action), (state, name, action)


def test_plans_hang_on_where_keys_and_doors_are() -> None:
    key = lambda text: parse_world(Source("cellar.world", text), "cellar").planning_key
    assert key(TEXT) == key(TEXT + "\n")
    assert key(TEXT) != key(TEXT.replace("k.D.", ".kD."))
    assert key(TEXT) != key(TEXT.replace("k.D.", "k..D"))


def test_each_of_several_keys_opens() -> None:
    text = TEXT.replace("G#.", "G#h").replace("carries = key", "carries = {key, hook}")
    text = text.replace("opened_by = key", "opened_by = {key, hook}")
    spec = spec_of(text + "object hook\n    symbol = h\n")
    dynamics = build_dynamics(spec)
    states = [state_as_json(spec, dynamics, s) for s in range(dynamics.state_count)]
    opened = 0
    for number, state in enumerate(states):
        if state["bob"] == [1, 1] and state["door"] == [2, 1] and state["ann"] != [2, 1]:
            after = states[dynamics.successor[1][ACTIONS.index("east"), number]]
            able = "bob" in (state["key"], state["hook"])
            assert after["door"] == (None if able else [2, 1])
            opened += able
    assert opened


def test_states_are_found_without_a_table_of_all_arrangements(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """With the things that are alike in any order."""
    text = TEXT.replace("    pushes = ann", "    pushes = {ann, box}")
    spec = spec_of(text + "object box\n    count = 2\n")
    listed = build_dynamics(spec)
    assert len(listed.lookup) == spec.arrangement_count
    monkeypatch.setattr("i2pdsl.worlds.grid.spec.GridSpec.is_sparse", True)
    sparse = build_dynamics.__wrapped__(spec)
    assert len(sparse.lookup) == 0
    for one, other in zip(listed.successor, sparse.successor, strict=True):
        assert (one == other).all()
    codes = np.arange(spec.arrangement_count)
    assert (sparse.find(codes) == listed.lookup).all()


@pytest.fixture(scope="module")
def told(tmp_path_factory: pytest.TempPathFactory):
    folder = tmp_path_factory.mktemp("keys")
    (folder / "cell.world").write_text(TEXT)
    text = "world cell\nlength 6\nstart at(ann, (0, 0)) and at(bob, (1, 1))\n"
    text += "maximize depict(rho > 0 and G_ann = far)\n"
    text += "require eventually [opens(bob, door)] require eventually [at(ann, far)]\n"
    return Story.from_text(text.replace(" require", "\nrequire"), folder=folder)


@pytest.fixture(scope="module")
def script(told) -> Script:
    with compiling_briefly(places=8):
        return told.solve(0).script


def test_who_cares_fetches_the_key_and_opens(script: Script) -> None:
    at = lambda question: np.asarray(script.query(question))
    took = at("[takes(bob, key) @ script[t]]")
    opened = at("[opens(bob, door) @ script[t]]")
    assert took.sum() == opened.sum() == 1
    held = at("[holds(bob, key) @ script[t]]")
    assert (held == np.cumsum(took)).all()
    assert (at("[absent(door) @ script[t]]") == np.cumsum(opened)).all()
    assert not at("[pushes(bob, key) @ script[t]] + [pushes(bob, door) @ script[t]]").any()
    assert script.query("P(rho > 0 | script[:T])") > 0.5


def test_a_script_is_written_read_and_drawn(script: Script, tmp_path: Path) -> None:
    from i2pdsl.render.grid.choreography import choreograph
    from i2pdsl.render.grid.pictures import stage_of

    document = script.record.as_json()
    read = Script.load(script.save(tmp_path / "script.json"))
    assert (read.trajectory.states == script.trajectory.states).all()
    wrong = json.dumps(document).replace('"key": "bob"', '"key": "ann"')
    (tmp_path / "wrong.json").write_text(wrong)
    with pytest.raises(StoryError, match="`ann` cannot carry `key`"):
        Script.load(tmp_path / "wrong.json")
    film = choreograph(stage_of(script.world.spec), document)
    beats = [describe(beat) for beat in film.beats if beat.verb == "vanish"]
    assert beats == ["bob takes key", "bob opens door"]
    last = film.tracks["key"][-1]
    holder = document["frames"][-1]["state"]["bob"]
    assert document["frames"][-1]["state"]["key"] == "bob"
    assert abs(last.x - holder[0]) < 0.5 > abs(last.y - holder[1])
    assert last.scale_x < 1


def test_positions_of_what_is_carried_are_missing(script: Script, tmp_path: Path) -> None:
    (tmp_path / "cell.world").write_text(TEXT)
    states = [script.record.start, *(frame["state"] for frame in script.record.frames)]
    rows = [
        {
            "who": name,
            "frame": t,
            "x": place[0] if on_map else None,
            "y": place[1] if on_map else None,
        }
        for t, state in enumerate(states)
        for name, place in state.items()
        for on_map in [isinstance(place, list)]
    ]
    found = Script.from_positions("cell", rows, tmp_path)
    assert (found.trajectory.states == script.trajectory.states).all()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("opened_by = key", "opened_by = kex", "no other object `kex`"),
        ("opened_by = key", "opened_by = door", "no other object `door`"),
        ("carries = key", "carries = {}", "nobody carries `key`"),
        ("    symbol = k\n", "", "`key` is carried, but has no place at first"),
        ("    pushes = ann", "    pushes = {ann, key}", "is moved by bob, too"),
        ("    opened_by = key", "    opened_by = key\n    may_be_absent = yes", "may be absent"),
        ("carries = key", "carries = {key, door}", "is opened, too"),
    ],
)
def test_what_cannot_be_is_said(old: str, new: str, message: str) -> None:
    text = TEXT.replace("    k.D.", "    ..D.") if not new else TEXT
    with pytest.raises(StoryError) as caught:
        spec_of(text.replace(old, new))
    assert any(message in d.message for d in caught.value.diagnostics)
    assert all(d.span.start > 0 for d in caught.value.diagnostics)
