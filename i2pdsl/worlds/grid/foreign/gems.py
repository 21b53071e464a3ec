"""Maps of doors, keys and gems (Zhi-Xuan et al. 2020, arXiv:2006.07532) as their problems draw
them, alone or in the comment of a PDDL file: W wall, . floor, s or h who acts, g and G gems, k a
key and D a door; or keys r b y e p and doors R B Y E P of colours, and m a second one who acts."""

from __future__ import annotations

from i2pdsl.errors import Source, Span, error
from i2pdsl.worlds.grid.foreign.level import (
    Level,
    Part,
    Row,
    check_size,
    color_line,
    keys_and_doors,
    numbered,
    rows_of,
    unknown,
)
from i2pdsl.worlds.grid.spec import FLOOR, NO_GOAL, WALL, Cell

WHAT = "a map of doors, keys and gems"
_COLORS = {"r": "red", "b": "blue", "y": "yellow", "e": "green", "p": "pink"}
_KEYS = {"k": "", **_COLORS}
_DOORS = {"D": "", **{sign.upper(): color for sign, color in _COLORS.items()}}
_WHO = {"s": ("human", "child"), "h": ("human", "child"), "m": ("robot", "robot")}
_KNOWN = {"W", ".", "g", "G", *_KEYS, *_DOORS, *_WHO}
_HINT = (
    "W is a wall, . floor, s (or h, m) who acts, g a gem, k a key and D a door; r b y e p are keys "
    "of colours and R B Y E P their doors"
)
_TINTS = ("red", "yellow", "blue", "green", "purple", "pink")


def _drawn(source: Source) -> list[Row]:
    """The first lines without spaces that are equally long, if they stand in comments too."""
    found: list[Row] = []
    for row in rows_of(source, ";"):
        text = row.text.strip()
        fits = bool(text) and " " not in text and not set(text) & set("();:")
        if fits and (not found or len(text) == len(found[0].text)):
            found.append(Row(text, row.start + row.text.index(text)))
        elif len(found) > 1:
            break
        else:
            found = []
    return found


def recognises(source: Source) -> bool:
    signs = "".join(row.text for row in _drawn(source))
    known = sum(sign in _KNOWN for sign in signs)
    return bool(set(signs) & {*_WHO}) and known > 0.8 * len(signs)


def read(source: Source, number: int) -> Level:
    """The map. Raises StoryError."""
    rows = _drawn(source)
    check_size(source, rows)
    at: dict[str, list[Cell]] = {sign: [] for sign in _KNOWN}
    for r, row in enumerate(rows):
        for c, sign in enumerate(row.text):
            if sign not in _KNOWN:
                raise unknown(source, row.start + c, 1, _HINT)
            at[sign].append((c, r))
    for who, count in (("human", len(at["s"] + at["h"])), ("robot", len(at["m"]))):
        if count > 1:
            message = f"there are {count} of `{who}` on this map"
            raise error("world-map", message, Span(source, rows[0].start, rows[0].start + 1), _HINT)
    of = lambda kinds: [(color, cell) for sign, color in kinds.items() for cell in at[sign]]
    keys, doors, shut = keys_and_doors(of(_KEYS), of(_DOORS))
    closed = {*at["W"], *shut}
    walls = tuple(
        "".join(WALL if (c, r) in closed else FLOOR for c in range(len(row.text)))
        for r, row in enumerate(rows)
    )
    cells = sorted(at["g"] + at["G"], key=lambda cell: (cell[1], cell[0]))
    tint = lambda i: (color_line(_TINTS[i % len(_TINTS)]),)
    named = enumerate(zip(numbered(["gem"] * len(cells)), cells, strict=True))
    gems = [Part("tile", name, (cell,), (), tint(i)) for i, (name, cell) in named]
    wants = ("goals", (*(gem.name for gem in gems), NO_GOAL))
    links = (wants, ("carries", tuple(key.name for key in keys)))
    actors = [
        Part("character", who, tuple(at[sign]), links, (f'sprite = "{look}"',))
        for sign, (who, look) in _WHO.items()
        if at[sign]
    ]
    told = {
        "There a gem is picked up, and that is the end; here whoever wants it wants to be on its "
        "tile, and is paid in every turn there.": gems,
        "A key is taken by stepping on it and not used up: it opens all doors of its colour.": keys,
        f"Doors that no key opens are walls here: {len(shut)}.": shut,
        "The two know nothing of each other; add `toward` and `attitude` to one of them if it "
        "shall care.": len(actors) > 1,
    }
    notes = tuple(note for note, is_so in told.items() if is_so)
    return Level(WHAT, walls, (*gems, *actors, *keys, *doors), notes).without_outside()
