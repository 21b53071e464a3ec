"""Mistakes in a line of the REPL, shown where they were typed."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import replace

from i2pdsl.errors import Diagnostic, Source, Span, StoryError, closest, error, moved
from i2pdsl.language.builtins import STATEMENT_WORDS
from i2pdsl.language.forms import Word
from i2pdsl.repl.words import COMMAND_WORDS, COMMANDS

INPUT = "input"  # what a line is called in messages
_WORD = re.compile(r"[^\W\d]\w*")


def wrong(command: str, rest: str, message: str, hint: str | None = None) -> StoryError:
    """A mistake in what stands behind a command."""
    source = Source(INPUT, f"{command} {rest}".rstrip())
    span = Span(source, len(command) + 1 if rest else 0, len(source.text))
    return error("command", message, span, hint)


def usage(command: str, rest: str, commands: Iterable[Word] = COMMANDS) -> StoryError:
    """How a command is written."""
    word = next(word for word in commands if word.name == command)
    what = "cannot be read" if rest else "needs more"
    return wrong(command, rest, f"`{command}` {what}", f"`{word.signature}`")


def placed(
    diagnostics: Iterable[Diagnostic], piece: str, line: str, offset: int
) -> tuple[Diagnostic, ...]:
    """Diagnostics about a piece of a line that was read by itself, shown in the line.

    Args:
        offset: where the piece begins in the line; negative where words were put before it.
    """

    def move(span: Span) -> tuple[int, int] | None:
        inside = span.source.text == piece
        return (span.start + offset, span.end + offset) if inside else None

    return put_into(diagnostics, line, move)


def put_into(
    diagnostics: Iterable[Diagnostic],
    line: str,
    move: Callable[[Span], tuple[int, int] | None],
) -> tuple[Diagnostic, ...]:
    """Diagnostics with some of their places put into a line; `move` says where, if there."""
    source = Source(INPUT, line)

    def put(span: Span) -> Span:
        place = move(span)
        if place is None:
            return span
        start, end = (max(0, min(len(line), x)) for x in place)
        return Span(source, start, end)

    return moved(diagnostics, put)


def misspelt_command(problem: StoryError, text: str, known: set[str]) -> StoryError:
    """The mistakes of a question, with a hint where it may have been meant as a command."""
    match = _WORD.match(text)
    word = match[0] if match is not None else "help" if text.startswith("?") else ""
    if word in COMMAND_WORDS:  # `help()`, `?`
        hint = f"the command is `{word}`, and no more"
    elif not word or word in known:
        return problem
    else:
        meant = closest(word, (*COMMAND_WORDS, *STATEMENT_WORDS))
        if meant is None:
            return problem
        hint = f"did you mean `{meant}`?"
    first, *others = problem.diagnostics
    hint += f" {first.hint}" if first.hint else ""
    return StoryError((replace(first, hint=hint), *others))
