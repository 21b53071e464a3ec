"""Taking typed lines apart: commas outside brackets, unfinished lines, files behind `>`."""

from __future__ import annotations

import re
from dataclasses import dataclass
from textwrap import wrap

_OPEN, _CLOSE = "([{", ")]}"
_UNFINISHED = re.compile(r"(?:[-+*/^=<>,:|@]|\b(?:and|or|not|then|else|if|in))$")
_LONGEST = 8  # characters of a line's end, more than any of these and what is before it
_FILE = re.compile(r'\s*("[^"]+"|\S*\.[^\W\d]\w*)\s*$')
_GAP = re.compile(r"\S.*?  +(?=\S)")  # between a word and what is said about it
PICTURES = (".png", ".svg", ".pdf")


def without_comment(line: str) -> str:
    """A line up to its comment."""
    quoted = False
    for i, c in enumerate(line):
        quoted ^= c == '"'
        if c == "#" and not quoted:
            return line[:i].rstrip()
    return line.rstrip()


def wrapped(text: str, columns: int) -> str:
    """A text whose lines end between words; what goes on stands under where it began."""
    lines = []
    for line in text.splitlines():
        gap = _GAP.match(line)
        indent = gap.end() if gap is not None else len(line) - len(line.lstrip())
        if indent > columns // 2:
            indent = 4
        lines += wrap(
            line,
            max(columns, 20),
            subsequent_indent=" " * indent,
            break_on_hyphens=False,
            break_long_words=False,
        ) or [""]
    return "\n".join(lines)


@dataclass(frozen=True)
class Brackets:
    """What lines leave open: how many brackets, and how the last one that is not blank ends."""

    depth: int = 0
    end: str = ""

    def after(self, text: str) -> Brackets:
        """The same with more lines behind those read so far."""
        depth, end = self.depth, self.end
        for line in map(without_comment, text.splitlines()):
            depth += sum(map(line.count, _OPEN)) - sum(map(line.count, _CLOSE))
            end = line[-_LONGEST:] if line.strip() else end
        return Brackets(depth, end)

    @property
    def are_unfinished(self) -> bool:
        """Whether more must follow: a bracket is open, or the last line ends with an operator."""
        return self.depth > 0 or _UNFINISHED.search(self.end) is not None


def is_unfinished(text: str) -> bool:
    """Whether more must follow a text."""
    return Brackets().after(text).are_unfinished


def split_file(text: str) -> tuple[str, str | None]:
    """`EXPR, EXPR > file.png` as the expressions and the file; no expression ends like one."""
    head, mark, tail = text.rpartition(">")
    match = _FILE.match(tail)
    if not mark or match is None:
        return text, None
    return head, match[1].strip('"')
