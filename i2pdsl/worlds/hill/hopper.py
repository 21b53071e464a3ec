"""The hopper, the rope and the box: nodes, springs and named groups of them (model.md, "Hill").

Lengths are in the world's unit (the hopper is about 14 tall), masses and times in theirs.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from i2pdsl.worlds.hill.spec import HillSpec

# Drawn on a grid: column x, row y. Where a node stands at rest: (5 (x - 4), 4 (y + 0.4)).
_DRAWN = (
    *((-0.8, -0.8), (0.8, -0.8), (0.0, 0.0)),
    *((-0.4, 0.5), (0.4, 0.5), (0.0, 1.0)),
    *((-0.4, 1.5), (0.4, 1.5), (0.0, 2.0)),
    *((-0.4, 2.5), (0.4, 2.5)),
    *((-3.0, -1.0), (-3.0, 0.0), (-4.0, -1.0), (-4.0, 0.0)),
    *((-5.0, -1.0), (-5.0, 0.0), (-6.0, -1.0), (-6.0, 0.0)),
)
LEFT_FOOT, RIGHT_FOOT, HIPS = 0, 1, 2
HEAD_LEFT, HEAD_RIGHT = 9, 10
HAND, HOOK = 6, 12  # where the rope is tied to the hopper and to the box
FEET = (LEFT_FOOT, RIGHT_FOOT)
HOPPER = tuple(range(11))
BOX = tuple(range(11, 19))
BOX_OUTLINE = (12, 14, 16, 18, 17, 15, 13, 11)  # around the box, from the hook
GROUPS = {"hopper": HOPPER, "box": BOX}

BONES = (
    *((0, 1), (1, 2), (0, 2)),
    *((2, 3), (2, 4), (3, 4), (3, 5), (4, 5)),
    *((5, 6), (5, 7), (6, 7), (6, 8), (7, 8)),
    *((8, 9), (8, 10), (9, 10)),
)
MUSCLES = ((0, 3), (3, 6), (6, 9), (1, 4), (4, 7), (7, 10))
CRATE = (
    *((11, 12), (11, 13), (11, 14), (12, 13), (12, 14), (13, 14), (13, 15), (13, 16)),
    *((14, 15), (14, 16), (15, 16), (15, 17), (15, 18), (16, 17), (16, 18), (17, 18)),
)
ROPE = ((HAND, HOOK),)
SPRINGS = (*BONES, *MUSCLES, *CRATE, *ROPE)

NODE_COUNT, SPRING_COUNT, MUSCLE_COUNT = len(_DRAWN), len(SPRINGS), len(MUSCLES)
FIRST_MUSCLE = len(BONES)
ROPE_SPRING = SPRING_COUNT - 1
DRAWN_SLOPE = 0.1
STIFFNESS, ROPE_STIFFNESS, DAMPING = 500.0, 100.0, 20.0


def rest_ascents() -> dict[str, float]:
    """How far up the slope the middle of each group stands at the start, from the origin."""
    along = np.array([np.cos(DRAWN_SLOPE), np.sin(DRAWN_SLOPE)]) @ rest_positions()
    return {name: float(along[list(nodes)].mean()) for name, nodes in GROUPS.items()}


class Body(NamedTuple):
    """The arrays of the simulation. N = 19 nodes, S = 39 springs.

    Attributes:
        incidence [S, N]: -1 at a spring's first node, +1 at its second.
        rest [S]: lengths without actuation.
        stiffness [S]: force for each unit of extension.
        damping: force along a spring for each unit of speed of its ends.
        friction [N]: Coulomb's coefficient.
        gravity: acceleration.
        slope: angle in radians.
    """

    incidence: np.ndarray
    rest: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    friction: np.ndarray
    gravity: np.ndarray
    slope: np.ndarray


def rest_positions() -> np.ndarray:
    """Where the nodes stand before anything moves, [2, N]."""
    x, y = np.array(_DRAWN).T
    return np.stack([5 * (x - 4), 4 * (y + 0.4)])


def initial_state(slope: float = DRAWN_SLOPE) -> np.ndarray:
    """The first state: at rest, [76]. The box drops onto the slope in the first frames.

    What was drawn for a slope of 0.1 is turned about the origin onto another one.
    """
    x, y = rest_positions()
    sine, cosine = np.sin(slope - DRAWN_SLOPE), np.cos(slope - DRAWN_SLOPE)
    turned = np.concatenate([cosine * x - sine * y, sine * x + cosine * y])
    return np.concatenate([turned, np.zeros(2 * NODE_COUNT)])


def build_body(spec: HillSpec) -> Body:
    """The springs and nodes of a hill."""
    numbers = spec.settings
    incidence = np.zeros((SPRING_COUNT, NODE_COUNT))
    for number, (first, second) in enumerate(SPRINGS):
        incidence[number, first], incidence[number, second] = -1.0, 1.0
    ends = incidence @ rest_positions().T
    stiffness = np.full(SPRING_COUNT, STIFFNESS)
    stiffness[ROPE_SPRING] = ROPE_STIFFNESS
    friction = np.full(NODE_COUNT, numbers.friction)
    friction[list(BOX)] = numbers.box_friction
    return Body(
        incidence,
        np.sqrt((ends**2).sum(-1)),
        stiffness,
        np.array(DAMPING),
        friction,
        np.array(numbers.gravity),
        np.array(numbers.slope),
    )


def masses(spec: HillSpec, weight: float) -> np.ndarray:
    """The mass of each node, [N], for a box of a weight."""
    mass = np.full(NODE_COUNT, spec.settings.node_mass)
    mass[list(FEET)] = spec.settings.foot_mass
    mass[list(BOX)] = spec.settings.node_mass * weight
    return mass
