"""The fewest frames until something is seen, at least, in worlds whose states cannot be listed.

A condition of what stands where is asked of a small world with those whom it is about and all who
move them (worlds/world.py:SmallWorld), where reach.py tells how soon it can be. Of several that
shall hold at once it takes at least as long as of each, where that world would be too large for all
of them. Of other conditions nothing is known but that it takes a frame.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from i2pdsl.language import typed as ty
from i2pdsl.objective.reach import NEVER, Question, frames_until
from i2pdsl.worlds.world import SmallWorld, World

Array = Any
Asking = Any  # from a world and a condition to a question


class Relaxed(NamedTuple):
    """Of each condition that shall hold the rows [E, M] of its small world (SmallWorld), and how
    many frames it takes from each of them, [R]."""

    rows: tuple[Array, ...]
    frames: tuple[Array, ...]


def relaxed(world: World, condition: ty.Typed, events: tuple[int, ...], asking: Asking) -> Relaxed:
    """The tables of a condition.

    Args:
        events: those that may happen, as numbers of `world.events`.
        asking: from a small world and a condition to what is asked of its frames.
    """
    found = []
    for part, small in _asked(world, condition):
        own = _events(world, small, events)
        asked: Question = asking(small.world, _renamed(part, small.numbers))
        frames = np.full(small.size, NEVER, dtype=np.int32)
        frames[small.row] = frames_until(small.world, own, asked, True)[: len(small.row)]
        found.append((small.rows, frames))
    rows, frames_ = zip(*found, strict=True) if found else ((), ())
    return Relaxed(tuple(rows), tuple(frames_))


def _asked(world: World, condition: ty.Typed) -> list[tuple[ty.Typed, SmallWorld]]:
    """Parts of a condition of what stands where, each with a small world to ask it in: all of them
    together where that is not too large."""
    parts = [(part, about) for part in _parts(condition) if (about := _about(world, part))]
    every = frozenset[int]().union(*(about for _, about in parts))
    if len(parts) > 1 and (small := world.small(every)) is not None:
        return [(ty.Apply("and", tuple(part for part, _ in parts)), small)]
    found = ((part, world.small(about)) for part, about in parts)
    return [(part, small) for part, small in found if small is not None]


def least(world: World, tables: Any, known: Relaxed, state: Array) -> Array:
    """The fewest frames after some states, at least, [...]."""
    fewest = state * 0 + 1
    for rows, frames in zip(known.rows, known.frames, strict=True):
        xp = fewest.__array_namespace__()
        fewest = xp.maximum(fewest, frames[world.row(tables, rows, state)])
    return fewest


def _parts(condition: ty.Typed) -> list[ty.Typed]:
    """What must hold for a condition to hold."""
    match condition:
        case ty.Apply(operation="and", arguments=arguments):
            return [part for each in arguments for part in _parts(each)]
        case ty.Apply(operation="choose", arguments=(part, ty.Constant(), ty.Constant(value=0))):
            return _parts(part)  # 1 where it holds
    return [condition]


def _about(world: World, condition: ty.Typed) -> frozenset[int]:
    """Whom a condition is about, if it is one of what stands where alone; else nobody."""
    known, found = world.vocabulary.predicates, set[int]()
    for node in _nodes(condition):
        if isinstance(node, ty.Feature) and not known[node.predicate].needs_action:
            found |= {a for a in node.arguments if isinstance(a, int)}
        elif not isinstance(node, ty.Apply | ty.Constant):
            return frozenset()
    return frozenset(found)


def _nodes(condition: ty.Typed) -> list[ty.Typed]:
    inner = condition.arguments if isinstance(condition, ty.Apply) else ()
    return [condition, *(node for part in inner for node in _nodes(part))]


def _renamed(condition: ty.Typed, numbers: dict[int, int]) -> ty.Typed:
    """A condition of what stands where with other numbers of whom it is about."""
    if isinstance(condition, ty.Apply):
        parts = tuple(_renamed(part, numbers) for part in condition.arguments)
        return replace(condition, arguments=parts)
    if not isinstance(condition, ty.Feature):
        return condition
    arguments = tuple(numbers[a] if isinstance(a, int) else a for a in condition.arguments)
    return replace(condition, arguments=arguments)


def _events(world: World, small: SmallWorld, events: tuple[int, ...]) -> tuple[int, ...]:
    """The events that may happen in a small world, of those that may in the large one."""
    dropped = (world.dropped[e] for e in events)
    return tuple(small.world.dropped.index(small.numbers[e]) for e in dropped if e in small.numbers)
