"""Places in a text as editors count them: lines, and characters in units of UTF-16 (or others)."""

from __future__ import annotations

import re
from bisect import bisect_right
from dataclasses import dataclass
from functools import cached_property

_LINE_END = re.compile(r"\r\n|\r|\n")


@dataclass(frozen=True)
class Lines:
    """The lines of a text in the sense of the language server protocol.

    `encoding` is what a character of a line counts: utf-8, utf-16 or utf-32 units.
    """

    text: str
    encoding: str = "utf-16"

    @cached_property
    def starts(self) -> list[int]:
        return [0, *(found.end() for found in _LINE_END.finditer(self.text))]

    def position(self, offset: int) -> tuple[int, int]:
        """Line and character, from 0, of an offset in the text."""
        offset = max(0, min(offset, len(self.text)))
        line = bisect_right(self.starts, offset) - 1
        return line, sum(map(self.units, self.text[self.starts[line] : offset]))

    def offset(self, line: int, character: int) -> int:
        """The offset of a place; behind the end of its line, or of the text, it is that end."""
        if line >= len(self.starts):
            return len(self.text)
        offset, end = self.starts[line], len(self.text)
        ending = _LINE_END.search(self.text, offset)
        if ending is not None:
            end = ending.start()
        while offset < end and character > 0:
            character -= self.units(self.text[offset])
            offset += character >= 0  # a place inside a character is before it
        return offset

    def units(self, character: str) -> int:
        """The units that a character counts."""
        if self.encoding == "utf-16":
            return 2 if character > "\uffff" else 1
        return len(character.encode("utf-8", "replace")) if self.encoding == "utf-8" else 1
