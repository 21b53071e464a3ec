"""The hopper, its rope and its box, drawn: a lamp with a springy spine, and a crate of planks."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np

from i2pdsl.render.hill.rig import (
    SAG,
    Part,
    Weights,
    bend,
    coil,
    dot,
    grounded,
    joined,
    line,
    node,
    path_data,
    pose_vector,
    smooth,
    unit,
)
from i2pdsl.render.ink import INK, mix
from i2pdsl.worlds.hill.hopper import BOX_OUTLINE, HAND, HOOK, MUSCLES

# Of the box. They tell performances apart and say nothing of the weight.
CRATES = ("#d9a25f", "#7fa3c2", "#c9829b", "#8fb07a")
BODY, BASE, RUBBER, ROPE = "#4fa6a0", "#5b6675", "#39404c", "#efe0c0"
SHORT, IDLE, LONG = "#e0472f", "#f3ead8", "#3f6fd8"  # a muscle that pulls, rests, pushes
LAYERS = ("shadow", "box", "rope", "hopper")
OUTLINE = 2.4

Shape = tuple[str, np.ndarray]


@cache
def rig(crate: str = CRATES[0]) -> dict[str, tuple[Part, ...]]:
    """All parts by layer, those in front last. `crate` is the box's colour."""
    return {
        "shadow": tuple(_shadows()),
        "box": tuple(_crate(crate)),
        "rope": tuple(_rope()),
        "hopper": tuple(_hopper()),
    }


def pose_svg(
    positions: np.ndarray,
    pull: np.ndarray,
    slope: float,
    crate: str = CRATES[0],
    layers: Sequence[str] = LAYERS,
) -> str:
    """A pose, [2, 19], with its muscles' pull [6] from -1 to 1, as SVG elements in SVG units."""
    parts = rig(crate)
    vector = pose_vector(positions, slope)
    return "".join(part_svg(part, vector, pull) for layer in layers for part in parts[layer])


def part_svg(part: Part, vector: np.ndarray, pull: np.ndarray) -> str:
    """One part at a pose."""
    tint = "" if part.muscle is None else f' stroke="{muscle_color(pull[part.muscle])}"'
    return f'<path d="{path_data(part.shape, part.points @ vector)}" {part.style}{tint}/>'


def muscle_color(pull: float) -> str:
    """Red where a muscle pulls its ends together, blue where it pushes them apart."""
    return mix(IDLE, SHORT if pull < 0 else LONG, min(abs(float(pull)), 1.0))


def _stroke(color: str, width: float, more: str = "") -> str:
    round_ = 'fill="none" stroke-linecap="round" stroke-linejoin="round"'
    return f'{round_} stroke="{color}" stroke-width="{width:g}"{more}'


def _fill(color: str, outline: float = OUTLINE) -> str:
    return (
        f'fill="{color}" stroke="{INK}" stroke-width="{outline:g}" stroke-linejoin="round" '
        'stroke-linecap="round"'
    )


def _inked(shape: Shape, color: str, width: float) -> list[Part]:
    """A line with an outline."""
    inked = Part(*shape, _stroke(INK, width + 2 * OUTLINE * 0.8))
    return [inked, Part(*shape, _stroke(color, width))]


def _shadows() -> list[Part]:
    style = _stroke(INK, 13, ' stroke-opacity="0.16"')
    return [
        Part(*line(grounded(0), grounded(1)), style),
        Part(*line(*(grounded(k) for k in BOX_OUTLINE)), style),
    ]


# -------------------------------------------------------------------------------------- the box


def _crate(color: str) -> list[Part]:
    """Planks along it, battens across, a metal band at both ends."""
    dark, light = mix(color, INK, 0.34), mix(color, "#ffffff", 0.28)
    columns = ((11, 12), (13, 14), (15, 16), (17, 18))  # below and above, from the hook's end

    def along(share: float) -> Shape:
        return line(*(node(low) + share * (node(high) - node(low)) for low, high in columns))

    def across(low: Weights, high: Weights) -> Shape:
        return line(low + 0.06 * (high - low), high - 0.06 * (high - low))

    outline = line(*(node(k) for k in BOX_OUTLINE), closed=True)
    parts = [Part(*outline, _fill(INK, 12))]
    parts.append(Part(*outline, f'fill="{color}" stroke="{color}" stroke-width="7.5" '
                                'stroke-linejoin="round"'))  # fmt: skip
    parts.append(Part(*along(0.92), _stroke(light, 3)))
    parts += [Part(*along(share), _stroke(dark, 1.8)) for share in (0.32, 0.66)]
    inner = [across(node(low), node(high)) for low, high in columns[1:3]]
    outer = [across(node(low), node(high)) for low, high in (columns[0], columns[3])]
    for shape in inner:
        parts += [Part(*shape, _stroke(dark, 8.5)), Part(*shape, _stroke(light, 5.5))]
    for shape in outer:
        parts += [Part(*shape, _stroke(dark, 10)), Part(*shape, _stroke(mix(color, INK, 0.16), 7))]
    nails = joined(
        dot(node(low) + share * (node(high) - node(low)))
        for low, high in columns
        for share in (0.12, 0.88)
    )
    parts.append(Part(*nails, _stroke(INK, 2.6)))
    return parts


def _rope() -> list[Part]:
    middle = (node(HAND) + node(HOOK)) / 2 + 2 * SAG
    shape = ("MQ", np.stack([node(HAND), middle, node(HOOK)]))
    twist = Part(*shape, _stroke(mix(ROPE, INK, 0.4), 3.2, ' stroke-dasharray="1.2 4.6"'))
    ring = [Part(*dot(node(HOOK)), _stroke(INK, 11)), Part(*dot(node(HOOK)), _stroke(ROPE, 6))]
    return [*_inked(shape, ROPE, 3.2), twist, *ring]


# ----------------------------------------------------------------------------------- the hopper


def _hopper() -> list[Part]:
    return [*_base(), *_spine(), *_muscles(), *_belt(), *_head()]


def _base() -> list[Part]:
    """An arch from foot to foot with the hips as its keystone, and rubber soles."""
    left, right, hips, along = node(0), node(1), node(2), unit(0, 1)
    up = 1j * along
    top = hips + 0.9 * up
    outside = bend(
        left - 1.0 * along - 0.1 * up,
        (left - 0.9 * along + 1.5 * up, hips - 2.6 * along + 0.5 * up, top),
        (hips + 2.6 * along + 0.5 * up, right + 0.9 * along + 1.5 * up,
         right + 1.0 * along - 0.1 * up),
        (right + 0.6 * along - 0.1 * up, right - 0.4 * along - 0.1 * up, right - 0.9 * along),
        (right - 1.2 * along + 1.0 * up, left + 1.2 * along + 1.0 * up, left + 0.9 * along),
    )  # fmt: skip
    shine = bend(
        left - 0.2 * along + 0.9 * up,
        (left + 0.2 * along + 1.6 * up, hips - 2.2 * along, hips - 0.8 * along + 0.35 * up),
        closed=False,
    )
    soles = [line(foot - 0.75 * along, foot + 0.75 * along) for foot in (left, right)]
    return [
        Part(*outside, _fill(BASE)),
        Part(*shine, _stroke(mix(BASE, "#ffffff", 0.4), 2.6)),
        *(part for sole in soles for part in _inked(sole, RUBBER, 7)),
    ]


def _spine() -> list[Part]:
    """Two beads and a neck, pinched where the triangles of the spine meet."""
    low, middle, high = unit(3, 4), unit(6, 7), unit(9, 10)
    waist, neck = (low + middle) / 2, (middle + high) / 2
    left = [node(2) - 1.2 * low, node(3) + 0.1 * low, node(5) - 1.15 * waist,
            node(6) + 0.1 * middle, node(8) - 1.0 * neck, node(9) + 0.5 * high]  # fmt: skip
    right = [node(2) + 1.2 * low, node(4) - 0.1 * low, node(5) + 1.15 * waist,
             node(7) - 0.1 * middle, node(8) + 1.0 * neck, node(10) - 0.5 * high]  # fmt: skip
    rim = [node(9) + 0.5 * high + 0.5j * high, node(10) - 0.5 * high + 0.5j * high]
    shine = [node(2) + 0.5 * (node(3) - node(2)) + 0.5 * low, node(3) + 0.9 * low,
             node(5) - 0.5 * waist, node(6) + 0.9 * middle, node(8) - 0.3 * neck]  # fmt: skip
    pleats = [line(node(k) - 0.7 * w, node(k) + 0.7 * w) for k, w in ((5, waist), (8, neck))]
    return [
        Part(*smooth([*left, *rim, *reversed(right)], closed=True), _fill(BODY)),
        Part(*smooth(shine), _stroke(mix(BODY, "#ffffff", 0.45), 3)),
        Part(*joined(pleats), _stroke(mix(BODY, INK, 0.5), 2)),
        Part(*dot(node(2)), _stroke(INK, 15)),
        Part(*dot(node(2)), _stroke(mix(BASE, "#ffffff", 0.55), 10)),
        Part(*dot(node(2)), _stroke(INK, 3.5)),
    ]


def _muscles() -> list[Part]:
    """Coil springs on both sides, hung on pins, coloured by their pull."""
    parts = []
    for number, (first, second) in enumerate(MUSCLES):
        shape = coil(first, second, 4, 0.5)
        parts.append(Part(*shape, _stroke(INK, 5.2)))
        style = 'fill="none" stroke-linecap="round" stroke-linejoin="round" stroke-width="2.7"'
        parts.append(Part(*shape, style, number))
    pins = joined(dot(node(k)) for k in (3, 4, 6, 7, 9, 10))
    return [*parts, Part(*pins, _stroke(INK, 7)), Part(*pins, _stroke("#fff3d9", 3.4))]


def _belt() -> list[Part]:
    """The rope's end, tied around the body."""
    around = unit(6, 7)
    loop = bend(
        node(HAND),
        (node(HAND) + 1.1 * around - 0.75j * around, node(7) - 1.1 * around - 0.75j * around,
         node(7)),
        closed=False,
    )  # fmt: skip
    knot = dot(node(HAND))
    return [*_inked(loop, ROPE, 3.2), Part(*knot, _stroke(INK, 10)), Part(*knot, _stroke(ROPE, 6))]


def _head() -> list[Part]:
    """A lamp shade that opens uphill, an eye for a bulb."""
    ahead = unit(9, 10) * np.exp(0.17j)
    root = (node(9) + node(10)) / 2

    def at(x: float, y: float) -> Weights:
        return root + (x + 1j * y) * ahead

    neck = line(root, at(-0.1, 1.5))
    shade = bend(
        at(-2.5, 3.6),
        (at(-1.2, 4.0), at(0.2, 4.6), at(1.7, 5.5)),
        (at(3.1, 4.6), at(3.1, 1.0), at(1.7, 0.1)),
        (at(0.2, 0.9), at(-1.2, 1.4), at(-2.5, 1.8)),
        (at(-3.1, 2.2), at(-3.1, 3.2), at(-2.5, 3.6)),
    )
    opening = bend(
        at(1.7, 5.5),
        (at(2.75, 4.7), at(2.75, 0.9), at(1.7, 0.1)),
        (at(0.65, 0.9), at(0.65, 4.7), at(1.7, 5.5)),
    )
    cap = bend(
        at(-2.5, 3.6),
        (at(-3.1, 3.2), at(-3.1, 2.2), at(-2.5, 1.8)),
        (at(-1.9, 2.2), at(-1.9, 3.2), at(-2.5, 3.6)),
    )
    shine = bend(at(-1.6, 3.45), (at(-0.7, 3.7), at(0.0, 4.0), at(0.7, 4.4)), closed=False)
    eye, pupil, glint = dot(at(1.95, 2.8)), dot(at(2.55, 2.85)), dot(at(2.75, 3.3))
    return [
        *_inked(neck, mix(BASE, "#ffffff", 0.3), 8),
        Part(*shade, _fill(BODY)),
        Part(*shine, _stroke(mix(BODY, "#ffffff", 0.5), 3)),
        Part(*cap, _fill(mix(BODY, INK, 0.25))),
        Part(*opening, _fill("#ffe9a8")),
        Part(*eye, _stroke(INK, 33)),
        Part(*eye, _stroke("#ffffff", 29)),
        Part(*pupil, _stroke(INK, 14)),
        Part(*glint, _stroke("#ffffff", 4.6)),
    ]
