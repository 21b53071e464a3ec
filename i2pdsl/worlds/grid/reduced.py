"""Small copies of grid worlds: the same rules, casts and goals, on a map with fewer cells."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from i2pdsl.worlds.grid.reach import steps_to
from i2pdsl.worlds.grid.spec import WALL, Cell, GridSpec

SPARE = 3  # cells at least that nobody stands on


def reduced(spec: GridSpec, fits: Callable[[GridSpec], bool]) -> GridSpec | None:
    """The world without so many rows and columns that it fits; None where it never does.

    Tiles keep one of their cells, and what has a place of its own keeps that. Of the other rows
    and columns that goes first which is most like one beside it.
    """
    found: GridSpec | None = replace(
        spec,
        characters=tuple(replace(c, cell=None) for c in spec.characters),
        things=tuple(t if spec.is_fixed(t) else replace(t, cells=()) for t in spec.things),
    )
    while found is not None and not fits(found):
        found = _smaller(found)
    return found


def _smaller(spec: GridSpec) -> GridSpec | None:
    """The world without one more line."""
    candidates = [
        (_oddness(spec, axis, at), axis, at)
        for axis, count in enumerate((len(spec.rows[0]), len(spec.rows)))
        for at in range(count)
    ]
    for _, axis, at in sorted(candidates):
        found = _without(spec, axis, at)
        if found is not None and len(found.free_cells) < len(spec.free_cells):
            return found
    return None


def _oddness(spec: GridSpec, axis: int, at: int) -> int:
    """In how many cells a column (0) or row (1) differs from the one beside it that is most like
    it: in walls, and in tiles."""
    tiles = {cell: tile.name for tile in spec.tiles for cell in tile.cells}
    count = len(spec.rows[0]) if axis == 0 else len(spec.rows)

    def line(number: int) -> list[str]:
        other = range(len(spec.rows) if axis == 0 else len(spec.rows[0]))
        cells = [(number, k) if axis == 0 else (k, number) for k in other]
        return [
            tiles.get(cell, "") if spec.rows[cell[1]][cell[0]] != WALL else WALL for cell in cells
        ]

    own, beside = line(at), [line(k) for k in (at - 1, at + 1) if 0 <= k < count]
    return min((sum(a != b for a, b in zip(own, each, strict=True)) for each in beside), default=0)


def _without(spec: GridSpec, axis: int, at: int) -> GridSpec | None:
    """The world without a column (0) or a row (1); None where a goal would be lost or out of reach
    that was not, or too few cells are left."""

    def moved(cell: Cell) -> Cell | None:
        column, row = cell
        if cell[axis] == at:
            return None
        return (column - (column > at), row) if axis == 0 else (column, row - (row > at))

    rows = [row[:at] + row[at + 1 :] for row in spec.rows] if axis == 0 else [*spec.rows]
    if axis == 1:
        del rows[at]
    tiles = tuple(
        replace(tile, cells=tuple(filter(None, map(moved, tile.cells)))) for tile in spec.tiles
    )
    things = tuple(replace(t, cells=tuple(filter(None, map(moved, t.cells)))) for t in spec.things)
    pairs = [(moved(a), moved(b)) for a, b in spec.walls]
    walls = tuple(sorted((a, b) for a, b in pairs if a is not None and b is not None))
    found = replace(spec, rows=tuple(rows), tiles=tiles, things=things, walls=walls)
    lost = any(not t.cells for t in tiles) or any(
        len(new.cells) < len(old.cells) for new, old in zip(things, spec.things, strict=True)
    )
    enough = len(found.free_cells) >= len(found.entities) + SPARE if rows and rows[0] else False
    if lost or not enough or _parts(found) > _parts(spec):
        return None
    return found


def _parts(spec: GridSpec) -> int:
    """Into how many parts the map falls."""
    left, count = set(spec.free_cells), 0
    while left:
        left -= set(steps_to([min(left)], set(spec.free_cells), spec.walls))
        count += 1
    return count
