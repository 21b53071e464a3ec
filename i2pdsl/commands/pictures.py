"""Drawing for `i2p run` and `i2p render`."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from i2pdsl.commands.arguments import Size
from i2pdsl.errors import Diagnostic, whole_file
from i2pdsl.output import DONE, WRONG, in_words, show
from i2pdsl.render.files import SEE_THROUGH, FilmLook

if TYPE_CHECKING:
    from i2pdsl.stories import Script


def film_options(command: Callable[..., int]) -> Callable[..., int]:
    """The options of films, handed to a command as `look`."""

    @click.option(
        "--pace",
        type=click.FloatRange(0.1, 10),
        default=1.0,
        help="Films and pages: 2 is twice as fast.",
    )
    @click.option("--no-meter", is_flag=True, help="Films: without title and curves.")
    @click.option("--size", type=Size(), default=None, help="Films: pixels, as 1920x1080.")
    @click.option(
        "--transparent", is_flag=True, help="Films (gif, webm): who acts, on no background."
    )
    @wraps(command)
    def with_look(
        *arguments: Any,
        pace: float,
        no_meter: bool,
        size: tuple[int, int] | None,
        transparent: bool,
        **named: Any,
    ) -> int:
        if transparent and "mp4" in named["formats"]:
            message = f"mp4 cannot be transparent; write --format {' or '.join(SEE_THROUGH)}"
            raise click.UsageError(message)
        look = FilmLook(pace, not (no_meter or transparent), size, transparent)
        return command(*arguments, look=look, **named)

    return with_look


def draw(
    scripts: list[Script],
    folder: Path,
    formats: tuple[str, ...],
    files: dict[str, str],
    title: str | None = None,
    look: FilmLook | None = None,
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

    pictures = pictures_of(scripts, title, look)
    for each in (each for each in formats if each not in pictures.offered):
        message = f"there is no {each} of {scripts[0].world.name}"
        hint = f"there are: {', '.join(pictures.offered)}"
        where = whole_file("pictures")
        show([Diagnostic("pictures", message, where, hint, severity="warning")])
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
