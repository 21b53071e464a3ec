"""What stands before the cursor in its statement, read by the real grammar as far as it goes."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from lark import Token
from lark.exceptions import UnexpectedInput
from lark.utils import TextSlice

from i2pdsl.editor.colours import Piece, colour
from i2pdsl.errors import Source
from i2pdsl.language.builtins import STATEMENT_WORDS
from i2pdsl.language.parse import grammar
from i2pdsl.language.statements import DEEPEST, LONGEST_FILE, split_statements

_KEYWORD_LINE = re.compile(rf"^(?:{'|'.join(STATEMENT_WORDS)})\b", re.MULTILINE)
_WORD = re.compile(r"\w*\Z")
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
    found = _WORD.search(text, 0, offset)
    begin = found.start() if found else offset
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


def _last_piece(text: str, begin: int, offset: int) -> Piece | None:
    """The piece of the line that ends at the cursor."""
    line = text.rfind("\n", 0, offset) + 1
    last = None
    for piece in colour(text[line:offset]):
        last = piece
    return last._replace(start=last.start + line, end=last.end + line) if last else None


def _statement_start(text: str, end: int) -> int | None:
    """Where the statement around `end` begins."""
    tail = 0
    for found in _KEYWORD_LINE.finditer(text, 0, end):
        tail = found.start()
    cut = split_statements(Source("", text[tail:end]), STATEMENT_WORDS)
    starts = [*(p.span.start for p in cut.pieces), *(s.start for s in cut.unread)]
    return tail + max(starts) if starts else None


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
    whole = _parse(TextSlice(text, begin, end), rule)
    if whole is not None:
        return whole
    for fragment in _fragments(text[begin:end]):
        part = _parse(TextSlice(fragment, 0, len(fragment)), "expression")
        if part is not None:
            return part
    return (), None


def _parse(text: TextSlice[str], rule: str) -> tuple[tuple[Token, ...], frozenset[str]] | None:
    parser = grammar().parse_interactive(text, rule)
    try:
        tokens = parser.exhaust_lexer()
    except UnexpectedInput:
        return None
    return tuple(tokens), frozenset(parser.accepts())


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
            if piece.terminal == "LSQB" and before is not None and before.terminal != "E_KW":
                called = False
            head = before.start if called and before is not None else piece.start
            levels.append((head, piece.end, []))
        elif piece.terminal in _CLOSERS and levels:
            levels.pop()
        elif piece.terminal in _SEPARATORS and levels:
            levels[-1][2].append(piece)
        before = piece
    return levels
