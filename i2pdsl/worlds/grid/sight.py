"""How far it is to walk on a map, and what is in sight, between any two of its cells.

Both depend on the walls alone: characters and things can be pushed or walked around, and are looked
over.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from i2pdsl.worlds.grid.reach import steps_to

Walls = Sequence[tuple[tuple[int, int], tuple[int, int]]]


def walking(coordinates: np.ndarray, walls: Walls = ()) -> np.ndarray:
    """The fewest steps between cells, int32 [N + 1, N + 1].

    N where no way leads, and from and to what is not there (the last row and column).

    Args:
        coordinates: (column, row) of each free cell, [N, 2].
        walls: pairs of cells with a wall between them.
    """
    count = len(coordinates)
    number = {(int(c), int(r)): i for i, (c, r) in enumerate(coordinates)}
    steps = np.full((count + 1, count + 1), count, dtype=np.int32)
    for cell, i in number.items():
        found = steps_to((cell,), number.keys(), frozenset(walls))
        steps[i, [number[other] for other in found]] = list(found.values())
    return steps


def in_sight(coordinates: np.ndarray, walls: Walls = ()) -> np.ndarray:
    """Whether the straight line between the middles of two cells crosses no wall, [N + 1, N + 1].

    A line that only touches the corner of a wall, or the end of one between two cells, is free.
    False for what is not there.

    Args:
        coordinates: (column, row) of each free cell, [N, 2]; what lies between them is wall.
        walls: pairs of cells with a wall between them.
    """
    count = len(coordinates)
    size = coordinates.max(0) + 1
    is_wall = np.ones(size, dtype=bool)
    is_wall[tuple(coordinates.T)] = False
    seen = np.zeros((count + 1, count + 1), dtype=bool)
    seen[:count, :count] = True
    blocks = np.argwhere(is_wall)
    for cell, here in enumerate(coordinates):
        way = coordinates - here  # [N, 2]
        for wall in blocks - here:
            # The line passes the middle of the square nearer than its corners do (twice, in whole
            # numbers), and the square lies between the ends.
            aside = 2 * abs(way[:, 0] * wall[1] - way[:, 1] * wall[0])
            near = aside < abs(way).sum(1)
            between = (np.minimum(way, 0) <= wall) & (wall <= np.maximum(way, 0))
            seen[cell, :count] &= ~(near & between.all(1))
        for one, other in walls:
            seen[cell, :count] &= ~_crosses(way, np.array(one) - here, np.array(other) - here)
    return seen


def _crosses(way: np.ndarray, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Whether lines from the origin to the cells of `way` [N, 2] cross the wall between two cells.

    All in twice the size, so that the ends of the wall are whole numbers.
    """
    middle, along = one + other, (other - one)[::-1]
    ends = middle - along, middle + along
    side = [2 * (way[:, 0] * end[1] - way[:, 1] * end[0]) for end in ends]
    across = other - one
    # How far the wall is, and how far one looks, across it.
    far, reach = (middle * across).sum(), 2 * (way * across).sum(1)
    beyond = (abs(reach) > abs(far)) & (reach * far > 0)
    return (side[0] * side[1] < 0) & beyond
