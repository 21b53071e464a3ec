"""Several good scripts that a viewer can tell apart, because the best score is not always the
best story."""

from __future__ import annotations

import numpy as np

from i2pdsl.worlds.grid.world import GridWorld

APART = 2.0  # cells: two scripts look alike if everyone stands closer than this, on average
_FAR = 4.0  # distance of something present from something absent


def distance(world: GridWorld, first: np.ndarray, second: np.ndarray) -> float:
    """How differently two scripts look, in cells.

    The largest, over the characters and the things that move in either script, of the mean
    distance over time between where it stands in the one and in the other.

    Args:
        first, second: states [T + 1].
    """
    cells = world.dynamics.cells
    a, b = cells[first].astype(np.int64), cells[second].astype(np.int64)
    characters = len(world.spec.characters)
    moves = (a != a[:1]).any(0) | (b != b[:1]).any(0)
    moves[:characters] = True
    place = world.tables.coordinates
    apart = np.abs(place[a] - place[b]).sum(-1).astype(float)
    absent = world.dynamics.absent
    apart = np.where((a == absent) != (b == absent), _FAR, np.minimum(apart, 2 * _FAR))
    return float(apart.mean(0)[moves].max())


def select_different(world: GridWorld, paths: list[np.ndarray], count: int) -> list[int]:
    """The first `count` scripts (best first) that differ visibly from all better ones."""
    chosen: list[int] = []
    for i, path in enumerate(paths):
        if all(distance(world, path, paths[j]) >= APART for j in chosen):
            chosen.append(i)
            if len(chosen) == count:
                break
    return chosen
