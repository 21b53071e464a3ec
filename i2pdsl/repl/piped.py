"""The REPL without a terminal: a question a line, an answer a line."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from typing import TextIO

import click

from i2pdsl.commands.output import output, show
from i2pdsl.repl.session import Session
from i2pdsl.repl.showing import in_a_line
from i2pdsl.repl.texts import is_unfinished


def answer_lines(session: Session, stream: TextIO) -> None:
    """Reads lines to the end and answers each; mistakes go to standard error."""
    for line in entries(stream):
        reply = session.run(line)
        show(reply.diagnostics)
        for remark in (*reply.noted, *reply.said):
            click.echo(remark, err=True)
        for shown in reply.shown:
            output(in_a_line(shown))
        if reply.shown:
            sys.stdout.flush()
        if reply.leaves:
            break


def entries(lines: Iterable[str]) -> Iterator[str]:
    """What belongs together: a line that is not finished goes on in the indented lines below it.

    The next line is read only where one is unfinished, so that a program on the other end of the
    pipe can wait for each answer.
    """
    waiting: list[str] = []
    for line in lines:
        line = line.rstrip("\r\n")
        if waiting and not line[:1].isspace():
            yield "\n".join(waiting)
            waiting = []
        waiting.append(line)
        if not is_unfinished("\n".join(waiting)):
            yield "\n".join(waiting)
            waiting = []
    if waiting:
        yield "\n".join(waiting)
