"""Worlds by hand: maps that are painted, and the blocks of a world's file, as changes of its text.

What a kind of world draws, it says itself (`Kind.map_of`); its blocks and their settings are those
of its syntax.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from i2pdsl.errors import Source, Span
from i2pdsl.render.pictures import drawing_for
from i2pdsl.studio.fields import fields
from i2pdsl.studio.protocol import REFUSED, USAGE, Refusal
from i2pdsl.worlds.drawings import beside
from i2pdsl.worlds.find import vocabulary_of
from i2pdsl.worlds.kind import DrawnMap, Kind, Spec
from i2pdsl.worlds.kinds import kind_of_file, parse_world

LARGEST = 64  # cells of a side that can be painted
_NAME = re.compile(r"[^\W\d]\w*")
_INDENT = "    "
_ENTITIES = ("character", "object")


def read(text: str, path: str, folder: Path) -> Spec:
    """A world from its text; its sprites lie in the folder. Raises StoryError."""
    return parse_world(Source(path, text), Path(path).stem, beside(folder))


def world_as_json(spec: Spec, text: str, path: str) -> dict[str, Any]:
    """What the page is told of a world."""
    source = Source(path, text)
    kind, words, drawing = kind_of_file(source), vocabulary_of(spec), drawing_for(spec)
    drawn, blocks = kind.map_of(source), _blocks(kind, source)
    return {
        "name": spec.name,
        "kind": spec.kind,
        "about": spec.documentation,
        "can": {"paint": drawn is not None, "blocks": list(kind.syntax.named)},
        "map": drawn and _map_as_json(drawn, blocks),
        "entities": [
            {
                "name": each["name"],
                "what": each["what"],
                "color": _plain(each["settings"].get("color")),
                "sprite": _plain(each["settings"].get("sprite")),
                "at": _plain(each["settings"].get("at") or each["settings"].get("cell")),
            }
            for each in blocks
            if each["what"] in _ENTITIES
        ],
        "places": list(words.places),
        "blocks": blocks,
        "fields": fields(kind.syntax, words, blocks),
        "units": drawing.units(spec),
        "stage": drawing.empty_stage(spec),
        "spots": [
            {"place": spot.place, "at": spot.at, "shape": spot.shape}
            for spot in drawing.spots(spec)
        ],
    }


def _map_as_json(drawn: DrawnMap, blocks: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    colors = {each["name"]: _plain(each["settings"].get("color")) for each in blocks}
    return {
        "rows": list(drawn.rows),
        "walls": [list(map(list, side)) for side in drawn.walls],
        "tiles": [
            {"name": name, "symbol": symbol, "color": colors.get(name)}
            for symbol, name in drawn.symbols.items()
        ],
        "wall": drawn.wall,
        "free": drawn.floor,
    }


def _plain(value: str | None) -> str | None:
    """A setting's text without its quotes."""
    return None if value is None else value.strip('"')


def _blocks(kind: Kind, source: Source) -> list[dict[str, Any]]:
    """The blocks of a file as they are written: keyword, name, and settings as texts."""
    found = []
    for piece in kind.syntax.cut(source).pieces:
        if piece.keyword in kind.syntax.keys:
            head, *lines = piece.span.text.split("\n")
            settings = (line.partition("=") for line in lines if "=" in line)
            found.append(
                {
                    "what": piece.keyword,
                    "name": _name_of(head),
                    "settings": {k.strip(): v.strip() for k, _, v in settings},
                }
            )
    return found


def _name_of(head: str) -> str:
    words = head.split("#")[0].split()
    return words[1] if len(words) > 1 else ""


# Maps.


def painted(text: str, path: str, cells: Sequence[Sequence[int]], symbol: str) -> str:
    """The text with some cells of its map otherwise."""
    source, kind, drawn = _drawn(text, path)
    if symbol not in (drawn.floor, drawn.wall, *drawn.symbols):
        raise Refusal(USAGE, f"`{symbol[:8]}` is no sign of this map")
    rows = [list(row) for row in drawn.rows]
    for cell in cells:
        if len(cell) != 2 or not (0 <= cell[1] < len(rows) and 0 <= cell[0] < len(rows[0])):
            raise Refusal(USAGE, f"{tuple(cell)[:2]} is no cell of this map")
        rows[cell[1]][cell[0]] = symbol
    return kind.with_map(source, replace(drawn, rows=tuple(map("".join, rows))))


def walled(text: str, path: str, sides: Sequence[Sequence[Sequence[int]]], wall: bool) -> str:
    """The text with walls between cells, or without them."""
    source, kind, drawn = _drawn(text, path)
    walls = dict.fromkeys(drawn.walls)
    for side in sides:
        if len(side) != 2 or any(len(cell) != 2 for cell in side):
            raise Refusal(USAGE, "a side is a pair of cells")
        (a, b), (c, d) = sorted(tuple(cell) for cell in side)
        if (c - a, d - b) not in ((1, 0), (0, 1)) or min(a, b) < 0:
            raise Refusal(USAGE, "a side is between two neighbouring cells")
        if wall:
            walls[(a, b), (c, d)] = None
        else:
            walls.pop(((a, b), (c, d)), None)
    return kind.with_map(source, replace(drawn, walls=tuple(walls)))


def sized(text: str, path: str, columns: int, rows: int) -> str:
    """The text with a larger or smaller map: at the right and below."""
    if not (1 <= columns <= LARGEST and 1 <= rows <= LARGEST):
        raise Refusal(USAGE, f"a map has 1 to {LARGEST} columns and rows")
    source, kind, drawn = _drawn(text, path)
    old = [row[:columns].ljust(columns, drawn.floor) for row in drawn.rows[:rows]]
    more = [drawn.floor * columns] * (rows - len(old))
    return kind.with_map(source, replace(drawn, rows=(*old, *more)))


def _drawn(text: str, path: str) -> tuple[Source, Kind, DrawnMap]:
    source = Source(path, text)
    kind = kind_of_file(source)
    drawn = kind.map_of(source)
    if drawn is None:
        raise Refusal(REFUSED, "this world has no map that can be painted")
    return source, kind, drawn


# Blocks.


def with_block(
    text: str,
    path: str,
    what: str,
    name: str,
    settings: Mapping[str, str] | None,
    another: bool = False,
) -> str:
    """The text with a block, with some of its settings otherwise (an empty one goes), or without
    it (None); with `another`, one more of its kind."""
    source = Source(path, text)
    syntax = kind_of_file(source).syntax
    if what not in syntax.keys:
        raise Refusal(USAGE, f"this kind of world has no `{what[:40]}`")
    if what in syntax.named and not _NAME.fullmatch(name):
        raise Refusal(USAGE, f"`{name[:40]}` is no name")
    for key, value in (settings or {}).items():
        if key not in syntax.keys[what] or "\n" in value:
            raise Refusal(USAGE, f"`{what}` has no `{key[:40]}`")
    for piece in syntax.cut(source).pieces:
        here = piece.keyword == what and (
            what not in syntax.named or _name_of(piece.span.text.split("\n")[0]) == name
        )
        if another:
            break
        if here and settings is None:
            return _without(text, piece.span)
        if here and settings is not None:
            new = _with_settings(piece.span.text, settings)
            return f"{text[: piece.span.start]}{new}{text[piece.span.end :]}"
    if settings is None:
        raise Refusal(USAGE, f"there is no `{what} {name}`")
    head = f"{what} {name}" if what in syntax.named else what
    lines = [head, *(f"{_INDENT}{key} = {value}" for key, value in settings.items() if value)]
    return f"{text.rstrip()}\n\n" + "\n".join(lines) + "\n"


def _without(text: str, span: Span) -> str:
    """Without a statement, and the blank lines behind it."""
    rest = text[span.end :].lstrip("\n")
    return f"{text[: span.start]}{rest}" if rest else f"{text[: span.start].rstrip()}\n"


def _with_settings(block: str, settings: Mapping[str, str]) -> str:
    for key, value in settings.items():
        value_of = rf"^[ \t]+{re.escape(key)}[ \t]*=(?:\"[^\"\n]*\"|[^#\"\n])*?([ \t]*#.*)?$"
        line = re.compile(value_of, re.MULTILINE)
        told, found = f"{_INDENT}{key} = {value}", line.search(block)
        if not value:
            if found is not None:
                before = block[: found.start()].rstrip("\n")
                block = f"{before}{block[found.end() :]}"
        elif found is None:
            block = f"{block.rstrip()}\n{told}"
        else:
            block = f"{block[: found.start()]}{told}{found[1] or ''}{block[found.end() :]}"
    return block
