"""From text to statements: reading, and cutting where a keyword stands in the first column.

Both languages (.story and .world) are cut in this way, so that a mistake in one statement hides
none in the others.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from i2pdsl.errors import Diagnostic, Note, Source, Span, StoryError, error, whole_file

LONGEST_FILE = 500_000  # characters; a story is read by people
DEEPEST = 200  # nesting (language.md)

_CLOSERS = {")": "(", "]": "[", "}": "{"}
_FRAMES = 40 * DEEPEST  # of Python's stack: what the deepest story that is allowed may need


@contextmanager
def room_for_nesting() -> Iterator[None]:
    """Lets Python recurse as deeply as a story may be nested."""
    before = sys.getrecursionlimit()
    sys.setrecursionlimit(max(before, _FRAMES))
    try:
        yield
    finally:
        sys.setrecursionlimit(before)


@dataclass(frozen=True)
class Piece:
    """One statement's range of the text, its keyword, and the comment block right above it."""

    span: Span
    keyword: str
    documentation: str


def read_source(path: Path | str) -> Source:
    """Reads a file as UTF-8 text; anything else is a StoryError, never a UnicodeDecodeError."""
    name = str(path)
    try:
        data = Path(path).read_bytes()
    except FileNotFoundError:
        raise error("no-file", "there is no such file", whole_file(name)) from None
    except OSError as problem:
        message = f"cannot be read: {problem.strerror or problem}"
        raise error("no-file", message, whole_file(name)) from None
    return decode(data, name)


def decode(data: bytes, name: str) -> Source:
    """Decodes a file's bytes."""
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as problem:
        before = data[: problem.start].decode("utf-8-sig", errors="replace")
        source = Source(name, before + "�")
        span = Span(source, len(before), len(before) + 1)
        message = f"this is no text: byte 0x{data[problem.start]:02x} is not UTF-8"
        raise error("not-text", message, span, "save the file as UTF-8") from None
    return Source(name, text)


def check_text(source: Source) -> None:
    """Refuses control characters and files that are too long to be written by people."""
    if len(source.text) > LONGEST_FILE:
        message = f"the file has {len(source.text):,} characters; at most {LONGEST_FILE:,} are read"
        raise error("too-long", message, Span(source, 0, 0))
    for offset, character in enumerate(source.text):
        if (character < " " and character not in "\n\r\t\f") or character == "\x7f":
            message = f"this is no text: character U+{ord(character):04X}"
            raise error("not-text", message, Span(source, offset, offset + 1))


def split_statements(
    source: Source, keywords: Iterable[str], drawn: frozenset[str] = frozenset()
) -> tuple[list[Piece], list[Diagnostic]]:
    """Cuts a text into statements and checks their brackets.

    A statement begins where a line begins in its first column, outside brackets; a line that
    begins with a keyword begins one in any case, since no keyword stands inside an expression,
    so that a forgotten bracket spoils one statement only. The indented lines of a statement whose
    keyword is in `drawn` (a map) are taken as they are: `#` is a wall there, not a comment.
    """
    text, words = source.text, set(keywords)
    pieces: list[Piece] = []
    problems: list[Diagnostic] = []
    comments: list[str] = []  # the comment block that ended on the line before
    start, keyword, documentation = -1, "", ""
    end = 0  # end of the last token of the current statement
    brackets: list[tuple[str, int]] = []
    broken = False

    def finish() -> None:
        nonlocal start, broken
        if start < 0:
            return
        if brackets and not broken:
            bracket, offset = brackets[-1]
            closer = next(c for c, o in _CLOSERS.items() if o == bracket)
            message = f"`{bracket}` is never closed"
            span = Span(source, offset, offset + 1)
            problems.append(Diagnostic("bracket", message, span, f"add `{closer}`"))
            broken = True
        if not broken:
            pieces.append(Piece(Span(source, start, end), keyword, documentation))
        brackets.clear()
        start, broken = -1, False

    for number, line_start in enumerate(source.line_starts, 1):
        line = source.line(number)
        stripped = line.strip()
        if not stripped:
            comments = []
            continue
        if start >= 0 and keyword in drawn and line[0].isspace():
            end = line_start + len(line.rstrip())
            continue
        if stripped.startswith("#"):
            comments.append(stripped.lstrip("#").strip())
            continue
        first_column = not line[0].isspace()
        word = _first_word(line)
        if first_column and (not brackets or word in words):
            finish()
            start, keyword, documentation = line_start, word, "\n".join(comments)
        elif start < 0:
            span = Span(source, line_start + len(line) - len(line.lstrip()), line_start + len(line))
            hint = "a statement begins in the first column"
            problems.append(
                Diagnostic("indentation", "an indented line continues nothing", span, hint)
            )
            comments = []
            continue
        comments = []
        i = line_start
        while i < line_start + len(line):
            c = text[i]
            if c == "#":
                break
            if c == '"':
                close = text.find('"', i + 1, line_start + len(line))
                if close < 0:
                    if not broken:
                        span = Span(source, i, line_start + len(line))
                        problems.append(
                            Diagnostic("string", "the text is never closed", span, 'add `"`')
                        )
                    broken = True
                    end = line_start + len(line)
                    break
                i = close
            elif c in "([{":
                brackets.append((c, i))
                if len(brackets) > DEEPEST and not broken:
                    problems.append(_too_deep(Span(source, i, i + 1)))
                    broken = True
            elif c in _CLOSERS:
                if brackets and brackets[-1][0] == _CLOSERS[c]:
                    brackets.pop()
                elif not broken:
                    problems.append(_mismatch(source, c, i, brackets))
                    broken = True
            if not c.isspace():
                end = i + 1
            i += 1
    finish()
    return pieces, problems


def too_deep(span: Span) -> StoryError:
    """The error for nesting beyond DEEPEST."""
    return StoryError([_too_deep(span)])


def _too_deep(span: Span) -> Diagnostic:
    message = f"nested deeper than {DEEPEST}"
    return Diagnostic("nesting", message, span, "name the parts with `let`")


def _mismatch(
    source: Source, closer: str, offset: int, brackets: list[tuple[str, int]]
) -> Diagnostic:
    span = Span(source, offset, offset + 1)
    if not brackets:
        return Diagnostic("bracket", f"`{closer}` closes nothing", span)
    opener, opened = brackets[-1]
    wanted = next(c for c, o in _CLOSERS.items() if o == opener)
    note = Note(f"`{opener}` was opened here", Span(source, opened, opened + 1))
    return Diagnostic(
        "bracket", f"`{closer}` cannot close `{opener}`", span, f"expected `{wanted}`", (note,)
    )


def _first_word(line: str) -> str:
    end = 0
    while end < len(line) and (line[end].isalnum() or line[end] == "_"):
        end += 1
    return line[:end]
