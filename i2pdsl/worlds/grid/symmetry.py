"""The symmetries of a map: two scripts of which one is the other's mirror image look alike."""

from __future__ import annotations

from functools import lru_cache
from itertools import product

import numpy as np

from i2pdsl.worlds.grid.spec import GridSpec

# The rotations and reflections of a square, as matrices that act on (column, row).
_SQUARE = tuple(
    np.array([[0, a], [b, 0]] if swapped else [[a, 0], [0, b]])
    for swapped, a, b in product((False, True), (1, -1), (1, -1))
)


@lru_cache(maxsize=32)
def symmetries(spec: GridSpec) -> tuple[tuple[int, ...], ...]:
    """The numbers of the cells [N] that all cells go to, for each rotation and reflection under
    which the map and what may be wanted of it stay as they are; the identity is the first.

    Tiles may change places, but all cells of one go to one, and whoever may want the one may want
    the other. Cells are numbered as in `spec.free_cells`.
    """
    cells = np.array(spec.free_cells)
    number = {cell: i for i, cell in enumerate(spec.free_cells)}
    found = []
    for turn in _SQUARE:
        turned = cells @ turn.T
        turned += cells.min(0) - turned.min(0)
        images = [number.get((int(c), int(r))) for c, r in turned]
        known = tuple(i for i in images if i is not None)
        if (
            len(known) == len(cells)
            and _keeps_walls(spec, known, number)
            and _keeps_goals(spec, known, number)
        ):
            found.append(known)
    return tuple(dict.fromkeys(found))  # a corridor is its own mirror image


def _keeps_walls(
    spec: GridSpec, images: tuple[int, ...], number: dict[tuple[int, int], int]
) -> bool:
    """Whether every wall between two cells goes to one."""
    walls = {frozenset((number[a], number[b])) for a, b in spec.walls}
    return {frozenset(images[i] for i in wall) for wall in walls} == walls


def _keeps_goals(
    spec: GridSpec, images: tuple[int, ...], number: dict[tuple[int, int], int]
) -> bool:
    """Whether every tile goes to a tile, everyone's goals to his goals, and what has a cell of its
    own to itself."""
    named = {frozenset(number[cell] for cell in tile.cells): tile.name for tile in spec.tiles}
    renamed = {}
    for cells, name in named.items():
        image = named.get(frozenset(images[i] for i in cells))
        if image is None:
            return False
        renamed[name] = image
    fixed = [t.cells for t in spec.things if spec.is_fixed(t)]
    if any(images[number[cell]] != number[cell] for cells in fixed for cell in cells):
        return False
    wanted = [set(c.goals) for c in spec.characters]
    wanted += [set(c.via) for c in spec.characters]
    wanted += [set(places) for c in spec.characters for _, places in c.supposes]
    return all({renamed.get(goal, goal) for goal in goals} == goals for goals in wanted)
