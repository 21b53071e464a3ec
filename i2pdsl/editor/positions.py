"""Places in a text as editors count them: lines, and characters in units of UTF-16 (or others)."""

from __future__ import annotations

import re
from bisect import bisect_right
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate

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
        if "\r" not in self.text:
            return [0, *accumulate(len(line) + 1 for line in self.text.split("\n")[:-1])]
        return [0, *(found.end() for found in _LINE_END.finditer(self.text))]

    def position(self, offset: int) -> tuple[int, int]:
        """Line and character, from 0, of an offset in the text."""
        offset = max(0, min(offset, len(self.text)))
        line = bisect_right(self.starts, offset) - 1
        return line, self.units(self.text[self.starts[line] : offset])

    def offset(self, line: int, character: int) -> int:
        """The offset of a place; behind the end of its line, or of the text, it is that end.

        A place inside a character is before it.
        """
        if line >= len(self.starts):
            return len(self.text)
        start, end = self.starts[line], len(self.text)
        ending = _LINE_END.search(self.text, start)
        if ending is not None:
            end = ending.start()
        units = lambda length: self.units(self.text[start : start + length])
        return start + bisect_right(range(end - start + 1), max(0, character), key=units) - 1

    def units(self, text: str) -> int:
        """The units that a piece of a line counts."""
        if text.isascii() or self.encoding not in ("utf-8", "utf-16"):
            return len(text)
        if self.encoding == "utf-8":
            return len(text.encode("utf-8", "replace"))
        return len(text.encode("utf-16-le", "surrogatepass")) // 2
