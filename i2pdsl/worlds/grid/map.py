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
_EDGED = re.compile(r"[^\s|-](?:[ |][^\s|-])+")  # cells with a space or a wall between each two
_BETWEEN = re.compile(r"[-+| ]*-[-+| ]*")  # walls below the cells of the row above
# Behind a row, or a line of several words, where `#` may be a wall too.
_COMMENT = re.compile(r"(?:\S\s|^\s++(?=\S+\s+\S))\s*(#+\s*[^\W\d_]{3}.*)$")


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
        walls: pairs of cells with a wall between them.
        step: how many characters of a row a cell takes.
    """

    def __init__(self, source: Source):
        super().__init__(source, SYNTAX)
        self.rows: list[tuple[str, Span]] | None = None
        self.map_span = Span(source, 0, 0)
        self.spaced = False
        self.walls: list[tuple[tuple[int, int], tuple[int, int]]] = []
        self.step = 1
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
        if self.cut_edged():
            return
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

    def cut_edged(self) -> bool:
        """Cuts a map with walls between its cells, if it is one; returns whether it is.

        Between each two cells of a row stands one character, a space or `|`. A line between two
        rows has a `-` below each cell that has a wall there.
        """
        assert self.rows is not None
        lines = [place for _, place in self.rows]
        rows = [place for place in lines if not _BETWEEN.fullmatch(place.text)]
        good = [place for place in rows if _EDGED.fullmatch(place.text)]
        if 2 * len(good) <= len(rows) or not any(" " in place.text for place in good):
            return False
        self.step, margin = 2, self.source.position(good[0].start)[1]
        self.rows = []
        dashes: list[tuple[int, Span]] = []  # the row above, and the line
        for place in lines:
            if place not in rows:
                dashes.append((len(self.rows) - 1, place))
                continue
            self.check_edged(place, margin)
            number = len(self.rows)
            cells, marks = place.text[::2], place.text[1::2]
            cells = re.sub(r"[\s|-]", FLOOR, cells)  # where there is none, that is said
            self.rows.append((same_name(cells), place))
            east = [((c, number), (c + 1, number)) for c, mark in enumerate(marks) if mark == "|"]
            self.walls.extend(east)
        for row, place in dashes:
            self.read_dashes(row, place, margin)
        return True

    def check_edged(self, place: Span, margin: int) -> None:
        """Reports the first mistake in a row of cells with something between each two."""
        hint = f"a cell, a space or `|` for a wall, and the next cell: `{FLOOR} {FLOOR}|{FLOOR}`"
        if self.source.position(place.start)[1] != margin:
            self.problem("world-map", "this row does not begin below the others", place, hint)
            return
        for at, sign in enumerate(place.text):
            wrong = sign not in " |" if at % 2 else sign in " |-"
            if wrong or (at % 2 and at + 1 == len(place.text)):
                span = Span(self.source, place.start + at, place.start + at + 1)
                what = "between two cells stands a space or `|`" if at % 2 else "here is no cell"
                self.problem("world-map", what, span, hint)
                return

    def read_dashes(self, row: int, place: Span, margin: int) -> None:
        """Reads the walls below a row; -1 is above the first."""
        assert self.rows is not None
        first = self.source.position(place.start)[1] - margin
        width = len(self.rows[0][0]) if self.rows else 0
        signs = {first + at: sign for at, sign in enumerate(place.text)}
        for at, sign in signs.items():
            if sign != "-":
                continue
            column, aside = divmod(at, 2)
            span = Span(self.source, place.start + at - first, place.start + at - first + 1)
            if aside and "-" in (signs.get(at - 1), signs.get(at + 1)):
                continue  # part of a longer line
            if aside or not 0 <= column < width:
                hint = "a `-` stands right below the cell that has a wall below"
                self.problem("world-map", "this wall is below no cell", span, hint)
            elif not 0 <= row < len(self.rows) - 1:
                hint = "the edge of a map is a wall anyway"
                self.problem("world-map", "a wall between cells has a row on each side", span, hint)
            else:
                self.walls.append(((column, row), (column, row + 1)))

    def misplaced_row(self, place: Span) -> None:
        """Reports the first thing that stands on a line behind a row, or behind `map`."""
        line = self.source.position(place.start)[0]
        if not self.reported_lines:
            self.reported_lines = {self.source.position(d.span.start)[0] for d in self.problems}
        if line not in self.reported_lines:
            self.reported_lines.add(line)
            hint = "every row has its line, without spaces and without a comment (`#` is a wall)"
            self.problem("world-map", "no row of the map can begin here", place, hint)
