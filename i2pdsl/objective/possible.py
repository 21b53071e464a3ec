"""What can be seen in one frame of a story, if all that is pinned elsewhere is kept.

Of a world whose states can be listed [S]: those that the first pictures and earlier pins leave
open, found forward frame by frame, and from which later pins can be kept (objective/pins.py),
found backward. Chance may always come out as one likes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from i2pdsl.language import typed as ty
from i2pdsl.language.story import Pin, TypedStory
from i2pdsl.objective.compile import asked_of
from i2pdsl.objective.pins import Turns, pinned, turns_of
from i2pdsl.worlds.world import World


def possible_states(
    story: TypedStory, world: World, starts: np.ndarray, frame: int, free: Sequence[Pin] = ()
) -> np.ndarray:
    """The states that a frame can end in, as a mask [S]; with as few pins broken later as can be.

    Args:
        starts: the first pictures that the story allows.
        frame: 0 for the first picture.
        free: pins that are not kept.
    """
    kept = replace(story, pins=tuple(pin for pin in story.pins if pin not in free))
    turns = turns_of(world, world.events(story.allow))
    open_states = np.zeros(len(turns.states), bool)
    open_states[starts] = True
    for number in range(1, frame + 1):
        open_states = _followed(turns, open_states, [p for p in kept.pins if p.frame == number])
    tables = pinned(kept, world)
    if tables is None or not open_states.any():
        return open_states
    later = tables.later[tables.rows[3][frame]][: len(open_states)]
    found: np.ndarray = open_states & (later == later[open_states].min())
    return found


def _followed(turns: Turns, before: np.ndarray, pins: Sequence[Pin]) -> np.ndarray:
    """The states after a frame that is as its pins say; as if nothing were pinned where it cannot
    be so."""
    after = before if before.all() else turns.reached(before)
    allowed = np.ones(len(turns.states), bool)
    for pin in pins:
        kind, misses = turns.missed(pin.condition)
        if kind == "states":
            allowed &= misses[: len(allowed)] == 0
        else:
            allowed &= _reached_by(turns, before, kind, misses)
    kept: np.ndarray = after & allowed
    return kept if kept.any() else after


def _reached_by(turns: Turns, before: np.ndarray, kind: str, misses: np.ndarray) -> np.ndarray:
    """Where turns lead that are as a pin says, from some states."""
    found = np.zeros(len(turns.states) + 1, bool)
    for action, after in zip(turns.actions, turns.after, strict=True):
        if kind == "actions":
            if misses[action]:
                continue
            found[after[before]] = True
        else:
            found[after[before & (misses[: len(before), action] == 0)]] = True
    return found[:-1]


def holds_in(world: World, condition: ty.Typed, states: np.ndarray) -> bool:
    """Whether a condition on what is seen holds in one of some states (a mask [S])."""
    numbers = np.asarray(world.all_states(world.tables))[states]
    return bool(asked_of(world, condition)(numbers, numbers, numbers).any())
