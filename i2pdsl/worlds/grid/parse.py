"""From a .world file to a GridSpec, with every mistake of the file in one go."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from dataclasses import fields as dataclass_fields
from functools import cache
from pathlib import Path
from typing import Any

from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedInput
from lark.utils import TextSlice

from i2pdsl.errors import Diagnostic, Note, Source, Span, StoryError, did_you_mean
from i2pdsl.language.mistakes import explain
from i2pdsl.language.parse import RESERVED
from i2pdsl.language.statements import Piece, check_text, read_source, split_statements
from i2pdsl.resources import data_folder
from i2pdsl.worlds.grid.spec import (
    ACTIONS,
    NO_GOAL,
    WALL,
    Character,
    GridSpec,
    Settings,
    Thing,
    Tile,
)

KEYWORDS = (
    "map",
    "tile",
    "object",
    "character",
    "event",
    "rewards",
    "planning",
    "audience",
    "drawing",
)
EVENTS = ("deus",)
_FLOOR = "."
_TILE_COLORS = ("#e58aa8", "#6fae75", "#6f9fd8", "#e0a458", "#a98bd0", "#5bb5b0")


@cache
def _grammar() -> Lark:
    text = (data_folder("grammar") / "world.lark").read_text(encoding="utf-8")
    return Lark(
        text, parser="lalr", lexer="contextual", start="statement", propagate_positions=True
    )


@dataclass(frozen=True)
class _Value:
    """A value as written: a number, a name or text (str), a pair, or a tuple of values."""

    span: Span
    value: Any
    kind: str  # number | name | text | pair | list


@dataclass
class _Block:
    keyword: str
    name: str
    span: Span  # of the name, or of the keyword where there is none
    entries: dict[str, _Value]
    keys: dict[str, Span]


def load_world(path: Path | str, name: str | None = None) -> GridSpec:
    """Reads a .world file. Raises StoryError with all its mistakes."""
    return parse_world(read_source(path), name or Path(path).stem)


def parse_world(source: Source, name: str) -> GridSpec:
    """Parses and checks the text of a world. Raises StoryError with all its mistakes."""
    check_text(source)
    reader = _Reader(source)
    pieces, problems = split_statements(source, KEYWORDS, drawn=frozenset(("map",)))
    reader.problems.extend(problems)
    for piece in pieces:
        reader.statement(piece)
    spec = reader.world(name, _header(source))
    if reader.problems or spec is None:
        raise StoryError(sorted(reader.problems, key=lambda d: d.span.start))
    return spec


def _header(source: Source) -> str:
    """The comment block at the top of the file."""
    lines = []
    for line in source.text.splitlines():
        if not line.startswith("#"):
            break
        lines.append(line.lstrip("#").strip())
    return "\n".join(lines)


class _Reader:
    """Collects the blocks of a file and turns them into a GridSpec."""

    def __init__(self, source: Source):
        self.source = source
        self.problems: list[Diagnostic] = []
        self.blocks: list[_Block] = []
        self.rows: list[tuple[str, Span]] | None = None
        self.map_span = Span(source, 0, 0)

    def problem(
        self, code: str, message: str, span: Span, hint: str | None = None, note: Note | None = None
    ) -> None:
        notes = (note,) if note else ()
        self.problems.append(Diagnostic(code, message, span, hint, notes))

    # Syntax.

    def statement(self, piece: Piece) -> None:
        if piece.keyword not in KEYWORDS:
            span = Span(
                self.source, piece.span.start, piece.span.start + max(1, len(piece.keyword))
            )
            shown = piece.keyword or piece.span.text[:1]
            hint = did_you_mean(piece.keyword, KEYWORDS) or "one of " + ", ".join(KEYWORDS)
            self.problem("world-block", f"`{shown}` begins no block of a world", span, hint)
            return
        try:
            span = piece.span
            tree = _grammar().parse(TextSlice(self.source.text, span.start, span.end))
        except UnexpectedInput as problem:
            self.problems.append(explain(problem, self.source, piece.span))
            return
        if tree.data == "map":
            self.read_map(piece, tree)
        else:
            self.read_block(tree)

    def read_map(self, piece: Piece, tree: Tree[Token]) -> None:
        span = Span(self.source, piece.span.start, piece.span.start + 3)
        if self.rows is not None:
            note = Note("the first map", self.map_span)
            self.problem("duplicate", "the world has two maps", span, note=note)
            return
        self.map_span = span
        self.rows = [
            (str(t), self.token_span(t)) for t in tree.children[1:] if isinstance(t, Token)
        ]
        if not self.rows:
            self.problem("world-map", "the map has no rows", span, "draw it in indented lines")

    def read_block(self, tree: Tree[Token]) -> None:
        kind: Any = tree.children[0]
        token = kind.children[0]
        name: Any = tree.children[1]
        block = _Block(str(token), str(name or ""), self.token_span(name or token), {}, {})
        named = block.keyword in ("tile", "object", "character", "event")
        if named and not name:
            self.problem("world-block", f"this {token} needs a name", self.token_span(token))
            return
        if name and not named:
            self.problem("world-block", f"`{token}` has no name", block.span)
        for entry in tree.children[2:]:
            parts: Any = entry.children  # type: ignore[union-attr]
            key = str(parts[0])
            if key in block.entries:
                note = Note("the first", block.keys[key])
                self.problem(
                    "duplicate", f"`{key}` stands here twice", self.token_span(parts[0]), note=note
                )
            block.entries[key] = self.value(parts[2])
            block.keys[key] = self.token_span(parts[0])
        self.blocks.append(block)

    def token_span(self, token: Token) -> Span:
        assert token.start_pos is not None
        assert token.end_pos is not None
        return Span(self.source, token.start_pos, token.end_pos)

    def value(self, tree: Any) -> _Value:
        span = Span(self.source, tree.meta.start_pos, tree.meta.end_pos)
        parts = tree.children
        match str(tree.data):
            case "number":
                return _Value(span, float(parts[0]), "number")
            case "negative":
                return _Value(span, -float(parts[1]), "number")
            case "name":
                return _Value(span, str(parts[0]), "name")
            case "string":
                return _Value(span, str(parts[0])[1:-1], "text")
            case "pair":
                return _Value(span, (self.value(parts[1]), self.value(parts[3])), "pair")
            case _:
                items = [self.value(p) for p in parts if isinstance(p, Tree)]
                return _Value(span, items, "list")

    # Typed access to the entries of a block; a wrong one is reported and gives the default.

    def known_keys(self, block: _Block, known: tuple[str, ...]) -> None:
        for key, span in block.keys.items():
            if key not in known:
                hint = did_you_mean(key, known) or "known: " + ", ".join(known)
                self.problem("world-key", f"`{block.keyword}` has no `{key}`", span, hint)

    def number(
        self, block: _Block, key: str, default: float, valid: Callable[[float], bool], range_: str
    ) -> float:
        value = block.entries.get(key)
        if value is None:
            return default
        if value.kind != "number":
            self.problem("world-value", f"`{key}` must be a number", value.span)
            return default
        if not valid(value.value):
            message = f"`{key}` must be {range_}, not {value.span.text}"
            self.problem("world-range", message, value.span)
            return default
        return float(value.value)

    def word(self, block: _Block, key: str, default: str, allowed: tuple[str, ...] = ()) -> str:
        value = block.entries.get(key)
        if value is None:
            return default
        if value.kind not in ("name", "text"):
            self.problem("world-value", f"`{key}` must be a word", value.span)
            return default
        if allowed and value.value not in allowed:
            hint = did_you_mean(value.value, allowed) or "one of " + ", ".join(allowed)
            self.problem("world-value", f"`{key}` cannot be `{value.value}`", value.span, hint)
            return default
        return str(value.value)

    def words(
        self, block: _Block, key: str, allowed: tuple[str, ...], what: str
    ) -> tuple[str, ...]:
        value = block.entries.get(key)
        if value is None:
            return ()
        items = value.value if value.kind == "list" else [value]
        found: list[str] = []
        for item in items:
            if item.kind not in ("name", "text"):
                self.problem("world-value", f"`{key}` must name a {what}", item.span)
            elif item.value not in allowed:
                hint = did_you_mean(item.value, allowed)
                self.problem("world-name", f"there is no {what} `{item.value}`", item.span, hint)
            elif item.value not in found:
                found.append(item.value)
        return tuple(found)

    def color(self, block: _Block, key: str, default: str) -> str:
        value = block.entries.get(key)
        if value is None:
            return default
        if value.kind != "text" or not re.fullmatch(r"#[0-9a-fA-F]{6}", value.value):
            hint = 'write it as "#rrggbb"'
            self.problem("world-value", f"`{key}` must be a colour", value.span, hint)
            return default
        return str(value.value).lower()

    # The world.

    def world(self, name: str, documentation: str) -> GridSpec | None:
        of = lambda keyword: [b for b in self.blocks if b.keyword == keyword]
        whole = Span(self.source, 0, 0)
        if not self.source.text.strip():
            self.problem("empty", "the file is empty", whole, "a world needs a map and a character")
            return None
        if self.rows is None:
            self.problem("world-map", "the world has no map", whole, "draw one below `map`")
        self.unique_names()
        rows = self.checked_rows()
        tiles = self.tiles(of("tile"), rows)
        things = tuple(self.thing(b) for b in of("object"))
        thing_names = tuple(t.name for t in things)
        characters = self.characters(of("character"), tiles, thing_names, whole)
        events = self.events(of("event"), things)
        settings = self.settings(of)
        floor, wall = "#f1e8d8", "#7d6b5d"
        for block in of("drawing"):
            self.known_keys(block, ("floor", "wall"))
            floor, wall = self.color(block, "floor", floor), self.color(block, "wall", wall)
        characters = self.ordered(of("planning"), characters)
        spec = GridSpec(
            name,
            tuple(rows),
            tiles,
            characters,
            things,
            events,
            settings,
            floor,
            wall,
            documentation,
            self.source.text,
        )
        needed = len(characters) + sum(not t.may_be_absent for t in things)
        if rows and not self.problems and len(spec.free_cells) < needed:
            free = len(spec.free_cells)
            message = f"the map has {free or 'no'} free cell{'' if free == 1 else 's'}"
            self.problem(
                "world-map", f"{message} for {needed} characters and objects", self.map_span
            )
        return spec

    def unique_names(self) -> None:
        seen: dict[str, Span] = {}
        for block in self.blocks:
            if block.keyword not in ("tile", "object", "character"):
                continue
            if block.name in seen:
                note = Note("the other one", seen[block.name])
                message = f"two things have the name `{block.name}`"
                self.problem("duplicate", message, block.span, note=note)
            elif block.name in RESERVED or block.name in (*ACTIONS, NO_GOAL, "nothing"):
                message = f"`{block.name}` is a word of the language and cannot be a name"
                self.problem("reserved", message, block.span)
            seen.setdefault(block.name, block.span)

    def checked_rows(self) -> list[str]:
        rows = self.rows or []
        symbols = {_FLOOR, WALL}
        for block in self.blocks:
            if block.keyword == "tile" and "symbol" in block.entries:
                symbols.add(str(block.entries["symbol"].value))
        for row, span in rows:
            if len(row) != len(rows[0][0]):
                message = f"this row has {len(row)} cells, the first has {len(rows[0][0])}"
                self.problem("world-map", message, span, "all rows of a map are equally long")
            for i, symbol in enumerate(row):
                if symbol not in symbols:
                    place = Span(self.source, span.start + i, span.start + i + 1)
                    known = ", ".join(f"`{s}`" for s in sorted(symbols))
                    hint = f"known: {known}; declare it: tile NAME with symbol = {symbol}"
                    self.problem("world-map", f"unknown symbol `{symbol}`", place, hint)
        return [row for row, _ in rows]

    def tiles(self, blocks: list[_Block], rows: list[str]) -> tuple[Tile, ...]:
        tiles: list[Tile] = []
        owner: dict[tuple[int, int], _Block] = {}
        for number, block in enumerate(blocks):
            self.known_keys(block, ("symbol", "cell", "color"))
            color = self.color(block, "color", _TILE_COLORS[number % len(_TILE_COLORS)])
            cells = self.tile_cells(block, rows)
            for cell in cells:
                if cell in owner:
                    note = Note("the other one", owner[cell].span)
                    message = f"`{block.name}` lies on a cell of `{owner[cell].name}`"
                    self.problem("world-tile", message, block.span, note=note)
                owner[cell] = block
            tiles.append(Tile(block.name, cells, color))
        return tuple(tiles)

    def tile_cells(self, block: _Block, rows: list[str]) -> tuple[tuple[int, int], ...]:
        symbol, cell = block.entries.get("symbol"), block.entries.get("cell")
        if (symbol is None) == (cell is None):
            hint = "give `symbol = P`, drawn on the map, or `cell = (column, row)`"
            self.problem("world-tile", f"where does `{block.name}` lie?", block.span, hint)
            return ()
        if symbol is not None:
            mark = str(symbol.value)
            if (
                symbol.kind not in ("name", "text", "number")
                or len(symbol.span.text.strip('"')) != 1
            ):
                self.problem("world-tile", "a symbol is a single character", symbol.span)
                return ()
            if symbol.kind == "number":
                mark = symbol.span.text
            if mark in (WALL, _FLOOR):
                what = "a wall" if mark == WALL else "plain floor"
                self.problem("world-tile", f"`{mark}` means {what}", symbol.span)
                return ()
            found = tuple(
                (c, r) for r, row in enumerate(rows) for c, s in enumerate(row) if s == mark
            )
            if not found and rows:
                self.problem("world-tile", f"`{mark}` does not occur on the map", symbol.span)
            return found
        assert cell is not None
        if cell.kind != "pair" or any(v.kind != "number" for v in cell.value):
            self.problem("world-tile", "a cell is written (column, row)", cell.span)
            return ()
        column, row = (int(v.value) for v in cell.value)
        if not (0 <= row < len(rows) and 0 <= column < len(rows[row])):
            hint = "columns and rows count from 0 at the top left"
            self.problem("world-tile", f"({column}, {row}) is outside the map", cell.span, hint)
            return ()
        if rows[row][column] == WALL:
            self.problem("world-tile", f"the tile `{block.name}` lies on a wall", cell.span)
            return ()
        return ((column, row),)

    def thing(self, block: _Block) -> Thing:
        self.known_keys(block, ("may_be_absent", "sprite", "color"))
        absent = self.word(block, "may_be_absent", "no", ("yes", "no")) == "yes"
        sprite = self.word(block, "sprite", "box")
        return Thing(block.name, absent, sprite, self.color(block, "color", "#b08a5a"))

    def characters(
        self, blocks: list[_Block], tiles: tuple[Tile, ...], things: tuple[str, ...], whole: Span
    ) -> tuple[Character, ...]:
        if not blocks:
            self.problem("world-cast", "the world has no character", whole, "add `character NAME`")
        for block in blocks[2:]:
            self.problem("world-cast", "a world has one or two characters", block.span)
        blocks = blocks[:2]
        names = tuple(b.name for b in blocks)
        tile_names = tuple(t.name for t in tiles)
        found = tuple(self.one_character(b, names, tile_names, things) for b in blocks)
        if len([c for c in found if c.toward]) == 2:
            hint = "the one with an attitude models the other"
            message = "only one character can have an attitude"
            self.problem("world-cast", message, blocks[1].keys["toward"], hint)
        if len([c for c in found if c.toward or c.models]) == 2 and not self.problems:
            message = "two characters cannot model each other"
            self.problem("world-cast", message, blocks[1].span, "remove one of the two")
        return found

    def one_character(
        self,
        block: _Block,
        names: tuple[str, ...],
        tiles: tuple[str, ...],
        things: tuple[str, ...],
    ) -> Character:
        keys = ["success", "goals", "pushes", "toward", "attitude", "models", "sprite", "color"]
        self.known_keys(block, tuple(keys))
        others = tuple(n for n in names if n != block.name)
        success = self.number(
            block, "success", 1.0, lambda p: 0 < p <= 1, "a probability above 0 and up to 1"
        )
        goals = self.words(block, "goals", (*tiles, NO_GOAL), "tile") or (NO_GOAL,)
        pushes = self.words(block, "pushes", (*others, *things), "character or object")
        toward = self.words(block, "toward", others, "other character")
        models = self.words(block, "models", others, "other character")
        attitude = self.attitude(block, bool(toward))
        return Character(
            block.name,
            success,
            goals,
            pushes,
            toward[0] if toward else None,
            attitude,
            toward[0] if toward else models[0] if models else None,
            self.word(block, "sprite", "blob"),
            self.color(block, "color", "#7c9cc0"),
        )

    def attitude(self, block: _Block, has_target: bool) -> tuple[float, ...]:
        value = block.entries.get("attitude")
        if value is None:
            if has_target:
                message = f"`{block.name}` has no attitude toward anyone"
                hint = "give its values: attitude = {-1, 0, 1}"
                self.problem("world-cast", message, block.keys["toward"], hint)
            return ()
        if not has_target:
            hint = "add `toward = NAME` of the other character"
            self.problem("world-cast", "an attitude toward whom?", block.keys["attitude"], hint)
        items = value.value if value.kind == "list" else [value]
        numbers: list[float] = []
        for item in items:
            if item.kind != "number":
                self.problem("world-value", "an attitude is a number", item.span)
            elif item.value not in numbers:
                numbers.append(item.value)
        if not numbers:
            self.problem("world-value", "an attitude needs values", value.span)
        return tuple(numbers)

    def events(
        self, blocks: list[_Block], things: tuple[Thing, ...]
    ) -> tuple[tuple[str, tuple[str, ...]], ...]:
        found = []
        for block in blocks:
            self.known_keys(block, ("drops",))
            if block.name not in EVENTS:
                hint = did_you_mean(block.name, EVENTS)
                self.problem("world-name", f"there is no event `{block.name}`", block.span, hint)
            names = tuple(t.name for t in things)
            drops = self.words(block, "drops", names, "object")
            if not block.entries.get("drops"):
                self.problem("world-block", "what does it drop?", block.span, "drops = {table}")
            for name in drops:
                if not next(t for t in things if t.name == name).may_be_absent:
                    message = f"`{name}` is never absent, so it cannot fall"
                    hint = f"give `{name}` may_be_absent = yes"
                    self.problem("world-cast", message, block.entries["drops"].span, hint)
            found.append((block.name, drops))
        return tuple(found)

    def settings(self, of: Callable[[str], list[_Block]]) -> Settings:
        values: dict[str, Any] = {}
        groups = {
            "rewards": ("goal", "move", "stay"),
            "planning": ("gamma", "beta", "level0", "order"),
            "audience": ("forgetting", "hypotheses"),
        }
        for keyword, keys in groups.items():
            for block in of(keyword):
                self.known_keys(block, keys)
                for key in keys:
                    if key in block.entries and key != "order":
                        default = getattr(Settings(), key)
                        values[key] = self.setting(block, key, default)
        return Settings(**values)

    def setting(self, block: _Block, key: str, default: Any) -> float | str:
        if key in SETTING_WORDS:
            return self.word(block, key, default, SETTING_WORDS[key])
        valid, range_ = SETTING_RANGES[key]
        return self.number(block, key, default, valid, range_)

    def ordered(
        self, blocks: list[_Block], characters: tuple[Character, ...]
    ) -> tuple[Character, ...]:
        for block in blocks:
            if "order" not in block.entries:
                continue
            names = tuple(c.name for c in characters)
            order = self.words(block, "order", names, "character")
            if len(order) == len(characters):
                return tuple(next(c for c in characters if c.name == n) for n in order)
            if not self.problems:
                span = block.entries["order"].span
                self.problem("world-value", "the order must name every character once", span)
        return characters


SETTING_WORDS: dict[str, tuple[str, ...]] = {
    "level0": ("uniform", "costs"),
    "hypotheses": ("merged", "literal"),
}
SETTING_RANGES: dict[str, tuple[Callable[[float], bool], str]] = {
    "goal": (lambda x: abs(x) <= 1e6, "between -1e6 and 1e6"),
    "move": (lambda x: abs(x) <= 1e6, "between -1e6 and 1e6"),
    "stay": (lambda x: abs(x) <= 1e6, "between -1e6 and 1e6"),
    "gamma": (lambda x: 0 <= x < 1, "at least 0 and below 1"),
    "beta": (lambda x: 0 <= x <= 1e3, "between 0 and 1000"),
    "forgetting": (lambda x: 0 <= x <= 0.5, "between 0 and 0.5"),
}
assert set(SETTING_WORDS) | set(SETTING_RANGES) == {f.name for f in dataclass_fields(Settings)}
