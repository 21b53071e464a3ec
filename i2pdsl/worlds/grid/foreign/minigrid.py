"""Levels of MiniGrid as its environments print them: two letters for each cell, what is there and
its colour, `>>` and the like for who acts (Farama-Foundation/Minigrid, minigrid/minigrid_env.py,
`__str__`)."""

from __future__ import annotations

from i2pdsl.errors import Source, Span, error
from i2pdsl.worlds.grid.foreign.level import (
    Level,
    Part,
    check_size,
    color_line,
    keys_and_doors,
    numbered,
    rows_of,
    unknown,
)
from i2pdsl.worlds.grid.spec import FLOOR, NO_GOAL, WALL, Cell

WHAT = "a level of MiniGrid"
_ACTOR = (">>", "VV", "<<", "^^")
_COLORS = {"R": "red", "G": "green", "B": "blue", "P": "purple", "Y": "yellow"}
_KINDS = "WFDLKABGV"
_THINGS = {"K": "key", "A": "ball", "B": "box"}
_SPRITES = {"way": "door"}  # of an open door, which is a tile
_LAVA = 'color = "#e0762f"'
_HINT = (
    "two signs a cell, as `print(env)` writes them: `WG` a wall, two spaces floor, `>>` who acts, "
    "`GG` a goal, `KY` a yellow key, `LY` a locked door, `DY` one that is not, `__` an open one"
)


def _is_known(pair: str) -> bool:
    is_thing = len(pair) == 2 and pair[0] in _KINDS and pair[1] in _COLORS
    return is_thing or pair in ("  ", "__", *_ACTOR)


def recognises(source: Source) -> bool:
    rows = [row.text for row in rows_of(source) if row.text]
    pairs = [text[i : i + 2] for text in rows for i in range(0, len(text), 2)]
    return "WG" in pairs and sum(map(_is_known, pairs)) > 0.8 * len(pairs)


def read(source: Source, number: int) -> Level:
    """The level. Raises StoryError."""
    rows = rows_of(source)
    while not rows[-1].text:
        rows.pop()
    while not rows[0].text:
        rows.pop(0)
    check_size(source, rows, 2)
    width = max((len(row.text) + 1) // 2 for row in rows)
    found: dict[str, list[tuple[str, Cell]]] = {kind: [] for kind in (*_KINDS, ">")}
    walls = []
    for r, row in enumerate(rows):
        text, drawn = row.text.ljust(2 * width), []
        for c in range(width):
            pair = text[2 * c : 2 * c + 2]
            if not _is_known(pair):
                raise unknown(source, row.start + 2 * c, len(pair.rstrip()), _HINT)
            if pair in _ACTOR:
                found[">"].append(("", (c, r)))
            elif pair not in ("  ", "__"):
                found[pair[0]].append((_COLORS[pair[1]], (c, r)))
            drawn.append(WALL if pair[0] == "W" else FLOOR)
        walls.append("".join(drawn))
    if len(found[">"]) != 1:
        message = f"this map has {len(found['>'])} times who acts (>>, VV, << or ^^), not once"
        raise error("world-map", message, Span(source, rows[0].start, rows[0].start + 2), _HINT)
    return _level(walls, found).without_outside()


def _parts(keyword: str, what: list[tuple[str, str, Cell]]) -> list[Part]:
    names = numbered([kind if kind == "goal" else f"{kind}_{color}" for kind, color, _ in what])
    look = lambda kind: (f'sprite = "{_SPRITES.get(kind, kind)}"',) if kind != "goal" else ()
    return [
        Part(keyword, name, (at,), (), (*look(kind), color_line(color)))
        for name, (kind, color, at) in zip(names, what, strict=True)
    ]


def _level(walls: list[str], found: dict[str, list[tuple[str, Cell]]]) -> Level:
    locked = {color for color, _ in found["L"]}
    openers = [key for key in found["K"] if key[0] in locked]
    keys, doors, shut = keys_and_doors(openers, found["L"])
    for column, row in shut:
        walls[row] = f"{walls[row][:column]}{WALL}{walls[row][column + 1 :]}"
    loose = [
        (what, *one) for kind, what in _THINGS.items() for one in found[kind] if one not in openers
    ]
    goals = _parts("tile", [("goal", *one) for one in found["G"]] or loose)
    things = _parts("object", loose if found["G"] else [])
    ways = _parts("tile", [("way", *one) for one in found["D"]])
    lava = Part("tile", "lava", tuple(at for _, at in found["V"]), (), ("cost = 10", _LAVA))
    wants = ("goals", (*(tile.name for tile in goals), NO_GOAL))
    carries = ("carries", tuple(thing.name for thing in (*keys, *things)))
    start = found[">"][0][1]
    actor = Part("character", "agent", (start,), (wants, carries), ('sprite = "robot"',))
    told = {
        "In MiniGrid who acts turns and then walks; here it goes one cell to any side.": True,
        "It sees everything, and is paid in every turn in which it is on its goal.": True,
        "What it may be told to get is a tile here, and in nobody's way.": loose and not things,
        "Its balls, boxes and other keys are carried, too.": things,
        "It takes what it steps on, and may have several things at once.": carries[1],
        "Lava ends nothing here: whoever stands in it pays 10 in every turn.": lava.cells,
        "A door that is not locked is open here, and a tile.": ways,
        f"Locked doors that no key opens are walls here: {len(shut)}.": shut,
    }
    notes = tuple(note for note, is_so in told.items() if is_so)
    tiles = (*goals, *ways, *((lava,) if lava.cells else ()))
    return Level(WHAT, tuple(walls), (*tiles, actor, *keys, *things, *doors), notes)
