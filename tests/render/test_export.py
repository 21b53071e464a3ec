"""What other programs animate with: a sheet that shows what films show, a timeline that says what
scripts say, and a player that reads them and nothing else."""

import itertools
import json
import re
from pathlib import Path

import numpy as np
import pytest

from i2pdsl.render.grid import export
from i2pdsl.render.grid.choreography import MARKS, POSES, Key, choreograph, sample
from i2pdsl.render.grid.film import lengths
from i2pdsl.render.grid.scene import actor_svg, stage_symbols
from i2pdsl.render.grid.stage import Actor, Stage, Tile
from i2pdsl.render.mind import Panel, Series
from i2pdsl.render.raster import svg_rgba

CAST = (Actor("cheese", "cheese"), Actor("robot", "robot"), Actor("table", "table", "", "object"))
STAGE = Stage("kitchen", ("...#.", "....."), (Tile("pond", (0, 1), "#6f9fd8"),), CAST)
SCRIPT = {
    "start": {"cheese": [2, 1], "robot": [3, 1], "table": None},
    "frames": [
        {"cheese": {"action": "west", "moved": False}, "robot": {"action": "west", "moved": True},
         "event": None, "state": {"cheese": [1, 1], "robot": [2, 1], "table": None}},
        {"cheese": {"action": "stay", "moved": False}, "robot": {"action": "stay", "moved": False},
         "event": None, "state": {"cheese": [1, 1], "robot": [2, 1], "table": None}},
        {"event": {"deus": "table", "to": [4, 0]},
         "state": {"cheese": [1, 1], "robot": [2, 1], "table": [4, 0]}},
    ],
}  # fmt: skip
FILM = choreograph(STAGE, SCRIPT)
PANELS = [Panel("goal", "P", (Series("pink", np.array([0.5, 0.6, np.nan, 0.9]), "#ff0000"),))]
PLAYER = (Path(export.__file__).parent / export.PLAYER).read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def told():
    document = export.timeline(STAGE, SCRIPT, FILM, PANELS, "T", *lengths(FILM, 1.0, {1: 0.5}))
    return json.loads(json.dumps(document, allow_nan=False))


@pytest.fixture(scope="module")
def drawn():
    return export.sheet(STAGE)


def test_the_timeline_says_what_the_script_says(told):
    states = [SCRIPT["start"], *(frame["state"] for frame in SCRIPT["frames"])]
    for t, (frame, state) in enumerate(zip(told["frames"], states, strict=True)):
        assert frame["frame"] == t
        assert {name: one["cell"] for name, one in frame["entities"].items()} == state
    first, second, third = (frame["entities"] for frame in told["frames"][1:])
    assert [first[n]["success"] for n in ("cheese", "robot")] == [False, True]
    assert second["robot"] == {"cell": [2, 1], "action": "stay", "success": None}
    assert third["cheese"]["action"] is None
    assert told["frames"][3]["event"] == {"deus": "table", "to": [4, 0]}
    assert [f["beliefs"]["goal"]["pink"] for f in told["frames"]] == [0.5, 0.6, None, 0.9]
    assert told["world"]["walls"] == [[3, 0]]


def test_frames_follow_each_other_in_time(told):
    frames = told["frames"]
    for frame, after in itertools.pairwise(frames):
        end = frame["start"] + frame["seconds"] + frame["rests"]
        assert after["start"] == pytest.approx(end)
    push, still, fall = (frame["seconds"] for frame in frames[1:])
    assert still < 0.5 < 1 < push < fall
    assert [frame["rests"] > 0 for frame in frames[1:]] == [True, False, False]


def test_the_timelines_keys_are_the_films(told):
    assert told["keys"] == list(Key._fields)
    for name, keys in told["tracks"].items():
        track = [Key(*key) for key in keys]
        for time in np.linspace(0, 3, 31):
            ours, theirs = sample(FILM.tracks[name], time), sample(track, time)
            assert ours[1:8] == pytest.approx(theirs[1:8], abs=1e-4)
            assert ours.pose == theirs.pose


def test_the_sheet_holds_every_pose_where_it_says(drawn):
    picture, about = drawn
    assert set(about["entities"]) == {actor.name for actor in CAST}
    assert set(about["marks"]) == set(MARKS)
    (wide, high), (x, y) = about["size"], about["foot"]
    corners = [at for poses in about["entities"].values() for at in poses.values()]
    corners += about["marks"].values()
    assert len({tuple(at) for at in corners}) == len(CAST) * len(POSES) + len(MARKS)
    for left, top in corners:
        one = picture[top : top + high, left : left + wide, 3]
        assert one.shape == (high, wide)
        assert one.any()
        edges = np.concatenate([one[0], one[-1], one[:, 0], one[:, -1]])
        assert not edges.any(), "drawings do not run into their neighbours"
    # A pose stands where films draw it: its foot at the foot, a cell as large as a cell.
    left, top = about["entities"]["robot"]["push-west"]
    key = Key(0, x / about["cell"] - 0.5, y / about["cell"] - 0.94, pose="push-west")
    moment = svg_rgba(
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{wide}" height="{high}"><defs>'
        f"{stage_symbols(STAGE)}</defs>{actor_svg(CAST[1], key, about['cell'])}</svg>"
    )
    ours = picture[top : top + high, left : left + wide].astype(int)
    assert abs(ours - moment).max() < 40


def test_the_background_begins_where_it_says():
    picture, about = export.background(STAGE)
    left, top = (round(at) for at in about["origin"])
    wall = picture[top + 15, left + 3 * about["cell"] + 15, :3]
    assert wall.tolist() == [0xB0, 0x89, 0x68], "the wall's colour is the wall's colour"


def test_the_player_reads_only_what_is_there(told, drawn):
    """Of form alone: its brackets close, tabs indent, and each key that it asks for is written."""
    code = re.sub(r"#.*", "", PLAYER)
    for opening, closing in ("()", "[]", "{}"):
        assert code.count(opening) == code.count(closing)
    lines = [line for line in code.splitlines() if line.strip()]
    assert all(re.match(r"\t*\S", line) for line in lines)
    for line, after in itertools.pairwise(lines):
        deeper = len(after) - len(after.lstrip("\t")) - (len(line) - len(line.lstrip("\t")))
        assert deeper <= 1
        assert (deeper == 1) == line.rstrip().endswith((":", "{", "(")), line
    written = json.dumps([told, drawn[1], {"background": export.background(STAGE)[1]}])
    made = set(re.findall(r'"(\w+)": ', code))  # by the player itself
    for key in set(re.findall(r'\["(\w+)"\]', code)) - made:
        assert f'"{key}": ' in written, key
    for ease in {key[8] for track in told["tracks"].values() for key in track}:
        assert ease in ("linear", "in", "out", "in-out", "hold")
        assert ease == "linear" or f'"{ease}":' in code
    assert f'version") != {export.VERSION}' in code
    called = set(re.findall(r"\b(_[a-z_]+)\(", code))
    assert called == set(re.findall(r"func (_[a-z_]+)\(", code)), "all is defined, all is used"


def test_files(tmp_path):
    paths = export.save_sheet(tmp_path, STAGE)
    paths += [export.save_timeline(tmp_path, {"a": 1}), export.save_player(tmp_path)]
    assert sorted(path.name for path in paths) == sorted(p.name for p in tmp_path.iterdir())
    about = json.loads((tmp_path / "sprites.json").read_text())
    assert (tmp_path / about["image"]).read_bytes().startswith(b"\x89PNG")
    assert (tmp_path / about["background"]["image"]).read_bytes().startswith(b"\x89PNG")
