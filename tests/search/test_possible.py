"""What a frame can be if all else that is pinned is kept, against all scripts tried one by one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from i2pdsl.objective.pins import turns_of
from i2pdsl.objective.possible import possible_states
from i2pdsl.objective.starts import allowed_starts
from i2pdsl.worlds.grid.script import turn_in_words
from worlds_for_tests import Pair, small_kitchen

LENGTH = 6
HEAD = f"world small\nlength {LENGTH}\nmaximize depict(rho > 0)\n"


def steps(pair: Pair, events: bool) -> dict[int, list[tuple[str, int]]]:
    """What can be done in each state, in words, and where it leads."""
    world, found = pair.world, {}
    count = world.turn_count + (world.event_slots * len(world.moves.events) if events else 0)
    states = np.arange(pair.spec.state_count)
    found = {int(s): [] for s in states}
    for action in range(world.turn_count):
        after = np.asarray(world.transition(world.tables, states, np.full_like(states, action)))
        said = turn_in_words(world, action)
        for state, to in zip(states, after, strict=True):
            found[int(state)].append((said, int(to)))
    if events:
        fallen, possible = world.drops(world.tables, states)
        for slot in range(count - world.turn_count):
            for state in np.flatnonzero(possible[:, slot]):
                found[int(state)].append(("", int(fallen[state, slot])))
    return found


def places(pair: Pair, state: int) -> dict[str, tuple[int, int] | None]:
    found = {}
    for name, cell in zip(pair.spec.entities, pair.world.dynamics.cells_of(state), strict=True):
        absent = cell == pair.world.dynamics.absent
        found[name] = None if absent else tuple(int(x) for x in pair.world.tables.coordinates[cell])
    return found


CASES = {
    "nothing": ("", {}, False),
    "later": ("pin script[3]: at(robot, (0, 0))\n", {3: ("robot", (0, 0))}, False),
    "earlier": (
        "start at(robot, (2, 0)) and absent(table)\npin script[1]: at(cheese, (0, 2))\n",
        {1: ("cheese", (0, 2))},
        False,
    ),
    "both": (
        "start at(robot, (2, 0))\nallow deus(table)\n"
        "pin script[1]: at(robot, (1, 0))\npin script[5]: at(cheese, (0, 0))\n",
        {1: ("robot", (1, 0)), 5: ("cheese", (0, 0))},
        True,
    ),
    "a deed": ("start at(cheese, (1, 1))\npin script[2] = [cheese: east]\n", {}, False),
}


@pytest.mark.parametrize("name", CASES)
def test_against_all_scripts(name: str) -> None:
    text, pins, events = CASES[name]
    pair = small_kitchen()
    story = pair.story(HEAD + text)
    starts = allowed_starts(pair.world, story.start)
    then = steps(pair, events)
    where = {state: places(pair, state) for state in then}

    def holds(frame: int, state: int, deed: str) -> bool:
        if name == "a deed" and frame == 2 and "cheese: east," not in deed:
            return False
        who, cell = pins.get(frame, (None, None))
        return who is None or where[state][who] == cell

    ahead = [{int(s) for s in starts}]
    for frame in range(1, LENGTH + 1):
        reached = {to for s in ahead[-1] for deed, to in then[s] if holds(frame, to, deed)}
        ahead.append(reached)
    back = [set(then) for _ in range(LENGTH + 1)]
    for frame in range(LENGTH, 0, -1):
        back[frame - 1] = {
            s
            for s in then
            if any(holds(frame, to, deed) and to in back[frame] for deed, to in then[s])
        }
    for frame in range(LENGTH + 1):
        found = possible_states(story, pair.world, starts, frame)
        assert set(np.flatnonzero(found).tolist()) == ahead[frame] & back[frame], frame
        assert found.any()


def test_a_pin_that_is_not_kept() -> None:
    pair = small_kitchen()
    story = pair.story(HEAD + "pin script[3]: at(robot, (0, 0))\n")
    starts = allowed_starts(pair.world, None)
    free = possible_states(story, pair.world, starts, 3, story.pins)
    without = possible_states(replace(story, pins=()), pair.world, starts, 3)
    assert np.array_equal(free, without)
    assert free.sum() > possible_states(story, pair.world, starts, 3).sum()


def test_pins_that_cannot_all_be_kept() -> None:
    """What breaks fewest of them is possible still."""
    pair = small_kitchen()
    far = "pin script[2]: at(robot, (0, 0))\npin script[3]: at(robot, (2, 2))\n"
    story = pair.story(HEAD + far)
    starts = allowed_starts(pair.world, None)
    for frame in (1, 2, 3, 4):
        assert possible_states(story, pair.world, starts, frame).any()


def test_turns_are_kept_for_the_world_at_hand() -> None:
    pair = small_kitchen()
    assert turns_of(pair.world, ()) is turns_of(pair.world, ())
    assert turns_of(pair.world, (0,)) is not turns_of(pair.world, ())
