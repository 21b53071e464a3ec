"""`i2p repl`: questions and stories, line by line."""

from __future__ import annotations

import sys
from io import TextIOWrapper

import click

from i2pdsl.output import show


@click.command()
@click.argument("source", required=False, type=click.Path())
def repl(source: str | None) -> int | None:
    """Ask questions about a script, and write stories, line by line.

    With input piped in: one question a line, one answer a line.
    """
    from i2pdsl.repl.session import Session

    session = Session()
    if source is not None:
        reply = session.open(source)
        show(reply.diagnostics)
        session.past.clear()
    if not sys.stdin.isatty():
        from i2pdsl.repl.piped import answer_lines

        if isinstance(sys.stdin, TextIOWrapper):
            sys.stdin.reconfigure(encoding="utf-8-sig", errors="replace")
        answer_lines(session, sys.stdin)
        return None
    from i2pdsl.repl.terminal import converse

    converse(session)
    return None
