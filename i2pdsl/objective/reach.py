"""How far a state is from something that can be seen: what no script can reach any more in time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from i2pdsl.language import typed as ty
from i2pdsl.objective.frame import View
from i2pdsl.sizes import padded_size
from i2pdsl.worlds.world import World

Array = Any

NEVER = 1 << 20  # frames to what no turn leads to: more than a story can have
_AT_ONCE = 1 << 15  # states whose turns are looked at together


@dataclass(frozen=True)
class _Turns:
    """Transitions side by side: predicates are asked of the frames that they make."""

    world: World
    params: Any
    before: np.ndarray
    action: np.ndarray
    state: np.ndarray
    xp = np
    t = None

    @property
    def tables(self) -> Any:
        return self.world.tables

    def view(self, moment: ty.Moment) -> View:
        return View(None, self.state, self)  # type: ignore[arg-type]


def frames_until(world: World, away: ty.Away) -> np.ndarray:
    """The fewest frames after each state until the last of them is as asked, at least 1.

    Breadth first, backward over all turns (chance may always come out as one likes) and the
    allowed events. Everybody may stay where they are, so what can be had in n frames can be had
    in more.

    Returns: int32 [S], padded to the sizes of the tables of searches (worlds/grid/model.py).
    """
    from i2pdsl.objective.compile import Compiler

    compiler = Compiler(world, 0)
    asked = compiler.build(away.body)
    params = compiler.params()
    known = world.vocabulary.predicates
    features = [n for n in ty.walk(away.body) if isinstance(n, ty.Feature)]
    states = np.asarray(world.all_states(world.tables))
    after, actions, possible = _frames(world, states, away.events)
    if any(known[f.predicate].needs_action for f in features):
        now = np.concatenate(
            [
                asked(_Turns(world, params, *np.broadcast_arrays(some[:, None], actions), ends))
                != 0
                for some, ends in _pieces(states, after)
            ]
        )
    else:
        now = (asked(_Turns(world, params, states, states, states)) != 0)[after]
    frames = np.where((now & possible).any(1), 1, NEVER).astype(np.int32)
    waiting = np.flatnonzero(frames == NEVER)
    for count in range(2, NEVER):
        come = (frames[after[waiting]] < NEVER).any(1)
        if not come.any():
            break
        frames[waiting[come]] = count
        waiting = waiting[~come]
    return np.pad(frames, (0, padded_size(len(states), 8192) - len(states)))


def _frames(
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
