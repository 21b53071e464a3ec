"""Worlds by name: a .world file beside the story, else one of the built-in ones. No JAX."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

from i2pdsl.errors import Diagnostic
from i2pdsl.language.statements import read_source
from i2pdsl.language.story import TypedStory
from i2pdsl.language.vocabulary import Settings, Vocabulary
from i2pdsl.resources import data_folder
from i2pdsl.worlds.drawings import beside
from i2pdsl.worlds.kind import Spec
from i2pdsl.worlds.kinds import kind_of, parse_world


def world_path(name: str, folder: Path | None) -> Path | None:
    """The .world file that a name or a path means, or None."""
    here = folder or Path()
    if name.endswith(".world"):
        candidates = [here / name]
    else:
        candidates = [here / f"{name}.world", data_folder("stories") / "worlds" / f"{name}.world"]
    return next((p for p in candidates if p.is_file()), None)


def builtin_worlds() -> list[str]:
    """The names of the worlds that come with i2pdsl."""
    return sorted(p.stem for p in (data_folder("stories") / "worlds").glob("*.world"))


def find_spec(name: str, folder: Path | None = None) -> Spec | None:
    """The description of a world, or None if there is none of this name.

    Raises StoryError if the file has mistakes.
    """
    path = world_path(name, folder)
    if path is None:
        return None
    return _load(path, path.stat().st_mtime_ns)


@lru_cache(maxsize=32)
def _load(path: Path, modified: int) -> Spec:
    return parse_world(read_source(path), path.stem, beside(path.parent))


def vocabulary_of(spec: Spec) -> Vocabulary:
    """The words of a world, with its settings."""
    return kind_of(spec).vocabulary(spec)


def find_vocabulary(
    name: str, folder: Path | None = None, settings: Settings = ()
) -> Vocabulary | None:
    """A world's vocabulary, or None if there is no such world.

    Raises StoryError if its file has mistakes.
    """
    path = world_path(name, folder)
    if path is None:
        return None
    modified = path.stat().st_mtime_ns
    if settings:
        return vocabulary_of(_load(path, modified).with_settings(dict(settings)))
    return _words(path, modified)


@lru_cache(maxsize=32)
def _words(path: Path, modified: int) -> Vocabulary:
    return vocabulary_of(_load(path, modified))


def world_warnings(
    name: str, folder: Path | None = None, story: TypedStory | None = None
) -> tuple[Diagnostic, ...]:
    """What is odd about a world, with a story's settings, without being a mistake."""
    path, spec = world_path(name, folder), find_spec(name, folder)
    if path is None or spec is None:
        return ()
    told = spec if story is None else spec.with_settings(dict(story.settings))
    return kind_of(spec).warnings(told, str(path), story)
