"""Drawing for `i2p run` and `i2p render`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from i2pdsl.pipeline import Script


def draw(
    scripts: list[Script],
    folder: Path,
    formats: tuple[str, ...],
    files: dict[str, str],
    title: str | None = None,
) -> None:
    """Writes the pictures; their paths are put into `files` as they are finished."""
    if not formats:
        return
    from i2pdsl.progress import Bars
    from i2pdsl.render.pictures import pictures_of

    pictures = pictures_of(scripts, title)
    with Bars() as bars:
        try:
            for name, path in pictures.drawn(folder, formats, bars.drawing):
                files[name] = str(path)
        except RuntimeError as problem:  # of ffmpeg: a full disk, most likely
            raise OSError(str(problem)) from problem
