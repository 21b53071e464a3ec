"""The names in a room, on tags that keep clear of all that shall be seen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from xml.sax.saxutils import escape

import numpy as np

from i2pdsl.render.ink import mix
from i2pdsl.render.lettering import FONTS, fitted
from i2pdsl.render.plane.labels import Obstacles, Tag, gap, placed
from i2pdsl.render.plane.performance import Performance
from i2pdsl.render.plane.room import BLACK, LEAST, WHITE, View, rect_svg
from i2pdsl.render.raster import text_width

FAR = 6.0  # pixels: a name that is farther from what it names has a line to it
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
    places = placed(tags, obstacles)
    drawn = list(zip(tags, places, texts, names, strict=True))
    leaders = "".join(_leader(tag, at, name) for tag, at, _, name in drawn)
    return leaders + "".join(_tag(*one) for one in drawn)


def _leader(tag: Tag, at: tuple[float, float], name: Name) -> str:
    """A line to a tag from the edge of what it names, where the two are apart."""
    if gap(tag, at, tag) <= FAR:
        return ""
    (x, y), level = at, (tag.width - tag.height) / 2
    middle = np.array([tag.x, tag.y])
    end = np.clip(middle, (x - level, y), (x + level, y))
    begin = middle + (end - middle) * tag.reach / np.hypot(*(end - middle))
    return (
        f'<path class="leader" d="M{begin[0]:.1f} {begin[1]:.1f}L{end[0]:.1f} {end[1]:.1f}" '
        f'stroke="{mix(name.color, BLACK, 0.4)}" stroke-width="1.6"/>'
    )


def _tag(tag: Tag, at: tuple[float, float], text: str, name: Name) -> str:
    """A name on a tag in light and dark shades of its colour."""
    (x, y), w, h = at, tag.width, tag.height
    style = f'rx="{h / 2:.1f}" stroke="{mix(name.color, BLACK, 0.3)}" stroke-width="1"'
    box = rect_svg(x - w / 2, y - h / 2, w, h, mix(name.color, WHITE, 0.86), style)
    return (
        f'<g class="name">{box}'
        f'<text x="{x:.1f}" y="{y + 0.36 * name.size:.1f}" {FONTS} font-size="{name.size:.1f}" '
        f'font-weight="bold" text-anchor="middle" fill="{mix(name.color, BLACK, 0.68)}">'
        f"{escape(text)}</text></g>"
    )
