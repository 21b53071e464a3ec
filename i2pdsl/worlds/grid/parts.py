"""Parts of a world, with few of its entities, whose states can be listed where the world's own are
computed.

What entities can come to in the world they can come to in a part at least as soon, if all who move
them are in it: the others are in their way at most, chance may come out as one likes, and whoever
acts may stay instead.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

import numpy as np

from i2pdsl.worlds.grid.additive import Entities, ranks_of, sub_world, things_of
from i2pdsl.worlds.grid.spec import NO_GOAL, Character, GridSpec
from i2pdsl.worlds.world import SmallWorld, World

MOST = 5 * 10**7  # ends of turns that are listed


def with_movers(spec: GridSpec, about: Entities) -> Entities:
    """Some entities with all on whom it depends where they can be: those who move or carry them,
    who is told apart from them by its place alone, and the keys of doors."""
    found, last = set(about), set[int]()
    while found != last:
        last = set(found)
        names = {spec.entities[e] for e in last}
        for group in spec.groups:
            found |= set(group) if last & set(group) else set()
        for thing in spec.things:
            if thing.name in names:
                found |= spec.numbers_of(thing.opened_by)
        for who, c in enumerate(spec.characters):
            if spec.numbers_of(c.pushes + c.pulls + c.carries) & last:
                found.add(who)
    return frozenset(found)


@lru_cache(maxsize=8)
def part_of(
    spec: GridSpec, about: Entities, ruled: Callable[[GridSpec], World]
) -> SmallWorld | None:
    """A world with some entities and all who move them; None where it has too many states.

    Args:
        ruled: from a world's file to its rules, its states listed.
    """
    kept = with_movers(spec, about)
    if not any(e < len(spec.characters) for e in kept):
        kept |= {0}
    small = sub_world(spec, ((),) * len(spec.characters), kept, frozenset())
    called = dict(zip((t.name for t in things_of(spec, kept)), small.spec.things, strict=True))
    events = tuple(
        (name, tuple(called[thing].name for thing in things if thing in called))
        for name, things in spec.events
    )
    listed = replace(
        small.spec,
        characters=tuple(_with(c, {*called}) for c in small.spec.characters),
        events=tuple((name, things) for name, things in events if things),
    ).with_settings({"method": "exact", "states": "auto"})
    turns = np.prod([len(c.actions) * (1 + c.is_weak) for c in listed.characters])
    turns += len(listed.events) * len(listed.free_cells)
    if listed.state_count * turns > MOST:
        return None
    world, ranks = ruled(listed), ranks_of(spec, small)
    rows = np.zeros((len(spec.entities), spec.place_count), dtype=np.int32)
    for entity, rank in ranks.items():
        rows[entity] = rank
    own = [e for e in small.entities if e < len(spec.characters)]
    absent = len(spec.free_cells)
    place = np.array([*range(absent + 1), *(absent + 1 + each for each in own)])
    row = sum(
        rows[entity][place[world.tables.cells[:, at]]] for at, entity in enumerate(small.entities)
    )
    count = int(np.prod([len(spec.places[e]) for e in small.entities]))
    numbers = {entity: number for number, entity in enumerate(small.entities)}
    return SmallWorld(world, numbers, rows, np.asarray(row), count)


def _with(character: Character, things: set[str]) -> Character:
    """A character who wants nothing, and carries what is there of what it can."""
    carries, puts = (
        tuple(name for name in names if name in things)
        for names in (character.carries, character.puts_down)
    )
    return replace(character, goals=(NO_GOAL,), carries=carries, puts_down=puts)
