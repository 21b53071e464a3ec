"""A state of a grid world in characters: its map."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise

from i2pdsl.errors import display_width, padded
from i2pdsl.render.characters import Ink, laid_out
from i2pdsl.worlds.grid.script import state_as_json
from i2pdsl.worlds.grid.spec import WALL, GridSpec
from i2pdsl.worlds.grid.world import GridWorld


def map_in_characters(world: GridWorld, state: int, ink: Ink) -> str:
    """The map with everyone on it, and who is who."""
    spec = world.spec
    places = state_as_json(spec, world.dynamics, state)
    letters = _letters(spec.entities)
    floor, wall = ("·", "█") if ink.unicode else (".", "#")
    signs = (*letters.values(), *(tile.name[0].lower() for tile in spec.tiles))
    wide = max(map(display_width, signs), default=1)
    wall, floor = wall * wide, padded(floor, wide)
    rows = [[wall if symbol == WALL else floor for symbol in row] for row in spec.rows]
    for tile in spec.tiles:
        for column, row in tile.cells:
            sign = padded(tile.name[0].lower(), wide)
            rows[row][column] = ink.paint(sign, _colour(tile.color))
    for name, place in places.items():
        if place is not None and not isinstance(place, str):
            sign = padded(letters[name], wide)
            rows[place[1]][place[0]] = ink.paint(sign, f"1;{_colour(_look(spec, name))}")
    where = lambda place: f" (with {place})" if isinstance(place, str) else ""
    told = [
        (
            letters[name],
            f"1;{_colour(_look(spec, name))}",
            name + (where(place) if place else " (absent)"),
        )
        for name, place in places.items()
    ]
    told += [(tile.name[0].lower(), _colour(tile.color), tile.name) for tile in spec.tiles]
    legend = [(f"{sign} {name}", f"{ink.paint(sign, code)} {name}") for sign, code, name in told]
    lines = [f"    {line}" for line in _fenced(spec, rows, wide, ink)]
    return "\n".join((*lines, *laid_out(legend, 2, 4, ink.columns)))


def _fenced(spec: GridSpec, rows: list[list[str]], wide: int, ink: Ink) -> list[str]:
    """The rows of cells [height][width] with the walls between them, each cell `wide` columns."""
    upright, level = ("│", "─") if ink.unicode else ("|", "-")
    walls, lines = set(spec.walls), []
    for r, row in enumerate(rows):
        gaps = [upright if ((c, r), (c + 1, r)) in walls else " " for c in range(len(row) - 1)]
        lines.append("".join(cell + gap for cell, gap in zip(row, [*gaps, ""], strict=True)))
        below = [((c, r), (c, r + 1)) in walls for c in range(len(row))]
        if any(below):
            cells = [level * wide if wall else " " * wide for wall in below]
            joints = [level if a and b else " " for a, b in pairwise(below)]
            line = "".join(cell + gap for cell, gap in zip(cells, [*joints, ""], strict=True))
            lines.append(line.rstrip())
    return lines


def _letters(names: Iterable[str]) -> dict[str, str]:
    """A capital letter for each, as near to the front of its name as others leave it."""
    found: dict[str, str] = {}
    for name in names:
        free = [c.upper() for c in name if c.isalpha() and c.upper() not in found.values()]
        found[name] = free[0] if free else "?"
    return found


def _look(spec: GridSpec, name: str) -> str:
    colours = {c.name: c.color for c in spec.characters}
    return (colours | {n: t.color for t in spec.things for n in t.names})[name]


def _colour(value: str) -> str:
    """A colour of the world as a code of ANSI terminals."""
    red, green, blue = (int(value[i : i + 2], 16) for i in (1, 3, 5))
    return f"38;2;{red};{green};{blue}"
