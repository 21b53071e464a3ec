"""How far a state is from something that can be seen: what no script can reach any more in time."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from i2pdsl.sizes import padded_size
from i2pdsl.worlds.world import World

NEVER = 1 << 20  # frames to what no turn leads to: more than a story can have
_AT_ONCE = 1 << 15  # states whose turns are looked at together


Question = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]
"""Whether frames are as asked: (states before, actions, states after), side by side."""


def frames_until(
    world: World, events: tuple[int, ...], asked: Question, of_states: bool
) -> np.ndarray:
    """The fewest frames after each state until the last of them is as asked, at least 1.

    Breadth first, backward over all turns (chance may always come out as one likes) and the
    allowed events. Everybody may stay where they are, so what can be had in n frames can be had
    in more.

    Args:
        events: those that may happen, as numbers of `world.events`.
        of_states: whether it depends on the state at the end of a frame alone.

    Returns: int32 [S], padded to the sizes of the tables of searches (worlds/grid/arrays.py).
    """
    states = np.asarray(world.all_states(world.tables))
    after, actions, possible = possible_frames(world, states, events)
    now = seen_in(asked, states, after, actions, of_states)
    frames = np.where((now & possible).any(1), 1, NEVER).astype(np.int32)
    waiting = np.flatnonzero(frames == NEVER)
    for count in range(2, NEVER):
        come = (frames[after[waiting]] < NEVER).any(1)
        if not come.any():
            break
        frames[waiting[come]] = count
        waiting = waiting[~come]
    return np.pad(frames, (0, padded_size(len(states), 8192) - len(states)))


def seen_in(
    asked: Question, states: np.ndarray, after: np.ndarray, actions: np.ndarray, of_states: bool
) -> np.ndarray:
    """Whether each frame that can follow each state is as asked, [S, K]."""
    if of_states:
        found: np.ndarray = asked(states, states, states)[after]
        return found
    pieces = _pieces(states, after)
    parts = [asked(s[:, None] + 0 * actions, actions + 0 * ends, ends) for s, ends in pieces]
    return np.concatenate(parts)


def possible_frames(
    world: World, states: np.ndarray, events: tuple[int, ...]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The states after each turn and event [S, K], their actions [K], and which can happen.

    What cannot happen changes nothing here.
    """
    count, slots = world.turn_count, world.event_slots
    pieces = [
        world.endings(world.tables, some).astype(np.int32) for some, _ in _pieces(states, states)
    ]
    after, actions = np.concatenate(pieces), np.arange(count)
    possible = np.ones(after.shape, dtype=bool)
    if not events:
        return after, actions, possible
    numbers = np.concatenate([np.arange(e * slots, (e + 1) * slots) for e in events])
    fallen, free = world.drops(world.tables, states)
    return (
        np.concatenate([after, fallen[:, numbers].astype(np.int32)], axis=1),
        np.concatenate([actions, count + numbers]),
        np.concatenate([possible, free[:, numbers]], axis=1),
    )


def _pieces(states: np.ndarray, *more: np.ndarray) -> Iterator[tuple[np.ndarray, ...]]:
    """Arrays over states in parts that fit into memory."""
    for first in range(0, len(states), _AT_ONCE):
        yield tuple(array[first : first + _AT_ONCE] for array in (states, *more))
