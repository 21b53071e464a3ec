"""Additive planning: values of a crowded world as sums over worlds with fewer in them.

A character belongs together with those whom it models (`core`). Its value after an action is taken
to be made of what these can reach alone, of what each other entity changes about that, of what each
two of them change beyond that, and so on, up to sub-worlds of `at_once` entities. With O the
others, m of which fit in beside the core, and W_T the exact values of the sub-world of the core and
T,

    W(s) = sum_{T in O, |T| <= m} c(|T|) W_T(s),   c(k) = (-1)^(m - k) binom(|O| - k - 1, m - k)

and W = W_O where all fit in. This is the truncated expansion of a function around an anchor
(cut-HDMR: Rabitz and Alis, General foundations of high-dimensional model representations, J. Math.
Chem. 1999), the anchor being that the others are not there. For a couple and two tables, three at
once: W(c, r, t1) + W(c, r, t2) - W(c, r).

Whatever moves, pushes or stands in the way does so for all of them: only the values are sums.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from itertools import combinations
from math import comb

import numpy as np

from i2pdsl.worlds.grid.arrays import Terms
from i2pdsl.worlds.grid.dynamics import Dynamics
from i2pdsl.worlds.grid.problems import Key, thought_of
from i2pdsl.worlds.grid.spec import Character, GridSpec, Thing

Entities = frozenset[int]
NOBODY = ("",)  # whom one pulls who pulls none that are kept: its actions stay as many


@dataclass(frozen=True)
class SubWorld:
    """A world with some of another's entities, in their order.

    Attributes:
        spec: as a world of its own.
        keys: the problems of its characters that are wanted.
        entities: their numbers in the whole world.
    """

    spec: GridSpec
    keys: tuple[tuple[Key, ...], ...]
    entities: tuple[int, ...]


def core(spec: GridSpec, who: int) -> Entities:
    """The entities that a character's plans cannot do without: itself, those whom it models, those
    whom these model, and all keys and doors with those who carry them."""
    found = set(thought_of(spec, spec.characters[who]))
    linked = tuple(thing.name for thing in spec.things if spec.is_linked(thing))
    holders = {each for name in linked for each in spec.holders(name)}
    return frozenset(found | holders | spec.numbers_of(linked))


def coefficients(spec: GridSpec, who: int, at_once: int) -> dict[Entities, int]:
    """The sub-worlds of which a character's values are the sum, and how often each counts."""
    own = core(spec, who)
    others = [e for e in range(len(spec.entities)) if e not in own]
    most = max(0, at_once - len(own))
    if most >= len(others):
        return {own | frozenset(others): 1}
    found: dict[Entities, int] = {}
    for size in range(most, -1, -1):
        count = (-1) ** (most - size) * comb(len(others) - size - 1, most - size)
        found |= {own | frozenset(some): count for some in combinations(others, size)}
    return found


@cache
def sub_worlds(
    spec: GridSpec, keys: tuple[tuple[Key, ...], ...], at_once: int
) -> dict[Entities, SubWorld]:
    """The sub-worlds that are planned for, each once for all who need it; like ones are equal."""
    wanted: dict[Entities, Entities] = {}
    for who in range(len(spec.characters)):
        for kept in coefficients(spec, who, at_once):
            wanted[kept] = wanted.get(kept, frozenset()) | core(spec, who)
    return {kept: sub_world(spec, keys, kept, minded) for kept, minded in wanted.items()}


def sub_world(
    spec: GridSpec, keys: tuple[tuple[Key, ...], ...], kept: Entities, minded: Entities
) -> SubWorld:
    """A world with the entities that are kept, of whom some have a mind."""
    entities, count = tuple(sorted(kept)), len(spec.characters)
    things = things_of(spec, kept)
    # Things that differ in nothing but their names are called alike: their worlds are planned once.
    plain = not any(spec.is_linked(thing) for thing in things)
    called = {t.name: f"thing {i}" if plain else t.name for i, t in enumerate(things)}
    called |= {c.name: c.name for who, c in enumerate(spec.characters) if who in kept}

    def known(names: tuple[str, ...]) -> tuple[str, ...]:
        return tuple(sorted(called[name] for name in names if name in called))

    def character(who: int) -> Character:
        c = spec.characters[who]
        pulls = (known(c.pulls) or NOBODY) if c.pulls else ()
        c = replace(c, pushes=known(c.pushes), pulls=pulls, misreads=(), supposes=(), cell=None)
        return c if who in minded else replace(c, goals=(), attitudes=(), models=())

    small = replace(
        spec,
        name=f"part of {spec.name}",
        characters=tuple(character(who) for who in entities if who < count),
        things=tuple(replace(t, name=called[t.name], sprite="", color="") for t in things),
        events=(),
        documentation="",
        source="",
        shares=(),
    )
    own = tuple(keys[who] if who in minded else () for who in entities if who < count)
    return SubWorld(small, own, entities)


def things_of(spec: GridSpec, kept: Entities) -> tuple[Thing, ...]:
    """The things that are kept; of several that are alike, as many."""
    found, first = [], len(spec.characters)
    for thing in spec.things:
        number = sum(first + i in kept for i in range(thing.count))
        first += thing.count
        if number:
            cells = thing.cells if spec.is_fixed(thing) else ()
            found.append(replace(thing, count=number, cells=cells))
    return tuple(found)


def summed(
    spec: GridSpec,
    at_once: int,
    planned: dict[SubWorld, tuple[Dynamics, tuple[np.ndarray, ...]]],
    parts: dict[Entities, SubWorld],
) -> Iterator[tuple[np.ndarray, Terms]]:
    """For each character its values in all its sub-worlds [R, P], and how they are summed.

    Args:
        planned: of each sub-world the states and continuations.
        parts: as `sub_worlds` has them.
    """
    for who in range(len(spec.characters)):
        tables: list[np.ndarray] = []
        begins: dict[SubWorld, int] = {}
        terms = coefficients(spec, who, at_once)
        rows = np.zeros((len(spec.entities), spec.place_count, len(terms)), dtype=np.int32)
        first = np.zeros(len(terms), dtype=np.int32)
        for k, kept in enumerate(terms):
            part = parts[kept]
            ranks = ranks_of(spec, part)
            for entity, rank in ranks.items():
                rows[entity, :, k] = rank
            like = replace(part, entities=())
            if like not in begins:
                begins[like] = sum(map(len, tables))
                tables.append(_laid_out(spec, part, ranks, who, *planned[like]))
            first[k] = begins[like]
        yield np.concatenate(tables), Terms(rows, first, np.array([*terms.values()], dtype=float))


def ranks_of(spec: GridSpec, part: SubWorld) -> dict[int, np.ndarray]:
    """What each cell of each entity of a sub-world adds to the number of a row: int [M] each."""
    found, step = {}, 1
    for entity in reversed(part.entities):
        places = spec.places[entity]
        rank = np.zeros(spec.place_count, dtype=np.int32)
        rank[list(places)] = step * np.arange(len(places))
        found[entity] = rank
        step *= len(places)
    return found


def _laid_out(
    spec: GridSpec,
    part: SubWorld,
    ranks: dict[int, np.ndarray],
    who: int,
    dynamics: Dynamics,
    values: tuple[np.ndarray, ...],
) -> np.ndarray:
    """A character's values in a sub-world, with a row for each arrangement: [R, P]."""
    own = [e for e in part.entities if e < len(spec.characters)]
    absent = len(spec.free_cells)
    # Who carries something has another number among fewer characters.
    place = np.array([*range(absent + 1), *(absent + 1 + each for each in own)])
    row = sum(
        rank[place[dynamics.cells[:, at]]] for at, (_, rank) in enumerate(sorted(ranks.items()))
    )
    count = int(np.prod([len(spec.places[e]) for e in part.entities]))
    theirs = values[own.index(who)]
    found = np.zeros((count, theirs.shape[1]))
    found[row] = theirs
    return found
