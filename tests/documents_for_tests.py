"""The fenced blocks of documents."""

from __future__ import annotations

import re
from dataclasses import dataclass

TYPED = "i2p> "
FENCE = re.compile(r"^```(.*)$")


@dataclass
class Block:
    """A fenced block: the words behind its fence, its text, and the lines that it fills."""

    words: list[str]
    text: str
    first: int
    last: int
    output: Block | None = None

    @property
    def holds_answers(self) -> bool:
        return any(not line.startswith(TYPED) for line in self.text.splitlines())

    def option(self, name: str) -> str | None:
        found = (w.partition("=")[2] for w in self.words if w.startswith(f"{name}="))
        return next(found, None)


def blocks(text: str) -> list[Block]:
    """The blocks of a document; an output belongs to the block above it."""
    found: list[Block] = []
    opened: Block | None = None
    lines = text.splitlines()
    for number, line in enumerate(lines):
        fence = FENCE.match(line)
        if not fence:
            continue
        if opened is None:
            opened = Block(fence[1].split(), "", number + 1, number + 1)
            continue
        assert not fence[1], f"line {number + 1}: a block begins inside another one"
        opened.last = number
        opened.text = "".join(f"{x}\n" for x in lines[opened.first : number])
        if opened.words[:1] == ["repl"] and opened.holds_answers:
            opened.output = opened
        if opened.words[:1] == ["output"]:
            found[-1].output = opened
        else:
            found.append(opened)
        opened = None
    assert opened is None, "the last block is never closed"
    return found
