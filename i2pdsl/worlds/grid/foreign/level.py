"""A map of another tool as plain data, and what its readers share. No JAX."""

from __future__ import annotations

import re
from collections import Counter, deque
from collections.abc import Container, Iterable
from dataclasses import dataclass, replace

from i2pdsl.errors import Source, Span, StoryError, error
from i2pdsl.language.naming import NAME
from i2pdsl.worlds.grid.spec import FLOOR, NO_GOAL, WALL, Cell
from i2pdsl.worlds.grid.words import taken

MOST_CELLS = 10_000  # of a map: more than can be planned for anyway
_SIGNS = re.compile(r"\W+")
COLORS = {
    "red": "#d0564a",
    "blue": "#4a7fc0",
    "green": "#6fae75",
    "yellow": "#e0b34a",
    "purple": "#9a78c8",
    "pink": "#e58aa8",
}


@dataclass(frozen=True)
class Part:
    """A block of the world: a tile, an object or a character.

    Attributes:
        cells: where it lies or stands; none where that is open.
        names: keys whose values are names of other parts.
        lines: its other keys, as they are written.
    """

    keyword: str
    name: str
    cells: tuple[Cell, ...]
    names: tuple[tuple[str, tuple[str, ...]], ...] = ()
    lines: tuple[str, ...] = ()

    def named(self, key: str) -> tuple[str, ...]:
        return dict(self.names).get(key, ())

    def among(self, known: set[str]) -> Part:
        """With those names only that are known."""
        left = ((key, tuple(n for n in names if n in known)) for key, names in self.names)
        return replace(self, names=tuple((key, names) for key, names in left if names))


@dataclass(frozen=True)
class Level:
    """A map with what stands on it.

    Attributes:
        what: of what tool it is, in words.
        rows: FLOOR and WALL only, equally long.
        notes: what is otherwise here, a sentence each.
    """

    what: str
    rows: tuple[str, ...]
    parts: tuple[Part, ...]
    notes: tuple[str, ...] = ()

    def named(self, keyword: str) -> list[Part]:
        return [part for part in self.parts if part.keyword == keyword]

    def steps_from(self, start: Cell, shut: Container[Cell] = ()) -> dict[Cell, int]:
        """How many steps each free cell is from another, through all that stands there but what is
        shut."""
        found, waiting = {start: 0}, deque([start])
        while waiting:
            c, r = waiting.popleft()
            for there in ((c + 1, r), (c - 1, r), (c, r + 1), (c, r - 1)):
                if there not in found and there not in shut and self.is_free(there):
                    found[there] = found[c, r] + 1
                    waiting.append(there)
        return found

    def is_free(self, cell: Cell) -> bool:
        column, row = cell
        inside = 0 <= row < len(self.rows) and 0 <= column < len(self.rows[row])
        return inside and self.rows[row][column] == FLOOR

    def without_outside(self) -> Level:
        """With a wall wherever no character can get to, and without rows and columns of nothing
        else at the edges. What lies there is left out, and a door whose keys do is a wall."""
        starts = [cell for part in self.named("character") for cell in part.cells]
        if not starts:
            return self
        inside = {cell for start in starts for cell in self.steps_from(start)}
        columns, rows = zip(*inside, strict=True)
        left, top = max(min(columns) - 1, 0), max(min(rows) - 1, 0)
        right, bottom = max(columns) + 2, max(rows) + 2
        known = {part.name for part in self.parts if inside & {*part.cells}}
        parts = []
        for part in (part for part in self.parts if part.name in known):
            kept = part.among(known | {NO_GOAL})
            if part.named("opened_by") and not kept.named("opened_by"):
                inside -= {*part.cells}
            else:
                cells = tuple((c - left, r - top) for c, r in part.cells if (c, r) in inside)
                parts.append(replace(kept, cells=cells))
        drawn = tuple(
            "".join(FLOOR if (c, r) in inside else WALL for c in range(left, min(right, len(row))))
            for r, row in list(enumerate(self.rows))[top:bottom]
        )
        return replace(self, rows=drawn, parts=tuple(parts))


@dataclass(frozen=True)
class Row:
    """A line of a map: its text without what is around it, and where that begins in the file."""

    text: str
    start: int


def rows_of(source: Source, comment: str = "") -> list[Row]:
    """The lines of a file, without line ends, spaces behind them, and the sign of a comment with a
    space before what it says."""
    found = []
    for number, start in enumerate(source.line_starts, 1):
        text = source.line(number).rstrip()
        skipped = 0
        while comment and text[skipped:].startswith(comment):
            skipped += len(comment)
        skipped += bool(skipped) and text[skipped : skipped + 1] == " "
        found.append(Row(text[skipped:], start + skipped))
    return found


def check_size(source: Source, rows: list[Row], step: int = 1) -> None:
    """Refuses maps that are too large. Raises StoryError."""
    cells = len(rows) * max((len(row.text) for row in rows), default=0) // step
    if cells > MOST_CELLS:
        message = f"this map has {cells:,} cells; at most {MOST_CELLS:,} are read"
        raise error("too-large", message, Span(source, rows[0].start, rows[0].start + 1))


def unknown(source: Source, at: int, length: int, hint: str) -> StoryError:
    """The mistake that a sign of a map means nothing."""
    sign = source.text[at : at + length]
    message = f"`{sign}` means nothing on such a map"
    return error("world-map", message, Span(source, at, at + length), hint)


def name_of(text: str, others: Iterable[str] = (), usual: str = "place") -> str:
    """A name of a world for any text: `donut_n` of `Donut N`; another one where that is taken."""
    plain = _SIGNS.sub("_", text.lower()).strip("_")[:30]
    if not re.fullmatch(NAME, plain) or not plain.isascii():
        plain = usual
    if taken(plain) is not None:
        plain = f"{plain}_{usual}"
    names, found, number = set(others), plain, 2
    while found in names:
        found, number = f"{plain}_{number}", number + 1
    return found


def numbered(wanted: list[str]) -> list[str]:
    """Names: as they are wanted, and with numbers from 1 where several would be alike."""
    seen, count = Counter[str](), Counter(wanted)
    found: list[str] = []
    for name in wanted:
        seen[name] += 1
        plain = f"{name}_{seen[name]}" if count[name] > 1 else name
        found.append(name_of(plain, found, "one"))
    return found


def color_line(color: str) -> str:
    return f'color = "{COLORS[color]}"'


def keys_and_doors(
    keys: list[tuple[str, Cell]], doors: list[tuple[str, Cell]]
) -> tuple[list[Part], list[Part], list[Cell]]:
    """Keys and doors of colours, each door with the keys that open it; and the cells of those that
    no key opens. No colour, the empty text, is one too."""
    colored = lambda what, color: f"{what}_{color}" if color else what
    look = lambda what, color: (f'sprite = "{what}"', *((color_line(color),) if color else ()))
    names = numbered([colored("key", color) for color, _ in keys])
    made, opening = [], dict[str, tuple[str, ...]]()
    for name, (color, at) in zip(names, keys, strict=True):
        made.append(Part("object", name, (at,), (), look("key", color)))
        opening[color] = (*opening.get(color, ()), name)
    fitting = [(color, at) for color, at in doors if color in opening]
    names = numbered([colored("door", color) for color, _ in fitting])
    found = [
        Part("object", name, (at,), (("opened_by", opening[color]),), look("door", color))
        for name, (color, at) in zip(names, fitting, strict=True)
    ]
    return made, found, [at for color, at in doors if color not in opening]
