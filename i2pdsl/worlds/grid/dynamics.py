"""States and moves of a grid world as arrays (NumPy, built once per world).

A state is the index of a valid arrangement: the cells of the characters and then of the things,
no two on one cell; an absent thing has the cell number `absent` = number of free cells.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from i2pdsl.worlds.grid.spec import ACTIONS, OFFSETS, GridSpec

Array = Any  # numpy.ndarray or jax.Array: the functions of a world serve both


@dataclass(frozen=True)
class Dynamics:
    """The arrays of a world's states. S states, E entities, C characters, A = 5 actions, N cells.

    Attributes:
        cells: int16 [S, E] (int32 on maps too large for it), the cell of each entity.
        lookup: int32 [N+1]*E flattened, the state of an arrangement, -1 where it is invalid.
        strides: int [E], so that lookup[(cells * strides).sum()] is the state.
        successor: int32 [C, A, S], the state after a character's action if it succeeds; the state
            itself where the character is blocked or stays.
        coordinates: int [N, 2], (column, row) of each cell.
    """

    cells: np.ndarray
    lookup: np.ndarray
    strides: np.ndarray
    successor: np.ndarray
    coordinates: np.ndarray

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
    count = len(coordinates)
    cells = _arrangements(spec, count)
    entities = cells.shape[1]
    strides = (count + 1) ** np.arange(entities - 1, -1, -1, dtype=np.int64)
    lookup = np.full((count + 1) ** entities, -1, dtype=np.int32)
    lookup[cells.astype(np.int64) @ strides] = np.arange(len(cells), dtype=np.int32)
    neighbour = _neighbours(spec, count)
    successor = np.stack(
        [
            _successors(spec, who, cells, neighbour, lookup, strides)
            for who in range(len(spec.characters))
        ]
    )
    return Dynamics(cells, lookup, strides, successor, coordinates)


def _arrangements(spec: GridSpec, count: int) -> np.ndarray:
    """All valid cells of the entities, in row-major order: int16 or int32 [S, E]."""
    narrow = np.dtype(np.int16 if count <= np.iinfo(np.int16).max else np.int32)
    cells = np.zeros((1, 0), dtype=narrow)
    may_be_absent = [False] * len(spec.characters) + [t.may_be_absent for t in spec.things]
    for absent_too in may_be_absent:
        options = np.arange(count + absent_too, dtype=narrow)
        repeated = np.repeat(cells, len(options), axis=0)
        column = np.tile(options, len(cells))
        free = np.ones(len(column), dtype=bool)
        for other in range(cells.shape[1]):
            # Two absent things share the number `count` without being in each other's way.
            free &= (repeated[:, other] != column) | (column == count)
        cells = np.concatenate([repeated[free], column[free, None]], axis=1)
    return cells


def _neighbours(spec: GridSpec, count: int) -> np.ndarray:
    """The neighbouring cell in each direction, -1 where there is a wall: int [N + 1, A]."""
    number = {cell: i for i, cell in enumerate(spec.free_cells)}
    table = np.full((count + 1, len(ACTIONS)), -1, dtype=np.int64)
    for (column, row), cell in number.items():
        for action, (dx, dy) in enumerate(OFFSETS):
            table[cell, action] = number.get((column + dx, row + dy), -1)
    return table


def _successors(
    spec: GridSpec,
    who: int,
    cells: np.ndarray,
    neighbour: np.ndarray,
    lookup: np.ndarray,
    strides: np.ndarray,
) -> np.ndarray:
    """The successful outcome of each action of one character: int32 [A, S]."""
    names = spec.entities
    pushed_by = [name in spec.characters[who].pushes for name in names]
    own = cells[:, who].astype(np.int64)
    result = np.empty((len(ACTIONS), len(cells)), dtype=np.int32)
    base = cells.astype(np.int64) @ strides
    for action in range(len(ACTIONS)):
        target = neighbour[own, action]
        beyond = neighbour[target, action]  # -1 reads the last row, which is all -1
        possible = target >= 0
        index = base + (target - own) * strides[who]
        for other in range(cells.shape[1]):
            if other == who:
                continue
            met = (cells[:, other] == target) & (target >= 0)
            if not pushed_by[other]:
                possible &= ~met
                continue
            free = beyond >= 0
            for third in range(cells.shape[1]):
                if third not in (who, other):
                    free &= cells[:, third] != beyond
            possible &= ~met | free
            index += np.where(met & free, (beyond - target) * strides[other], 0)
        states = np.arange(len(cells), dtype=np.int32)
        result[action] = np.where(possible, lookup[np.where(possible, index, base)], states)
    return result
