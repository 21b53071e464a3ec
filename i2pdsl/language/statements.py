"""From text to statements: reading, and cutting where a keyword stands in the first column.

Both languages (.story and .world) are cut in this way, so that a mistake in one statement hides
none in the others.
"""

from __future__ import annotations

import errno
import re
import sys
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from i2pdsl.errors import Diagnostic, Note, Source, Span, StoryError, error, whole_file
from i2pdsl.untrusted import read_bytes

LONGEST_FILE = 500_000  # characters; a story is read by people
LARGEST_TEXT = 4 * LONGEST_FILE + 3  # bytes of as many characters, and of a byte order mark
LARGEST_SCRIPT = 128 * 2**20  # bytes; of the hill's script with most frames, 124 MB
DEEPEST = 200  # nesting (language.md)

_OPENERS = {"(": ")", "[": "]", "{": "}"}
_CLOSERS = {closer: opener for opener, closer in _OPENERS.items()}
_NO_TEXT = re.compile(r"[\x00-\x08\x0b\x0e-\x1f\x7f]")
_MARK = re.compile(r'["#()\[\]{}]')  # what a line is cut by
_WORD = re.compile(r"\w*")
_FRAMES = 40 * DEEPEST  # of Python's stack: what the deepest story that is allowed may need


class _Recursion:
    """The limit is the interpreter's: the first thread raises it, the last one lowers it."""

    lock = threading.Lock()
    users = 0
    usual = 0


_recursion = _Recursion()


@contextmanager
def room_for_nesting() -> Iterator[None]:
    """Lets Python recurse as deeply as a story may be nested; several threads may be in here."""
    with _recursion.lock:
        if _recursion.users == 0:
            _recursion.usual = sys.getrecursionlimit()
            sys.setrecursionlimit(max(_recursion.usual, _FRAMES))
        _recursion.users += 1
    try:
        yield
    finally:
        with _recursion.lock:
            _recursion.users -= 1
            if _recursion.users == 0:
                sys.setrecursionlimit(_recursion.usual)


@dataclass(frozen=True)
class Piece:
    """One statement's range of the text, its keyword, and the comment block right above it."""

    span: Span
    keyword: str
    documentation: str


class Cut(NamedTuple):
    """The statements of a text, the ranges of those with wrong brackets, and the mistakes."""

    pieces: list[Piece]
    unread: list[Span]
    problems: list[Diagnostic]


def read_source(path: Path | str) -> Source:
    """Reads a regular file as UTF-8 text; anything else is a StoryError.

    A script may be larger than what people write.
    """
    name = str(path)
    is_written = name.endswith((".story", ".world", ".study"))
    return decode(read_data(path, LARGEST_TEXT if is_written else LARGEST_SCRIPT), name)


def read_data(path: Path | str, largest: int) -> bytes:
    """The content of a regular file of at most `largest` bytes. Raises StoryError."""
    where = whole_file(str(path))
    try:
        return read_bytes(path, largest)
    except FileNotFoundError:
        raise error("no-file", "there is no such file", where) from None
    except OSError as problem:
        code = "too-long" if problem.errno == errno.EFBIG else "no-file"
        message = f"cannot be read: {problem.strerror or problem}"
        raise error(code, message, where) from None


def decode(data: bytes, name: str) -> Source:
    """Decodes a file's bytes."""
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as problem:
        before = data[: problem.start].decode("utf-8-sig", errors="replace")
        source = Source(name, before + "�")
        span = Span(source, len(before), len(before) + 1)
        message = f"this is not text: byte 0x{data[problem.start]:02x} is not UTF-8"
        raise error("not-text", message, span, "save the file as UTF-8") from None
    return Source(name, text)


def check_text(source: Source) -> None:
    """Refuses control characters and files that are too long to be written by people."""
    if len(source.text) > LONGEST_FILE:
        message = f"the file has {len(source.text):,} characters; at most {LONGEST_FILE:,} are read"
        raise error("too-long", message, Span(source, 0, 0))
    found = _NO_TEXT.search(source.text)
    if found is not None:
        message = f"this is not text: character U+{ord(found.group()):04X}"
        raise error("not-text", message, Span(source, found.start(), found.end()))


def split_statements(
    source: Source, keywords: Iterable[str], drawn: frozenset[str] = frozenset()
) -> Cut:
    """Cuts a text into statements and checks their brackets.

    A statement begins where a line begins in its first column, outside brackets; a line that
    begins with a keyword begins one in any case, since no keyword stands inside an expression,
    so that a forgotten bracket spoils one statement only. The indented lines of a statement whose
    keyword is in `drawn` (a map) are taken as they are: `#` is a wall there, not a comment.
    """
    cutter = _Cutter(source, frozenset(keywords), drawn)
    offset = 0
    for line in source.text.split("\n"):
        if line:
            cutter.line(line.rstrip("\r"), offset)
        else:
            cutter.comments = []
        offset += len(line) + 1
    cutter.finish()
    return Cut(cutter.pieces, cutter.unread, cutter.problems)


def check_brackets(source: Source) -> list[Diagnostic]:
    """The mistakes with brackets and quotes in a text that is one expression."""
    cutter = _Cutter(source, frozenset(), frozenset())
    cutter.start = 0
    for number, offset in enumerate(source.line_starts, 1):
        cutter.scan(source.line(number), offset)
    cutter.finish()
    return cutter.problems


class _Cutter:
    """Reads line by line; `start` is where the current statement begins, or -1."""

    def __init__(self, source: Source, keywords: frozenset[str], drawn: frozenset[str]):
        self.source = source
        self.keywords = keywords
        self.drawn = drawn
        self.pieces: list[Piece] = []
        self.unread: list[Span] = []
        self.problems: list[Diagnostic] = []
        self.comments: list[str] = []  # the comment block that ended on the line before
        self.start, self.keyword, self.documentation = -1, "", ""
        self.end = 0  # end of the last character of the current statement that is no space
        self.brackets: list[tuple[str, int]] = []
        self.broken = False

    def problem(self, problem: Diagnostic) -> None:
        """Reports the first mistake of a statement; others may follow from it."""
        if not self.broken:
            self.problems.append(problem)
        self.broken = True

    def line(self, line: str, offset: int) -> None:
        stripped = line.strip()
        if not stripped:
            self.comments = []
            return
        indented = line[0].isspace()
        if self.start >= 0 and self.keyword in self.drawn and indented:
            self.end = offset + len(line.rstrip())
            return
        if stripped.startswith("#"):
            self.comments.append(stripped.lstrip("#").strip())
            return
        word = _first_word(stripped)
        if not indented and (not self.brackets or word in self.keywords):
            self.begin(offset, word)
        elif self.start < 0:
            self.begin(offset + len(line) - len(line.lstrip()), word)
            span = Span(self.source, self.start, self.start + max(1, len(word)))
            hint = "move it to the first column"
            message = "a statement begins in the first column, indented lines continue one"
            self.problem(Diagnostic("indentation", message, span, hint))
        self.comments = []
        self.scan(line, offset)

    def begin(self, start: int, word: str) -> None:
        self.finish()
        self.start, self.keyword, self.documentation = start, word, "\n".join(self.comments)

    def scan(self, line: str, offset: int) -> None:
        """Follows brackets and quotes through a line, up to its comment."""
        end = len(line)  # where its comment begins
        found = _MARK.search(line)
        while found is not None:
            i, c = found.start(), found.group()
            if c == "#":
                end = i
                break
            after = i + 1
            if c == '"':
                close = line.find('"', i + 1)
                if close < 0:
                    span = Span(self.source, offset + i, offset + len(line))
                    self.problem(Diagnostic("string", "the text is never closed", span, 'add `"`'))
                    break
                after = close + 1
            elif c in _OPENERS:
                self.brackets.append((c, offset + i))
                if len(self.brackets) > DEEPEST and not self.broken:
                    self.problem(_too_deep(Span(self.source, offset + i, offset + i + 1)))
            else:
                self.close(c, offset + i)
            found = _MARK.search(line, after)
        written = len(line[:end].rstrip())
        if written:
            self.end = offset + written

    def close(self, closer: str, offset: int) -> None:
        if self.brackets and self.brackets[-1][0] == _CLOSERS[closer]:
            self.brackets.pop()
            return
        if self.broken:
            return
        span = Span(self.source, offset, offset + 1)
        if not self.brackets:
            message = f"`{closer}` closes nothing"
            self.problem(Diagnostic("bracket", message, span, "remove it, or open it before"))
            return
        opener, opened = self.brackets[-1]
        note = Note(f"`{opener}` was opened here", Span(self.source, opened, opened + 1))
        message = f"`{closer}` cannot close `{opener}`"
        hint = f"expected `{_OPENERS[opener]}`"
        self.problem(Diagnostic("bracket", message, span, hint, (note,)))

    def finish(self) -> None:
        """Ends the current statement."""
        if self.start < 0:
            return
        if self.brackets:
            bracket, offset = self.brackets[-1]
            span = Span(self.source, offset, offset + 1)
            message = f"`{bracket}` is never closed"
            hint = f"add `{_OPENERS[bracket]}`"
            self.problem(Diagnostic("bracket", message, span, hint))
        span = Span(self.source, self.start, max(self.start, self.end))
        if self.broken:
            self.unread.append(span)
        else:
            self.pieces.append(Piece(span, self.keyword, self.documentation))
        self.brackets.clear()
        self.start, self.broken = -1, False


def too_deep(span: Span) -> StoryError:
    """The error for nesting beyond DEEPEST."""
    return StoryError([_too_deep(span)])


def _too_deep(span: Span) -> Diagnostic:
    message = f"nested deeper than {DEEPEST}"
    return Diagnostic("nesting", message, span, "name the parts with `let`")


def _first_word(line: str) -> str:
    found = _WORD.match(line)
    assert found is not None
    return found.group()


def split_outside(text: str, mark: str) -> list[str]:
    """The parts of a text between marks that stand in no bracket."""
    parts, depth, start = [], 0, 0
    for i, c in enumerate(text):
        depth += (c in "([{") - (c in ")]}")
        if c == mark and depth == 0:
            parts.append(text[start:i])
            start = i + 1
    return [*parts, text[start:]]
