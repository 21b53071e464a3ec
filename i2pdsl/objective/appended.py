"""Turns that a story appends to its script: the last picture of a flashback."""

from __future__ import annotations

from typing import Any

from i2pdsl.language import typed as ty
from i2pdsl.objective.frame import Frame, observe
from i2pdsl.worlds.world import World

Array = Any

MOST_SUFFIX_BYTES = 400 * 2**20


def worth_a_table(world: World, tables: Any, turns: tuple[ty.Turn, ...]) -> bool:
    """Whether what each hypothesis says of appended turns is tabulated before a search.

    A search scores an appended turn after every candidate, far more often than there are states,
    so it is, unless the table is too big.
    """
    if not (turns and world.lists_states):
        return False
    size = 4 * len(world.all_states(tables)) * world.log_prior(tables).size * len(turns)
    return size * len(world.vocabulary.characters) <= MOST_SUFFIX_BYTES


def tabulate_turns(world: World, tables: Any, turns: tuple[ty.Turn, ...]) -> tuple[Array, ...]:
    """For each appended turn log P(action | H) in every state, [S, U, O, H]."""
    states = world.all_states(tables)
    rows = []
    for turn in turns:
        action, _ = world.act(tables, states, turn)
        after = world.transition(tables, states, action)
        found = world.log_rows(tables, states, action, after)
        rows.append(found[0].__array_namespace__().stack(found, axis=1))
    return tuple(rows)


def append_turns(
    world: World,
    tables: Any,
    turns: tuple[ty.Turn, ...],
    last: Frame,
    rows: tuple[Array, ...] = (),
) -> list[tuple[Frame, Array]]:
    """The frames of appended turns after a frame, and whether each can happen.

    `rows` are the tables of `tabulate_turns`, if there are any.
    """
    found = []
    possible: Array = True
    current = last
    for i, turn in enumerate(turns):
        action, allowed = world.act(tables, current.state, turn)
        known = None
        if rows:
            known = tuple(rows[i][current.state, u] for u in range(rows[i].shape[1]))
        number = current.number + 1
        current = observe(world, tables, number, current.state, action, current.belief, known)
        possible = possible & allowed
        found.append((current, possible))
    return found


def with_suffix(xp: Any, frames: Frame, suffix: list[tuple[Frame, Array]]) -> tuple[Frame, Array]:
    """A history [T + 1, ...] with appended frames behind it, and which frames can happen."""
    join = lambda old, *new: xp.concatenate([old, xp.stack(new)])
    joined = frames.each(join, *(frame for frame, _ in suffix))
    ok = xp.ones((frames.number.shape[0],), dtype=bool)
    return joined, xp.concatenate([ok, xp.stack([xp.asarray(p) for _, p in suffix])])
