"""What moves on the hill, as paths whose points are linear in the nodes.

A point of the plane is a complex number. The vector of a pose holds the 19 nodes and what is
derived from them (directions between nodes, their feet on the slope, the rope's sag); every point
of a drawing is a product of constant complex weights with that vector: `node(3) + 0.5j * unit(3,
4)` lies half a unit to the left of the way from node 3 to node 4. So a drawing is data, and the
HTML page's player, which repeats only `pose_vector` and `path_data`, draws the same figures.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from i2pdsl.worlds.hill.hopper import BOX_OUTLINE, HAND, HOOK, MUSCLES, NODE_COUNT, rest_positions

SCALE = 10  # SVG units to a unit of the world; SVG's y points down

# Pairs of nodes whose direction (a complex number of length 1) drawings use.
UNITS = ((0, 1), (3, 4), (6, 7), (9, 10), *MUSCLES)
GROUNDED = (0, 1, *BOX_OUTLINE)  # nodes whose point on the slope, right below, drawings use
_SAG = NODE_COUNT + len(UNITS) + len(GROUNDED)
VECTOR_SIZE = _SAG + 1
_WEIGHTS = np.eye(VECTOR_SIZE, dtype=complex)
_HAND, _HOOK = rest_positions()[:, HAND], rest_positions()[:, HOOK]
ROPE_LENGTH = float(np.hypot(*(_HAND - _HOOK)))

Weights = np.ndarray  # [VECTOR_SIZE] complex: a point, or a difference of points


def node(number: int) -> Weights:
    """A node's place."""
    return _WEIGHTS[number]


def unit(first: int, second: int) -> Weights:
    """The direction from one node to another."""
    return _WEIGHTS[NODE_COUNT + UNITS.index((first, second))]


def grounded(number: int) -> Weights:
    """The point of the slope right below (or above) a node."""
    return _WEIGHTS[NODE_COUNT + len(UNITS) + GROUNDED.index(number)]


SAG = _WEIGHTS[_SAG]  # how far the rope's middle hangs below a straight line


def pose_vector(positions: np.ndarray, slope: float) -> np.ndarray:
    """The vector of a pose, complex [VECTOR_SIZE], from its positions [2, 19]."""
    nodes = positions[0] + 1j * positions[1]
    ways = np.asarray([nodes[b] - nodes[a] for a, b in UNITS])
    length = np.maximum(abs(ways), 1e-9)
    feet = positions[0, list(GROUNDED)] * (1 + 1j * np.tan(slope))
    distance = abs(nodes[HAND] - nodes[HOOK])
    # Of a flat arc of length L over a chord d: L = d + 8 s^2 / (3 d).
    sag = np.sqrt(0.375 * distance * max(ROPE_LENGTH - distance, 0.0))
    return np.concatenate([nodes, ways / length, feet, [-1j * sag]])


@dataclass(frozen=True, eq=False)
class Part:
    """One path of a drawing.

    Attributes:
        shape: the path's commands, of M, L, C, Q and Z.
        points [P, VECTOR_SIZE]: weights of the points that these take, in order.
        style: SVG attributes.
        muscle: the muscle whose pull colours the stroke.
    """

    shape: str
    points: np.ndarray
    style: str
    muscle: int | None = field(default=None)


TAKES = {"M": 1, "L": 1, "Q": 2, "C": 3, "Z": 0}


def path_data(shape: str, points: np.ndarray) -> str:
    """The `d` of a path through complex points, in SVG units."""
    told, at = [], 0
    for command in shape:
        taken = points[at : at + TAKES[command]]
        at += TAKES[command]
        told.append(
            command + " ".join(f"{SCALE * p.real:.1f} {-SCALE * p.imag:.1f}" for p in taken)
        )
    return "".join(told)


# ------------------------------------------------------------------------------------ shapes


def line(*points: Weights, closed: bool = False) -> tuple[str, np.ndarray]:
    """Straight lines through points."""
    return "M" + "L" * (len(points) - 1) + "Z" * closed, np.stack(points)


def dot(at: Weights) -> tuple[str, np.ndarray]:
    """A line of no length, which a round cap makes a disc as wide as the stroke."""
    return "ML", np.stack([at, at + 1e-3 * unit(0, 1)])


def smooth(points: Sequence[Weights], closed: bool = False) -> tuple[str, np.ndarray]:
    """A curve through points (Catmull and Rom's), as cubic Béziers."""
    count = len(points)
    bends = count if closed else count - 1
    around = [points[i % count] if closed else points[min(max(i, 0), count - 1)]
              for i in range(-1, bends + 2)]  # fmt: skip
    drawn = [points[0]]
    for before, start, end, after in zip(around, around[1:], around[2:], around[3:], strict=False):
        drawn += [start + (end - before) / 6, end - (after - start) / 6, end]
    return "M" + "C" * bends + "Z" * closed, np.stack(drawn[: 1 + 3 * bends])


def bend(start: Weights, *curves: Sequence[Weights], closed: bool = True) -> tuple[str, np.ndarray]:
    """Cubic Béziers, each of two controls and an end."""
    points = [start, *(point for curve in curves for point in curve)]
    return "M" + "C" * len(curves) + "Z" * closed, np.stack(points)


def coil(first: int, second: int, turns: int, width: float) -> tuple[str, np.ndarray]:
    """A coil spring between two nodes."""
    start, way, side = node(first), node(second) - node(first), 1j * unit(first, second)
    straight = 0.16
    steps = np.linspace(straight, 1 - straight, 2 * turns)
    sides = width * (-1.0) ** np.arange(2 * turns)
    zigzag = [start + t * way + s * side for t, s in zip(steps, sides, strict=True)]
    return line(start, start + 0.1 * way, *zigzag, start + 0.9 * way, node(second))


def joined(parts: Iterable[tuple[str, np.ndarray]]) -> tuple[str, np.ndarray]:
    """Several shapes as one path."""
    shapes, points = zip(*parts, strict=True)
    return "".join(shapes), np.concatenate(points)
