"""The syntax of a .world file: its map, and its blocks of NAME = VALUE lines, with their places."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

from lark import Lark, Token, Tree

from i2pdsl.errors import (
    MOST_SHOWN,
    Diagnostic,
    Note,
    Source,
    Span,
    StoryError,
    closest,
    did_you_mean,
    shorten,
)
from i2pdsl.language.format import format_statements
from i2pdsl.language.mistakes import explain
from i2pdsl.language.statements import Piece, check_text, split_statements
from i2pdsl.language.tables import Tables, UnexpectedError
from i2pdsl.resources import data_folder

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
MAP = frozenset(("map",))  # its lines are drawn, not written
NAMED = ("tile", "object", "character", "event")


@cache
def grammar() -> Lark:
    text = (data_folder("grammar") / "world.lark").read_text(encoding="utf-8")
    return Lark(
        text, parser="lalr", lexer="contextual", start="statement", propagate_positions=True
    )


@cache
def tables() -> Tables:
    """The same grammar, for a faster driver."""
    return Tables(grammar())


def block_tree(piece: Piece, mistakes: int = 0) -> Tree[Token]:
    """Lark's tree of a block; after many mistakes it explains none. Raises StoryError."""
    source, span = piece.span.source, piece.span
    try:
        return tables().parse(source.text, span.start, span.end, "statement")
    except UnexpectedError as problem:
        if mistakes > MOST_SHOWN:
            place = Span(source, problem.start, min(problem.start + 1, span.end))
            raise StoryError([Diagnostic("syntax", "this cannot be read", place)]) from None
        raise StoryError([explain(problem, source, span)]) from None


def format_world(source: Source) -> str:
    """The text of a .world file in the usual layout; the map stays as it is drawn.

    Raises StoryError if it has syntax errors.
    """
    check_text(source)
    cut = split_statements(source, KEYWORDS, drawn=MAP)
    return format_statements(source, cut, block_tree, drawn=MAP)


@dataclass(frozen=True)
class Value:
    """A value as written: a number, a name or text (str), a pair, or a tuple of values."""

    span: Span
    value: Any
    kind: str  # number | name | text | pair | list


@dataclass
class Block:
    keyword: str
    name: str
    span: Span  # of the name, or of the keyword where there is none
    entries: dict[str, Value]
    keys: dict[str, Span]


class BlockReader:
    """Collects the blocks of a file, and gives typed access to their entries.

    `incomplete` is whether a block could not be read: what seems to be missing may stand there.
    """

    def __init__(self, source: Source):
        self.source = source
        self.problems: list[Diagnostic] = []
        self.blocks: list[Block] = []
        self.rows: list[tuple[str, Span]] | None = None
        self.map_span = Span(source, 0, 0)
        self.incomplete = False
        self.reported_lines: set[int] = set()

    def read(self) -> None:
        """Reads the whole text."""
        pieces, unread, problems = split_statements(self.source, KEYWORDS, drawn=MAP)
        self.problems.extend(problems)
        self.incomplete = bool(unread)
        for piece in pieces:
            self.statement(piece)

    def problem(
        self, code: str, message: str, span: Span, hint: str | None = None, note: Note | None = None
    ) -> None:
        notes = (note,) if note else ()
        self.problems.append(Diagnostic(code, message, span, hint, notes))

    # Syntax.

    def statement(self, piece: Piece) -> None:
        if piece.keyword not in KEYWORDS:
            self.incomplete = True
            if not piece.keyword and self.rows == []:
                return  # a row in the first column: the empty map was reported
            start = piece.span.start
            span = Span(self.source, start, start + max(1, len(piece.keyword)))
            shown = shorten(piece.keyword) or piece.span.text[:1]
            close = closest(piece.keyword, KEYWORDS)
            hint = f"did you mean `{close}`?" if close else "blocks: " + ", ".join(KEYWORDS)
            self.problem("world-block", f"`{shown}` begins no block of a world", span, hint)
            return
        try:
            tree = block_tree(piece, len(self.problems))
        except StoryError as problem:
            self.problems.extend(problem.diagnostics)
            self.incomplete = True
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
        self.rows = []
        line = self.source.position(span.start)[0]
        for token in tree.children[1:]:
            assert isinstance(token, Token)
            place = self.token_span(token)
            before, line = line, self.source.position(place.start)[0]
            if before != line:
                self.rows.append((str(token), place))
            elif self.rows or before == self.source.position(span.start)[0]:
                self.misplaced_row(place)
        if not self.rows and not tree.children[1:]:
            hint = "draw it in indented lines below `map`"
            self.problem("world-map", "the map has no rows", span, hint)

    def misplaced_row(self, place: Span) -> None:
        """Reports the first thing that stands on a line behind a row, or behind `map`."""
        line = self.source.position(place.start)[0]
        if not self.reported_lines:
            self.reported_lines = {self.source.position(d.span.start)[0] for d in self.problems}
        if line not in self.reported_lines:
            self.reported_lines.add(line)
            hint = "every row has its line, without spaces and without a comment (`#` is a wall)"
            self.problem("world-map", "no row of the map can begin here", place, hint)

    def read_block(self, tree: Tree[Token]) -> None:
        kind: Any = tree.children[0]
        token = kind.children[0]
        name: Any = tree.children[1]
        block = Block(str(token), str(name or ""), self.token_span(name or token), {}, {})
        named = block.keyword in NAMED
        if named and not name:
            hint = f"write `{token} NAME`"
            message = f"every {token} needs a name"
            self.problem("world-block", message, self.token_span(token), hint)
            self.incomplete = True
            return
        if name and not named:
            self.problem("world-block", f"`{token}` takes no name", block.span, "remove the name")
        for entry in tree.children[2:]:
            parts: Any = entry.children  # type: ignore[union-attr]
            key = str(parts[0])
            if key in block.entries:
                note = Note("the first one", block.keys[key])
                span = self.token_span(parts[0])
                self.problem("duplicate", f"`{key}` is given twice", span, note=note)
                continue
            block.entries[key] = self.value(parts[2])
            block.keys[key] = self.token_span(parts[0])
        self.blocks.append(block)

    def token_span(self, token: Token) -> Span:
        assert token.start_pos is not None
        assert token.end_pos is not None
        return Span(self.source, token.start_pos, token.end_pos)

    def value(self, tree: Any) -> Value:
        span = Span(self.source, tree.meta.start_pos, tree.meta.end_pos)
        parts = tree.children
        match str(tree.data):
            case "number":
                return Value(span, float(parts[0]), "number")
            case "negative":
                return Value(span, -float(parts[1]), "number")
            case "name":
                return Value(span, str(parts[0]), "name")
            case "string":
                return Value(span, str(parts[0])[1:-1], "text")
            case "pair":
                return Value(span, (self.value(parts[1]), self.value(parts[3])), "pair")
            case _:
                items = [self.value(p) for p in parts if isinstance(p, Tree)]
                return Value(span, items, "list")

    # Typed access to the entries of a block; a wrong one is reported and gives the default.

    def known_keys(self, block: Block, known: tuple[str, ...]) -> None:
        for key, span in block.keys.items():
            if key not in known:
                close = closest(key, known)
                hint = f"did you mean `{close}`?" if close else "known: " + ", ".join(known)
                self.problem("world-key", f"`{block.keyword}` has no `{key}`", span, hint)

    def number(
        self, block: Block, key: str, default: float, valid: Callable[[float], bool], range_: str
    ) -> float:
        value = block.entries.get(key)
        if value is None:
            return default
        if value.kind != "number":
            message = f"`{key}` must be a number, not `{shorten(value.span.text)}`"
            self.problem("world-value", message, value.span)
            return default
        if not valid(value.value):
            message = f"`{key}` must be {range_}, not {value.span.text}"
            self.problem("world-range", message, value.span)
            return default
        return float(value.value)

    def word(self, block: Block, key: str, default: str, allowed: tuple[str, ...] = ()) -> str:
        value = block.entries.get(key)
        if value is None:
            return default
        if value.kind not in ("name", "text"):
            message = f"`{key}` must be a word, not `{shorten(value.span.text)}`"
            hint = "one of " + ", ".join(allowed) if allowed else None
            self.problem("world-value", message, value.span, hint)
            return default
        if allowed and value.value not in allowed:
            close = closest(value.value, allowed)
            hint = f"did you mean `{close}`?" if close else "one of " + ", ".join(allowed)
            message = f"`{key}` cannot be `{shorten(value.value)}`"
            self.problem("world-value", message, value.span, hint)
            return default
        return str(value.value)

    def words(self, block: Block, key: str, allowed: tuple[str, ...], what: str) -> tuple[str, ...]:
        value = block.entries.get(key)
        if value is None:
            return ()
        items = value.value if value.kind == "list" else [value]
        found: dict[str, None] = {}
        possible = set(allowed)
        for item in items:
            if item.kind not in ("name", "text"):
                self.problem("world-value", f"`{key}` must name a {what}", item.span)
            elif item.value not in possible:
                if not self.incomplete:
                    few = len(self.problems) <= MOST_SHOWN
                    hint = did_you_mean(item.value, possible) if few else None
                    message = f"there is no {what} `{shorten(item.value)}`"
                    self.problem("world-name", message, item.span, hint)
            elif item.value not in found:
                found[item.value] = None
        return tuple(found)

    def color(self, block: Block, key: str, default: str) -> str:
        value = block.entries.get(key)
        if value is None:
            return default
        if value.kind != "text" or not re.fullmatch(r"#[0-9a-fA-F]{6}", value.value):
            hint = 'write it as "#rrggbb"'
            self.problem("world-value", f"`{key}` must be a colour", value.span, hint)
            return default
        return str(value.value).lower()
