"""The kinds of worlds: the one table that names them. It is read to complete a word in a shell, so
what it does not need to name them is imported where it is used."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any

from i2pdsl.errors import Source, StoryError, did_you_mean, error, shorten
from i2pdsl.worlds.beginnings import Beginnings

if TYPE_CHECKING:
    from i2pdsl.worlds.blocks import Syntax
    from i2pdsl.worlds.drawings import Files
    from i2pdsl.worlds.kind import Kind, Spec


@dataclass(frozen=True)
class Place:
    """Where a kind is: modules that have a `KIND`, a `DRAWING` and its `BEGINNINGS`, if it has any,
    imported when they are used."""

    worlds: str
    drawing: str
    beginnings: str = ""


USUAL = "grid"  # of files that name none
KINDS = {
    USUAL: Place(
        "i2pdsl.worlds.grid.kind", "i2pdsl.render.grid.drawing", "i2pdsl.worlds.grid.beginnings"
    ),
    "hill": Place(
        "i2pdsl.worlds.hill.kind", "i2pdsl.render.hill.drawing", "i2pdsl.worlds.hill.beginnings"
    ),
    "plane": Place(
        "i2pdsl.worlds.plane.kind", "i2pdsl.render.plane.drawing", "i2pdsl.worlds.plane.beginnings"
    ),
}


def kind_named(name: str) -> Kind:
    """A kind of the table."""
    found: Kind = import_module(KINDS[name].worlds).KIND
    return found


def drawing_named(name: str) -> Any:
    """What draws a kind of the table (render/drawing.py)."""
    return import_module(KINDS[name].drawing).DRAWING


def beginnings_named(name: str) -> Beginnings:
    """What stories in a kind of the table can begin as."""
    place = KINDS[name].beginnings
    found: Beginnings = import_module(place).BEGINNINGS if place else Beginnings()
    return found


def kind_of(spec: Spec) -> Kind:
    """The kind of a world."""
    return kind_named(spec.kind)


def kind_of_file(source: Source) -> Kind:
    """The kind of world that a file says it is. Raises StoryError where there is none."""
    from i2pdsl.worlds.blocks import kind_said

    said = kind_said(source)
    if said is None:
        return kind_named(USUAL)
    name, span = said
    if name not in KINDS:
        known = ", ".join(KINDS)
        message = f"there is no kind of world `{shorten(name)}`" if name else "which kind of world?"
        hint = (did_you_mean(name, KINDS) if name else None) or f"`kind = NAME`; kinds: {known}"
        raise error("world-kind", message, span, hint)
    return kind_named(name)


def parse_world(source: Source, name: str, files: Files | None = None) -> Spec:
    """A world from the text of its file. Raises StoryError with all its mistakes.

    Args:
        files: where its own sprites are; without it they are not looked at.
    """
    return kind_of_file(source).parse(source, name, files)


def syntax_of(source: Source) -> Syntax:
    """The syntax of a world's file; the usual one where it names no kind that there is."""
    try:
        return kind_of_file(source).syntax
    except StoryError:
        return kind_named(USUAL).syntax


def format_world(source: Source) -> str:
    """The text of a world's file in the usual layout. Raises StoryError."""
    return kind_of_file(source).syntax.formatted(source)


def drawing_of(spec: Spec) -> Any:
    """What draws a kind of world (render/drawing.py)."""
    return drawing_named(spec.kind)


def beginnings_of(spec: Spec) -> Beginnings:
    """What stories in a kind of world can begin as."""
    return beginnings_named(spec.kind)
