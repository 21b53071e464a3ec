"""Mistakes in what people write, and how they are shown: one renderer for every front end."""

from __future__ import annotations

import re
import unicodedata
from bisect import bisect_right
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property


@dataclass(frozen=True)
class Source:
    """A text and where it came from. Lines and columns count characters, from 1."""

    name: str
    text: str

    @cached_property
    def line_starts(self) -> list[int]:
        return [0] + [found.end() for found in re.finditer("\n", self.text)]

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
        return harmless("\n".join(part for part in parts if part))

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
    """A hint that names the closest known word, or those of which it is the first part or has the
    parts in another order (`rho`, `rho_hen_fox` of `rho_fox_hen`), or lists the known ones if they
    are few."""
    words = set(known)
    close = closest(word, words)
    if close:
        return f"did you mean `{close}`?"
    parts = sorted(word.split("_"))
    alike = sorted(w for w in words if w.startswith(f"{word}_") or sorted(w.split("_")) == parts)
    if 0 < len(alike) <= 12:
        return f"did you mean {' or '.join(f'`{w}`' for w in alike)}?"
    if 0 < len(words) <= 12:
        return "known here: " + ", ".join(sorted(words))
    return None


_LONGEST_WORD = 60  # that can be a misspelling of another


def closest(word: str, known: Iterable[str]) -> str | None:
    """The known word that `word` is most likely a misspelling of; None rather than a far guess.

    One slip of the hand (a letter left out, added, changed, or two exchanged) for every four
    letters, or the beginning of one known word only.
    """
    from rapidfuzz.distance import OSA  # the edit distance in which an exchange is one slip
    from rapidfuzz.process import extract

    if len(word) > _LONGEST_WORD:
        return None
    plain = _folded(word)
    folded = {_folded(w): w for w in sorted(known)}
    if plain in folded:
        return folded[plain]
    most = max(1, len(plain) // 4)
    near = [
        (slips, folded[f])
        for f, slips, _ in extract(
            plain, list(folded), scorer=OSA.distance, score_cutoff=most, limit=None
        )
        if slips <= _bearable(plain, f)
    ]
    if near:
        return min(near)[1]
    begun = [w for f, w in folded.items() if len(plain) >= 3 and f.startswith(plain)]
    return begun[0] if len(begun) == 1 else None


def _folded(word: str) -> str:
    """A word without what the eye may miss: case, and the ways of writing one letter."""
    return word.lower() if word.isascii() else unicodedata.normalize("NFKC", word).casefold()


def _bearable(a: str, b: str) -> int:
    """How many slips two words may be apart and still be one word."""
    if a[1:2] == "_" and a[:2] == b[:2]:  # of `G_cat` only the name can be misspelt
        a, b = a[2:], b[2:]
    shorter = min(len(a), len(b))
    return max(1, shorter // 4) if 3 <= shorter <= _LONGEST_WORD else 0


_LONGEST_PIECE = 1000  # characters of a text that are looked at to show its beginning


def shorten(text: str) -> str:
    """A piece of a story on one line, cut where it is long, for use in a message."""
    line = " ".join(text[:_LONGEST_PIECE].split())
    return line if len(line) <= 40 else line[:39] + "…"


def harmless(text: str) -> str:
    """A text for a terminal: characters that would steer it are shown as �.

    Lines stay lines, and halves of characters, which file names have that are not UTF-8.
    """
    if text.isprintable():
        return text
    steering = lambda c: not c.isprintable() and c not in "\n\t" and not "\ud800" <= c <= "\udfff"
    return "".join("�" if steering(c) else c for c in text)


_WIDEST = 160  # characters of a line that are shown around a mistake
_JOINERS = "\u200c\u200d"  # not printable by themselves, but letters of several scripts need them


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
    text = "".join(c if c.isprintable() or c in _JOINERS else "�" for c in text)
    gutter = f"{line:>5} | "
    before, marked = display_width(text[: column - 1]), text[column - 1 : column - 1 + length]
    width = display_width(text[: column - 1 + length]) - before
    if marked and width == 0:  # a mark that is drawn on the letter before it
        before -= 1
    return f"{gutter}{text}\n{' ' * (len(gutter) - 2)}| {' ' * before}{'^' * max(1, width)}"


def display_width(text: str) -> int:
    """The columns of a terminal that a text takes: 2 for wide letters, 0 for marks on others."""
    if text.isascii():
        return len(text)
    from wcwidth import wcswidth

    width = wcswidth(text)
    return width if width >= 0 else len(text)  # control characters have no width


def padded(text: str, width: int, right: bool = False) -> str:
    """A text with spaces up to so many columns, behind it, or before it (`right`)."""
    space = " " * (width - display_width(text))
    return space + text if right else text + space


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


def moved(diagnostics: Iterable[Diagnostic], put: Callable[[Span], Span]) -> tuple[Diagnostic, ...]:
    """Diagnostics whose places are put elsewhere."""
    return tuple(
        replace(d, span=put(d.span), notes=tuple(Note(n.message, put(n.span)) for n in d.notes))
        for d in diagnostics
    )
