"""What commands write: results on standard output, everything else on standard error."""

from __future__ import annotations

import errno
import json
import math
import os
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

import click

from i2pdsl.errors import Diagnostic, harmless

DONE, WRONG, USAGE, INTERRUPTED = 0, 1, 2, 130  # exit statuses (interfaces.md)


def in_words(problem: OSError | MemoryError) -> str:
    """What the machine refuses (a full disk, a folder that cannot be written to), on one line."""
    if isinstance(problem, MemoryError):
        return "there is not enough memory"
    what = " ".join((problem.strerror or str(problem) or type(problem).__name__).split())
    name = problem.filename2 or problem.filename
    return harmless(f"{what}: {name}" if name else what)


def forget_output() -> None:
    """Lets standard output end in nothing: flushing what is left in it would fail once more."""
    with suppress(OSError, ValueError, AttributeError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)


def show(diagnostics: tuple[Diagnostic, ...] | list[Diagnostic]) -> None:
    """Diagnostics as people read them, on standard error."""
    for diagnostic in diagnostics:
        click.echo(diagnostic.render(), err=True)


def output_json(document: Any) -> None:
    """The one document of `--json`. Infinities and NaN, which JSON has not, become null."""
    try:
        text = json.dumps(document, ensure_ascii=False, allow_nan=False)
    except ValueError:
        text = json.dumps(finite(document), ensure_ascii=False)
    encoding = getattr(sys.stdout, "encoding", None) or "utf-8"
    try:
        text.encode(encoding)
    except UnicodeEncodeError:  # a terminal without Unicode, or a file name that is not UTF-8
        text = json.dumps(finite(document))
    click.echo(text)


def finite(value: Any) -> Any:
    """Plain data with null for numbers that are infinite or undefined."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    return [finite(item) for item in value] if isinstance(value, list) else value


def output(text: str, colour: bool | None = None) -> None:
    """A result for people; characters that the terminal does not have are spelt out.

    With `colour` the text says itself how it is coloured, else nothing in it steers the terminal.
    """
    text = harmless(text) if colour is None else text
    encoding = getattr(sys.stdout, "encoding", None) or "utf-8"
    click.echo(text.encode(encoding, "backslashreplace").decode(encoding), color=colour)


def check_writable(folder: Path) -> None:
    """Says that nothing can be written to a folder before the work rather than after it."""
    place = next((p for p in (folder, *folder.parents) if p.exists()), Path())
    if not place.is_dir():
        raise NotADirectoryError(errno.ENOTDIR, "is no folder", str(place))
    if not os.access(place, os.W_OK | os.X_OK):
        raise PermissionError(errno.EACCES, "cannot be written to", str(place))
