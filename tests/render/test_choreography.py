"""A script becomes keyframes: exact at whole turns, continuous between, pushes told from steps."""

from itertools import pairwise

import pytest

from i2pdsl.render.grid.choreography import choreograph
from i2pdsl.render.grid.stage import Actor, Stage, break_down, describe
from i2pdsl.render.grid.tracks import MARKS, POSES, Key, bend, sample

ROWS = ("...#...", ".......", "...#...")
CHEESE, ROBOT = Actor("cheese", "cheese"), Actor("robot", "robot")
STAGE = Stage("small kitchen", ROWS, (), (CHEESE, ROBOT, Actor("table", "table", "", "object")))


ACTING = ("cheese", "robot")
STATE = (*ACTING, "table")


def turn(cheese, robot, *cells):
    """A frame: (action, moved) of both, then where cheese, robot and table are."""
    acts = {
        name: {"action": a, "moved": m}
        for name, (a, m) in zip(ACTING, (cheese, robot), strict=True)
    }
    return {**acts, "event": None, "state": dict(zip(STATE, cells, strict=True))}


SCRIPT = {
    "start": {"cheese": [3, 1], "robot": [6, 1], "table": None},
    "frames": [
        turn(("west", False), ("west", True), [3, 1], [5, 1], None),  # fails; steps
        turn(("north", False), ("west", True), [3, 1], [4, 1], None),  # bumps into a wall
        turn(("east", False), ("west", True), [2, 1], [3, 1], None),  # into the robot; pushed
        {"event": {"deus": "table", "to": [4, 1]}, "state": {"cheese": [2, 1], "robot": [3, 1],
                                                              "table": [4, 1]}},
        turn(("west", True), ("east", True), [1, 1], [4, 1], [5, 1]),  # robot pushes the table
        turn(("north", True), ("stay", False), [1, 0], [4, 1], [5, 1]),
        turn(("stay", False), ("south", True), [1, 0], [4, 2], [5, 1]),
    ],
}  # fmt: skip
FILM = choreograph(STAGE, SCRIPT)
STATES = [SCRIPT["start"], *(frame["state"] for frame in SCRIPT["frames"])]


def test_whole_turns_show_the_scripts_states_exactly():
    assert FILM.duration == len(SCRIPT["frames"])
    for t, state in enumerate(STATES):
        for name, cell in state.items():
            key = sample(FILM.tracks[name], t)
            if cell is None:
                assert key.opacity == 0
            else:
                assert (key.x, key.y, key.opacity, key.lift, key.angle) == (*cell, 1, 0, 0)


def test_the_second_character_acts_when_the_first_has_finished():
    assert sample(FILM.tracks["robot"], 0.5).x == 6
    assert sample(FILM.tracks["cheese"], 5 - 0.5).x == 1
    assert sample(FILM.tracks["robot"], 5 - 0.5).x == 3
    alone = choreograph(
        Stage("hall", ("...",), (), (ROBOT,)),
        {"start": {"robot": [0, 0]},
         "frames": [{"robot": {"action": "east", "moved": True}, "event": None,
                     "state": {"robot": [1, 0]}}]},
    )  # fmt: skip
    assert 0 < sample(alone.tracks["robot"], 0.4).x < 1
    assert sample(alone.tracks["robot"], 0.85).x == 1


def test_beats_say_what_happened():
    verbs = [(beat.frame, beat.actor, beat.verb) for beat in FILM.beats]
    assert verbs == [
        (1, "cheese", "fail"), (1, "robot", "step"),
        (2, "cheese", "bump"), (2, "robot", "step"),
        (3, "cheese", "bump"), (3, "robot", "push"),
        (4, "table", "fall"),
        (5, "cheese", "step"), (5, "robot", "push"),
        (6, "cheese", "step"), (6, "robot", "stay"),
        (7, "cheese", "stay"), (7, "robot", "step"),
    ]  # fmt: skip
    pushes = [(b.frame, s) for b in FILM.beats for s in b.pushed]
    assert pushes == [(3, ("cheese", (3, 1), (2, 1))), (5, ("table", (4, 1), (5, 1)))]
    assert [describe(beat) for beat in FILM.beats if beat.frame in (1, 3, 4)] == [
        "cheese tries west and fails",
        "robot goes west",
        "cheese bumps east",
        "robot pushes cheese west",
        "table falls from the sky",
    ]


def test_pusher_and_pushed_keep_in_touch():
    gaps = []
    for i in range(51):
        time = 2.5 + i / 100
        robot, cheese = (sample(FILM.tracks[name], time) for name in ("robot", "cheese"))
        if 2 + 1e-9 < cheese.x < 3 - 1e-9:
            gaps.append(robot.x - cheese.x)
            assert robot.pose == "push-west"
            assert cheese.pose == "surprised"
    assert len(gaps) > 10
    assert max(gaps) - min(gaps) < 1e-9
    assert gaps[0] < 0.9


def test_a_failed_move_starts_and_sinks_back():
    xs = [sample(FILM.tracks["cheese"], i / 100).x for i in range(51)]
    assert 2.5 < min(xs) < 2.85
    assert xs[-1] == 3
    assert {"try-west", "sad"} <= {key.pose for key in FILM.tracks["cheese"]}
    ys = [sample(FILM.tracks["cheese"], 1 + i / 100).y for i in range(51)]
    assert 0.75 < min(ys) < 0.95, "a bump is shorter than a failed move"


def test_tracks_are_continuous_except_for_poses_and_unseen_things():
    step = 1 / 400
    for track in FILM.tracks.values():
        assert all(a.time <= b.time for a, b in pairwise(track))
        for i in range(int(FILM.duration / step)):
            a, b = sample(track, i * step), sample(track, (i + 1) * step)
            if a.opacity == b.opacity == 0:
                continue
            assert abs(b.x - a.x) < 0.05
            assert abs(b.y - a.y) < 0.05
            assert abs(b.lift - a.lift) < 0.12
            assert abs(b.scale_x - a.scale_x) < 0.05
            assert abs(b.scale_y - a.scale_y) < 0.05
            assert abs(b.angle - a.angle) < 0.01


def test_a_fall_comes_from_above_bounces_and_starts_unseen():
    table = [sample(FILM.tracks["table"], 3 + i / 100) for i in range(101)]
    assert table[0].opacity == 0
    assert max(key.lift for key in table if key.opacity == 1) > 2
    lifts = [key.lift for key in table]
    first = next(i for i in range(30, 101) if lifts[i] == 0)
    assert max(lifts[first:]) > 0.1
    assert lifts[-1] == 0
    assert "surprised" in {sample(FILM.tracks["cheese"], 3.5).pose}


def test_marks_begin_and_end_unseen():
    kinds = [mark.kind for mark in FILM.marks]
    assert set(kinds) <= set(MARKS)
    assert {"puff", "sweat", "bump", "lines", "dust", "bang"} == set(kinds)
    for mark in FILM.marks:
        assert mark.track[0].opacity == mark.track[-1].opacity == 0
        assert any(key.opacity == 1 for key in mark.track)
        assert 0 <= mark.track[0].time < mark.track[-1].time <= FILM.duration


def test_every_pose_used_is_announced():
    assert {key.pose for track in FILM.tracks.values() for key in track} <= set(POSES)


def test_sampling():
    track = [Key(0, 0, 0, ease="linear"), Key(1, 2, 4, ease="hold"), Key(2, 6, 0)]
    assert sample(track, -1)[1:3] == (0, 0)
    assert sample(track, 0.25)[1:3] == (0.5, 1)
    assert sample(track, 1.999)[1:3] == (2, 4)
    assert sample(track, 2)[1:3] == (6, 0)
    assert sample(track, 9)[1:3] == (6, 0)
    assert [bend(e, 0.25) for e in ("in", "out", "in-out")] == [0.0625, 0.4375, 0.15625]
    with pytest.raises(ValueError, match="unknown ease"):
        bend("wobble", 0.5)


def test_states_that_the_plain_rules_do_not_explain_are_still_reached():
    script = {
        "start": {"cheese": [0, 1], "robot": [6, 1], "table": [6, 0]},
        "frames": [turn(("east", True), ("west", True), [2, 1], [5, 1], [6, 2])],  # slides
    }
    film = choreograph(STAGE, script)
    for name, cell in script["frames"][0]["state"].items():
        assert sample(film.tracks[name], 1)[1:3] == tuple(cell)
    assert break_down(STAGE, script)[0].target == (2, 1)


def test_an_empty_script_is_a_still():
    film = choreograph(STAGE, {"start": SCRIPT["start"], "frames": []})
    assert film.duration == 0
    assert sample(film.tracks["robot"], 0)[1:3] == (6, 1)


def test_eyes_follow_intent():
    """Before it acts one looks at where its way ends or at whom it pushes, else at who acts."""
    script = {
        "start": {"cheese": [1, 0], "robot": [6, 1], "table": None},
        "frames": [
            turn(("stay", False), ("west", True), [1, 0], [5, 1], None),
            turn(("stay", False), ("north", True), [1, 0], [5, 0], None),
            turn(("stay", False), ("west", False), [1, 0], [5, 0], None),
            turn(("south", True), ("stay", False), [1, 1], [5, 0], None),
        ],
    }
    tracks = choreograph(STAGE, script).tracks
    assert sample(tracks["robot"], 0.56).pose == "look-northwest", "to where it goes in two turns"
    assert sample(tracks["robot"], 1.56).pose == "look-north", "the rest of the way"
    assert sample(tracks["robot"], 2.56).pose == "look-west", "a way that fails"
    assert sample(tracks["cheese"], 0.3).pose == "look-east", "who stays looks at the other"
    assert sample(tracks["robot"], 3.4).pose == "look-west", "who waits watches who acts"
    before = FILM.tracks["robot"]
    assert sample(before, 2.54).pose == "look-west", "at the cheese that it pushes"
