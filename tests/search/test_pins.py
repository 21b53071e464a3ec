"""Pinned frames, against plain Python on all turns of a small world."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from jax.tree import leaves as tree_leaves

from i2pdsl.errors import Source, StoryError
from i2pdsl.language.check import Library, TypedStory, check_source
from i2pdsl.objective.frame import Frame
from i2pdsl.objective.pins import broken, pinned, still_to_break
from i2pdsl.objective.replay import replay
from i2pdsl.objective.terms import story_objective
from i2pdsl.scripts import Script, make_record, script_of
from i2pdsl.stories import Story
from i2pdsl.worlds.grid.world import GridWorld
from plane_for_tests import DESK, build_plane
from stories_for_tests import BARE
from worlds_for_tests import planned, trajectory

WORLD = """
map
    A.B
    .##
tile left
    symbol = A
tile right
    symbol = B
character small
    success = 0.6
    goals = {left, right}
character tall
    goals = {left, right, none}
    pushes = {small}
    toward = small
    attitude = {-2, 0, 2}
"""
SEARCH = "search beam(starts = 12, polish = 0)\n"
NOT_PUSHED = "pin script[3]: not pushes(tall, small)"  # all searches here have one program
Shown = dict[str, Any]
"""A frame as a script's file has it, with `before`, the state before it."""


@cache
def world() -> GridWorld:
    return planned(WORLD, "stair")


def story(*lines: str, length: int = 5, weights: str = BARE) -> TypedStory:
    text = "\n".join((f"world stair\nlength {length}\n{weights}", *lines))
    checked = check_source(Source("s.story", text), lambda *_: world().vocabulary)
    assert not isinstance(checked, Library)
    return checked


@cache
def turns() -> dict[int, list[tuple[int, int, Shown]]]:
    """All that can be done from each state: actions, states after, and how it is written."""
    found: dict[int, list[tuple[int, int, Shown]]] = {}
    for state in range(world().dynamics.state_count):
        found[state] = []
        for action in range(world().turn_count):
            path = trajectory(world(), state, np.array([action]))
            record = make_record(world(), path, {}, {}, None)
            (frame,) = record.frames
            shown = {**frame, "before": record.start}
            if shown not in [other for _, _, other in found[state]]:
                found[state].append((action, int(path.states[1]), shown))
    return found


def fails(state: int, frame: Shown, who: str) -> bool:
    """Whether someone's move failed that could have succeeded, all else being the same."""
    other = {"action": frame[who]["action"], "moved": True}
    acts = lambda f: {name: f[name] for name in ("small", "tall") if name != who}
    first = who == "small"
    return not frame[who]["moved"] and any(
        f[who] == other and (first or acts(f) == acts(frame)) for _, _, f in turns()[state]
    )


Asked = Callable[[int, Shown], bool]
PINS: dict[str, tuple[range, Asked]] = {
    "pin script[1] = [tall: west]": (range(1, 2), lambda s, f: f["tall"]["action"] == "west"),
    "pin script[2] = [small: east!]": (
        range(2, 3),
        lambda s, f: f["small"]["action"] == "east" and fails(s, f, "small"),
    ),
    "pin script[2..3]: at(tall, left)": (range(2, 4), lambda s, f: f["state"]["tall"] == [0, 0]),
    "pin script[4]: pushes(tall, small) and not at(small, right)": (
        range(4, 5),
        lambda s, f: (
            f["tall"]["moved"]
            and f["state"]["small"] != [2, 0]
            and f["state"]["small"] != after_small(s, f)
        ),
    ),
    "pin script[T] = [small: stay, tall: east]": (
        range(5, 6),
        lambda s, f: (f["small"]["action"], f["tall"]["action"]) == ("stay", "east"),
    ),
    "pin script[1]: at(small, (0, 1)) and at(tall, right)": (
        range(1, 2),
        lambda s, f: f["state"] == {"small": [0, 1], "tall": [2, 0]},
    ),
}


def after_small(state: int, frame: Shown) -> list[int]:
    """Where the small one stands once it has acted, before the tall one does."""
    column, row = frame["before"]["small"]
    steps = {"north": (0, -1), "south": (0, 1), "east": (1, 0), "west": (-1, 0)}
    dx, dy = steps[frame["small"]["action"]] if frame["small"]["moved"] else (0, 0)
    return [column + dx, row + dy]


def test_each_state_knows_what_can_no_longer_be_kept() -> None:
    for count, some in enumerate(itertools.combinations(PINS, 3)):
        if count % 3:
            continue  # enough
        typed = story("maximize 0", *some)
        tables = pinned(typed, world())
        assert tables is not None
        states = np.arange(world().dynamics.state_count)
        fewest = dict.fromkeys(states.tolist(), 0)
        for number in range(typed.length, 0, -1):
            assert still_to_break(tables, number, states).tolist() == list(fewest.values()), some
            asked = [holds for frames, holds in map(PINS.get, some) if number in frames]
            before = {}
            for state, frames in turns().items():
                counts = []
                for action, after, shown in frames:
                    here = sum(not holds(state, shown) for holds in asked)
                    counts.append(here + fewest[after])
                    parts = (np.asarray(x) for x in (number, state, action, after))
                    frame = Frame(*parts, *(np.zeros(()),) * 5)
                    assert broken(tables, frame) == here, (some, number, shown)
                before[state] = min(counts)
            fewest = before
        assert still_to_break(tables, 0, states).tolist() == list(fewest.values()), some


def test_the_rest_is_solved_around_what_is_pinned() -> None:
    lines = (
        "maximize depict(rho > 0)",
        NOT_PUSHED,
        "pin script[2]: at(tall, left)",
        "pin script[4] = [tall: east]",
    )
    found = Story(story(*lines, weights=SEARCH), known=world().spec).solve(
        candidates=3, choose="score"
    )
    for script in found.candidates:
        assert not script.unmet
        assert script.record.frames[1]["state"]["tall"] == [0, 0]
        assert script.record.frames[3]["tall"]["action"] == "east"


def test_what_cannot_be_kept_is_said_and_the_rest_is_kept() -> None:
    lines = (
        "pin script[1]: at(small, (0, 1)) and at(tall, right)",
        "pin script[2]: at(small, right) and at(tall, (0, 1))",
        "pin script[5]: at(tall, left)",
        NOT_PUSHED,
    )
    typed = story("maximize depict(rho > 0)", *lines, weights=SEARCH)
    found = Story(typed, known=world().spec).solve()
    (missed,) = found.unmet
    assert missed.text in lines[:2]
    told = missed.missed().render()
    frame = 1 + lines.index(missed.text)
    assert f"warning[unmet]: no script was found whose frame {frame} is so" in told
    assert found.script.record.frames[4]["state"]["tall"] == [0, 0]


def test_frames_of_a_script_are_kept_as_they_are() -> None:
    actions, state = [], 5
    for number in (7, 3, 11, 2, 9):
        possible = turns()[state]
        action, state, _ = possible[number % len(possible)]
        actions.append(action)
    path = trajectory(world(), 5, np.array(actions))
    frames_of = replay(world(), path.states, path.actions)
    first = script_of(story("maximize 0"), world(), path, frames_of, {}, None)
    other = Story(story("maximize depict(rho < 0)", weights=SEARCH), known=world().spec)
    for frames in ((1, 2), (3, 5)):
        found = other.keeping(first, frames).solve(seed=0)
        assert not found.unmet
        assert _looks(found.script, frames) == _looks(first, frames)
        assert "pin script[" in found.script.record.text  # it says how it was made


def _looks(script: Script, frames: tuple[int, ...]) -> list[Shown]:
    states = [script.record.start, *(frame["state"] for frame in script.record.frames)]
    return [{"before": states[k - 1], **script.record.frames[k - 1]} for k in frames]


def test_a_descent_keeps_what_is_done_and_comes_near_to_where_it_was_done() -> None:
    desk = build_plane(DESK)
    search = "search descend(seeds = 2, window = 12, lookahead = 0, steps = 25, optimiser = adam)"
    lines = ("world desk", "length 12", "{}", search)
    stories = []
    for goal in ("left", "right"):
        text = "\n".join(lines).format(f"maximize depict(G_hand = {goal})")
        typed = check_source(Source("s.story", text), lambda *_: desk.vocabulary)
        assert not isinstance(typed, Library)
        stories.append(Story(typed, known=DESK))
    first = stories[0].solve().script
    free = stories[1].solve().script
    kept = stories[1].keeping(first, [1, 2, 3, 9]).solve().script
    was, now = first.trajectory, kept.trajectory
    assert np.array_equal(was.actions[[0, 1, 2, 8]], now.actions[[0, 1, 2, 8]])
    assert np.array_equal(was.states[:4], now.states[:4])
    away = lambda path: np.abs(path.states[8:10, :2] - was.states[8:10, :2]).max()
    assert away(now) < 0.3 * away(free.trajectory)


def test_frames_that_are_those_of_files(tmp_path: Path) -> None:
    """What `keeping` keeps is written in a story, also of two scripts."""

    def told(rest: str, world: str = "desk") -> Story:
        return Story.from_text(f"world {world}\n{rest}\nsearch naive\n", tmp_path)

    def task(pins: str) -> Any:
        return told(f"length 12\nmaximize depict(G_hand = left)\n{pins}").task()

    nine = told("length 9")

    def script(name: str, story: Story, seed: int) -> Script:
        story.solve(seed).script.save(tmp_path / f"{name}.json")
        return Script.load(tmp_path / f"{name}.json")

    first, other = (script(*each) for each in (("first", nine, 1), ("other", nine, 2)))
    script("house", told("length 12", "house"), 0)
    given = told("length 12").keeping(first, [1, 2, 3, 9]).task().kept
    found = task('pin script[1..3] = "first.json"\npin script[9] = "first.json"').kept
    assert given is not None
    assert found.frames == given.frames == (1, 2, 3, 9)
    assert found.runs == [(1, 3), (9, 9)]
    near = [0, 1, 2, 3, 8, 9]
    assert np.array_equal(found.path.states[near], given.path.states[near])
    assert np.array_equal(found.path.actions[[0, 1, 2, 8]], given.path.actions[[0, 1, 2, 8]])
    both = task('pin script[1..3] = "first.json"\npin script[4..6] = "other.json"').kept
    assert both.frames == (1, 2, 3, 4, 5, 6)
    assert np.array_equal(both.path.actions[:3], first.trajectory.actions[:3])
    assert np.array_equal(both.path.actions[3:6], other.trajectory.actions[3:6])
    assert np.array_equal(both.path.states[:3], first.trajectory.states[:3])
    assert np.array_equal(both.path.states[3:7], other.trajectory.states[3:7])
    # And what is wrong with them is said at the pin.
    for file, message in (("first", "has 9 frames"), ("house", "another world"), ("no", "no such")):
        with pytest.raises(StoryError) as problem:
            task(f'pin script[2..10] = "{file}.json"')
        (diagnostic,) = problem.value.diagnostics
        assert message in diagnostic.message
        assert diagnostic.span.text == f'"{file}.json"'
    for file in ("../first.json", "/etc/first.json", "first.story", ".json/..", ""):
        with pytest.raises(StoryError, match="no script beside"):
            task(f'pin script[2..3] = "{file}"')
    (warning,) = told('length 12\npin script[1] = "no.json"').warnings
    assert (warning.code, warning.severity) == ("keep", "warning")


def test_a_pin_of_a_plane_moves_without_another_program() -> None:
    """Compiling a descent takes half a minute."""
    desk = build_plane(DESK)
    shapes = set()
    for frame, place in ((3, "left"), (7, "left"), (12, "left")):
        pin = f"pin script[{frame}]: at(hand, {place})"
        text = f"world desk\nlength 12\nmaximize depict(G_hand = left)\n{pin}\n"
        typed = check_source(Source("s.story", text), lambda *_: desk.vocabulary)
        assert not isinstance(typed, Library)
        found = story_objective(typed, desk)
        shapes.add((found.shape, tuple(np.shape(part) for part in tree_leaves(found.params))))
    assert len(shapes) == 1
