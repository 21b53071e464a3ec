"""What follows an action of one character: looked up where states are listed (dynamics.py), else
computed from the cells (packed.py). In NumPy and JAX alike; shapes as in model.py."""

from __future__ import annotations

from typing import Any

from i2pdsl.worlds.grid.arrays import (
    Moves,
    Packed,
    Tables,
    arrangement,
    cells_at,
    cells_of,
    continued,
    entries,
    namespace,
    state_of,
    summed_terms,
)

Array = Any


def action_count(tables: Tables, who: int) -> int:
    """How many actions a character has."""
    if tables.packed is None:
        return len(tables.successor[who])
    return tables.packed.rules[who].target.shape[1]


def successors(tables: Tables, who: int, here: Array) -> Array:
    """The arrangements after each action of a character, if it succeeds: [..., A]."""
    if tables.packed is None:
        after = entries(tables.successor[who], (slice(None), here))
        return namespace(tables.coordinates).moveaxis(after, 0, -1)
    return state_of(tables.packed, moved(tables.packed, who, cells_of(tables.packed, here)))


def successor(tables: Tables, who: int, act: Array, here: Array) -> Array:
    """The arrangement after one action of a character, if it succeeds: [...]."""
    if tables.packed is None:
        return entries(tables.successor[who], (act, here))
    xp, after = namespace(tables.coordinates), successors(tables, who, here)
    act = xp.broadcast_to(xp.asarray(act), after.shape[:-1])
    return xp.take_along_axis(after, act[..., None], axis=-1)[..., 0]


def in_frame(frame: Array, place: Array) -> Array:
    """The states of arrangements [..., more axes] in a frame, of which `state - arrangement` [...]
    tells."""
    return place + frame.reshape(frame.shape + (1,) * (place.ndim - frame.ndim))


def joint(tables: Tables, here: Array) -> tuple[Array, Array, Array]:
    """The arrangement after each pair of actions of two who act together, if both succeed, and
    whether the first and the second are moved by them: [..., A_1, A_2] each."""
    xp = namespace(tables.coordinates)
    first, second = (successors(tables, who, here) for who in (0, 1))
    in_order = successors(tables, 1, first)  # [..., A_1, A_2]
    in_turn = xp.swapaxes(successors(tables, 0, second), -1, -2)
    waits = (first == here[..., None])[..., None]
    second, first = second[..., None, :], first[..., None]
    return (
        xp.where(waits, in_turn, in_order),
        ~waits | (in_turn != second),
        xp.where(waits, second != here[..., None, None], in_order != first),
    )


def values_after(tables: Tables, who: int, here: Array) -> Array:
    """W(s) after each action of a character, if it succeeds, in every problem: [..., A, P]."""
    if tables.packed is None or tables.terms is None:
        return continued(tables, who, successors(tables, who, here))
    return summed_terms(tables, who, moved(tables.packed, who, cells_at(tables, here)))


def moved(packed: Packed, who: int, cells: Array) -> Array:
    """The cells [..., A, E] after each action of a character, if it succeeds, of cells [..., E]:
    those before it where it cannot be done. The rules are those of dynamics.py."""
    xp, rules = namespace(packed.radix), packed.rules[who]
    mine = packed.absent + 1 + who
    own, every = cells[..., who], cells[..., None, :]
    target = entries(rules.target, own)
    met = (every == target[..., None]) & rules.others
    able, blocked, after = target >= 0, met, every
    if rules.pushes is not None:
        beyond = entries(rules.beyond, own)
        is_free = (beyond >= 0) & ~(every == beyond[..., None]).any(-1)
        pushed = met & rules.pushes & is_free[..., None]
        after, blocked = xp.where(pushed, beyond[..., None], after), blocked & ~pushed
    if rules.takes is not None:
        taken = met & rules.takes
        after, blocked = xp.where(taken, mine, after), blocked & ~taken
    if rules.opens is not None:
        has_key = ((cells == mine)[..., None, :] & rules.keys).any(-1)
        opened = met & rules.opens & has_key[..., None, :]
        after, blocked = xp.where(opened, packed.absent, after), blocked & ~opened
    if rules.behind is not None:
        behind = entries(rules.behind, own)
        follows = (every == behind[..., None]) & rules.pulls
        able &= follows.any(-1) | ~rules.is_pull
        after = xp.where(follows, own[..., None, None], after)
    able &= ~blocked.any(-1)
    number = xp.arange(cells.shape[-1])
    after = xp.where(able[..., None], xp.where(number == who, target[..., None], after), every)
    if rules.aside is not None:
        after = _put(packed, who, cells, after)
    return after if packed.alike is None else _in_order(packed, after)


def _put(packed: Packed, who: int, cells: Array, after: Array) -> Array:
    """The cells [..., A, E] after actions by which a character also puts down, on the cell aside,
    the first of its things that can go there; or hands it to who stands there and carries such."""
    xp, rules, absent = namespace(packed.radix), packed.rules[who], packed.absent
    aside = entries(rules.aside, cells[..., who])
    is_taken = (cells[..., None, :] == aside[..., None]).any(-1)
    done, number = aside < 0, xp.arange(cells.shape[-1])
    for k in range(len(rules.puts)):
        thing = rules.puts[k]
        goes = xp.where(is_taken, -1, aside)
        for other in range(rules.holders.shape[1]):
            is_given = (cells[..., other, None] == aside) & rules.holders[k, other]
            goes = xp.where(is_given, absent + 1 + other, goes)
        has = xp.take(cells, thing, axis=-1) == absent + 1 + who
        able = ~done & has[..., None] & (goes >= 0)
        after = xp.where(able[..., None] & (number == thing), goes[..., None], after)
        done = done | able
    return after


def _in_order(packed: Packed, cells: Array) -> Array:
    """Cells in which entities that are alike stand in order again, after one of them moved."""
    xp, count = namespace(packed.radix), cells.shape[-1]
    parts = [cells[..., entity] for entity in range(count)]
    # One pass brings it back as far as it must, the other one forth.
    for first in (*range(count - 2, -1, -1), *range(count - 1)):
        one, two = parts[first : first + 2]
        swap = packed.alike[first] & (one > two)
        parts[first : first + 2] = xp.where(swap, two, one), xp.where(swap, one, two)
    return xp.stack(parts, axis=-1)


def _numbered(tables: Tables, code: Array) -> Array:
    """The arrangements that are listed under some numbers, -1 where there is none."""
    if tables.lookup.ndim == 1:
        return tables.lookup[code]
    xp, (known, numbers) = namespace(tables.coordinates), tables.lookup
    place = xp.minimum(xp.searchsorted(known, code), len(known) - 1)
    return xp.where(known[place] == code, numbers[place], -1)


def drops(tables: Tables, moves: Moves, state: Array) -> tuple[Array, Array]:
    """The arrangements after each event (every thing onto every cell) and whether it can happen.

    Shapes [..., events * slots]. A thing falls only while it is absent, onto a free cell.
    """
    xp = namespace(tables.coordinates)
    cells = xp.arange(moves.slots)
    place = arrangement(tables, state)
    here = cells_at(tables, place)
    on_map = cells < tables.absent
    there = xp.where(on_map, cells, 0)
    results, possible = [], []
    for entity in moves.events:
        absent = here[..., entity, None] == tables.absent
        if tables.packed is None:
            code = (here * tables.strides).sum(-1)[..., None]
            falls = (there - tables.absent) * tables.strides[entity]
            after = _numbered(tables, code + xp.where(on_map, falls, 0))
            is_free = after >= 0
        else:
            digits = tables.packed.digits[entity]
            after = place[..., None] + digits[there] - digits[tables.absent]
            is_free = ~(here[..., None, :] == there[:, None]).any(-1)
        possible.append(absent & on_map & is_free)
        results.append(xp.where(possible[-1], after, place[..., None]))
    return xp.concatenate(results, axis=-1), xp.concatenate(possible, axis=-1)
