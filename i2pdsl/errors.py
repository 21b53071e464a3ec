"""Mistakes in what people write, and how they are shown: one renderer for every front end."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable
from dataclasses import dataclass, field
from difflib import get_close_matches
from functools import cached_property
from itertools import accumulate


@dataclass(frozen=True)
class Source:
    """A text and where it came from. Lines and columns count characters, from 1."""

    name: str
    text: str

    @cached_property
    def line_starts(self) -> list[int]:
        return [0, *accumulate(len(line) + 1 for line in self.text.split("\n")[:-1])]

    def position(self, offset: int) -> tuple[int, int]:
        """Line and column of a character offset."""
        line = bisect_right(self.line_starts, offset)
        return line, offset - self.line_starts[line - 1] + 1

    def line(self, number: int) -> str:
        start, end = self.line_range(number)
        return self.text[start:end].rstrip("\r")

    def line_range(self, number: int) -> tuple[int, int]:
        """Where a line begins and ends, without its line feed."""
        starts = self.line_starts
        end = starts[number] - 1 if number < len(starts) else len(self.text)
        return starts[number - 1], end


@dataclass(frozen=True)
class Span:
    """The half-open range of characters [start, end) of a source."""

    source: Source = field(repr=False, compare=False)
    start: int
    end: int

    def to(self, other: Span) -> Span:
        """The span from the start of this one to the end of `other`."""
        return Span(self.source, self.start, max(self.end, other.end))

    @property
    def text(self) -> str:
        return self.source.text[self.start : self.end]


@dataclass(frozen=True)
class Note:
    """A second place that helps to understand a mistake."""

    message: str
    span: Span


@dataclass(frozen=True)
class Diagnostic:
    """One mistake (or warning): what, where, and what to do about it."""

    code: str
    message: str
    span: Span
    hint: str | None = None
    notes: tuple[Note, ...] = ()
    severity: str = "error"

    def render(self) -> str:
        """The diagnostic as shown on a terminal; its first line is a contract (interfaces.md)."""
        line, column = self.span.source.position(self.span.start)
        head = f"{self.span.source.name}:{line}:{column}: {self.severity}[{self.code}]"
        parts = [f"{head}: {self.message}", _excerpt(self.span)]
        for note in self.notes:
            line, column = note.span.source.position(note.span.start)
            parts.append(f"  {note.message} ({note.span.source.name}:{line}:{column})")
            parts.append(_excerpt(note.span))
        if self.hint:
            parts.append(f"  hint: {self.hint}")
        return "\n".join(part for part in parts if part)

    def as_json(self) -> dict[str, object]:
        """The diagnostic as plain data for editors; positions count from 1."""
        return {
            "code": self.code,
            "severity": self.severity,
            "message": self.message,
            "hint": self.hint,
            **_place(self.span),
            "notes": [{"message": n.message, **_place(n.span)} for n in self.notes],
        }


class StoryError(Exception):
    """A story, world or script that is wrong, with every diagnostic that was found.

    Attributes:
        diagnostics: the mistakes in the order of their places.
    """

    def __init__(self, diagnostics: list[Diagnostic] | tuple[Diagnostic, ...]):
        self.diagnostics = tuple(diagnostics)
        super().__init__(self.diagnostics)

    def __str__(self) -> str:
        return "\n".join(d.render() for d in self.diagnostics)

    def _render_traceback_(self) -> list[str]:
        """What IPython shows instead of a traceback."""
        return str(self).splitlines()


MOST_SHOWN = 200  # mistakes of one file


def first_of(problems: list[Diagnostic]) -> list[Diagnostic]:
    """The first mistakes, and how many more there are: nobody reads thousands."""
    more = len(problems) - MOST_SHOWN
    if more <= 0:
        return problems
    message = f"and {more:,} more mistake{'' if more == 1 else 's'}, from here on"
    last = Diagnostic("too-many", message, problems[MOST_SHOWN].span, "mend the first ones")
    return [*problems[:MOST_SHOWN], last]


def error(
    code: str, message: str, span: Span, hint: str | None = None, notes: tuple[Note, ...] = ()
) -> StoryError:
    """A StoryError of a single diagnostic, ready to be raised."""
    return StoryError([Diagnostic(code, message, span, hint, notes)])


def whole_file(name: str) -> Span:
    """A span for mistakes that have no place in a text (a file that is not there)."""
    return Span(Source(name, ""), 0, 0)


def did_you_mean(word: str, known: Iterable[str]) -> str | None:
    """A hint that names the closest known word, or lists the known ones if they are few."""
    words = set(known)
    close = closest(word, words)
    if close:
        return f"did you mean `{close}`?"
    if 0 < len(words) <= 12:
        return "known here: " + ", ".join(sorted(words))
    return None


_MANY = 1000  # words that are too many to be compared with one by one
_LONGEST_WORD = 60  # that can be a misspelling of another


def closest(word: str, known: Iterable[str]) -> str | None:
    """The known word that `word` is most likely a misspelling of."""
    if len(word) > _LONGEST_WORD:
        return None
    among = known if isinstance(known, set | frozenset) else set(known)
    if len(among) > _MANY:
        return min(_one_change(word) & among, default=None)
    words = sorted(among)
    lowered = {w.lower(): w for w in words}
    if word.lower() in lowered:
        return lowered[word.lower()]
    close = get_close_matches(word, words, n=1, cutoff=0.6)
    if not close:
        close = [lowered[c] for c in get_close_matches(word.lower(), lowered, n=1, cutoff=0.6)]
    return close[0] if close else None


def _one_change(word: str) -> set[str]:
    """The words that are one letter away: one less, one more, another, or two in other order."""
    letters = {*word, *"abcdefghijklmnopqrstuvwxyz_0123456789"}
    cuts = [(word[:i], word[i:]) for i in range(len(word) + 1)]
    less = {a + b[1:] for a, b in cuts if b}
    swapped = {a + b[1] + b[0] + b[2:] for a, b in cuts if len(b) > 1}
    other = {a + c + b[1:] for a, b in cuts if b for c in letters}
    return less | swapped | other | {a + c + b for a, b in cuts for c in letters}


_LONGEST_PIECE = 1000  # characters of a text that are looked at to show its beginning


def shorten(text: str) -> str:
    """A piece of a story on one line, cut where it is long, for use in a message."""
    line = " ".join(text[:_LONGEST_PIECE].split())
    return line if len(line) <= 40 else line[:39] + "…"


_WIDEST = 160  # characters of a line that are shown around a mistake


def _excerpt(span: Span) -> str:
    """The source line with the span underlined; long lines are cut around the span."""
    line, column = span.source.position(span.start)
    start, end = span.source.line_range(line)
    while end > start and span.source.text[end - 1] == "\r":
        end -= 1
    length = max(1, min(span.end - span.start, end - start - column + 1))
    if end - start <= _WIDEST:
        text = span.source.text[start:end]
    else:
        first = max(0, column - 1 - _WIDEST // 4)
        cut = span.source.text[start + first : min(end, start + first + _WIDEST)]
        column -= first
        text = ("…" if first else "") + cut + "…"
        column += 1 if first else 0
        length = min(length, _WIDEST)
    text = text.replace("\t", " ")
    if not text.strip(" …") and not span.text[:_WIDEST].strip():
        return ""
    text = "".join(c if c.isprintable() else "�" for c in text)
    gutter = f"{line:>5} | "
    return f"{gutter}{text}\n{' ' * (len(gutter) - 2)}| {' ' * (column - 1)}{'^' * length}"


def _place(span: Span) -> dict[str, object]:
    line, column = span.source.position(span.start)
    end_line, end_column = span.source.position(span.end)
    return {
        "file": span.source.name,
        "line": line,
        "column": column,
        "end_line": end_line,
        "end_column": end_column,
    }
