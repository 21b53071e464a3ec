"""Levels of Sokoban in the usual letters (XSB): # wall, @ keeper, $ box, . goal, * and + a box and
the keeper on a goal; p, b, P and B are read as @, $, + and *, and -, _ and spaces as floor."""

from __future__ import annotations

from i2pdsl.errors import Source, Span, error
from i2pdsl.worlds.grid.cast import MOST_ALIKE
from i2pdsl.worlds.grid.foreign.level import (
    Level,
    Part,
    Row,
    check_size,
    numbered,
    rows_of,
    unknown,
)
from i2pdsl.worlds.grid.spec import FLOOR, NO_GOAL, WALL

WHAT = "a level of Sokoban"
_ON = {"keeper": "@+pP", "box": "$*bB", "goal": ".*+BP"}
_KNOWN = {WALL, *" -_", *"".join(_ON.values())}
_HINT = "# is a wall, @ who pushes, $ a box, . a goal, * and + a box and who pushes on a goal"


def recognises(source: Source) -> bool:
    signs = "".join(row.text for row in rows_of(source) if _is_row(row))
    known = sum(sign in _KNOWN for sign in signs)
    return any(sign in _ON["keeper"] for sign in signs) and known > 0.8 * len(signs)


def _is_row(row: Row) -> bool:
    """Whether a line is one of a level: all are closed by walls."""
    return row.text.lstrip(" -_").startswith(WALL)


def _levels(source: Source) -> list[list[Row]]:
    """The levels of a file, between which stand titles or nothing."""
    found: list[list[Row]] = [[]]
    for row in rows_of(source):
        if _is_row(row):
            found[-1].append(row)
        elif found[-1]:
            found.append([])
    return [rows for rows in found if rows]


def read(source: Source, number: int) -> Level:
    """The level of a number, from 1. Raises StoryError."""
    every = _levels(source)
    if number > len(every):
        message = f"there are {len(every)} levels in this file, no level {number}"
        raise error("range", message, Span(source, 0, 1), f"--level 1 to --level {len(every)}")
    rows = every[number - 1]
    check_size(source, rows)
    at: dict[str, list[tuple[int, int]]] = {what: [] for what in _ON}
    width = max(len(row.text) for row in rows)
    for r, row in enumerate(rows):
        for c, sign in enumerate(row.text):
            if sign not in _KNOWN:
                raise unknown(source, row.start + c, 1, _HINT)
            for what, signs in _ON.items():
                if sign in signs:
                    at[what].append((c, r))
    whole = Span(source, rows[0].start, rows[0].start + len(rows[0].text))
    if len(at["keeper"]) != 1:
        message = f"this level has {len(at['keeper'])} times who pushes (@), not once"
        raise error("world-map", message, whole, _HINT)
    walls = tuple(
        "".join(WALL if sign == WALL else FLOOR for sign in row.text.ljust(width)) for row in rows
    )
    names = numbered(["goal"] * len(at["goal"]))
    goals = [Part("tile", name, (cell,)) for name, cell in zip(names, at["goal"], strict=True)]
    links = (("goals", (*names, NO_GOAL)), ("pushes", ("box",)))
    keeper = Part("character", "keeper", tuple(at["keeper"]), links, ('sprite = "robot"',))
    boxes = (Part("object", "box", tuple(at["box"])),) * bool(at["box"])
    level = Level(WHAT, walls, (*goals, keeper, *boxes)).without_outside()
    count = sum(len(part.cells) for part in level.named("object"))
    if count > MOST_ALIKE:
        message = f"this level has {count} boxes; at most {MOST_ALIKE} can be alike"
        raise error("too-large", message, whole)
    return Level(WHAT, level.rows, level.parts, _notes(level, count))


def _notes(level: Level, boxes: int) -> tuple[str, ...]:
    told = [
        "In Sokoban boxes shall come to the goals. Here only characters want something, and what "
        "they want is to be on a tile: viewers wonder to which goal the keeper itself is going."
    ]
    goals = level.named("tile")
    if boxes and goals:
        box = "box" if boxes == 1 else "box_1"
        told.append(
            "That a box comes to a goal can be asked of a story: "
            f"`require eventually [at({box}, {goals[0].name})]`."
        )
    return (*told, "Nothing is won: a story is over when its frames are.")
