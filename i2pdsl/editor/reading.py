"""What stands before the cursor in its statement, read by the real grammar as far as it goes."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace

from lark import Token

from i2pdsl.editor.colours import Piece, colour
from i2pdsl.errors import Source, Span, StoryError
from i2pdsl.language import ast
from i2pdsl.language.build import Builder
from i2pdsl.language.builtins import STATEMENT_WORDS
from i2pdsl.language.forms import EXPECTED
from i2pdsl.language.parse import statement_tree, tables
from i2pdsl.language.statements import (
    DEEPEST,
    LONGEST_FILE,
    room_for_nesting,
    split_statements,
)
from i2pdsl.language.tables import UnexpectedError

_KEYWORD_LINE = re.compile(rf"^(?:{'|'.join(STATEMENT_WORDS)})\b", re.MULTILINE)
_LONGEST = 40_000  # characters of a statement before the cursor that are read
_WIDEST = 10_000  # of a line around it
_LONGEST_BROKEN = 2_000  # of one with mistakes, which is read in many ways
_OPENERS = ("LPAR", "LSQB", "LBRACE", "BIG_OPEN")
_CLOSERS = ("RPAR", "RSQB", "RBRACE")
_TRIED = 12  # brackets around a mistake that are looked into
_SEPARATORS = ("COMMA", "SEMI", "BAR", "DBAR", "AT", "COLON", "RANGE")


@dataclass(frozen=True)
class Reading:
    """What was read before the word at the cursor.

    Attributes:
        start: where that word begins; it ends at the cursor.
        begins: whether a statement may begin with it.
        tokens: of its statement, before it.
        accepts: the terminals that can come next; None where what stands before makes no sense.
    """

    start: int
    begins: bool
    tokens: tuple[Token, ...]
    accepts: frozenset[str] | None


def read_before(text: str, offset: int, start: str, ended: bool = False) -> Reading | None:
    """Reads up to the word at the cursor; None inside a comment, a number or a text in quotes.

    Where the word has `ended`, it is read too.
    """
    if len(text) > LONGEST_FILE:
        return None
    begin = offset
    while begin > 0 and (text[begin - 1].isalnum() or text[begin - 1] == "_"):
        begin -= 1
    last = _last_piece(text, begin, offset)
    if last is not None and last.kind in ("comment", "string"):
        closed = last.kind == "string" and last.end - last.start > 1 and text[last.end - 1] == '"'
        if not closed:
            return None
    if text[begin : begin + 1].isdecimal() and begin < offset:
        if last is None or last.kind != "number":
            return None
        begin = offset
    if ended:
        begin = offset
    begins = start == "file" and (begin == 0 or text[begin - 1] == "\n")
    if start == "file":
        statement = _statement_start(text, begin)
        if statement is None:
            return Reading(begin, begins, (), None)
        word = _KEYWORD_LINE.match(text, statement)
        if word is None:  # a misspelt statement: what follows may be an expression
            statement = min(_after_word(text, statement), begin)
        rule = "statement" if word else "expression"
    else:
        statement, rule = 0, "expression"
    tokens, accepts = _read(text, statement, begin, rule)
    depth = _open_brackets(tokens)
    if (begins and not depth) or depth > DEEPEST:
        return Reading(begin, begins, (), None)
    return Reading(begin, begins, tokens, accepts)


def line_around(text: str, offset: int) -> tuple[int, int]:
    """Where the line of a place begins and ends; of a very long one, what is near the place."""
    start, end = text.rfind("\n", 0, offset) + 1, text.find("\n", offset)
    if offset - start > _WIDEST:
        start = text.rfind(" ", start, offset - _WIDEST // 2) + 1 or offset - _WIDEST // 2
    return start, min(end if end >= 0 else len(text), offset + _WIDEST)


def _last_piece(text: str, begin: int, offset: int) -> Piece | None:
    """The piece of the line that ends at the cursor."""
    line, _ = line_around(text, offset)
    last = None
    for piece in colour(text[line:offset]):
        last = piece
    return last._replace(start=last.start + line, end=last.end + line) if last else None


def _statement_start(text: str, end: int) -> int | None:
    """Where the statement around `end` begins."""
    tail = _keyword_before(text, end)
    cut = split_statements(Source("", text[tail:end]), STATEMENT_WORDS)
    starts = [*(p.span.start for p in cut.pieces), *(s.start for s in cut.unread)]
    return tail + max(starts) if starts else None


def _keyword_before(text: str, end: int) -> int:
    """The last line that begins with a keyword; the text's beginning if there is none."""
    tail = 0
    for found in _KEYWORD_LINE.finditer(text, 0, end):
        tail = found.start()
    return tail


def statement_around(text: str, offset: int) -> ast.Statement | None:
    """The statement around a place, if it can be read."""
    start = _keyword_before(text, text.find("\n", offset) + 1 or len(text))
    following = _KEYWORD_LINE.search(text, start + 1)
    end = following.start() if following is not None else len(text)
    if end - start > _LONGEST:
        return None
    source = Source("", text)
    for piece in split_statements(Source("", text[start:end]), STATEMENT_WORDS).pieces:
        span = Span(source, start + piece.span.start, start + piece.span.end)
        if span.start <= offset < span.end:
            try:
                with room_for_nesting():
                    tree = statement_tree(replace(piece, span=span))
                    return Builder(source, piece.documentation).statement(tree)
            except StoryError:
                return None
    return None


def _after_word(text: str, start: int) -> int:
    found = re.compile(r"\w*").match(text, start)
    return found.end() if found else start


def _open_brackets(tokens: tuple[Token, ...]) -> int:
    opened = sum(t.type in _OPENERS for t in tokens)
    return opened - sum(t.type in _CLOSERS for t in tokens)


def _read(
    text: str, begin: int, end: int, rule: str
) -> tuple[tuple[Token, ...], frozenset[str] | None]:
    """The tokens of a part of a text and what can follow them.

    Where that is wrong, its brackets are tried from the outermost in, and then with what stood
    in their earlier parts left out.
    """
    if end - begin <= _LONGEST:
        whole = _parse(text, begin, end, rule)
        if whole is not None:
            return whole
    elif sum(text.count(c, begin, end) for c in "([{") > DEEPEST:
        return (), None
    if end - begin > _LONGEST_BROKEN:
        begin = text.find(" ", end - _LONGEST_BROKEN, end) + 1 or end
    for fragment in _fragments(text[begin:end]):
        part = _parse(fragment, 0, len(fragment), "expression")
        if part is not None:
            return part
    return (), None


def _parse(
    text: str, begin: int, end: int, rule: str
) -> tuple[tuple[Token, ...], frozenset[str]] | None:
    try:
        return tables().read(text, begin, end, rule)
    except UnexpectedError:
        return None


def _fragments(text: str) -> Iterator[str]:
    """Smaller texts that stand for what encloses the end of `text`."""
    levels = _open_levels(text)[-_TRIED:]
    for head, _, _ in levels:
        yield text[head:]
    for head, inner, separators in reversed(levels):
        opening = text[head:inner]
        if opening == "[" and text[:head].rstrip().endswith("++"):
            opening = "script ++ ["
        elif opening == "[" and re.search(r"[\w)\]]\s*\Z", text[:head]):
            opening = "script["
        elif opening == "{":
            opening = "t in {"
        before = "".join(f" 0 {text[s.start : s.end]} " for s in separators)
        rest = text[separators[-1].end if separators else inner :]
        yield f"{opening}{before}{rest}"
        yield f"{opening}{before}"


def _open_levels(text: str) -> list[tuple[int, int, list[Piece]]]:
    """For each open bracket where it begins with its word, where it ends, and its separators."""
    levels: list[tuple[int, int, list[Piece]]] = []
    before: Piece | None = None
    for piece in colour(text):
        if piece.kind in ("space", "comment"):
            continue
        if piece.terminal in _OPENERS:
            called = before is not None and (
                before.terminal == "NAME" or before.kind in ("form", "function")
            )
            called = called and piece.terminal in ("LPAR", "LSQB")
            if (
                piece.terminal == "LSQB"
                and before is not None
                and before.terminal != EXPECTED.terminal
            ):
                called = False
            head = before.start if called and before is not None else piece.start
            levels.append((head, piece.end, []))
        elif piece.terminal in _CLOSERS and levels:
            levels.pop()
        elif piece.terminal in _SEPARATORS and levels:
            levels[-1][2].append(piece)
        before = piece
    return levels
