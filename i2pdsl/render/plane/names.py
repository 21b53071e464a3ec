"""The names in a room, on tags that keep clear of all that shall be seen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from xml.sax.saxutils import escape

import numpy as np

from i2pdsl.render.ink import mix
from i2pdsl.render.lettering import FONTS, fitted
from i2pdsl.render.plane.labels import Obstacles, Tag, placed
from i2pdsl.render.plane.performance import Performance
from i2pdsl.render.plane.room import BLACK, LEAST, WHITE, View, rect_svg
from i2pdsl.render.raster import text_width

ROOM = 130.0  # pixels: the width up to which names are written out in rooms that are wide enough


@dataclass(frozen=True)
class Name:
    """A name or a number beside a point of the plane.

    Attributes:
        reach: pixels from the point that it keeps away.
        size: of its letters, in pixels.
    """

    text: str
    at: np.ndarray
    reach: float
    size: float
    color: str


def place_names(view: View) -> list[Name]:
    """The names of the places."""
    return [
        Name(p.name, np.array(p.at), max(view.scale * p.radius, LEAST), view.text, p.color)
        for p in view.spec.places
    ]


def names_svg(view: View, names: Sequence[Name], performances: Sequence[Performance]) -> str:
    """Names on tags, clear of walls, places, the performances' ways with the discs at both ends,
    and each other."""
    spec = view.spec
    room = max(min(view.width - 16, ROOM), 0.4 * view.width)
    tags, texts = [], []
    for name in names:
        text = fitted(name.text, name.size, room, bold=True)
        x, y = view.pixels(name.at)
        wide = text_width(text, name.size, bold=True) + 10
        tags.append(Tag(x, y, name.reach, wide, 1.3 * name.size))
        texts.append(text)
    spots = [(*view.pixels(np.array(p.at)), view.scale * p.radius) for p in spec.places]
    for p in performances:
        for ends in (p.positions[0], p.positions[-1]):
            spots += [(*at, view.radius(k)) for k, at in enumerate(view.pixels(ends))]
    w, h, m = spec.width * view.scale, spec.height * view.scale, 0.9 * view.margin
    obstacles = Obstacles(
        (-m, -m, w + m, h + m),
        view.pixels(np.array(spec.segments).reshape(-1, 2, 2)),
        np.array(spots).reshape(-1, 3),
        view.pixels(np.concatenate([p.positions.reshape(-1, 2) for p in performances])),
    )
    return "".join(
        _tag(tag, at, text, name)
        for tag, at, text, name in zip(tags, placed(tags, obstacles), texts, names, strict=True)
    )


def _tag(tag: Tag, at: tuple[float, float], text: str, name: Name) -> str:
    """A name on a tag in light and dark shades of its colour."""
    (x, y), w, h = at, tag.width, tag.height
    style = f'rx="{h / 2:.1f}" stroke="{mix(name.color, BLACK, 0.3)}" stroke-width="1"'
    light = mix(name.color, WHITE, 0.86)
    return (
        f'<g class="name">{rect_svg(x - w / 2, y - h / 2, w, h, light, style)}'
        f'<text x="{x:.1f}" y="{y + 0.36 * name.size:.1f}" {FONTS} font-size="{name.size:.1f}" '
        f'font-weight="bold" text-anchor="middle" fill="{mix(name.color, BLACK, 0.68)}">'
        f"{escape(text)}</text></g>"
    )
