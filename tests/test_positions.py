"""Scripts from tables of positions: what the world's rules allow is found, the rest is said."""

from __future__ import annotations

import csv
import json
from itertools import product
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest

from commands_for_tests import Run
from i2pdsl.errors import Source, StoryError
from i2pdsl.scripts import script_of_positions
from i2pdsl.stories import Script, Story
from i2pdsl.worlds.grid.kind import KIND
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.grid.spec import GridSpec
from i2pdsl.worlds.inferred import inferred_turns
from i2pdsl.worlds.kinds import kind_of
from i2pdsl.worlds.kinds import parse_world as parse_any
from i2pdsl.worlds.positions import Inferred, read_positions
from worlds_for_tests import SMALL_MAP, Pair, kitchen_text, small_kitchen

Rows = list[dict[str, Any]]


def pair() -> Pair:
    return small_kitchen()


def rows_of(document: dict[str, Any], actions: bool) -> Rows:
    """A script's positions as a table, with what everybody does or without."""
    found = []
    frames = [{"state": document["start"]}, *document["frames"]]
    for number, frame in enumerate(frames):
        for who, place in frame["state"].items():
            act = frame.get(who, {}).get("action") if actions else None
            x, y = place or (None, None)
            found.append({"who": who, "frame": number, "x": x, "y": y, "action": act})
    return found


def told(rows: Any) -> Inferred:
    world = pair().world
    return inferred_turns(KIND, world, read_positions(rows, world.vocabulary))


@pytest.mark.parametrize("seed", range(20))
def test_actions_that_are_given_are_found_again(seed: int) -> None:
    """With them, a script is all that it was: its blocked and failed moves, its events."""
    document = pair().document(pair().random_script(Random(seed), 6, events=0.2))
    found = told(rows_of(document, actions=True))
    assert (found.start, list(found.frames)) == (document["start"], list(document["frames"]))
    assert not found.warnings


@pytest.mark.parametrize("seed", range(20))
def test_as_few_as_can_be_act(seed: int) -> None:
    """Against all turns that there are, by plain Python."""
    truth = pair().reference
    document = pair().document(pair().random_script(Random(seed), 6, events=0.2))
    found = told(rows_of(document, actions=False))
    assert [f["state"] for f in found.frames] == [f["state"] for f in document["frames"]]
    state = truth.state(document["start"])
    for frame in found.frames:
        after = truth.after(state, frame)  # holds it against the rules
        if not frame["event"]:
            acts = [frame[who]["action"] for who in truth.characters]
            least = min(
                sum(action != "stay" for action in turn)
                for turn in product(truth_actions(), repeat=2)
                if after in endings(truth, state, turn)
            )
            assert sum(action != "stay" for action in acts) == least
        state = after


def truth_actions() -> tuple[str, ...]:
    return ("north", "south", "east", "west", "stay")


def endings(truth: Any, state: Any, turn: tuple[str, ...]) -> list[Any]:
    """The states that a turn can lead to."""
    found = [state]
    for who, action in zip(truth.characters, turn, strict=True):
        found = [after for s in found for _, after in truth.outcomes(s, who, action)]
    return found


def place(
    *places: tuple[str, int, int, int], actions: dict[tuple[str, int], str] | None = None
) -> Rows:
    given = actions or {}
    return [
        {"who": who, "frame": frame, "x": x, "y": y, "action": given.get((who, frame))}
        for who, frame, x, y in places
    ]


# P . .
# # . G
# . . .
PUSH = (("robot", 0, 0, 2), ("cheese", 0, 1, 2), ("robot", 1, 1, 2), ("cheese", 1, 2, 2))


def test_a_push_is_taken_for_one_unless_the_table_says_otherwise() -> None:
    """And that this is not sure is said, with the frame and who."""
    found = told(place(*PUSH))
    assert found.frames[0]["cheese"] == {"action": "stay", "moved": False}
    (warning,) = found.warnings
    assert (warning.severity, "cheese" in warning.message, "frame 1" in warning.message) == (
        "warning",
        True,
        True,
    )
    found = told(place(*PUSH, actions={("cheese", 1): "east"}))
    assert found.frames[0]["cheese"] == {"action": "east", "moved": True}
    assert not found.warnings


def test_things_need_rows_only_where_they_move() -> None:
    """Who is absent at first falls where it is met first."""
    rows = place(*PUSH[:2], ("robot", 1, 0, 2), ("cheese", 1, 1, 2), ("table", 1, 1, 0))
    rows += place(("robot", 2, 0, 2), ("cheese", 2, 1, 1))
    found = told(rows)
    assert found.start["table"] is None
    assert found.frames[0]["event"] == {"deus": "table", "to": [1, 0]}
    assert found.frames[1]["state"]["table"] == [1, 0]


MISSED = {"who": "table", "frame": 1, "x": None, "y": None}
WRONG: dict[str, tuple[Rows, str, str]] = {
    "too far": (
        place(*PUSH[:2], ("robot", 1, 0, 2), ("cheese", 1, 1, 0)),
        "`cheese` cannot get from [1, 2] to [1, 0]",
        "can get to [",
    ),
    "a wall": (place(*PUSH[:3], ("cheese", 1, 0, 1)), "`cheese` cannot stand at [0, 1]", ""),
    "one cell": (
        place(*PUSH[:3], ("cheese", 1, 1, 2)),
        "`cheese` and `robot` stand on one cell, [1, 2]",
        "",
    ),
    "at once": (
        place(("robot", 0, 0, 2), ("cheese", 0, 1, 2), ("robot", 1, 1, 2), ("cheese", 1, 0, 2)),
        "`cheese` cannot get from",
        "",
    ),
    "nobody": (place(*PUSH[:3]), "where is `cheese`?", ""),
    "the action": (
        place(*PUSH, actions={("robot", 1): "stay"}),
        "`robot` ends elsewhere by `stay`",
        "it can have been east",
    ),
    "half a cell": (
        [*place(*PUSH[:3]), {"who": "cheese", "frame": 1, "x": 1.5, "y": 2}],
        "whole numbers",
        "",
    ),
    "vanished": (
        [*place(*PUSH[:2], ("table", 0, 1, 0), *PUSH[2:]), MISSED],
        "`table` cannot vanish",
        "",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_impossible_is_said_with_frame_and_who(name: str) -> None:
    rows, message, hint = WRONG[name]
    with pytest.raises(StoryError) as wrong:
        told(rows)
    (diagnostic,) = wrong.value.diagnostics
    assert diagnostic.message.startswith("frame 1: ")
    assert message in diagnostic.message
    assert hint in (diagnostic.hint or "")


TABLE = "who,frame,x,y\nrobot,0,0,2\ncheese,0,1,2\nrobot,1,1,2\ncheese,1,2,2\n"


@pytest.mark.parametrize(
    ("text", "place", "message"),
    [
        ("", (1, 1), "the table is empty"),
        (TABLE.replace("frame", "time"), (1, 1), "there is no column `frame`"),
        (TABLE.replace("cheese,0", "chese,0"), (3, 1), "there is no `chese` in the small"),
        (TABLE.replace("cheese,0,1", "cheese,0,one"), (3, 1), "`x` must be a number, not 'one'"),
        (TABLE.replace("cheese,0,1", "cheese,0,"), (3, 1), "both `x` and `y` are given"),
        (TABLE.replace("robot,1", "robot,0.5"), (4, 1), "frames are whole numbers from 0 on"),
        (TABLE.replace("robot,1", "robot,0"), (4, 1), "frame 0 has `robot` twice"),
        (TABLE.replace(",1,", ",3,", 2), (1, 1), "frame"),
        (TABLE + "robot,2,1\n", (6, 1), "this row has 3 cells"),
        (TABLE.splitlines()[0], (1, 1), "a script needs frame 0 and at least one more"),
        ('who,frame,x,y\n"robot,0,0,2\n', (2, 1), "this is no CSV"),
    ],
)  # fmt: skip
def test_a_wrong_table_is_shown_at_its_line(
    text: str, place: tuple[int, int], message: str, tmp_path: Path
) -> None:
    (tmp_path / "table.csv").write_text(text, encoding="utf-8")
    with pytest.raises(StoryError) as wrong:
        told(tmp_path / "table.csv")
    diagnostic = wrong.value.diagnostics[0]
    assert message in diagnostic.message
    assert diagnostic.span.source.position(diagnostic.span.start) == place


def test_tables_may_be_of_any_make(tmp_path: Path) -> None:
    """A file, rows, columns, a record array, a DataFrame."""
    import pandas

    (tmp_path / "table.csv").write_text(TABLE, encoding="utf-8")
    rows = place(*PUSH)
    frame = pandas.DataFrame(rows)
    columns = {name: frame[name].to_numpy() for name in frame}
    expected = told(tmp_path / "table.csv").frames
    for table in (rows, frame, columns, frame.to_records(index=False)):
        assert told(table).frames == expected


def spec() -> GridSpec:
    return parse_world(Source("small.world", kitchen_text(SMALL_MAP, gamma="0.8")), "small")


def test_a_script_from_positions_can_be_asked_and_kept(tmp_path: Path) -> None:
    script = script_of_positions(spec(), place(*PUSH), {}, {})
    assert [w.code for w in script.warnings] == ["positions"]
    again = Script.load(script.save(tmp_path / "script.json"))
    question = "P(rho > 0 | script[:t])"
    assert (again.query(question) == script.query(question)).all()


def test_a_story_gives_its_audience_and_names(tmp_path: Path, i2p: Run) -> None:
    text = kitchen_text(SMALL_MAP, gamma="0.8")
    (tmp_path / "small.world").write_text(text, encoding="utf-8")
    lines = "world small\nlength 2\nlet friend = rho > 0\naudience bayesian(forgetting = 0.2)\n"
    (tmp_path / "my.story").write_text(f"{lines}maximize depict(friend)\n", encoding="utf-8")
    (tmp_path / "table.csv").write_text(TABLE, encoding="utf-8")
    done = i2p("script", tmp_path / "my.story", tmp_path / "table.csv", "-o", tmp_path / "o.json")
    assert done.status == 0, done.err
    assert "may have moved by itself or been pushed in frame 1" in done.err
    told = Script.load(tmp_path / "o.json").query("P(friend | script[:1])")
    plain = i2p(
        "script",
        tmp_path / "small.world",
        tmp_path / "table.csv",
        "-o",
        tmp_path / "p.json",
        "--json",
    )
    assert json.loads(plain.out)["frames"] == 1
    script = Script.load(tmp_path / "p.json")
    assert script.query("P(rho > 0 | script[:1])", audience="bayesian(forgetting = 0.2)") == told
    assert i2p("script", "nowhere", tmp_path / "table.csv").status == 1


# Where bodies move.


def plane_rows(script: Script, digits: int) -> Rows:
    count = len(script.world.vocabulary.characters)
    return [
        {
            "who": who,
            "frame": t,
            "x": round(state[2 * i], digits),
            "y": round(state[2 * i + 1], digits),
        }
        for t, state in enumerate(script.trajectory.states)
        for i, who in enumerate(script.world.vocabulary.characters[:count])
    ]


def test_velocities_are_found_in_a_plane() -> None:
    """Those of a chase, whose places come again; viewers believe the same of motion that nothing
    stopped."""
    script = Story.from_text("world meadow\nlength 12\nsearch naive(noise = 0.3)\n").solve(1).script
    again = script_of_positions(script.world.spec, plane_rows(script, 6), {}, {})
    assert np.allclose(again.trajectory.states, script.trajectory.states, atol=1e-4)
    rows = plane_rows(script, 6)
    rows[-1]["x"] += 3 * script.world.spec.characters[-1].fastest
    with pytest.raises(StoryError, match=r"frame 12: .* cannot be there"):
        script_of_positions(script.world.spec, rows, {}, {})


def test_who_is_faster_than_it_can_was_pushed() -> None:
    """A slow one before a fast one: no velocity of its own leads there."""
    text = (
        "kind = plane\nsize\n    width = 8\n    height = 4\nplace home\n    at = (7, 2)\n"
        "character fast\n    at = (1, 2)\n    speed = 0.13\n    mass = 10\n    goals = {home}\n"
        "character slow\n    at = (2, 2)\n    speed = 0.02\n    goals = {home}\n"
    )
    spec = parse_any(Source("push.world", text), "push")
    world = kind_of(spec).rules(spec)
    start = world.starts()[0]
    states = [start]
    for _ in range(8):
        states.append(world.transition(world.tables, states[-1], np.array([0.25, 0.0, 0.0, 0.0])))
    rows = [
        {"who": who, "frame": t, "x": state[2 * i], "y": state[2 * i + 1]}
        for t, state in enumerate(states)
        for i, who in enumerate(("fast", "slow"))
    ]
    script = script_of_positions(spec, rows, {}, {})
    assert np.allclose(script.trajectory.states, states, atol=1e-3)


def test_a_hill_says_that_positions_are_not_enough(tmp_path: Path) -> None:
    (tmp_path / "table.csv").write_text(
        "who,frame,x,y\nhopper,0,0,0\nhopper,1,1,0\n", encoding="utf-8"
    )
    with pytest.raises(StoryError, match="does not say all of a state"):
        Script.from_positions("hill", tmp_path / "table.csv")
    with pytest.raises(StoryError, match="there is no world"):
        Script.from_positions("nowhere", tmp_path / "table.csv")


def test_what_was_written_for_a_spreadsheet_is_read(tmp_path: Path) -> None:
    """A byte order mark, quotes, empty lines, another order of columns, a column of its own."""
    rows = place(*PUSH)
    with open(tmp_path / "table.csv", "w", encoding="utf-8-sig", newline="") as file:
        writer = csv.DictWriter(file, ["x", "y", "frame", "who", "note"], quoting=csv.QUOTE_ALL)
        writer.writeheader()
        for row in rows:
            del row["action"]
            writer.writerow({**row, "note": "two\nlines"})
            file.write("\n")
    assert told(tmp_path / "table.csv").frames == told(place(*PUSH)).frames
