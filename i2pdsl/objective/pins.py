"""Pinned frames of a search: what each frame must be, and which states can still keep all that is
pinned later.

A search goes forward; a pin is met from both sides because every state knows, by dynamic
programming backward from the last pinned frame over all turns, the fewest pins that later frames
must break. Chance may always come out as one likes, and everybody may stay where they are, so
between pins this settles after as many frames as the way is long.

S states, A actions (joint turns, then events), T frames.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from i2pdsl.language import typed as ty
from i2pdsl.language.story import TypedStory
from i2pdsl.objective.compile import asked_of, is_of_states
from i2pdsl.objective.frame import Frame
from i2pdsl.objective.reach import possible_frames, seen_in
from i2pdsl.sizes import padded_size
from i2pdsl.worlds.world import World

Array = Any


class Pins(NamedTuple):
    """Tables of how many pins are broken; their first rows are 0.

    Attributes:
        rows: [4, T + 1], which row of each table is that of a frame.
        states: [n, S], of a frame, by the state at its end.
        actions: [n, A], by what is done in it.
        turns: [n, S, A], by what is done from which state; None if no pin needs it.
        later: [n, S], the fewest of all later frames, from the state at a frame's end.
    """

    rows: Array
    states: Array
    actions: Array
    turns: Array | None
    later: Array


def broken(pins: Pins, frame: Frame) -> Array:
    """How many pins of a frame it breaks."""
    states, actions, turns, _ = (row[frame.number] for row in pins.rows)
    found = pins.states[states, frame.state] + pins.actions[actions, frame.action]
    if pins.turns is not None:
        found = found + pins.turns[turns, frame.before, frame.action]
    return found


def still_to_break(pins: Pins, number: Array, state: Array) -> Array:
    """The fewest pins that the frames after a state at the end of frame `number` must break."""
    return pins.later[pins.rows[3][number], state]


def pinned(story: TypedStory, world: World) -> Pins | None:
    """The tables of a story in a world whose states are listed; None where nothing is pinned."""
    if not (story.pins and world.lists_states):
        return None
    turns = turns_of(world, world.events(story.allow))
    missed = {pin.span.start: turns.missed(pin.condition) for pin in story.pins}
    tables = [_Table(turns.sizes[kind]) for kind in (*_KINDS, "states")]
    rows = np.zeros((4, story.length + 1), dtype=np.int32)
    later, settled = np.zeros(turns.sizes["states"], np.int32), True  # settled: one more is no help
    for frame in range(max(pin.frame for pin in story.pins), 0, -1):
        rows[3, frame] = tables[3].row(later)
        mine = [missed[pin.span.start] for pin in story.pins if pin.frame == frame]
        if settled and not mine:
            continue
        here = [sum(misses for of, misses in mine if of == kind) for kind in _KINDS]
        rows[:3, frame] = [table.row(each) for table, each in zip(tables, here, strict=False)]
        before = turns.fewest(len(story.pins), later, *here)
        settled = not mine and np.array_equal(before, later)
        later = before
    rows[3, 0] = tables[3].row(later)
    of_states, of_actions, of_turns, of_later = (table.stacked() for table in tables)
    needs_turns = len(tables[2].rows) > 1
    return Pins(rows, of_states, of_actions, of_turns if needs_turns else None, of_later)


_KINDS = ("states", "actions", "turns")
_MANY = 1 << 24  # pins: more than a story can have
_LARGEST = 1 << 28  # bytes of turns that are kept


class Turns:
    """All turns and allowed events [K] from all states, and the sizes of tables of each kind.

    Attributes:
        states: [S], and one more stands for what cannot happen.
        after: [K, S], the states that they lead to.
        actions: [K].
    """

    def __init__(self, world: World, events: tuple[int, ...]):
        self.world = world
        self.states = np.asarray(world.all_states(world.tables))
        after, self.actions, possible = possible_frames(world, self.states, events)
        self.after = np.ascontiguousarray(after.T)
        self.after[~possible.T] = len(self.states)
        # Of about as many states, worlds share programs (worlds/grid/arrays.py:padded).
        size = padded_size(len(self.states), 8192), int(self.actions.max()) + 1
        self.sizes = dict(zip(_KINDS, (size[:1], size[1:], size), strict=True))

    def missed(self, condition: ty.Typed) -> tuple[str, np.ndarray]:
        """What a condition hangs on, and where it does not hold: 1, else 0."""
        asked, states = asked_of(self.world, condition), self.states
        if is_of_states(self.world, condition):
            misses = np.zeros(self.sizes["states"], np.int32)
            misses[: len(states)] = ~asked(states, states, states)
            return "states", misses
        # What cannot happen is never looked up: any state will do.
        after = np.minimum(self.after, len(states) - 1).T
        held = seen_in(asked, states, after, self.actions, of_states=False)
        kind = "actions" if _is_of_actions(condition) else "turns"
        misses = np.zeros(self.sizes[kind], np.int32)
        if kind == "actions":
            misses[self.actions] = ~held[0]
        else:
            misses[: len(states), self.actions] = ~held
        return kind, misses

    def fewest(
        self, most: int, later: np.ndarray, of_states: Array, of_actions: Array, of_turns: Array
    ) -> np.ndarray:
        """The fewest pins that break from each state on, in a frame (0 or a table) and later, of
        `most` in all."""
        count = len(self.states)
        ahead = np.append((later + of_states)[:count], _MANY)
        # Numbers that fit into the processor's cache are found several times as fast.
        small = np.int16 if most < 1 << 13 else np.int32
        ahead = np.minimum(ahead, 1 << 13 if small is np.int16 else _MANY).astype(small)
        fewest = np.full(count, ahead[-1], small)
        found = np.empty(count, small)
        for action, after in zip(self.actions, self.after, strict=True):
            np.take(ahead, after, out=found, mode="clip")
            if np.ndim(of_actions) and of_actions[action]:
                np.add(found, of_actions[action], out=found, casting="unsafe")
            if np.ndim(of_turns):
                np.add(found, of_turns[:count, action], out=found, casting="unsafe")
            np.minimum(fewest, found, out=fewest)
        return np.pad(fewest.astype(np.int32), (0, len(later) - count))

    def reached(self, states: np.ndarray) -> np.ndarray:
        """Where one can be a frame after one of some states: masks [S]."""
        after = np.zeros(len(self.states) + 1, bool)
        after[self.after[:, states]] = True
        return after[:-1]


_last: list[tuple[World, tuple[int, ...], Turns]] = []


def turns_of(world: World, events: tuple[int, ...]) -> Turns:
    """The turns of a world; the last are kept, since they are asked for again at every change of a
    story."""
    for known, allowed, turns in _last:
        if known is world and allowed == events:
            return turns
    turns = Turns(world, events)
    if turns.after.nbytes < _LARGEST:
        _last[:] = [(world, events, turns)]
    return turns


def _is_of_actions(condition: ty.Typed) -> bool:
    """Whether it asks for turns that can be done anywhere."""
    if not isinstance(condition, ty.Acted):
        return False
    acts = condition.turn
    return isinstance(acts, ty.Drop) or not any(act is not None and act.fails for act in acts)


class _Table:
    """Rows that differ, the first of them of zeros."""

    def __init__(self, size: tuple[int, ...]):
        self.size = size
        self.rows: dict[bytes, Array] = {b"": 0}

    def row(self, numbers: Array) -> int:
        """The number of a row, added if it is new; 0 stands for zeros."""
        if not np.any(numbers):
            return 0
        key = numbers.tobytes()
        self.rows.setdefault(key, numbers)
        return list(self.rows).index(key)

    def stacked(self) -> np.ndarray:
        """All rows [n, ...], with room for more, so that some pins more need no other program."""
        found = np.zeros(
            (padded_size(len(self.rows), 16 if len(self.size) == 1 else 4), *self.size), np.int32
        )
        for number, row in enumerate(self.rows.values()):
            found[number] = row
        return found
