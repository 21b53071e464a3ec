"""The files of a folder that people mean when they name it: stories, scripts, what they write."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from i2pdsl.errors import error, whole_file


def script_files(path: str) -> list[Path]:
    """The file itself, or all scripts of a folder and those in it, but hidden ones."""
    from i2pdsl.worlds.record import FORMAT

    def is_script(file: Path) -> bool:
        if file.suffix != ".json" or file.name.startswith("."):
            return False
        with open(file, encoding="utf-8", errors="replace") as opened:
            return FORMAT in opened.read(200)  # other programs' files lie there, too

    return _files(path, is_script, "scripts")


def story_files(path: str) -> list[Path]:
    """The file itself, or all stories and worlds of a folder and those in it, but hidden ones."""
    return _files(path, lambda file: file.name.endswith((".story", ".world")), "stories")


def written_files(path: str) -> list[Path]:
    """As `story_files`, with studies: all that people write."""
    wanted = (".story", ".world", ".study")
    return _files(path, lambda file: file.name.endswith(wanted), "stories")


def _files(path: str, is_one: Callable[[Path], bool], what: str) -> list[Path]:
    """The file itself, or those of a folder that are wanted, but not of hidden folders."""
    place = Path(path)
    if not place.is_dir():
        return [place]
    found: list[Path] = []
    for folder, inner, names in os.walk(place):
        inner[:] = [name for name in inner if not name.startswith(".")]
        found += filter(is_one, (Path(folder, name) for name in names))
    if not found:
        raise error("no-file", f"there are no {what} in this folder", whole_file(path))
    return sorted(found)
