"""All pictures of finished scripts: each kind of world draws its own."""

from __future__ import annotations

from collections.abc import Sequence

from i2pdsl.errors import error, whole_file
from i2pdsl.render.drawing import Drawing
from i2pdsl.render.files import FilmLook, PictureFiles
from i2pdsl.render.reasons import account_of
from i2pdsl.scripts import Script
from i2pdsl.worlds.kind import Spec
from i2pdsl.worlds.kinds import KINDS, drawing_named, drawing_of


def drawing_for(spec: Spec) -> Drawing:
    """What draws a kind of world."""
    found: Drawing = drawing_of(spec)
    return found


def page_scripts() -> tuple[str, ...]:
    """The modules, below `render`, that move films in pages: of each kind that has one."""
    found = (drawing_named(name).page_script() for name in KINDS)
    return tuple(script for script in found if script)


def pictures_of(
    scripts: Sequence[Script], title: str | None = None, look: FilmLook | None = None
) -> PictureFiles:
    """What draws a script, or several scripts side by side.

    Raises StoryError where they cannot be drawn together, or not as `look` wants it.
    """
    pictures = drawing_for(scripts[0].world.spec).pictures(scripts, title)
    if len(scripts) == 1:
        pictures.wishes = scripts[0].wishes
        pictures.note = "" if scripts[0].trust is None else scripts[0].trust.in_words()
        pictures.explained = lambda: account_of(scripts[0].shown())
    if look is not None:
        if look.transparent and not pictures.can_be_transparent:
            message = f"films of {scripts[0].world.name} cannot be transparent"
            where = whole_file(scripts[0].record.where)
            raise error("pictures", message, where, "those of worlds on a grid can")
        pictures.look = look
    return pictures
