"""The REPL without a terminal: a question a line, an answer a line."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from typing import TextIO

import click

from i2pdsl.output import output, show
from i2pdsl.repl.faults import taken
from i2pdsl.repl.session import Session
from i2pdsl.repl.showing import Reply, in_a_line
from i2pdsl.repl.texts import Brackets


def answer_lines(session: Session, stream: TextIO) -> None:
    """Reads lines to the end and answers each; mistakes go to standard error."""
    for line in entries(stream):
        if not taken(session, line, tell):
            break


def tell(reply: Reply) -> None:
    """Writes what a line came to."""
    texts = [in_a_line(shown) for shown in reply.shown]
    show(reply.diagnostics)
    for remark in (*reply.noted, *reply.said):
        click.echo(remark, err=True)
    for text in texts:
        output(text)
    if texts:
        sys.stdout.flush()


def entries(lines: Iterable[str]) -> Iterator[str]:
    """What belongs together: a line that is not finished goes on in the indented lines below it.

    The next line is read only where one is unfinished, so that a program on the other end of the
    pipe can wait for each answer.
    """
    waiting: list[str] = []
    brackets = Brackets()
    for line in lines:
        line = line.rstrip("\r\n")
        if waiting and not line[:1].isspace():
            yield "\n".join(waiting)
            waiting, brackets = [], Brackets()
        waiting.append(line)
        brackets = brackets.after(line)
        if not brackets.are_unfinished:
            yield "\n".join(waiting)
            waiting, brackets = [], Brackets()
    if waiting:
        yield "\n".join(waiting)
