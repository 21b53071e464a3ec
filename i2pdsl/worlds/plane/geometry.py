"""Shortest ways of a disc among walls: exact lengths, tabulated.

Walls are straight segments, so a shortest way of a disc's middle is made of straight parts and of
arcs about ends of walls. Here each arc is a polygon (`CORNERS` to the turn, 2 % longer), and the
way one of a graph of points that see each other (Lozano-Perez and Wesley 1979, Communications of
the ACM 22, 10). Only the *detour* is tabulated, by how much the way is longer than the
straight line: it is 0 wherever the goal is in sight, so that distances there are exact and have
no grid in them. NumPy only; worlds/plane/ways.py reads the tables.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

Array = Any

CORNERS = 12
MOST_NODES = 8000  # of the grid of a field
MOST_PAIRS = 1000  # nodes of the grid of detours between any two points
_SLACK = 1e-6  # a way that touches a wall is free
_CHUNK = 100_000  # numbers at a time: they stay in the processor's cache


class Grid(NamedTuple):
    """Nodes at regular distances that cover the plane.

    Attributes:
        nodes [rows * columns, 2]: row by row, from the lower left.
        scale [2]: nodes per unit.
    """

    rows: int
    columns: int
    nodes: np.ndarray
    scale: np.ndarray


def regular_grid(width: float, height: float, spacing: float, most: int) -> Grid:
    """A grid of at most about this spacing, wider where it would have too many nodes."""
    spacing = max(spacing, float(np.sqrt(width * height / most)))
    columns, rows = (max(2, round(length / spacing) + 1) for length in (width, height))
    x, y = np.linspace(0, width, columns), np.linspace(0, height, rows)
    nodes = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    return Grid(rows, columns, nodes, np.array([(columns - 1) / width, (rows - 1) / height]))


def norm(vector: Array) -> Array:
    """Lengths [...] of vectors [..., 2]; the gradient at 0 is 0, not NaN."""
    xp = vector.__array_namespace__()
    square = (vector**2).sum(-1)
    return xp.where(square > 0, xp.sqrt(xp.where(square > 0, square, 1.0)), 0.0)


def direction(apart: Array) -> tuple[Array, Array]:
    """Lengths [...] and unit vectors [..., 2]; 0 where the length is 0."""
    xp = apart.__array_namespace__()
    length = norm(apart)
    return length, apart / xp.where(length > 0, length, 1.0)[..., None]


def nearest_on(segments: Array, points: Array) -> Array:
    """The point of each segment [W, 2, 2] that is nearest to each point: [..., W, 2]."""
    xp = points.__array_namespace__()
    first, along = segments[:, 0], segments[:, 1] - segments[:, 0]
    share = ((points[..., None, :] - first) * along).sum(-1) / (along**2).sum(-1)
    return first + xp.clip(share, 0.0, 1.0)[..., None] * along


def clearance(segments: np.ndarray, points: np.ndarray) -> np.ndarray:
    """The distance of each point to the nearest wall, [...]; inf where there is none."""
    if not len(segments):
        return np.full(points.shape[:-1], np.inf)
    return norm(points[..., None, :] - nearest_on(segments, points)).min(-1)


def _cross(a: Array, b: Array) -> Array:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def crossed(segments: Array, start: Array, end: Array) -> Array:
    """Whether the straight way from a point to another [..., 2] crosses each segment [W, 2, 2]:
    [..., W]."""
    first, second = segments[:, 0], segments[:, 1]
    start, end = start[..., None, :], end[..., None, :]
    wall, way = second - first, end - start
    across = _cross(wall, start - first) * _cross(wall, end - first) < 0
    found: Array = across & (_cross(way, first - start) * _cross(way, second - start) < 0)
    return found


def in_sight(
    segments: np.ndarray, radius: float, points: np.ndarray, others: np.ndarray
) -> np.ndarray:
    """Whether a disc can go straight from each point to each of the others: [N, C]."""
    free = radius * (1 - _SLACK)
    seen = (clearance(segments, points) >= free)[:, None] & (clearance(segments, others) >= free)
    ends, numbers = np.unique(segments.reshape(-1, 2), axis=0, return_inverse=True)
    size = max(1, _CHUNK // max(1, len(others)))
    for begin in range(0, len(points), size):
        start = points[begin : begin + size, None]
        way = others[None] - start  # [n, C, 2]
        square = (way**2).sum(-1)
        near, sides = np.zeros(square.shape, bool), []
        for end in ends:
            side, along = _cross(way, end - start), ((end - start) * way).sum(-1)
            near |= (side**2 < free**2 * square) & (along > 0) & (along < square)
            sides.append(side)
        for (first, second), (a, b) in zip(segments, numbers.reshape(-1, 2), strict=True):
            wall = second - first
            across = _cross(wall, start - first) * _cross(wall, others - first)
            near |= (across < 0) & (sides[a] * sides[b] < 0)
        seen[begin : begin + size] &= ~near
    return seen


def turning_points(segments: np.ndarray, radius: float, width: float, height: float) -> np.ndarray:
    """Where shortest ways of a disc can bend: polygons about the ends of walls, [C, 2]."""
    ends = np.unique(segments.reshape(-1, 2), axis=0)
    angles = 2 * np.pi * np.arange(CORNERS) / CORNERS
    around = radius / np.cos(np.pi / CORNERS) * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    points = (ends[:, None] + around).reshape(-1, 2)
    edge = np.minimum(points, np.array([width, height]) - points).min(-1)
    return points[(clearance(segments, points) >= radius * (1 - _SLACK)) & (edge >= radius - 1e-9)]


def _shortest(lengths: np.ndarray) -> np.ndarray:
    """All shortest ways in a graph, by Floyd's algorithm."""
    found = lengths.copy()
    for middle in range(len(found)):
        found = np.minimum(found, found[:, middle, None] + found[None, middle])
    return found


class Ways:
    """Shortest ways of a disc of some radius among walls [W, 2, 2]."""

    def __init__(self, segments: np.ndarray, radius: float, width: float, height: float):
        self.segments, self.radius = segments, radius
        self.far = 10 * (width + height)  # how far is what cannot be reached
        self.corners = turning_points(segments, radius, width, height)
        self.between = _shortest(self._lengths(self.corners, self.corners))

    def _lengths(self, points: np.ndarray, others: np.ndarray) -> np.ndarray:
        """Lengths of straight ways, inf where a wall is between: [N, C]."""
        seen = in_sight(self.segments, self.radius, points, others)
        return np.where(seen, norm(points[:, None] - others[None]), np.inf)

    def freed(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The free points next to points that are in or too near a wall, and how far they are."""
        blocked = clearance(self.segments, points) < self.radius * (1 - _SLACK)
        moved = points + blocked[:, None] * np.array([1e-9, 3e-9])  # on a wall, one side of it
        for _ in range(4):
            if not blocked.any():
                break
            apart = moved[:, None] - nearest_on(self.segments, moved)
            lengths = norm(apart)
            rows = np.arange(len(moved))
            nearest = lengths.argmin(-1)
            length = lengths[rows, nearest][:, None]
            out = apart[rows, nearest] / np.maximum(length, 1e-12)
            moved = moved + np.maximum(self.radius - length, 0) * out
        return moved, norm(moved - points)

    def lengths(self, points: np.ndarray, others: np.ndarray) -> np.ndarray:
        """The shortest way from each point to each of the others, [N, M]."""
        start, before = self.freed(points)
        end, after = self.freed(others)
        straight = self._lengths(start, end)
        found = straight
        if len(self.corners):
            onward = self._joined(self.between, self._lengths(self.corners, end))
            found = np.minimum(straight, self._joined(self._lengths(start, self.corners), onward))
        found = np.minimum(found, self.far)
        return found + before[:, None] + after[None]

    @staticmethod
    def _joined(first: np.ndarray, second: np.ndarray) -> np.ndarray:
        """The shortest of all ways that are a first [N, C] and a second [C, M] part."""
        found = np.full((len(first), second.shape[1]), np.inf)
        for middle in range(first.shape[1]):
            np.minimum(found, first[:, middle, None] + second[None, middle], out=found)
        return found

    def detours(self, points: np.ndarray, others: np.ndarray) -> np.ndarray:
        """By how much the shortest ways are longer than straight lines, [N, M]."""
        return self.lengths(points, others) - norm(points[:, None] - others[None])


def disc(directions: int, speeds: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights of a quadrature over the unit disc: equal angles, Gauss-Legendre radii."""
    radii, weights = np.polynomial.legendre.leggauss(speeds)
    radii, weights = (radii + 1) / 2, weights / 2
    angles = 2 * np.pi * np.arange(directions) / directions
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    nodes = (radii[:, None, None] * circle).reshape(-1, 2)
    return nodes, np.repeat(weights * radii * 2 * np.pi / directions, directions)


def unreachable(
    segments: Any, radius: float, width: float, height: float, start: Any, goals: list[Any]
) -> list[bool]:
    """Which goals a disc cannot get to."""
    ways = Ways(np.array(segments, float), radius, width, height)
    lengths = ways.lengths(np.array([start], float), np.array(goals, float).reshape(-1, 2))
    return [bool(length >= ways.far) for length in lengths[0]]
