"""What other programs animate with: a sheet that shows what films show, a timeline that says what
scripts say, and a player that reads them and nothing else."""

import itertools
import json
import re
from pathlib import Path

import numpy as np
import pytest
from hill_performances import performance as hill_performance
from plane_performances import DUET
from plane_performances import performance as plane_performance

from i2pdsl.render import export as files
from i2pdsl.render.grid import export
from i2pdsl.render.grid.choreography import choreograph
from i2pdsl.render.grid.film import lengths
from i2pdsl.render.grid.scene import actor_svg, stage_symbols
from i2pdsl.render.grid.stage import Actor, Stage, Tile
from i2pdsl.render.grid.tracks import MARKS, POSES, Key, sample
from i2pdsl.render.hill import export as hill_export
from i2pdsl.render.mind import Panel, Series
from i2pdsl.render.plane import export as plane_export
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
PLAYER = (Path(files.__file__).parent / files.PLAYER).read_text(encoding="utf-8")


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


# ------------------------------------------------------------------------------ bodies that move

DISCS, BODY = plane_performance(spec=DUET, frames=20), hill_performance(frames=12)


def clock(frames):
    return np.full(frames, 0.1), np.zeros(frames)


def plane_told():
    document = plane_export.timeline(DISCS, clock(DISCS.frames))
    return json.loads(json.dumps(document, allow_nan=False))


def hill_told():
    return json.loads(json.dumps(hill_export.timeline(BODY, clock(BODY.frames)), allow_nan=False))


def test_in_a_plane_tracks_are_the_ways():
    told, names = plane_told(), [c.name for c in DUET.characters]
    assert [entity["name"] for entity in told["entities"]] == names
    for k, name in enumerate(names):
        track = [Key(*key) for key in told["tracks"][name]]
        for time in (0, 3.25, 19.5, 20):
            (x, y), gaze = (each[k] for each in DISCS.at(time))
            key = sample(track, time)
            assert (key.x, DUET.height - key.y) == pytest.approx((x, y), abs=1e-4)
            if time == int(time):
                assert told["frames"][time]["entities"][name]["at"] == [key.x, key.y]
                assert key.pose == plane_export.pose_of(gaze)
    values = [frame["beliefs"]["mover's goal"]["lamp"] for frame in told["frames"]]
    assert values == pytest.approx(DISCS.panels[0].series[0].values, abs=1e-6)
    assert told["frames"][-1]["start"] == pytest.approx(1.9)
    lamp = told["world"]["tiles"][0]
    assert (lamp["name"], lamp["at"]) == ("lamp", pytest.approx([10.5, 6.8]))


def test_eyes_look_the_way_that_is_nearest():
    for pose in plane_export.POSES:
        assert plane_export.pose_of(0.9 * plane_export.gaze_of(pose)) == pose
    assert plane_export.pose_of(np.array([1.0, 0.3])) == "look-east"
    assert plane_export.pose_of(np.array([0.0, -1.0])) == "look-south"
    assert plane_export.pose_of(np.array([-1.0, -0.01])) == "look-west"
    assert plane_export.pose_of(np.array([0.1, 0.1])) == "idle"


def test_discs_stand_on_their_feet_in_their_size():
    picture, about = plane_export.sheet(DUET)
    side = about["size"][0]
    for character in DUET.characters:
        seen = []
        for left, top in about["entities"][character.name].values():
            one = picture[top : top + side, left : left + side]
            rows, columns = np.nonzero(one[..., 3] > 128)
            for at in (rows, columns):
                assert (at.min() + at.max() + 1) / 2 == pytest.approx(about["foot"][0], abs=1)
                wide = (at.max() + 1 - at.min()) / 2 / about["cell"]
                assert wide == pytest.approx(character.radius, rel=0.03)
            seen.append(one.tobytes())
        assert len(set(seen)) == len(plane_export.POSES)
    room, place = plane_export.background(DISCS)
    spot = np.array(DUET.places[0].at) * (1, -1) + (0, DUET.height)
    x, y = (place["cell"] * spot + place["origin"]).round().astype(int)
    corner = room[round(place["origin"][1]) + 9, round(place["origin"][0]) + 9]
    assert abs(room[y, x].astype(int) - corner).max() > 30, "the lamp's rug lies where it is said"


def test_on_the_hill_shapes_go_through_the_nodes():
    told = hill_told()
    nodes = np.array(told["nodes"])
    assert nodes * (1, -1) == pytest.approx(np.moveaxis(BODY.positions, 1, 2), abs=1e-4)
    used = {node for shape in told["shapes"] for node in shape["nodes"]}
    assert used == set(range(19)), "all of the bodies is drawn"
    for entity in told["entities"]:
        inside = nodes[:, entity["nodes"]]
        at = np.array([frame["entities"][entity["name"]]["at"] for frame in told["frames"]])
        assert (inside.min(1) <= at).all()
        assert (at <= inside.max(1)).all()
    pulls = [frame["entities"]["hopper"]["pull"] for frame in told["frames"]]
    assert pulls == pytest.approx(BODY.pull, abs=1e-4)
    assert told["world"]["rise"] == pytest.approx(np.tan(BODY.slope))


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
    moving = [plane_told(), plane_export.sheet(DUET)[1], hill_told()]
    written = json.dumps([told, drawn[1], {"background": export.background(STAGE)[1]}, *moving])
    made = set(re.findall(r'"(\w+)": ', code))  # by the player itself
    for key in set(re.findall(r'\["(\w+)"\]', code)) - made:
        assert f'"{key}": ' in written, key
    for ease in {key[8] for track in told["tracks"].values() for key in track}:
        assert ease in ("linear", "in", "out", "in-out", "hold")
        assert ease == "linear" or f'"{ease}":' in code
    assert f'version") != {files.VERSION}' in code
    called = set(re.findall(r"\b(_[a-z_]+)\(", code))
    assert called == set(re.findall(r"func (_[a-z_]+)\(", code)), "all is defined, all is used"


def test_files(tmp_path):
    paths = files.save_sheet(tmp_path, export.sheet(STAGE), export.background(STAGE))
    paths += [files.save_timeline(tmp_path, {"a": 1}), files.save_player(tmp_path)]
    assert sorted(path.name for path in paths) == sorted(p.name for p in tmp_path.iterdir())
    about = json.loads((tmp_path / "sprites.json").read_text())
    assert (tmp_path / about["image"]).read_bytes().startswith(b"\x89PNG")
    assert (tmp_path / about["background"]["image"]).read_bytes().startswith(b"\x89PNG")
