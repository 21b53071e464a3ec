"""A story's text, and changes of it: everything that is done by hand is one.

What is not meant stays as it was written, comments and all, and an editor is told only what is
other than before, so that its cursor stays where it was.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from difflib import SequenceMatcher
from functools import cached_property
from itertools import accumulate
from typing import Any

from i2pdsl.editor.positions import Lines
from i2pdsl.errors import Source, Span
from i2pdsl.language import ast
from i2pdsl.language.naming import same_name
from i2pdsl.language.parse import parse_tolerantly
from i2pdsl.studio.protocol import USAGE, Range, Refusal


@dataclass(frozen=True)
class Change:
    """What comes to the place [start, end) of a text, in characters."""

    start: int
    end: int
    new: str


@dataclass(frozen=True)
class StoryText:
    """The statements of a text, also of one that has mistakes."""

    text: str

    @cached_property
    def source(self) -> Source:
        return Source("story", self.text)

    @cached_property
    def program(self) -> ast.Program:
        return parse_tolerantly(self.source)[0]

    @cached_property
    def lines(self) -> Lines:
        return Lines(self.text)

    @property
    def length(self) -> int | None:
        """T, where it is written as a number: the greatest of several."""
        for said in self.program.of(ast.LengthIs):
            number = said.most or said.frames
            if isinstance(number, ast.Number):
                return int(number.value)
        return None

    def frame(self, index: ast.Expr) -> int | None:
        """The number of a frame, of a sum of numbers and T; None where it is computed otherwise."""
        match index:
            case ast.Number(value=value):
                return int(value)
            case ast.Length():
                return self.length
            case ast.Sum(signs=signs, terms=terms):
                parts = [self.frame(term) for term in terms]
                if None in parts:
                    return None
                return sum(s * p for s, p in zip(signs, parts, strict=True) if p is not None)
        return None

    def frames(self, pin: ast.Pin) -> range | None:
        """The frames that a statement pins."""
        first = self.frame(pin.first)
        last = first if pin.last is None else self.frame(pin.last)
        return None if first is None or last is None else range(first, last + 1)

    # Places.

    def range(self, start: int, end: int) -> dict[str, Any]:
        """A place as the language server protocol has it."""
        ends = (self.lines.position(offset) for offset in (start, end))
        first, last = ({"line": line, "character": at} for line, at in ends)
        return {"start": first, "end": last}

    def range_of(self, span: Span) -> dict[str, Any]:
        return self.range(span.start, span.end)

    def offsets(self, place: Range) -> tuple[int, int]:
        """The characters of a place. Raises Refusal where it is none."""
        ends = (place.start, place.end)
        start, end = (self.lines.offset(each.line, each.character) for each in ends)
        if start > end:
            raise Refusal(USAGE, "the range ends before it begins")
        return start, end

    def edits(self, new: str) -> list[dict[str, Any]]:
        """What makes another text of this one, as the language server protocol has it."""
        old, lines = self.text.splitlines(keepends=True), new.splitlines(keepends=True)
        ends = list(accumulate(map(len, old), initial=0))
        found = []
        for what, a, b, c, d in SequenceMatcher(None, old, lines, autojunk=False).get_opcodes():
            if what != "equal":
                before, after = "".join(old[a:b]), "".join(lines[c:d])
                same = _shared(before, after)
                rest = _shared(before[same:][::-1], after[same:][::-1])
                start, end = ends[a] + same, ends[b] - rest
                inserted = after[same : len(after) - rest]
                found.append({"range": self.range(start, end), "newText": inserted})
        return found

    # Statements.

    def without(self, span: Span) -> Change:
        """The text without a statement; its line goes too, unless a comment stands in it."""
        end = self.text.find("\n", span.end)
        end = len(self.text) if end < 0 else end
        comment = self.text.find("#", span.end, end)
        return Change(span.start, comment if comment >= 0 else min(end + 1, len(self.text)), "")

    def with_changes(self, changes: Iterable[Change]) -> StoryText:
        """The text with changes that do not overlap."""
        text = self.text
        for each in sorted(changes, key=lambda each: (each.start, each.end), reverse=True):
            text = text[: each.start] + each.new + text[each.end :]
        return StoryText(text)

    def with_statements(self, statements: Iterable[str], after: tuple[type, ...]) -> StoryText:
        """More statements, each on a line of its own: after the last of some kinds, else at the
        end."""
        new = list(statements)
        known = [s for s in self.program.statements if isinstance(s, after)]
        if known:
            at = self.text.find("\n", known[-1].span.end)
            at = len(self.text) if at < 0 else at
            added = "".join(f"\n{line}" for line in new)
            return StoryText(f"{self.text[:at]}{added}{self.text[at:]}")
        return StoryText(f"{self.text.rstrip()}\n\n" + "".join(f"{line}\n" for line in new))


def _shared(one: str, other: str) -> int:
    """How many characters two texts begin with alike."""
    pairs = zip(one, other, strict=False)
    return next((n for n, (a, b) in enumerate(pairs) if a != b), min(len(one), len(other)))


def parts(condition: ast.Expr) -> tuple[ast.Expr, ...]:
    """What a condition says, one thing after the other."""
    return condition.operands if isinstance(condition, ast.And) else (condition,)


def whose(condition: ast.Expr) -> str | None:
    """Of whom a condition says where it is, and nothing else."""
    said, words = condition, {"at", "absent"}
    if isinstance(condition, ast.Compare):  # 2 <= climbed(box) <= 3
        calls = [part for part in condition.operands if isinstance(part, ast.Call)]
        said, words = (calls[0] if len(calls) == 1 else condition), {"climbed"}
    if not isinstance(said, ast.Call) or said.callee.id not in words:
        return None
    first = said.arguments[0].value if said.arguments else None
    return same_name(first.id) if isinstance(first, ast.Name) else None
