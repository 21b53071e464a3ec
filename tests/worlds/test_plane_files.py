"""Files of planes: what they say, what is wrong with them, and scripts that come back."""

from pathlib import Path

import numpy as np
import pytest

from i2pdsl.errors import Source, StoryError
from i2pdsl.worlds.kinds import format_world, parse_world
from i2pdsl.worlds.plane.kind import KIND
from i2pdsl.worlds.plane.spec import PlaneSpec, Wall
from i2pdsl.worlds.record import Record, Trajectory
from plane_for_tests import PAIR, WALLED, build_plane, wandered

GOOD = """# Two in a room.

kind = plane

size
    width = 10
    height = 6

wall
    points = [(5, 0), (5, 2.5)]
wall
    points = [(7, 4), (8, 4), (8, 5)]
    closed = yes

place door
    at = (9, 1)
    radius = 0.7

character ann
    at = (2, 3)
    goals = {door, avoid}
character bob
    at = (3.5, 3)
    goals = {none, approach}
    toward = ann
    attitude = {-1, 0, 1}

planning
    beta = 5

audience
    observer = path
"""


def read(text: str) -> PlaneSpec:
    spec = parse_world(Source("room.world", text), "room")
    assert isinstance(spec, PlaneSpec)
    return spec


def test_a_file_says_what_it_says():
    spec = read(GOOD)
    assert (spec.width, spec.height) == (10.0, 6.0)
    assert spec.documentation == "Two in a room."
    assert spec.walls[0] == Wall(((5.0, 0.0), (5.0, 2.5)))
    assert spec.walls[1].segments[-1] == ((8.0, 5.0), (7.0, 4.0))
    assert spec.places[0].radius == 0.7
    assert spec.characters[1].attitude == (-1.0, 0.0, 1.0)
    assert spec.social == spec.characters[1]
    assert (spec.settings.beta, spec.settings.observer) == (5.0, "path")
    assert len(KIND.vocabulary(spec).hypotheses) == 2 * 2 * 3 - 2 + 2 + 2 + 1
    assert format_world(Source("room.world", GOOD)) == GOOD


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("width = 10", "width = 0", "6:13: error[world-range]: `width` must be above 0"),
        ("    height = 6\n", "", "5:1: error[world-size]: the size has no height"),
        (
            "(5, 2.5)]",
            "(5, 7)]",
            "10:23: error[world-place]: (5, 7) is outside the plane of 10 x 6",
        ),
        ("(5, 2.5)]", "(5, 0)]", "10:14: error[world-wall]: a point of a wall stands here twice"),
        (
            "points = [(5, 0), (5, 2.5)]",
            "points = (5, 0)",
            "10:14: error[world-wall]: a wall has 2",
        ),
        ("at = (9, 1)", "at = 9", "16:10: error[world-value]: `at` must be a point, not `9`"),
        ("at = (2, 3)", "at = (0.1, 3)", "20:10: error[world-place]: at (0.1, 3) it would reach"),
        ("at = (2, 3)", "at = (5.2, 2)", "20:10: error[world-place]: `ann` (radius 0.4) would"),
        ("at = (2, 3)", "at = (3, 3)", "23:10: error[world-place]: `ann` and `bob` would overlap"),
        ("{door, avoid}", "{dor}", "21:14: error[world-name]: there is no place `dor`"),
        ("    toward = ann\n", "", "25:5: error[world-cast]: an attitude toward whom?"),
        ("place door", "place approach", "15:7: error[reserved]: `approach` means something else"),
        ("character bob", "character ann", "22:11: error[duplicate]: two things have the name"),
        ("beta = 5", "gamma = 0.9", "29:5: error[world-key]: `planning` has no `gamma`"),
        ("observer = path", "observer = pat", "32:16: error[world-value]: `observer` cannot be"),
        ("place door", "tile door", "15:1: error[world-block]: `tile` begins no block"),
    ],
)
def test_mistakes_are_named_with_their_places(old, new, expected):
    with pytest.raises(StoryError) as caught:
        read(GOOD.replace(old, new, 1))
    assert f"room.world:{expected}" in str(caught.value)


def test_who_is_too_fast_for_walls():
    with pytest.raises(StoryError, match="a third of a radius"):
        read(GOOD.replace("at = (2, 3)", "at = (2, 3)\n    speed = 0.2"))


def test_a_goal_behind_walls_is_warned_of():
    closed = GOOD.replace("[(5, 0), (5, 2.5)]", "[(5, 0), (5, 6)]")
    assert KIND.warnings(read(GOOD), "room.world") == ()
    (told,) = KIND.warnings(read(closed), "room.world")
    assert told.severity == "warning"
    assert "`ann` cannot get from where it begins to `door`" in told.message


@pytest.mark.parametrize("spec", [PAIR, WALLED])
def test_scripts_come_back(spec):
    world = build_plane(spec)
    states, actions = wandered(world, 25)
    path = Trajectory(actions, states)
    start, frames = KIND.start_as_json(world, states[0]), KIND.frames_as_json(world, path)
    again = KIND.read(world, Record({}, {"name": spec.name}, None, start, frames))
    assert np.allclose(again.states, states, atol=1e-4)
    assert np.allclose(again.actions, actions, atol=1e-6)
    columns = KIND.columns(world.vocabulary, Record({}, {}, None, start, frames))
    assert np.allclose(columns["cat_y"][0], states[:, 3], atol=1e-6)


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (lambda s, f: s.pop("cat"), "start: the place of `cat` is written [x, y]"),
        (lambda s, f: s.update(dog=[1, 1]), "start: there is no `dog` in walled"),
        (lambda s, f: s.update(cat=[4.1, 4]), "start: `cat` stands in a wall"),
        (lambda s, f: s.update(cat=[6.2, 4]), "start: the two overlap"),
        (lambda s, f: f[1].pop("cat"), "frame 2: what does `cat` do?"),
        (lambda s, f: f[2]["state"].update(cat=[9, 9]), "frame 3: by the world's rules someone"),
        (
            lambda s, f: f[0]["mouse"].update(velocity=[1e400, 0]),
            "frame 1: the velocity of `mouse`",
        ),
    ],
)
def test_scripts_are_held_against_the_rules(change, expected):
    world = build_plane(WALLED)
    states, actions = wandered(world, 4)
    start = KIND.start_as_json(world, states[0])
    frames = KIND.frames_as_json(world, Trajectory(actions, states))
    change(start, frames)
    with pytest.raises(StoryError) as caught:
        KIND.read(world, Record({}, {"name": "walled"}, None, start, frames))
    assert expected in str(caught.value)


def test_by_hand():
    world = build_plane(PAIR)
    path = Trajectory(np.zeros((0, 4)), world.starts()[:1])
    longer, told = KIND.played(world, None, path, "mouse north, cat 180 0.5 5")
    assert told == "[mouse: north 1, cat: 180 0.5; 10 frames]"
    assert np.allclose(longer.states[-1, :4], [6.0, 5.0, 1.5, 2.0], atol=1e-6)
    assert KIND.frame_in_words(world, longer, 1) == "mouse: north 1, cat: west 0.5"
    for typed, expected in (
        ("dog east", "there is no character `dog`"),
        ("mouse up", "`up` is no direction"),
        ("mouse east 3", "expected a speed from 0 to 2"),
        ("mouse east 1 0", "expected a number of frames"),
        ("mouse", "who moves where?"),
        ("", "nobody moves"),
    ):
        with pytest.raises(StoryError) as caught:
            KIND.played(world, None, path, typed)
        assert expected in str(caught.value)


def test_the_worlds_that_come_along_can_be_read():
    folder = Path(__file__).parents[2] / "stories" / "worlds"
    names = ("desk", "meadow", "pasture", "house")
    for name in names:
        text = (folder / f"{name}.world").read_text(encoding="utf-8")
        spec = parse_world(Source(f"{name}.world", text), name)
        assert KIND.warnings(spec, name) == ()
        assert KIND.as_json(spec)["size"] == [spec.width, spec.height]
