"""The syntax of a .world file: its map, and its blocks of NAME = VALUE lines, with their places."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
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
from i2pdsl.language.naming import NAME, same_name, with_marks
from i2pdsl.language.statements import Piece, check_text, split_statements
from i2pdsl.language.tables import Tables, UnexpectedError
from i2pdsl.resources import data_folder
from i2pdsl.worlds.grid.spec import FLOOR, WALL
from i2pdsl.worlds.grid.words import KEYS, NAMED, hint_elsewhere

KEYWORDS = ("map", *KEYS)
MAP = frozenset(("map",))  # its lines are drawn, not written
_WORD = re.compile(NAME)
_SECOND_WORD = re.compile(rf"\S+\s+({NAME})")
_SYMBOL = re.compile(r'\bsymbol[ \t]*=[ \t]*"?(\S)')
# What stands behind `symbol =` without the quotes that it needs.
_BARE_SIGN = re.compile(
    r'^([^#"\n]*\bsymbol[ \t]*=[ \t]*)([^\w\s"]|[^\w\s"({[]\S*)(?=[ \t]*(?:#.*)?$)', re.MULTILINE
)
_COMMENT = re.compile(r"\s(#+\s*[^\W\d_]{3}.*)$")  # behind a row, where `#` may be a wall too


@cache
def grammar() -> Lark:
    text = (data_folder("grammar") / "world.lark").read_text(encoding="utf-8")
    return Lark(
        with_marks(text),
        parser="lalr",
        lexer="contextual",
        start=["statement", "entries"],
        propagate_positions=True,
    )


@cache
def tables() -> Tables:
    """The same grammar, for a faster driver."""
    return Tables(grammar())


def block_tree(piece: Piece, mistakes: int = 0) -> Tree[Token]:
    """Lark's tree of a block; after many mistakes it explains none. Raises StoryError."""
    return _tree(piece.span, "statement", mistakes)


def _tree(span: Span, start: str, mistakes: int) -> Tree[Token]:
    source = span.source
    try:
        return tables().parse(source.text, span.start, span.end, start)
    except UnexpectedError as problem:
        if mistakes > MOST_SHOWN:
            place = Span(source, problem.start, min(problem.start + 1, span.end))
            raise StoryError([Diagnostic("syntax", "this cannot be read", place)]) from None
        raise StoryError([explain(problem, source, span)]) from None


def with_quoted_signs(source: Source) -> tuple[Source, list[Diagnostic]]:
    """The text with a letter for each sign that stands behind `symbol =` without quotes, so that
    the rest can be read, and what is wrong about them."""
    problems = []

    def letters(match: re.Match[str]) -> str:
        sign = match[2]
        if is_mark(sign):
            hint = f'write `symbol = "{sign}"`'
            message = f"`{sign}` needs quotes to be a symbol"
            problems.append(Diagnostic("syntax", message, Span(source, *match.span(2)), hint))
        return match[1] + "x" * len(sign)

    text = _BARE_SIGN.sub(letters, source.text)
    return Source(source.name, text), problems


def is_mark(text: str) -> bool:
    """Whether a text can be the symbol of a tile."""
    return len(text) == 1 and text not in (WALL, FLOOR) and not text.isspace()


def format_world(source: Source) -> str:
    """The text of a .world file in the usual layout; the map stays as it is drawn.

    Raises StoryError if it has syntax errors.
    """
    check_text(source)
    unquoted = with_quoted_signs(source)[1]
    if unquoted:
        raise StoryError(unquoted)
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
    damaged: bool = False  # a line of it could not be read

    def mentioned(self) -> set[Any]:
        """The words in its values."""
        lists = [v.value if v.kind == "list" else [v] for v in self.entries.values()]
        return {v.value for values in lists for v in values if v.kind in ("name", "text")}


class BlockReader:
    """Collects the blocks of a file, and gives typed access to their entries.

    A line that cannot be read spoils neither the rest of its block nor the other blocks.

    Attributes:
        incomplete: whether a block could not be read: what seems to be missing may stand there.
        lost: the texts of such blocks.
        unsure: the kinds of blocks (`tile`, ...) of which one has lost its name.
        spaced: whether the map has spaces for floor.
    """

    def __init__(self, source: Source):
        self.source = source
        self.readable = source  # the same places, and what stands there can be parsed
        self.problems: list[Diagnostic] = []
        self.blocks: list[Block] = []
        self.rows: list[tuple[str, Span]] | None = None
        self.map_span = Span(source, 0, 0)
        self.incomplete = False
        self.lost: list[str] = []
        self.unsure: set[str] = set()
        self.spaced = False
        self.reported_lines: set[int] = set()

    def read(self) -> None:
        """Reads the whole text."""
        self.readable, unquoted = with_quoted_signs(self.source)
        self.problems.extend(unquoted)
        pieces, unread, problems = split_statements(self.readable, KEYWORDS, drawn=MAP)
        self.report(problems)
        for piece in pieces:
            self.statement(piece)
        for span in unread:  # the mistake is known: brackets, quotes, indentation
            word = _WORD.match(span.text)
            if word and word[0] in KEYS:
                self.salvage(span, None)
            else:
                self.lose(span.text, closest(word[0], KEYWORDS) if word else None)

    def report(self, problems: Iterable[Diagnostic]) -> None:
        """Reports mistakes in the readable text at their places in the text as it was written."""
        here = lambda span: Span(self.source, span.start, span.end)
        for d in problems:
            notes = tuple(replace(note, span=here(note.span)) for note in d.notes)
            self.problems.append(replace(d, span=here(d.span), notes=notes))

    def lose(self, text: str, kind: str | None) -> None:
        """Notes a block that could not be read; `kind` is what it would have been."""
        self.incomplete = True
        self.lost.append(text)
        if kind in NAMED and not _SECOND_WORD.match(text):
            self.unsure.add(kind)

    def may_be_lost(self, name: str, kinds: str) -> bool:
        """Whether an unknown name may be that of a block that could not be read."""
        names = {same_name(found[1]) for found in map(_SECOND_WORD.match, self.lost) if found}
        return name in names or any(kind in kinds for kind in self.unsure)

    def lost_symbols(self) -> set[str]:
        """The symbols of tiles that could not be read."""
        return {sign for text in self.lost for sign in _SYMBOL.findall(text)}

    def problem(
        self, code: str, message: str, span: Span, hint: str | None = None, note: Note | None = None
    ) -> None:
        notes = (note,) if note else ()
        self.problems.append(Diagnostic(code, message, span, hint, notes))

    # Syntax.

    def statement(self, piece: Piece) -> None:
        if piece.keyword not in KEYWORDS:
            meant = closest(piece.keyword, KEYWORDS)
            self.lose(self.source.text[piece.span.start : piece.span.end], meant)
            if not piece.keyword and self.rows == []:
                return  # a row in the first column: the empty map was reported
            start = piece.span.start
            span = Span(self.source, start, start + max(1, len(piece.keyword)))
            shown = shorten(piece.keyword) or piece.span.text[:1]
            hint = f"did you mean `{meant}`?" if meant else hint_elsewhere(piece.keyword)
            hint = hint or "blocks: " + ", ".join(KEYWORDS)
            self.problem("world-block", f"`{shown}` begins no block of a world", span, hint)
            return
        try:
            tree = block_tree(piece, len(self.problems))
        except StoryError as problem:
            self.report(problem.diagnostics)
            if piece.keyword in MAP:
                self.incomplete = True
            else:
                place = problem.diagnostics[0].span.start
                self.salvage(piece.span, self.source.position(place)[0])
            return
        if tree.data == "map":
            self.read_map(piece, tree)
        else:
            self.read_block(tree)

    def salvage(self, span: Span, reported: int | None) -> None:
        """Reads what can be read of a block, line by line.

        `reported` is the line of its first mistake; what is wrong on other lines is reported too.
        None where brackets or quotes are wrong: a line may then belong to the one before.
        """
        head = _WORD.match(span.text)
        known = KEYS.get(head[0], ()) if head else ()
        source, first = span.source, self.source.position(span.start)[0]
        last = self.source.position(max(span.start, span.end - 1))[0]
        block: Block | None = None
        entries = []
        damaged = False
        for number in range(first, last + 1):
            begin = max(span.start, source.line_starts[number - 1])
            line = Span(source, begin, min(span.end, begin + len(source.line(number))))
            if not line.text.split("#")[0].strip():
                continue
            try:
                if number == first:
                    block = self.head(_tree(line, "statement", len(self.problems)))
                    if block is None:
                        return
                else:
                    entries += _tree(line, "entries", len(self.problems)).children
            except StoryError as problem:
                damaged = True
                # A line may also be wrong for the one before it, which has no value.
                if reported is None:
                    word = _WORD.match(line.text.strip())
                    is_key = word is not None and word[0] in known
                    if is_key and not set(line.text) & set('(){}[]"'):
                        self.report(problem.diagnostics)
                elif number not in (reported, reported - 1):
                    self.report(problem.diagnostics)
                if number == first:
                    word = _WORD.match(line.text)
                    self.lose(self.source.text[span.start : span.end], word and word[0])
                    return
        if block is not None:
            block.damaged = damaged
            self.fill(block, entries)

    def read_map(self, piece: Piece, tree: Tree[Token]) -> None:
        span = Span(self.source, piece.span.start, piece.span.start + 3)
        if self.rows is not None:
            note = Note("the first map", self.map_span)
            self.problem("duplicate", "the world has two maps", span, note=note)
            return
        self.map_span = span
        self.rows = []
        lines: dict[int, list[Span]] = {}
        for token in tree.children[1:]:
            assert isinstance(token, Token)
            place = self.token_span(token)
            lines.setdefault(self.source.position(place.start)[0], []).append(place)
        beside = lines.pop(self.source.position(span.start)[0], None)
        if beside:
            self.misplaced_row(beside[0])
        for number, places in lines.items():
            row = self.source.line(number)
            comment = _COMMENT.search(row)
            if comment:
                begin = self.source.line_starts[number - 1] + comment.start(1)
                self.misplaced_row(next(p for p in places if p.start >= begin))
                places = [p for p in places if p.start < begin]
            if places:
                self.rows.append((row, places[0].to(places[-1])))
        self.cut_rows()
        if not self.rows and not tree.children[1:]:
            hint = "draw it in indented lines below `map`"
            self.problem("world-map", "the map has no rows", span, hint)

    def cut_rows(self) -> None:
        """Cuts the rows out of their lines. Spaces are no floor, but where they are meant as such
        (levels of games are drawn so), that is one mistake of the whole map."""
        assert self.rows is not None
        columns = {self.source.position(place.start)[1] for _, place in self.rows}
        lengths = {len(place.text) for _, place in self.rows}
        self.spaced = any(len(place.text.split()) > 1 for _, place in self.rows)
        self.spaced |= len(columns) > 1 and len(lengths) > 1
        if not self.spaced:
            self.rows = [(same_name(place.text), place) for _, place in self.rows]
            return
        margin = min(columns) - 1
        drawn = []
        for _, place in self.rows:
            before = self.source.position(place.start)[1] - 1 - margin
            drawn.append(Span(self.source, place.start - before, place.end))
        width = max(len(place.text) for place in drawn)
        floored = lambda text: "".join(FLOOR if sign.isspace() else sign for sign in text)
        self.rows = [(floored(place.text).ljust(width, FLOOR), place) for place in drawn]
        spaces = [place for place in drawn for sign in place.text if sign.isspace()]
        message = f"a space is no cell of a map, and this map has {len(spaces)}"
        hint = f"draw floor as `{FLOOR}`, and what is outside as `{WALL}`: all rows equally long"
        self.problem("world-map", message, spaces[0], hint)

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
        block = self.head(tree)
        if block is not None:
            self.fill(block, tree.children[2:])

    def head(self, tree: Tree[Token]) -> Block | None:
        """A block with its name, yet without its entries; None where the name is missing."""
        kind: Any = tree.children[0]
        token = kind.children[0]
        name: Any = tree.children[1]
        block = Block(
            str(token), same_name(str(name or "")), self.token_span(name or token), {}, {}
        )
        named = block.keyword in NAMED
        if named and not name:
            hint = f"write `{token} NAME`"
            message = f"every {token} needs a name"
            self.problem("world-block", message, self.token_span(token), hint)
            self.lose(str(token), str(token))
            return None
        if name and not named:
            self.problem("world-block", f"`{token}` takes no name", block.span, "remove the name")
        return block

    def fill(self, block: Block, entries: Iterable[Any]) -> None:
        """Puts the entries into a block."""
        for entry in entries:
            parts: Any = entry.children
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
                return Value(span, same_name(str(parts[0])), "name")
            case "string":
                return Value(span, same_name(str(parts[0])[1:-1]), "text")
            case "pair":
                return Value(span, (self.value(parts[1]), self.value(parts[3])), "pair")
            case _:
                items = [self.value(p) for p in parts if isinstance(p, Tree)]
                return Value(span, items, "list")

    # Typed access to the entries of a block; a wrong one is reported and gives the default.

    def known_keys(self, block: Block) -> None:
        """Reports the keys that a block does not have, and where they belong."""
        known = KEYS[block.keyword]
        for key, span in block.keys.items():
            if key not in known:
                close = closest(key, known)
                hint = f"did you mean `{close}`?" if close else hint_elsewhere(key, block.keyword)
                hint = (hint or "known: " + ", ".join(known)).replace("WHO", block.name or "WHO")
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
                if not self.may_be_lost(item.value, what):
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
