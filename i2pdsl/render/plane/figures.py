"""The characters of a plane, drawn: discs with eyes that look where they try to go, and trails."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from PIL import ImageColor

from i2pdsl.render.ink import INK, mix
from i2pdsl.render.lettering import fitted, text_svg
from i2pdsl.render.plane.performance import Performance
from i2pdsl.render.plane.room import View
from i2pdsl.render.raster import text_width
from i2pdsl.worlds.plane.spec import PlaneCharacter, PlaneSpec

# In hundredths of a disc's radius: how far face and pupils move with the gaze, y down.
FACE, PUPIL = (24, -20), (11, -13)
FAINT, STRONG = 0.35, 0.9  # opacity of a trail's oldest and of its newest piece
THIN = 0.45  # the width of its oldest piece, and of ways older than it, of the newest one's
DASHED = 1  # the character from which on trails are dashed, and discs wear a dashed belt
DASH = 0.58  # of a piece of a dashed trail is drawn; the rest is a gap
LINE = 'fill="none" stroke-linejoin="round"'
TRAIL = 30.0  # frames over which trails fade in films
KEY = 14.0  # pixels: the letters of a key
PALE = 130.0  # trails are darker than this, from 0 to 255
GHOST = 0.3  # opacity of where a trail begins

_EYES = "".join(
    f'<ellipse cx="{x}" cy="-10" rx="24" ry="29" fill="#fff" stroke="{INK}" stroke-width="7"/>'
    for x in (-29, 29)
)
_PUPILS = "".join(f'<circle cx="{x}" cy="-10" r="13" fill="{INK}"/>' for x in (-29, 29))
_MOUTH = (
    f'<path d="M-20 36q20 17 40 0" fill="none" stroke="{INK}" stroke-width="8" '
    'stroke-linecap="round"/>'
)


def tint(character: PlaneCharacter) -> str:
    """The colour of a character's trail: its own, dark enough for a light floor."""
    shades = (mix(character.color, "#2a1a10", share) for share in (0.3, 0.4, 0.5, 0.6))
    return next((shade for shade in shades if _lightness(shade) < PALE), INK)


def _lightness(color: str) -> float:
    """Of a colour as #rrggbb: luma, from 0 to 255 (ITU-R BT.601)."""
    return float(np.dot(ImageColor.getrgb(color)[:3], (0.299, 0.587, 0.114)))


# ---------------------------------------------------------------------------------------- discs


def figure_svg(
    character: PlaneCharacter,
    number: int,
    place: np.ndarray,
    radius: float,
    gaze: np.ndarray,
) -> str:
    """A disc of a radius at a place (pixels, y down) that looks along `gaze` (y up)."""
    color = character.color
    belt = ""
    if number >= DASHED:
        belt = (
            f'<circle r="82" fill="none" stroke="{mix(color, "#ffffff", 0.75)}" stroke-width="10" '
            'stroke-dasharray="25.8 17.1"/>'
        )
    face, pupils = face_moves(gaze)
    return (
        f'<g class="figure" transform="{placed_at(place, radius)}">'
        f'<circle r="94" fill="{color}" stroke="{INK}" stroke-width="12"/>'
        '<path d="M-62 62a88 88 0 0 0 124 0a100 100 0 0 1 -124 0" '
        f'fill="{INK}" fill-opacity="0.14"/>'
        f'{belt}<ellipse cx="-42" cy="-62" rx="22" ry="11" transform="rotate(-36 -42 -62)" '
        f'fill="#fff" fill-opacity="0.45"/><g class="face" transform="{face}">{_EYES}{_MOUTH}'
        f'<g class="pupils" transform="{pupils}">{_PUPILS}</g></g></g>'
    )


def placed_at(place: np.ndarray, radius: float) -> str:
    """The transform of what is drawn in hundredths of a radius."""
    return f"translate({place[0]:.2f} {place[1]:.2f}) scale({radius / 100:.4f})"


def face_moves(gaze: np.ndarray) -> tuple[str, str]:
    """The transforms of face and pupils."""
    face, pupils = (f"translate({gaze[0] * dx:.2f} {gaze[1] * dy:.2f})" for dx, dy in (FACE, PUPIL))
    return face, pupils


def shadow_svg(place: np.ndarray, radius: float) -> str:
    """The shadow beside a disc that light from the upper left falls on."""
    return (
        f'<g class="shadow" transform="{placed_at(place, radius)}">'
        f'<circle cx="10" cy="16" r="100" fill="{INK}" fill-opacity="0.2"/></g>'
    )


def cast_svg(performance: Performance, view: View, time: float) -> str:
    """Everybody at a time, with shadows."""
    places, gazes = performance.at(time)
    points = view.pixels(places)
    characters = performance.spec.characters
    drawn = [shadow_svg(point, view.radius(k)) for k, point in enumerate(points)]
    drawn += [
        figure_svg(c, k, points[k], view.radius(k), gazes[k]) for k, c in enumerate(characters)
    ]
    return "".join(drawn)


def ghosts_svg(performance: Performance, view: View, time: float) -> str:
    """Everybody at a time, faintly: where they came from."""
    places, gazes = performance.at(time)
    points = view.pixels(places)
    drawn = (
        figure_svg(c, k, points[k], view.radius(k), gazes[k])
        for k, c in enumerate(performance.spec.characters)
    )
    return f'<g opacity="{GHOST}">{"".join(drawn)}</g>'


# --------------------------------------------------------------------------------------- trails


@dataclass(frozen=True)
class Piece:
    """A piece of a trail: from one time to another, and how strong it is, from 0 to 1."""

    first: float
    last: float
    strength: float

    @property
    def opacity(self) -> float:
        return FAINT + (STRONG - FAINT) * self.strength

    @property
    def width(self) -> float:
        """In widths of the trail."""
        return THIN + (1 - THIN) * self.strength


def trail_pieces(first: float, last: float, step: float, span: float, number: int) -> list[Piece]:
    """The trail of a character from time `first` to `last`, the end of what fades over `span`.

    It is cut at multiples of `step` frames, so that the dashes of a trail that grows stay where
    they are.
    """
    part = DASH if number >= DASHED else 1.0
    edges = step * np.arange(np.floor(first / step), np.ceil(last / step))
    found = []
    for edge in edges.tolist():
        begin, end = max(edge, first), min(edge + part * step, last)
        if begin < end:
            found.append(Piece(begin, end, max(0.0, 1 - (last - end) / span)))
    return found


def trail_svg(
    performance: Performance, view: View, number: int, first: float, last: float, span: float
) -> str:
    """The trail of a character, as in `trail_pieces`."""
    color = tint(performance.spec.characters[number])
    parts = []
    for piece in trail_pieces(first, last, view.step(number), span, number):
        points = view.pixels(performance.way(number, piece.first, piece.last))
        parts.append(
            f'<path d="{line_data(points)}" {LINE} stroke="{color}" '
            f'stroke-width="{piece.width * view.trail:.2f}" stroke-opacity="{piece.opacity:.3f}"/>'
        )
    return "".join(parts)


def line_data(points: Sequence[Sequence[float]] | np.ndarray) -> str:
    """Path data through points [k, 2] in pixels."""
    return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in points)


def way_style(performance: Performance, view: View, number: int) -> str:
    """How the way before its trail is drawn, thin and faint, as attributes."""
    thin = THIN * view.trail
    dashes = f' stroke-dasharray="{4 * thin:.1f} {3 * thin:.1f}"' if number >= DASHED else ""
    color = tint(performance.spec.characters[number])
    return f'{LINE} stroke="{color}" stroke-width="{thin:.2f}" stroke-opacity="{FAINT}"{dashes}'


# ------------------------------------------------------------------------------------- the scene


def scene_svg(performance: Performance, view: View, first: float, time: float, span: float) -> str:
    """What moves, at a time: trails since `first`, and everybody."""
    trails = "".join(
        trail_svg(performance, view, number, first, time, span)
        for number in range(len(performance.spec.characters))
    )
    return trails + cast_svg(performance, view, time)


def film_svg(performance: Performance, view: View, time: float) -> str:
    """What moves in films, at a time: trails of the last frames and the ways before, everybody."""
    first = max(time - TRAIL, 0.0)
    ways = "".join(
        f'<path d="{line_data(view.pixels(performance.way(number, 0, first)))}" '
        f"{way_style(performance, view, number)}/>"
        for number in range(len(performance.spec.characters))
    )
    return ways + scene_svg(performance, view, first, time, TRAIL)


def key_svg(spec: PlaneSpec, x: float, y: float, room: float) -> str:
    """Who is who, and whose trail is which: a row 22 pixels high below a point."""
    parts = []
    names = [fitted(c.name, KEY, room / len(spec.characters) - 80) for c in spec.characters]
    for number, (character, name) in enumerate(zip(spec.characters, names, strict=True)):
        dashes = ' stroke-dasharray="7 5"' if number >= DASHED else ""
        parts.append(
            f'<path d="M{x:.1f} {y + 11:.1f}h40" {LINE} stroke="{tint(character)}" '
            f'stroke-width="4"{dashes}/>'
            f"{figure_svg(character, number, np.array([x + 40, y + 11]), 10, np.zeros(2))}"
            f"{text_svg(x + 56, y + 16, name, KEY)}"
        )
        x += 56 + text_width(name, KEY) + 24
    return "".join(parts)
