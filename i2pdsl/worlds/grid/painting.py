"""The map of a grid world's file, taken out of its text and put back otherwise."""

from __future__ import annotations

from collections.abc import Sequence

from i2pdsl.errors import Source
from i2pdsl.worlds.grid.map import MapReader
from i2pdsl.worlds.grid.spec import FLOOR, WALL
from i2pdsl.worlds.kind import DrawnMap, Side

_INDENT = "    "


def read_map(source: Source) -> DrawnMap | None:
    """The map of a text, None where it has none whose rows are equally long."""
    reader = MapReader(source)
    reader.read()
    rows = tuple(row for row, _ in reader.rows or ())
    if not rows or len({len(row) for row in rows}) > 1:
        return None
    symbols = {
        str(block.entries["symbol"].value): block.name
        for block in reader.blocks
        if block.keyword == "tile" and "symbol" in block.entries
    }
    return DrawnMap(rows, tuple(reader.walls), symbols, FLOOR, WALL)


def with_map(source: Source, drawn: DrawnMap) -> str:
    """The text with another map."""
    reader = MapReader(source)
    reader.read()
    first = source.position(reader.map_span.start)[0]
    last = first
    while last < len(source.line_starts) and source.line(last + 1)[:1].isspace():
        last += 1
    while last > first and not source.line(last).strip():
        last -= 1
    lines = source.text.split("\n")
    new = [f"{_INDENT}{line}" for line in _lines(drawn.rows, drawn.walls)]
    return "\n".join([*lines[:first], *new, *lines[last:]])


def _lines(rows: Sequence[str], walls: Sequence[Side]) -> list[str]:
    """A map as files draw it: with room between its cells where there are walls (map.cut_edged)."""
    inside = [
        side for side in walls if all(0 <= c < len(rows[0]) and 0 <= r < len(rows) for c, r in side)
    ]
    if not inside:
        return list(rows)
    east = {one for one, other in inside if one[1] == other[1]}
    south = {one for one, other in inside if one[0] == other[0]}
    found = []
    for number, row in enumerate(rows):
        between = ["|" if (c, number) in east else " " for c in range(len(row))]
        found.append("".join(map("".join, zip(row, between, strict=True)))[:-1])
        below = ["-" if (c, number) in south else " " for c in range(len(row))]
        if "-" in below:
            found.append(" ".join(below).rstrip())
    return found
