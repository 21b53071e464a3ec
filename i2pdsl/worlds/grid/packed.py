"""States of a grid world that are computed instead of listed.

A state is a number whose digits tell the place of each entity, in a base of its own: how many
places it can be in (spec.py:places), the last entity's digit the lowest. What an action leads to
is computed from the cells, by the rules of dynamics.py, for many states at once, in NumPy and in
JAX alike. What the rules of a world do not have costs nothing: its tables are not there.

S states, E entities, C characters, A actions of a character, N cells, M numbers of cells.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from i2pdsl.worlds.grid.arrays import Packed, Rules, cells_of, state_of
from i2pdsl.worlds.grid.dynamics import Dynamics, behind, neighbours
from i2pdsl.worlds.grid.spec import ACTIONS, PULLS, PUTS, STAY, GridSpec
from i2pdsl.worlds.world import Part

Array = Any

DRAWN = 1 << 18  # first pictures that are drawn, where there are more
_AT_ONCE = 1 << 21  # arrangements that are looked at together


def number_count(spec: GridSpec) -> int:
    """How many numbers there are, of valid arrangements and others."""
    return math.prod(map(len, spec.places))


@dataclass(frozen=True)
class Computed:
    """The states of a world, as dynamics.py:Dynamics lists them.

    Attributes:
        packed: how numbers tell cells, and what actions lead to.
        coordinates: int [N, 2], (column, row) of each cell.
        state_count: how many valid arrangements there are.
    """

    spec: GridSpec
    packed: Packed
    coordinates: np.ndarray
    state_count: int

    @property
    def absent(self) -> int:
        """The cell number of a thing that is not there."""
        return len(self.coordinates)

    @property
    def spots(self) -> np.ndarray:
        return np.arange(len(self.spec.characters))

    def cells_of(self, state: Array) -> np.ndarray:
        """The cells [..., E] in some states."""
        found: np.ndarray = cells_of(self.packed, np.asarray(state))
        return found

    def state_of(self, cells: np.ndarray) -> np.ndarray:
        """The states of arrangements [..., E]; -1 where one is invalid."""
        cells = np.array(cells, dtype=np.int64)
        for group in self.spec.groups:
            cells[..., list(group)] = np.sort(cells[..., list(group)], axis=-1)
        right = np.ones(cells.shape[:-1], dtype=bool)
        for entity, places in enumerate(self.spec.places):
            here = cells[..., entity]
            right &= np.isin(here, places)
            for other in range(entity):
                right &= (cells[..., other] != here) | (here >= self.absent)
        return np.where(right, state_of(self.packed, cells), -1)

    def drawn(self, placed: Sequence[int], parts: Sequence[Part], seed: int = 0) -> np.ndarray:
        """All states that fulfil some conditions, sorted; where there are too many, as many as
        `DRAWN` that are drawn from them.

        Entity by entity, arrangements of those before are completed in all ways that fulfil what
        is asked of those that are there; of too many, some are drawn first.

        Args:
            placed: the cell of each entity, -1 where that is open.
        """
        generator = np.random.default_rng(seed)
        entities = len(self.spec.entities)
        anywhere = np.array([places[0] for places in self.spec.places])
        later = {number for group in self.spec.groups for number in group[1:]}
        cells = np.zeros((1, 0), dtype=np.int64)
        asked = list(parts)
        for entity, places in enumerate(self.spec.places):
            options = np.array(places if placed[entity] < 0 else [placed[entity]])
            options = self._fulfilling(options[:, None], [entity], asked, anywhere)[:, 0]
            most = max(1, _AT_ONCE // max(1, len(options)))
            if len(cells) > most:
                cells = cells[np.sort(generator.choice(len(cells), most, replace=False))]
            column = np.tile(options, len(cells))
            cells = np.concatenate([np.repeat(cells, len(options), axis=0), column[:, None]], 1)
            before = cells[:, :-1]
            cells = cells[((before != column[:, None]) | (before >= self.absent)).all(1)]
            if entity in later:
                cells = cells[cells[:, -2] < cells[:, -1]]
            cells = self._fulfilling(cells, range(entity + 1), asked, anywhere)
            asked = [part for part in asked if not part[0] <= set(range(entity + 1))]
        if len(cells) > DRAWN:
            cells = cells[generator.choice(len(cells), DRAWN, replace=False)]
        assert cells.shape[1] == entities
        return np.sort(state_of(self.packed, cells))

    def _fulfilling(
        self, cells: np.ndarray, known: Sequence[int], parts: Sequence[Part], anywhere: np.ndarray
    ) -> np.ndarray:
        """Those of some arrangements [S, n] of a few entities that fulfil what is asked of these
        alone."""
        asked = [holds for about, holds in parts if about <= set(known)]
        if not asked or not len(cells):
            return cells
        every = np.tile(anywhere, (len(cells), 1))
        every[:, list(known)] = cells
        states = state_of(self.packed, every)
        return cells[np.logical_and.reduce([holds(states) for holds in asked])]


States = Dynamics | Computed


@lru_cache(maxsize=4)
def computed(spec: GridSpec) -> Computed:
    """How the states of a world are computed."""
    coordinates = np.array(spec.free_cells, dtype=np.int64).reshape(-1, 2)
    every = spec.places
    radix = np.array([len(places) for places in every])
    places = np.zeros((len(every), radix.max()), dtype=np.int64)
    digits = np.zeros((len(every), spec.place_count), dtype=np.int64)
    for entity, some in enumerate(every):
        step = int(np.prod(radix[entity + 1 :]))
        places[entity, : len(some)] = some
        digits[entity, list(some)] = step * np.arange(len(some))
    alike = np.zeros(len(every) - 1, dtype=bool)
    for group in spec.groups:
        alike[list(group[:-1])] = True
    packed = Packed(
        radix=radix,
        places=places,
        digits=digits,
        absent=np.array(len(coordinates)),
        rules=tuple(_rules(spec, who) for who in range(len(spec.characters))),
        alike=alike if alike.any() else None,
    )
    return Computed(spec, packed, coordinates, spec.state_count)


def _rules(spec: GridSpec, who: int) -> Rules:
    """What a character can do, as tables."""
    character, entities = spec.characters[who], spec.entities
    actions, count = character.actions, len(entities)
    near = neighbours(spec)
    on_map = len(spec.free_cells) + 1
    nowhere = np.full(on_map, -1)

    def beside(kinds: Sequence[str], table: Callable[[str], np.ndarray]) -> np.ndarray:
        return np.stack([table(a) if a in kinds else nowhere for a in actions], axis=1)

    def further(action: str) -> np.ndarray:
        once = near[action]
        return np.where(once >= 0, near[action][once], -1)

    def those(numbers: frozenset[int], kinds: Sequence[str]) -> np.ndarray | None:
        """Which actions do it to which of some entities: [A, E]; None where there are none."""
        which = np.array([e in numbers and e != who for e in range(count)])
        found = np.array([[a in kinds] for a in actions]) & which
        return found if found.any() else None

    goes = [a for a in actions if a not in PUTS]
    takes_by = [a for a in goes if a not in PULLS and a != ACTIONS[STAY]]
    locks = frozenset(entities.index(thing.name) for thing in spec.things if thing.opened_by)
    keys = np.zeros((count, count), dtype=bool)
    for thing in spec.things:
        for key in thing.opened_by:
            keys[entities.index(thing.name), entities.index(key)] = True
    pushes = those(spec.numbers_of(character.pushes), ACTIONS)
    opens = those(locks, takes_by)
    has_pulls, has_puts = (any(a in kinds for a in actions) for kinds in (PULLS, PUTS))
    pulled = spec.numbers_of(character.pulls)
    put = [entities.index(name) for name in character.puts_down] if has_puts else []
    holders = [[k in spec.holders(entities[n]) for k in range(len(spec.characters))] for n in put]
    return Rules(
        target=beside(goes, lambda a: near[a]),
        others=np.arange(count) != who,
        beyond=None if pushes is None else beside(ACTIONS, further),
        pushes=pushes,
        takes=those(spec.numbers_of(character.carries), takes_by),
        opens=opens,
        keys=None if opens is None else keys,
        behind=beside(PULLS, lambda a: behind(near[a])) if has_pulls else None,
        pulls=np.array([e in pulled and e != who for e in range(count)]) if has_pulls else None,
        is_pull=np.array([a in PULLS for a in actions]) if has_pulls else None,
        aside=beside(PUTS, lambda a: near[a]) if put else None,
        puts=np.array(put) if put else None,
        holders=np.array(holders) if put else None,
    )
