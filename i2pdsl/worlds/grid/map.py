"""The map of a grid world's file: rows that are drawn, and the symbols of tiles."""

from __future__ import annotations

import re

from lark import Token, Tree

from i2pdsl.errors import Diagnostic, Note, Source, Span, StoryError
from i2pdsl.language.naming import same_name
from i2pdsl.language.statements import Piece, check_text
from i2pdsl.worlds.blocks import BlockReader, Syntax
from i2pdsl.worlds.grid.spec import FLOOR, WALL
from i2pdsl.worlds.grid.words import KEYS, NAMED, hint_elsewhere

_SYMBOL = re.compile(r'\bsymbol[ \t]*=[ \t]*"?(\S)')
# What stands behind `symbol =` without the quotes that it needs.
_BARE_SIGN = re.compile(
    r'^([^#"\n]*\bsymbol[ \t]*=[ \t]*)([^\w\s"]|[^\w\s"({[]\S*)(?=[ \t]*(?:#.*)?$)', re.MULTILINE
)
_COMMENT = re.compile(r"\s(#+\s*[^\W\d_]{3}.*)$")  # behind a row, where `#` may be a wall too


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


class _GridSyntax(Syntax):
    def formatted(self, source: Source) -> str:
        check_text(source)
        unquoted = with_quoted_signs(source)[1]
        if unquoted:
            raise StoryError(unquoted)
        return super().formatted(source)


SYNTAX = _GridSyntax("world.lark", KEYS, NAMED, frozenset(("map",)), hint_elsewhere)


class MapReader(BlockReader):
    """Collects the blocks of a file, and the rows of its map.

    Attributes:
        spaced: whether the map has spaces for floor.
    """

    def __init__(self, source: Source):
        super().__init__(source, SYNTAX)
        self.rows: list[tuple[str, Span]] | None = None
        self.map_span = Span(source, 0, 0)
        self.spaced = False
        self.reported_lines: set[int] = set()

    def read(self) -> None:
        self.readable, unquoted = with_quoted_signs(self.source)
        self.problems.extend(unquoted)
        super().read()

    def lost_symbols(self) -> set[str]:
        """The symbols of tiles that could not be read."""
        return {sign for text in self.lost for sign in _SYMBOL.findall(text)}

    def is_known(self, piece: Piece) -> bool:
        # A row in the first column: the empty map was reported.
        return not piece.keyword and self.rows == []

    def read_drawn(self, piece: Piece, tree: Tree[Token]) -> None:
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
