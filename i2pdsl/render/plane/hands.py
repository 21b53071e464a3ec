"""Somebody in a plane who is put somewhere by hand: where that can be."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from i2pdsl.language import typed as ty
from i2pdsl.language.story import TypedStory
from i2pdsl.objective.starts import allowed_starts
from i2pdsl.render.plane.page import page_view
from i2pdsl.worlds.plane.features import NEAR
from i2pdsl.worlds.plane.geometry import Ways, clearance, norm
from i2pdsl.worlds.plane.spec import PlaneSpec
from i2pdsl.worlds.plane.world import PlaneWorld

CELL = 8.0  # pixels of the picture: what can be reached is told so finely
MOST_CELLS = 6000
DIGITS = 2  # behind the point, of a place in a story

Box = tuple[float, float, float, float]


def reached(world: PlaneWorld, story: TypedStory, frame: int, who: int) -> list[Box]:
    """Stretches of the picture where somebody can be in a frame, as boxes (x, y, width, height) in
    pixels: those from which no other pin of it is too far away, nor where it begins.

    Who is pushed goes as fast as whoever pushes.
    """
    spec, view = world.spec, page_view(world.spec)
    fastest = max(c.fastest for c in spec.characters)
    across, down = spec.width * view.scale, spec.height * view.scale
    cell = max(CELL, float(np.sqrt(across * down / MOST_CELLS)))
    columns, rows = (max(1, round(length / cell)) for length in (across, down))
    x = (np.arange(columns) + 0.5) * spec.width / columns
    y = spec.height - (np.arange(rows) + 0.5) * spec.height / rows
    points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    is_open = can_stand(spec, who, points)
    for number, at, slack in _known(world, story, who):
        if number != frame:
            way = _lengths(spec, who, points, at)
            is_open &= way <= abs(frame - number) * fastest + slack
    return list(_boxes(is_open.reshape(rows, columns), across / columns, down / rows))


def can_stand(spec: PlaneSpec, who: int, points: np.ndarray) -> np.ndarray:
    """Whether somebody has room at points [..., 2]."""
    r, size = spec.characters[who].radius, np.array([spec.width, spec.height])
    inside = ((points >= r - 1e-9) & (points <= size - r + 1e-9)).all(-1)
    walls = np.array(spec.segments, float).reshape(-1, 2, 2)
    return np.asarray(inside & (clearance(walls, points) >= r - 1e-9))


def _known(
    world: PlaneWorld, story: TypedStory, who: int
) -> Iterator[tuple[int, np.ndarray, float]]:
    """Frames for which it is told where somebody is: where, and how far from there it may be."""
    starts = allowed_starts(world, story.start)
    if len(starts):
        yield 0, starts[0][2 * who : 2 * who + 2], 0.0
    for pin in story.pins:
        for node in _conjuncts(pin.condition):
            if isinstance(node, ty.Feature) and node.predicate == "at" and node.arguments[0] == who:
                place = node.arguments[1]
                if isinstance(place, ty.Point):
                    at, slack = (place.x, place.y), NEAR * world.spec.characters[who].radius
                else:
                    assert isinstance(place, tuple)
                    known = world.spec.places[place[0][0]]
                    at, slack = known.at, known.radius
                yield pin.frame, np.array(at), slack


def _conjuncts(condition: ty.Typed) -> Iterator[ty.Typed]:
    if isinstance(condition, ty.Apply) and condition.operation == "and":
        for part in condition.arguments:
            yield from _conjuncts(part)
    else:
        yield condition


def _lengths(spec: PlaneSpec, who: int, points: np.ndarray, at: np.ndarray) -> np.ndarray:
    """The shortest ways of somebody from points to another, [N]."""
    if not spec.segments:
        return norm(points - at)
    return _ways(spec, who).lengths(points, at[None])[:, 0]


@lru_cache(maxsize=8)
def _ways(spec: PlaneSpec, who: int) -> Ways:
    walls = np.array(spec.segments, float)
    return Ways(walls, spec.characters[who].radius, spec.width, spec.height)


def _boxes(is_open: np.ndarray, width: float, height: float) -> Iterator[Box]:
    """The stretches of open cells, row by row."""
    for row, cells in enumerate(is_open):
        edges = np.flatnonzero(np.diff(np.concatenate([[False], cells, [False]]).astype(int)))
        for first, last in edges.reshape(-1, 2):
            yield first * width, row * height, (last - first) * width, height


def nearest(spec: PlaneSpec, who: int, at: np.ndarray) -> np.ndarray | None:
    """The point next to a point at which somebody has room; None where there is none near by."""
    r = spec.characters[who].radius
    inside = np.clip(at, r, np.array([spec.width, spec.height]) - r)
    moved = _ways(spec, who).freed(inside[None])[0][0] if spec.segments else inside
    told = np.round(moved, DIGITS)
    for x, y in ((0, 0), (1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, 1), (1, -1), (-1, -1)):
        near: np.ndarray = told + np.array([x, y]) * 10.0**-DIGITS
        if can_stand(spec, who, near):
            return near
    return None
