"""Maps of agentmodels.org (Evans, Stuhlmüller, Salvatier and Filan), from its JavaScript or from
JSON: a list of rows, each a list of cells, which are ' ', '#' or {name: 'Donut North'}; variables
stand for cells where the text says what they are. `start: [x, y]` counts from the bottom left
(agentmodels/webppl-agents, src/environments/makeGridWorldMDP.wppl)."""

from __future__ import annotations

import re
from typing import NamedTuple

from i2pdsl.errors import Source, Span, StoryError, error
from i2pdsl.worlds.grid.foreign.level import Level, Part, Row, check_size, name_of
from i2pdsl.worlds.grid.spec import FLOOR, NO_GOAL, WALL, Cell

WHAT = "a map of agentmodels"
_TEXT = r"""'[^'\n]{0,80}'|"[^"\n]{0,80}\""""
_NAMED = rf"""\{{\s{{0,9}}["']?name["']?\s{{0,9}}:\s{{0,9}}({_TEXT})\s{{0,9}},?\s{{0,9}}\}}"""
_NAME = r"[A-Za-z_$][\w$]{0,40}"
_TOKEN = re.compile(rf"\s*(?:({_TEXT})|{_NAMED}|({_NAME})|([\[\],])|(//[^\n]*))")
_DEFINED = re.compile(rf"({_NAME})\s{{0,9}}=\s{{0,9}}(?:({_TEXT})|{_NAMED})")
_BEGIN = re.compile(r"\[(?:\s|//[^\n]*)*\[")
_START = re.compile(r"""\bstart["']?\s{0,9}:\s{0,9}\[\s{0,9}(\d{1,4})\s{0,9},\s{0,9}(\d{1,4})""")
_HINT = "rows of cells: ' ' is floor, '#' a wall, {name: 'Donut'} a restaurant"


class Sign(NamedTuple):
    """A cell as it is written: floor, a wall, or the name of a restaurant."""

    is_wall: bool
    name: str
    at: int


def recognises(source: Source) -> bool:
    return _BEGIN.search(source.text) is not None


def read(source: Source, number: int) -> Level:
    """The map. Raises StoryError."""
    rows = _rows(source)
    check_size(source, [Row(FLOOR * len(row), row[0].at) for row in rows])
    for row in rows:
        if len(row) != len(rows[0]):
            message = f"this row has {len(row)} cells, the first one has {len(rows[0])}"
            raise _wrong(source, row[0].at, 1, message)
    walls = tuple("".join(WALL if cell.is_wall else FLOOR for cell in row) for row in rows)
    at: dict[str, list[Cell]] = {}
    for r, row in enumerate(rows):
        for c, cell in enumerate(row):
            if cell.name:
                at.setdefault(cell.name, []).append((c, r))
    names: dict[str, str] = {}
    for told in at:
        names[told] = name_of(told, names.values())
    tiles = [Part("tile", names[told], tuple(cells)) for told, cells in at.items()]
    start = _start(source, walls)
    wants = ("goals", (*names.values(), NO_GOAL))
    actor = Part("character", "bob", start, (wants,), ('sprite = "child"',))
    notes = [
        "There each restaurant is worth something of its own, once, and ends the walk. Here all "
        "are worth the same, in every turn there, and nothing ends: `goal` in `rewards`.",
        "There a walk has a total time; here that is the `length` of a story, or `horizon`.",
        "What somebody there may not know, whether a place is open, everybody knows here.",
    ]
    if not start:
        notes.append("Where the walk begins, stories say: `start at(bob, (column, row))`.")
    return Level(WHAT, walls, (*tiles, actor), tuple(notes)).without_outside()


def _wrong(source: Source, at: int, length: int, message: str, hint: str = _HINT) -> StoryError:
    return error("world-map", message, Span(source, at, at + length), hint)


def _rows(source: Source) -> list[list[Sign]]:
    """The cells, row by row. Raises StoryError."""
    text = source.text
    defined = {found[1]: found[2] or found[3] for found in _DEFINED.finditer(text)}
    begin = _BEGIN.search(text)
    assert begin is not None
    rows: list[list[Sign]] = []
    place, inside = begin.start() + 1, False
    while True:
        found = _TOKEN.match(text, place)
        if found is None:
            rest = text[place:].lstrip()
            at = len(text) - len(rest) if rest else len(text.rstrip()) - 1
            raise _wrong(source, at, 1, "this is no cell of a map")
        place, at = found.end(), found.start(found.lastindex or 0)
        written, named, variable, sign, comment = found.groups()
        if sign == "]" and not inside:
            break
        if sign == "[" and inside:
            raise _wrong(source, at, 1, "a row begins within a row")
        if sign in ("[", "]"):
            inside = sign == "["
            rows += [[]] if inside else []
        elif sign is None and comment is None:
            if not inside:
                raise _wrong(source, at, 1, "a cell outside a row")
            meant = defined.get(variable) if variable else written
            rows[-1].append(_sign(source, named, meant, variable, at))
    full = [row for row in rows if row]
    if not full:
        raise _wrong(source, begin.start(), 1, "this map has no cells")
    return full


def _sign(
    source: Source, named: str | None, written: str | None, variable: str | None, at: int
) -> Sign:
    """What a cell is. Raises StoryError."""
    if named is not None:
        return Sign(False, named[1:-1], at)
    if written is None and variable is not None and variable.strip("_"):
        hint = f"add `var {variable} = {{name: 'Donut'}}`, or write the cell itself"
        message = f"what `{variable}` is, the file does not say"
        raise _wrong(source, at, len(variable), message, hint)
    inner = (written or "' '")[1:-1]
    if not inner.strip() or inner == WALL:
        return Sign(inner == WALL, "", at)
    if variable is not None:  # one that holds a name
        return Sign(False, inner, at)
    raise _wrong(source, at, len(inner) + 2, "a cell is ' ', '#' or has a name")


def _start(source: Source, walls: tuple[str, ...]) -> tuple[Cell, ...]:
    """Where the walk begins, if that is said. Raises StoryError."""
    found = _START.search(source.text)
    if found is None:
        return ()
    column, row = int(found[1]), len(walls) - 1 - int(found[2])
    if not (0 <= row < len(walls) and column < len(walls[0]) and walls[row][column] == FLOOR):
        message = f"the walk cannot begin at [{found[1]}, {found[2]}]: no floor is there"
        hint = "[x, y] count from 0 at the bottom left"
        raise _wrong(source, found.start(), found.end() - found.start(), message, hint)
    return ((column, row),)
