"""States and moves of a grid world as arrays (NumPy, built once per world).

A state is the index of a valid arrangement: the cells of the characters and then of the things,
no two on one cell. An absent thing has the cell number `absent` = number of free cells, and one
that the k-th character carries `absent` + 1 + k (spec.py:places); marks are kept in the same way
(spec.py:marks). Things that are alike stand in the order of their cells: whichever arrangement of
them an action leads to, it is the same state.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import permutations, product
from typing import Any

import numpy as np

from i2pdsl.worlds.grid.spec import (
    ACTIONS,
    DIAGONALS,
    OFFSET_OF,
    OFFSETS,
    PULLS,
    PUTS,
    GridSpec,
)

Array = Any  # numpy.ndarray or jax.Array: the functions of a world serve both


@dataclass(frozen=True)
class Dynamics:
    """The arrays of a world's states. S states, E entities and marks, N cells, A actions of a
    character.

    Attributes:
        cells: int16 [S, E + K] (int32 on maps too large for it), the cell of each entity and mark;
            then of each character that has marks its cell + (N + 1) m, bit i of m saying whether it
            has its i-th mark.
        spots: int [C], the column of `cells` that tells where a character is, with its marks.
        lookup: int32 [M]*E flattened, M = N + 1 or, where something is carried, N + 1 + C, the
            state of an arrangement, -1 where it is invalid; empty where that would be long
            (spec.py:is_sparse).
        strides: int [E + K], so that lookup[(cells * strides).sum()] is the state.
        known: int64 [K], where `lookup` is empty: the numbers that it would have, sorted.
        states: int32 [K], their states.
        successor: for each character int32 [A, S], the state after its action if it succeeds; the
            state itself where it is blocked or stays.
        coordinates: int [N, 2], (column, row) of each cell.
    """

    cells: np.ndarray
    lookup: np.ndarray
    strides: np.ndarray
    successor: tuple[np.ndarray, ...]
    coordinates: np.ndarray
    known: np.ndarray
    states: np.ndarray
    spots: np.ndarray

    def find(self, codes: np.ndarray) -> np.ndarray:
        """The states of arrangements, (cells * strides).sum(); -1 where one is invalid."""
        if len(self.lookup):
            found: np.ndarray = self.lookup[codes]
            return found
        place = np.minimum(np.searchsorted(self.known, codes), len(self.known) - 1)
        return np.where(self.known[place] == codes, self.states[place], -1)

    @property
    def sorted_numbers(self) -> np.ndarray:
        """`known` and `states`, one above the other: [2, K]."""
        return np.stack([self.known, self.states.astype(self.known.dtype)])

    def state_of(self, cells: np.ndarray) -> np.ndarray:
        """The states of arrangements [..., E + marks]; -1 where one is invalid."""
        return self.find(cells @ self.strides[: cells.shape[-1]])

    def cells_of(self, state: Array) -> np.ndarray:
        """The cells [..., E] in some states, whatever their frames."""
        found: np.ndarray = self.cells[state % len(self.cells)]
        return found

    @property
    def state_count(self) -> int:
        return len(self.cells)

    @property
    def absent(self) -> int:
        """The cell number of a thing that is not there."""
        return len(self.coordinates)


@lru_cache(maxsize=4)
def build_dynamics(spec: GridSpec) -> Dynamics:
    """Enumerates the states of a world and all moves."""
    coordinates = np.array(spec.free_cells, dtype=np.int64).reshape(-1, 2)
    count, entities = len(coordinates), len(spec.entities) + len(spec.marks)
    strides = spec.place_count ** np.arange(entities - 1, -1, -1, dtype=np.int64)
    neighbour = neighbours(spec)
    cells = _in_reach(spec, neighbour, strides) if spec.is_limited else _arrangements(spec, count)
    states = np.arange(len(cells), dtype=np.int32)
    lookup = np.full(0 if spec.is_sparse else spec.arrangement_count, -1, dtype=np.int32)
    known, numbers = np.zeros(0, dtype=np.int64), states[:0]
    if spec.is_sparse:
        known, numbers = _numbered(spec, cells, strides)
    else:
        for order in _orders(spec):
            lookup[cells[:, order].astype(np.int64) @ strides] = states
    more, spots = _marked_cells(spec, cells)
    strides = np.concatenate([strides, np.zeros(more.shape[1], dtype=strides.dtype)])
    cells = np.concatenate([cells, more.astype(cells.dtype)], axis=1)
    plain = Dynamics(cells, lookup, strides, (), coordinates, known, numbers, spots)
    successor = tuple(
        # From the last frame of a limited world nothing leads on.
        np.where((after := plain.find(codes)) >= 0, after, states)
        for codes in (
            _successors(spec, who, cells[:, :entities], neighbour, strides[:entities])
            for who in range(len(spec.characters))
        )
    )
    return replace(plain, successor=successor)


def _numbered(
    spec: GridSpec, cells: np.ndarray, strides: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The numbers of arrangements in each order of those that are alike, sorted, and their
    states."""
    orders = _orders(spec)
    every = np.concatenate([cells[:, order].astype(np.int64) @ strides for order in orders])
    by_number = np.argsort(every)
    states = np.tile(np.arange(len(cells), dtype=np.int32), len(orders))
    return every[by_number], states[by_number]


def listed(spec: GridSpec, cells: np.ndarray, successor: tuple[np.ndarray, ...]) -> Dynamics:
    """Some arrangements [S, E] of a world without marks, and what follows them, as its states."""
    coordinates = np.array(spec.free_cells, dtype=np.int64).reshape(-1, 2)
    strides = spec.place_count ** np.arange(cells.shape[1] - 1, -1, -1, dtype=np.int64)
    known, states = _numbered(spec, cells, strides)
    lookup, spots = np.zeros(0, dtype=np.int32), np.arange(len(spec.characters))
    return Dynamics(cells, lookup, strides, successor, coordinates, known, states, spots)


def _marked_cells(spec: GridSpec, cells: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """For each character that has marks, where it is with them: [S, K], and its column [C]."""
    first, own = len(spec.entities), [who for who, _ in spec.marks]
    found: list[np.ndarray] = []
    spots = np.arange(len(spec.characters))
    for who in dict.fromkeys(own):
        been = [cells[:, first + m] > len(spec.free_cells) for m, w in enumerate(own) if w == who]
        bits = sum(mark.astype(np.int64) << bit for bit, mark in enumerate(been))
        spots[who] = cells.shape[1] + len(found)
        found.append(cells[:, who] + (len(spec.free_cells) + 1) * bits)
    return np.array(found, dtype=np.int64).reshape(len(found), len(cells)).T, spots


def initial_marks(spec: GridSpec, cells: np.ndarray) -> np.ndarray:
    """The marks [..., M] of characters who have been nowhere but where they are, of cells
    [..., C]."""
    absent, number = len(spec.free_cells), {cell: i for i, cell in enumerate(spec.free_cells)}
    tiles = {tile.name: [number[cell] for cell in tile.cells] for tile in spec.tiles}
    been = [
        np.where(np.isin(cells[..., who], tiles[tile]), absent + 1 + who, absent)
        for who, tile in spec.marks
    ]
    return np.stack(been, axis=-1) if been else np.zeros((*cells.shape[:-1], 0), dtype=np.int64)


def _with_marks(spec: GridSpec, codes: np.ndarray, strides: np.ndarray) -> np.ndarray:
    """The numbers of arrangements in which everybody who is on a tile of a mark of its own has
    it."""
    if not spec.marks:
        return codes
    count, first = len(spec.characters), len(spec.entities)
    digit = lambda column: codes // strides[column] % spec.place_count
    here = initial_marks(spec, np.stack([digit(who) for who in range(count)], axis=-1))
    for number in range(len(spec.marks)):
        before = digit(first + number)
        codes = codes + (np.maximum(before, here[..., number]) - before) * strides[first + number]
    return codes


def _arrangements(spec: GridSpec, count: int) -> np.ndarray:
    """All valid cells of the entities, in row-major order: int16 or int32 [S, E]."""
    narrow = np.dtype(np.int16 if count <= np.iinfo(np.int16).max // 2 else np.int32)
    cells = np.zeros((1, 0), dtype=narrow)
    later = {number for group in spec.groups for number in group[1:]}
    for entity, places in enumerate(spec.places):
        options = np.array(places, dtype=narrow)
        repeated = np.repeat(cells, len(options), axis=0)
        column = np.tile(options, len(cells))
        free = np.ones(len(column), dtype=bool)
        for other in range(cells.shape[1]):
            # Of what is on no cell, nobody is in the other's way.
            free &= (repeated[:, other] != column) | (column >= count)
        if entity in later:
            free &= repeated[:, -1] < column
        cells = np.concatenate([repeated[free], column[free, None]], axis=1)
    return cells


def _orders(spec: GridSpec) -> list[list[int]]:
    """Every order of the entities [E] in which those that are alike have changed places."""
    found = []
    for changed in product(*(permutations(group) for group in spec.groups)):
        order = list(range(len(spec.entities) + len(spec.marks)))
        for group, places in zip(spec.groups, changed, strict=True):
            for entity, place in zip(group, places, strict=True):
                order[entity] = place
        found.append(order)
    return found


Neighbours = Mapping[str, np.ndarray]
"""Of each action the cell [N + 1] to which it leads from each, -1 where there is a wall or that is
not the way; the last is that of no cell."""


def neighbours(spec: GridSpec) -> Neighbours:
    """Where each action leads from each cell of a map."""
    count = len(spec.free_cells)
    number = {cell: i for i, cell in enumerate(spec.free_cells)}
    walls = set(spec.walls)
    ways = {cell: tile.one_way for tile in spec.tiles if tile.one_way for cell in tile.cells}
    plain = {}
    for action, (dx, dy) in zip(ACTIONS, OFFSETS, strict=True):
        table = np.full(count + 1, -1, dtype=np.int64)
        for here, cell in number.items():
            there = here[0] + dx, here[1] + dy
            wrong = any(action not in ways.get(c, ACTIONS) for c in (here, there))
            is_open = (here, there) not in walls and (there, here) not in walls
            if there == here or (is_open and not wrong):
                table[cell] = number.get(there, -1)
        plain[action] = table
    found = {
        action: plain[ACTIONS[OFFSETS.index(way)]]
        for action, way in OFFSET_OF.items()
        if way in OFFSETS
    }
    for action in DIAGONALS:
        one, other = (plain[way] for way in action.split("_"))
        # Aslant only where both ways around the corner are open; -1 reads the last, which is -1.
        found[action] = np.where(other[one] == one[other], other[one], -1)
    return found


def _in_reach(spec: GridSpec, neighbour: Neighbours, strides: np.ndarray) -> np.ndarray:
    """The cells [S, E] of all arrangements that a limited world can come to in time, in the middle
    of a frame too, sorted."""
    number = {cell: i for i, cell in enumerate(spec.free_cells)}
    start = np.array([[number[cell] for cell in spec.placed if cell is not None]])
    start = np.concatenate([start, initial_marks(spec, start)], axis=1)
    found = ends = np.unique(_codes(spec, start, strides))

    def after(codes: np.ndarray, who: int) -> np.ndarray:
        cells = codes[:, None] // strides % spec.place_count
        moved = _successors(spec, who, cells, neighbour, strides)
        cells = np.unique(moved)[:, None] // strides % spec.place_count
        return np.unique(_codes(spec, cells, strides))

    everyone = range(len(spec.characters))
    for _ in range(spec.settings.horizon):
        # In any order: of two who act together, the second may go first (model.py).
        orders = [tuple(everyone), tuple(reversed(everyone))] if spec.together else [everyone]
        reached = []
        for order in orders:
            codes = ends
            for who in order:
                codes = after(codes, who)
                found = np.union1d(found, codes)
            reached.append(codes)
        ends = np.unique(np.concatenate(reached))
    return found[:, None] // strides % spec.place_count


def _codes(spec: GridSpec, cells: np.ndarray, strides: np.ndarray) -> np.ndarray:
    """The numbers of arrangements, in which those that are alike stand in order."""
    cells = cells.copy()
    for group in spec.groups:
        cells[:, list(group)] = np.sort(cells[:, list(group)], axis=1)
    codes: np.ndarray = cells @ strides
    return codes


def _successors(
    spec: GridSpec,
    who: int,
    cells: np.ndarray,
    neighbour: Neighbours,
    strides: np.ndarray,
) -> np.ndarray:
    """What each action of one character leads to, if it succeeds: numbers of arrangements,
    int64 [A, S]."""
    character = spec.characters[who]
    pushed, pulled = spec.numbers_of(character.pushes), spec.numbers_of(character.pulls)
    own = cells[:, who].astype(np.int64)
    result = np.empty((len(character.actions), len(cells)), dtype=np.int64)
    base = cells.astype(np.int64) @ strides
    others = [other for other in range(cells.shape[1]) if other != who]
    absent = len(spec.free_cells)
    mine = spec.numbers_of(character.carries)
    locks = {
        spec.entities.index(thing.name): [spec.entities.index(key) for key in thing.opened_by]
        for thing in spec.things
        if thing.opened_by
    }
    for row, action in enumerate(character.actions):
        target = neighbour[action][own]
        if action in PUTS:
            result[row] = base + _put(spec, who, cells, target, strides)
            continue
        beyond = neighbour[action][target]  # -1 reads the last row, which is -1
        possible = target >= 0
        index = base + (target - own) * strides[who]
        for other in others:
            met = (cells[:, other] == target) & (target >= 0)
            if action not in PULLS and action != "stay" and (other in mine or other in locks):
                # It is taken, or a door that opens to who has its key.
                keys = locks.get(other, [])
                able = other in mine or (cells[:, keys] == absent + 1 + who).any(1)
                goes = absent + 1 + who if other in mine else absent
                possible &= ~met | able
                index += np.where(met & able, (goes - target) * strides[other], 0)
                continue
            if other not in pushed or action not in ACTIONS:
                possible &= ~met
                continue
            free = beyond >= 0
            for third in others:
                if third != other:
                    free &= cells[:, third] != beyond
            possible &= ~met | free
            index += np.where(met & free, (beyond - target) * strides[other], 0)
        if action in PULLS:  # it goes one cell, and what stands behind it comes to where it was
            back = behind(neighbour[action])[own]
            held = np.zeros(len(cells), dtype=bool)
            for other in pulled:
                follows = (cells[:, other] == back) & (back >= 0)
                held |= follows
                index += np.where(follows, (own - back) * strides[other], 0)
            possible &= held
        result[row] = np.where(possible, index, base)
    return _with_marks(spec, result, strides)


def _put(
    spec: GridSpec, who: int, cells: np.ndarray, target: np.ndarray, strides: np.ndarray
) -> np.ndarray:
    """What the numbers of arrangements change by as a character puts down, on the target, the
    first of the things that it has and that can go there; or hands it to who stands there and
    carries such."""
    absent = len(spec.free_cells)
    change, done = np.zeros(len(cells), dtype=np.int64), target < 0
    taken = (cells == target[:, None]).any(1)
    for thing in spec.characters[who].puts_down:
        number = spec.entities.index(thing)
        goes = np.where(taken, -1, target)
        for other in spec.holders(thing):
            goes = np.where(cells[:, other] == target, absent + 1 + other, goes)
        able = ~done & (cells[:, number] == absent + 1 + who) & (goes >= 0)
        change += np.where(able, (goes - cells[:, number]) * strides[number], 0)
        done |= able
    return change


def behind(neighbour: np.ndarray) -> np.ndarray:
    """The cell [N + 1] from which an action leads to each, -1 where there is none."""
    found = np.full(len(neighbour), -1)
    cells = np.flatnonzero(neighbour >= 0)
    found[neighbour[cells]] = cells
    return found
