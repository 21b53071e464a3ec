"""The plane without anybody in it: floor, places, walls, and the places' names.

Coordinates are pixels with the room's upper left corner at (0, 0); a frame lies around it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from i2pdsl.render.ink import INK, mix
from i2pdsl.worlds.plane.spec import Place, PlaneSpec, Wall

WHITE, CREAM, BLACK = "#ffffff", "#fff3d9", "#000000"
FRAME = "#8b6f57"  # the rim of the room
LEAST = 5.0  # pixels: the radius below which nobody and no place is drawn
GRID = 22.0  # pixels between the lines of the floor, at least
DASH = 13.0  # pixels: about so long is a dash of a trail, with its gap


@dataclass(frozen=True)
class View:
    """A room at a scale, in pixels to a unit of the plane."""

    spec: PlaneSpec
    scale: float

    @cached_property
    def margin(self) -> float:
        """Pixels of frame around the room."""
        return min(max(0.4 * self.scale, 11.0), 18.0)

    @property
    def width(self) -> float:
        """In pixels, frame included."""
        return self.spec.width * self.scale + 2 * self.margin

    @property
    def height(self) -> float:
        """In pixels, frame included."""
        return self.spec.height * self.scale + 2 * self.margin

    @property
    def box(self) -> str:
        """The `viewBox`."""
        return f"{-self.margin:g} {-self.margin:g} {self.width:.2f} {self.height:.2f}"

    @property
    def text(self) -> float:
        """The size of names, in pixels."""
        return min(max(0.3 * self.scale, 11.0), 15.0)

    @property
    def trail(self) -> float:
        """The width of trails, in pixels."""
        return min(max(0.1 * self.scale, 3.0), 7.0)

    def pixels(self, points: np.ndarray) -> np.ndarray:
        """Points [..., 2] of the plane in pixels, y down."""
        points = np.asarray(points, float)
        return self.scale * (np.array([0.0, self.spec.height]) + points * np.array([1.0, -1.0]))

    def radius(self, number: int) -> float:
        """Of a character, in pixels."""
        return max(self.scale * self.spec.characters[number].radius, LEAST)

    def step(self, number: int) -> int:
        """The frames of a piece of a character's trail."""
        return max(1, round(DASH / (self.scale * self.spec.characters[number].speed)))


def view_within(spec: PlaneSpec, width: float, height: float) -> View:
    """The largest view of a room that is not larger than so many pixels."""
    scale = min(width / spec.width, height / spec.height)
    margin = View(spec, scale).margin
    inner = min((width - 2 * margin) / spec.width, (height - 2 * margin) / spec.height)
    return View(spec, max(inner, 1e-6))


def room_svg(view: View) -> str:
    """All that stands still, without the names."""
    spec = view.spec
    return "".join(
        (
            _floor(view),
            *(_rug(view, number, place) for number, place in enumerate(spec.places)),
            _shadows(view),
            _frame(view),
            *(_wall(view, wall) for wall in spec.walls),
        )
    )


def rect_svg(x: float, y: float, w: float, h: float, fill: str, more: str = "") -> str:
    return f'<rect x="{x:.1f}" y="{y:.1f}" width="{w:.1f}" height="{h:.1f}" fill="{fill}" {more}/>'


def _floor(view: View) -> str:
    """A quiet checker, its lines whole units apart."""
    spec, scale = view.spec, view.scale
    w, h = spec.width * scale, spec.height * scale
    steps = (s * 10.0**p for p in range(-3, 9) for s in (1, 2, 5))
    step = scale * next(s for s in steps if s * scale >= GRID)
    light = mix(spec.floor, WHITE, 0.16)
    squares = "".join(
        f"M{c * step:.1f} {max(h - (r + 1) * step, 0):.1f}V{h - r * step:.1f}"
        f"H{min((c + 1) * step, w):.1f}V{max(h - (r + 1) * step, 0):.1f}Z"
        for r in range(int(h / step - 1e-6) + 1)
        for c in range(int(w / step - 1e-6) + 1)
        if (c + r) % 2
    )
    # A little under the frame, too, lest a seam shows.
    floor = rect_svg(-1, -1, w + 2, h + 2, light)
    return floor + f'<path d="{squares}" fill="{mix(spec.floor, "#7a4a20", 0.03)}"/>'


def _frame(view: View) -> str:
    """The room's edge, seen from above, and what lies outside it."""
    m, w, h = view.margin, view.spec.width * view.scale, view.spec.height * view.scale
    across, down = w + 2 * m + 2, h + 2 * m + 2
    outside = f"M{-m - 1:.1f} {-m - 1:.1f}h{across:.1f}v{down:.1f}h{-across:.1f}Z"
    parts = [
        f'<path d="{outside}M0 0v{h:.1f}h{w:.1f}v{-h:.1f}Z" fill="{mix(FRAME, CREAM, 0.78)}"/>'
    ]
    for rim, color in ((0.5 * m, mix(FRAME, BLACK, 0.38)), (0.38 * m, mix(FRAME, BLACK, 0.1))):
        d = rim / 2
        edge = f'rx="{d:.1f}" stroke="{color}" stroke-width="{2 * d:.1f}"'
        parts.append(rect_svg(-d, -d, w + 2 * d, h + 2 * d, "none", edge))
    return "".join(parts)


def _thickness(view: View) -> float:
    """Of a wall, in pixels: thin, since discs come up to its middle."""
    return min(max(0.11 * view.scale, 3.0), 9.0)


def _outline(view: View, wall: Wall) -> str:
    points = view.pixels(np.array(wall.points))
    return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in points) + "Z" * wall.closed


def _shadows(view: View) -> str:
    """As one group: where two overlap it is no darker."""
    thick = _thickness(view)
    away = 0.55 * thick + 1
    drawn = "".join(
        f'<path d="{_outline(view, wall)}" fill="{INK if wall.closed else "none"}" '
        f'stroke="{INK}" stroke-width="{thick:.1f}"/>'
        for wall in view.spec.walls
    )
    return (
        f'<g opacity="0.18" stroke-linecap="round" stroke-linejoin="round" '
        f'transform="translate({0.7 * away:.1f} {away:.1f})">{drawn}</g>'
    )


def _wall(view: View, wall: Wall) -> str:
    """A wall seen from above: a light top with dark edges; a solid block is filled."""
    thick, outline = _thickness(view), _outline(view, wall)
    edge, top = mix(wall.color, BLACK, 0.42), mix(wall.color, CREAM, 0.3)
    round_ = 'stroke-linecap="round" stroke-linejoin="round"'
    fill = mix(wall.color, CREAM, 0.5) if wall.closed else "none"
    return (
        f'<path d="{outline}" fill="{fill}" stroke="{edge}" stroke-width="{thick:.1f}" {round_}/>'
        f'<path d="{outline}" fill="none" stroke="{top}" stroke-width="{0.45 * thick:.1f}" '
        f"{round_}/>"
    )


def _rug(view: View, number: int, place: Place) -> str:
    """A round rug; patterns tell those of similar colours apart."""
    (x, y), r = view.pixels(np.array(place.at)), max(view.scale * place.radius, LEAST)
    color, edge = place.color, mix(place.color, BLACK, 0.34)
    thin = min(max(0.05 * r, 0.8), 2.0)
    light = mix(color, WHITE, 0.38)
    return (
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{r:.1f}" fill="{mix(color, WHITE, 0.12)}" '
        f'stroke="{edge}" stroke-width="{1.3 * thin:.1f}"/>'
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{0.8 * r:.1f}" fill="none" '
        f'stroke="{mix(color, WHITE, 0.75)}" stroke-width="{thin:.1f}" '
        f'stroke-dasharray="{3 * thin:.1f} {2.2 * thin:.1f}"/>{_pattern(number, x, y, r, light)}'
    )


def _pattern(number: int, x: float, y: float, r: float, color: str) -> str:
    """The middle of a rug: a disc, a square, a lozenge, stripes or a triangle."""
    match number % 5:
        case 0:
            return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{0.45 * r:.1f}" fill="{color}"/>'
        case 1:
            a = 0.4 * r
            return rect_svg(x - a, y - a, 2 * a, 2 * a, color)
        case 2:
            a = 0.55 * r
            way = f"M{x:.1f} {y - a:.1f}l{a:.1f} {a:.1f}l{-a:.1f} {a:.1f}l{-a:.1f} {-a:.1f}Z"
        case 3:
            way = "".join(
                f"M{x + k * 0.34 * r - 0.09 * r:.1f} {y - 0.45 * r:.1f}h{0.18 * r:.1f}"
                f"v{0.9 * r:.1f}h{-0.18 * r:.1f}Z"
                for k in (-1, 0, 1)
            )
        case _:
            a = 0.55 * r
            way = f"M{x:.1f} {y - a:.1f}l{0.87 * a:.1f} {1.5 * a:.1f}h{-1.74 * a:.1f}Z"
    return f'<path d="{way}" fill="{color}"/>'
