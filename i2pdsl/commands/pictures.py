"""Drawing for `i2p run` and `i2p render`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from i2pdsl.errors import Diagnostic, whole_file
from i2pdsl.output import DONE, WRONG, in_words, show

if TYPE_CHECKING:
    from i2pdsl.pipeline import Script


def draw(
    scripts: list[Script],
    folder: Path,
    formats: tuple[str, ...],
    files: dict[str, str],
    title: str | None = None,
) -> int:
    """Writes the pictures; their paths are put into `files` as they are finished.

    Returns the exit status: films that cannot be written, and why, are said.
    """
    if not formats:
        return DONE
    from i2pdsl.progress import Bars
    from i2pdsl.render.fonts import noting
    from i2pdsl.render.pictures import pictures_of
    from i2pdsl.render.video import FilmError

    pictures = pictures_of(scripts, title)
    with Bars() as bars, noting(warn):
        try:
            for name, path in pictures.drawn(folder, formats, bars.drawing):
                files[name] = str(path)
        except FilmError as problem:
            click.echo(f"error: {in_words(problem)}", err=True)
            if files:
                click.echo(f"written all the same: {', '.join(files.values())}", err=True)
            return WRONG
        except RuntimeError as problem:
            raise OSError(str(problem)) from problem
    return DONE


def warn(message: str, hint: str) -> None:
    """Says what is odd about letters in pictures."""
    show([Diagnostic("font", message, whole_file("pictures"), hint, severity="warning")])
