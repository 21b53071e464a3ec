"""Where names stand in a room: near what they name, clear of walls, of each other and of whatever
else shall be seen. All lengths in pixels, y down."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, hypot, pi, sin

import numpy as np

GAP = 3.0  # between a name and what it names
AROUND = (90, 270, 0, 180, 45, 135, 315, 225)  # degrees below, above, right, left, ...; best first
SWEEPS = 3  # over all names, after each has its first place
# What it costs a name, beside its distance in pixels.
AWAY, OUTSIDE, ON_NAME, ON_WALL, ON_SPOT, ON_WAY = 0.4, 60.0, 80.0, 60.0, 35.0, 8.0
ASTRAY = 30.0  # where it seems to name something else


@dataclass(frozen=True)
class Tag:
    """A name of a size, to stand `reach` away from the middle of what it names."""

    x: float
    y: float
    reach: float
    width: float
    height: float


@dataclass(frozen=True)
class Obstacles:
    """What names avoid.

    Attributes:
        room: left, top, right, bottom.
        walls [k, 2, 2]: segments, most to be avoided.
        spots [k, 3]: discs, x, y and radius.
        ways [k, 2]: points that are gone through.
    """

    room: tuple[float, float, float, float]
    walls: np.ndarray
    spots: np.ndarray
    ways: np.ndarray


def placed(tags: Sequence[Tag], obstacles: Obstacles) -> list[tuple[float, float]]:
    """The middle of each tag: one after the other where it costs least, and then once more with
    all others there."""
    choices = [_choices(tag, obstacles) for tag in tags]
    fixed = [
        [
            cost + _fixed_cost(tag, place, obstacles) + ASTRAY * _is_astray(number, tags, place)
            for place, cost in options
        ]
        for number, (tag, options) in enumerate(zip(tags, choices, strict=True))
    ]
    chosen: dict[int, tuple[float, float]] = {}
    for _ in range(SWEEPS):
        for number, tag in enumerate(tags):
            others = [(tags[k], at) for k, at in chosen.items() if k != number]
            costs = [
                cost + ON_NAME * sum(_overlap(tag, place, *other) for other in others)
                for (place, _), cost in zip(choices[number], fixed[number], strict=True)
            ]
            chosen[number] = choices[number][int(np.argmin(costs))][0]
    return [chosen[number] for number in range(len(tags))]


def _choices(tag: Tag, obstacles: Obstacles) -> list[tuple[tuple[float, float], float]]:
    """Places around what is named, moved into the room, with the cost of their distance."""
    left, top, right, bottom = obstacles.room
    w, h = tag.width / 2, tag.height / 2
    found = []
    for ring in (0.0, 0.6, 1.3, 2.2, 3.2):
        for rank, angle in enumerate(AROUND):
            dx, dy = cos(angle * pi / 180), sin(angle * pi / 180)
            away = ring * tag.height
            # So far that the tag's edge, not its middle, keeps the distance.
            x = tag.x + dx * (tag.reach + GAP + away) + w * _side(dx)
            y = tag.y + dy * (tag.reach + GAP + away) + h * _side(dy)
            inside = min(max(x, left + w), right - w), min(max(y, top + h), bottom - h)
            moved = abs(inside[0] - x) + abs(inside[1] - y)
            found.append((inside, AWAY * (away + moved) + rank / 2))
    return found


def _side(direction: float) -> float:
    return 0.0 if abs(direction) < 1e-9 else 1.0 if direction > 0 else -1.0


def gap(tag: Tag, place: tuple[float, float], named: Tag) -> float:
    """Pixels between a tag at a place and what another (or the same) tag names."""
    across = max(abs(place[0] - named.x) - tag.width / 2, 0)
    down = max(abs(place[1] - named.y) - tag.height / 2, 0)
    return hypot(across, down) - named.reach


def _is_astray(number: int, tags: Sequence[Tag], place: tuple[float, float]) -> bool:
    """Whether a tag is nearer to what another names, or as near."""
    own = gap(tags[number], place, tags[number])
    return any(
        gap(tags[number], place, other) <= own + 1 for k, other in enumerate(tags) if k != number
    )


def _fixed_cost(tag: Tag, place: tuple[float, float], obstacles: Obstacles) -> float:
    """What lies below a tag at a place that does not move."""
    (x, y), w, h = place, tag.width / 2 + 1, tag.height / 2 + 1
    left, top, right, bottom = obstacles.room
    outside = max(left - x + w, 0) + max(x + w - right, 0)
    outside += max(top - y + h, 0) + max(y + h - bottom, 0)
    walls = lengths_inside(obstacles.walls, x - w, y - h, x + w, y + h).sum() / tag.height
    spots = obstacles.spots
    dx = np.maximum(abs(spots[:, 0] - x) - w, 0)
    dy = np.maximum(abs(spots[:, 1] - y) - h, 0)
    deep = np.clip(1 - np.hypot(dx, dy) / np.maximum(spots[:, 2], 1e-9), 0, 1).sum()
    ways = (abs(obstacles.ways - np.array([x, y])) < (w, h)).all(axis=-1)
    share = ways.sum() / max(len(ways), 1)
    cost = OUTSIDE * outside / tag.height + ON_WALL * min(walls, 3.0) + ON_SPOT * deep
    return float(cost + ON_WAY * (share > 0) + 10 * ON_WAY * share)


def lengths_inside(
    segments: np.ndarray, left: float, top: float, right: float, bottom: float
) -> np.ndarray:
    """[k] How much of each segment lies in a box (Liang and Barsky: cut by one edge at a time)."""
    start, way = segments[:, 0], segments[:, 1] - segments[:, 0]
    enter, leave = np.zeros(len(segments)), np.ones(len(segments))
    for axis, low, high in ((0, left, right), (1, top, bottom)):
        with np.errstate(divide="ignore", invalid="ignore"):
            a, b = (low - start[:, axis]) / way[:, axis], (high - start[:, axis]) / way[:, axis]
        level = abs(way[:, axis]) < 1e-9
        inside = (low < start[:, axis]) & (start[:, axis] < high)
        enter = np.maximum(enter, np.where(level, np.where(inside, 0, 1), np.minimum(a, b)))
        leave = np.minimum(leave, np.where(level, np.where(inside, 1, 0), np.maximum(a, b)))
    return np.maximum(leave - enter, 0) * np.hypot(way[:, 0], way[:, 1])


def _overlap(one: Tag, at: tuple[float, float], other: Tag, there: tuple[float, float]) -> float:
    """How much of the smaller of two tags the other covers, 1 at once where they touch much."""
    across = (one.width + other.width) / 2 + 2 - abs(at[0] - there[0])
    down = (one.height + other.height) / 2 + 2 - abs(at[1] - there[1])
    if across <= 0 or down <= 0:
        return 0.0
    return 0.3 + across * down / min(one.width * one.height, other.width * other.height)
