"""The hill without anybody on it: sky, far hills, turf, soil, and a scale along the slope.

What lies on the slope is drawn level and then sheared by its angle, so that it runs along the
slope and posts stand upright. Everything repeats in the same irregular way wherever one looks.
"""

from __future__ import annotations

from itertools import pairwise
from math import ceil, cos, degrees, floor, sin

from i2pdsl.render.hill.rig import SCALE
from i2pdsl.render.ink import mix
from i2pdsl.render.lettering import FONTS

SKY, SUN = "#fdf3df", "#fbe0a6"
FAR, NEAR = "#efdfc4", "#e3cfae"  # the two ranges of hills
TURF, LIP, SOIL = "#b4c487", "#94a967", "#c49a72"
MARK = "#fff6e4"
BACK, FRONT = 0.9, 1.9  # of the turf, in world units behind and before the nodes' line
DEPTH = 60.0  # of the soil: more than any picture shows
FAR_SHARE, NEAR_SHARE = 0.12, 0.3  # how much of the camera's way the ranges follow


def sky_svg(left: float, top: float, width: float, height: float) -> str:
    """Behind everything, in the picture's own coordinates."""
    radius = 0.16 * height
    return (
        f'<rect x="{left:.1f}" y="{top:.1f}" width="{width:.1f}" height="{height:.1f}" '
        f'fill="{SKY}"/><circle cx="{left + 0.8 * width:.1f}" cy="{top + 0.27 * height:.1f}" '
        f'r="{radius:.1f}" fill="{SUN}"/>'
    )


def range_svg(which: int, first: float, last: float, crest: float) -> str:
    """A range of hills from `first` to `last` (world units), about as high as `crest`."""
    color, pitch, rise = ((FAR, 34.0, 5.0), (NEAR, 22.0, 3.2))[which]
    numbers = range(floor(first / pitch) - 1, ceil(last / pitch) + 2)
    tops = [
        (n * pitch, crest + rise * sin(2.4 * n + which) * (0.6 + 0.4 * sin(n))) for n in numbers
    ]
    path = f"M{_at(*tops[0])}"
    for (x0, y0), (x1, y1) in pairwise(tops):
        middle = (x0 + x1) / 2
        path += f"C{_at(middle, y0)} {_at(middle, y1)} {_at(x1, y1)}"
    floor_ = -DEPTH
    return (
        f'<path d="{path}L{_at(tops[-1][0], floor_)} {_at(tops[0][0], floor_)}Z" fill="{color}"/>'
    )


def ground_svg(slope: float, first: float, last: float, origin: float) -> str:
    """The slope from `first` to `last`; its scale counts from `origin` (x, world units)."""
    left, width = SCALE * first, SCALE * (last - first)
    bands = [
        f'<rect x="{left:.1f}" y="{SCALE * y:.1f}" width="{width:.1f}" '
        f'height="{SCALE * high:.1f}" fill="{color}"/>'
        for y, high, color in (
            (FRONT, DEPTH, SOIL),
            (FRONT + 6.5, DEPTH, mix(SOIL, "#6b4326", 0.16)),
            (-BACK, BACK + FRONT, TURF),
        )
    ]
    steps = range(floor(first), ceil(last) + 1)
    parts = [
        "".join(_shrub(n) for n in steps if n % 19 == 7),
        *bands,
        _lip(first, last),
        f'<path d="{"".join(_tuft(n) for n in steps if n % 3 == 0)}" fill="none" '
        f'stroke="{LIP}" stroke-width="1.6" stroke-linecap="round"/>',
        "".join(_stone(n) for n in steps if n % 7 == 3),
        _scale(slope, first, last, origin),
    ]
    return f'<g transform="skewY({-degrees(slope):.3f})">{"".join(parts)}</g>'


def _at(x: float, y: float) -> str:
    return f"{SCALE * x:.1f} {-SCALE * y:.1f}"


def _chance(number: int, salt: int) -> float:
    """Between 0 and 1, the same for the same numbers everywhere."""
    return ((number * 7919 + salt * 104729) * 2654435761 % 2**32) / 2**32


def _lip(first: float, last: float) -> str:
    """The turf's scalloped front edge."""
    start, count = floor(first / 2), ceil(last / 2) - floor(first / 2)
    step, y = 2 * SCALE, SCALE * FRONT
    path = f"M{step * start} {y - 4:.1f}v4" + f"q{step / 2:g} 9 {step:g} 0" * count + "v-4Z"
    return f'<path d="{path}" fill="{LIP}"/>'


def _tuft(n: int) -> str:
    x, y = SCALE * (n + 2 * _chance(n, 1)), SCALE * (-0.4 + 1.9 * _chance(n, 2))
    return f"M{x:.1f} {y:.1f}l-2.5 -4.5M{x + 1.5:.1f} {y:.1f}v-6M{x + 3:.1f} {y:.1f}l2.5 -4.5"


def _stone(n: int) -> str:
    x, y = SCALE * (n + 5 * _chance(n, 3)), SCALE * (FRONT + 4.8 + 6 * _chance(n, 4))
    size = 3 + 5 * _chance(n, 5)
    shade = mix(SOIL, "#fff3d9" if _chance(n, 6) > 0.5 else "#6b4326", 0.28)
    return (
        f'<ellipse cx="{x:.1f}" cy="{y:.1f}" rx="{size:.1f}" ry="{0.62 * size:.1f}" '
        f'fill="{shade}"/>'
    )


def _shrub(n: int) -> str:
    """A bush behind the turf, in the far hills' quiet colours."""
    x, y, size = SCALE * (n + 4 * _chance(n, 7)), -SCALE * BACK + 2, 9 + 8 * _chance(n, 8)
    color = mix(TURF, NEAR, 0.45)
    return "".join(
        f'<circle cx="{x + dx * size:.1f}" cy="{y - dy * size:.1f}" r="{r * size:.1f}" '
        f'fill="{color}"/>'
        for dx, dy, r in ((-0.8, 0.25, 0.7), (0, 0.6, 0.95), (0.85, 0.2, 0.65))
    )


def _scale(slope: float, first: float, last: float, origin: float) -> str:
    """A line for each unit of way up the slope, a longer one for each five, numbers for tens."""
    to_x = cos(slope)
    begin, end = ceil((first - origin) / to_x), floor((last - origin) / to_x)
    top = SCALE * (FRONT + 1.1)
    path, numbers = "", ""
    for way in range(begin, end + 1):
        if way % 5:
            continue
        x = SCALE * (origin + way * to_x)
        path += f"M{x:.1f} {top:.1f}v{14 if way % 10 == 0 else 7}"
        if way % 10 == 0:
            told = f"{way}".replace("-", "−")
            numbers += f'<text x="{x:.1f}" y="{top + 31:.1f}">{told}</text>'
    return (
        f'<path d="{path}" stroke="{MARK}" stroke-width="2.6" stroke-linecap="round"/>'
        f'<g {FONTS} font-size="16" font-weight="bold" fill="{MARK}" text-anchor="middle">'
        f"{numbers}</g>"
    )
