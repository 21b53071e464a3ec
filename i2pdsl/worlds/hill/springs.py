"""The simulator: springs, muscles, contact and friction, differentiable (model.md, "Hill").

Semi-implicit Euler with SUBSTEPS steps of DT a frame. In each step a spring of length l between
nodes at x_a, x_b pulls both with

    tension = k clip(l - l_0, -1, 1) + c (v_b - v_a) . u,    u = (x_b - x_a) / l,

a muscle's l_0 being (1 + 0.25 tanh a) times its rest length. Below the slope a node is pushed back
along the normal by 2000 x depth; Coulomb's friction takes at most mu times that from its tangential
speed, and never more than stops it. Functions take NumPy or JAX arrays, the batch last: one
product with the incidence matrix then serves all rollouts.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from i2pdsl.worlds.hill.hopper import (
    FIRST_MUSCLE,
    HAND,
    HEAD_LEFT,
    HOOK,
    HOPPER,
    LEFT_FOOT,
    MUSCLE_COUNT,
    NODE_COUNT,
    ROPE_SPRING,
    Body,
)

Array = Any

DT = 0.0125  # of a substep
SUBSTEPS = 4
FRAME_SECONDS = DT * SUBSTEPS
LONGEST = 1.0  # a spring pulls no harder than at this extension
CONTRACTION = 0.25
GROUND = 2000.0  # force for each unit of depth
HEAD_FALLEN = 5.0  # a head below this height above the slope has fallen


class Motion(NamedTuple):
    """Positions and velocities, [2, N, B] each: x and y of N nodes in B rollouts."""

    position: Array
    velocity: Array


def motion_of(state: Array) -> Motion:
    """A state [..., 76] with its leading axes joined and moved last."""
    flat = state.reshape(-1, 4, NODE_COUNT)
    moved = flat.transpose(1, 2, 0)
    return Motion(moved[:2], moved[2:])


def state_of(motion: Motion, shape: tuple[int, ...]) -> Array:
    """The inverse of `motion_of`, given the leading axes."""
    xp = motion.position.__array_namespace__()
    both = xp.concatenate([motion.position, motion.velocity])
    return both.transpose(2, 0, 1).reshape(*shape, 4 * NODE_COUNT)


def step(body: Body, mass: Array, motion: Motion, actuation: Array) -> tuple[Motion, Array]:
    """One frame.

    Args:
        mass: [N] or [N, B].
        actuation: of the six muscles, [6, B].

    Returns: the motion at its end, and the mean power that the rope delivers to the box, [B].
    """
    xp = motion.position.__array_namespace__()
    mass = mass[:, None] if mass.ndim == 1 else mass
    rest = body.rest[:, None] + xp.zeros_like(motion.position[0, :1])
    factor = 1 + CONTRACTION * xp.tanh(actuation)
    last = FIRST_MUSCLE + MUSCLE_COUNT
    rest = xp.concatenate([rest[:FIRST_MUSCLE], rest[FIRST_MUSCLE:last] * factor, rest[last:]])
    delivered: Array = 0.0
    for _ in range(SUBSTEPS):
        motion, power = _substep(body, mass, rest, motion)
        delivered = delivered + power / SUBSTEPS
    return motion, delivered


def _substep(body: Body, mass: Array, rest: Array, motion: Motion) -> tuple[Motion, Array]:
    xp = motion.position.__array_namespace__()
    position, velocity = motion
    ends = body.incidence @ position
    apart = body.incidence @ velocity
    length = xp.sqrt((ends**2).sum(0))
    along = ends / length
    extension = xp.clip(length - rest, -LONGEST, LONGEST)
    tension = body.stiffness[:, None] * extension + body.damping * (apart * along).sum(0)
    force = -body.incidence.T @ (tension * along)
    # Axes along the slope: u (up the slope) and n (out of it).
    sine, cosine = xp.sin(body.slope), xp.cos(body.slope)
    depth = xp.maximum(sine * position[0] - cosine * position[1], 0.0)
    support = GROUND * depth
    push = xp.stack([-sine * support, cosine * support - body.gravity * mass])
    velocity = velocity + DT * (force + push) / mass
    sliding = cosine * velocity[0] + sine * velocity[1]
    most = DT * body.friction[:, None] * support / mass
    lost = xp.clip(sliding, -most, most)
    velocity = velocity - lost * xp.stack([cosine, sine])[:, None, None]
    hook = -(motion.velocity[:, HOOK] * along[:, ROPE_SPRING]).sum(0)
    return Motion(position + DT * velocity, velocity), tension[ROPE_SPRING] * hook


def head_height(body: Body, position: Array) -> Array:
    """Of the head above the slope below the left foot, [B]."""
    xp = position.__array_namespace__()
    return position[1, HEAD_LEFT] - xp.tan(body.slope) * position[0, LEFT_FOOT]


def stretch(body: Body, position: Array) -> Array:
    """How much longer the rope is than at rest, [B]; negative where it is slack."""
    xp = position.__array_namespace__()
    apart = position[:, HAND] - position[:, HOOK]
    return xp.sqrt((apart**2).sum(0)) - body.rest[ROPE_SPRING]


def observation(body: Body, motion: Motion) -> Array:
    """What viewers and controllers see, [76, B]: positions relative to the left foot along x and
    to the slope below it along y; velocities."""
    xp = motion.position.__array_namespace__()
    foot = motion.position[0, LEFT_FOOT]
    x = motion.position[0] - foot
    y = motion.position[1] - xp.tan(body.slope) * foot
    return xp.concatenate([x, y, motion.velocity[0], motion.velocity[1]])


def reward(
    body: Body, mass: Array, motion: Motion, actuation: Array, power: Array, charge: float
) -> Array:
    """Of a frame, [B]: head up, hopper forward, calm, without effort, and `charge` times the power
    that goes into the box (without it light and heavy boxes go up equally fast)."""
    mass = mass[:, None] if mass.ndim == 1 else mass
    hopper = slice(HOPPER[0], HOPPER[-1] + 1)
    velocity = motion.velocity[:, hopper]
    return (
        head_height(body, motion.position)
        + 0.5 * (velocity[0] * mass[hopper]).mean(0)
        - 0.1 * (velocity**2).sum(0).mean(0)
        - 0.1 * (actuation**2).mean(0)
        - charge * power
    )


def ascent(slope: Array, before: Array, after: Array, nodes: tuple[int, ...]) -> Array:
    """How far the middle of some nodes went up the slope between two positions [2, N, B]: [B]."""
    xp = after.__array_namespace__()
    first, last = nodes[0], nodes[-1] + 1
    moved = (after - before)[:, first:last].mean(1)
    return xp.cos(slope) * moved[0] + xp.sin(slope) * moved[1]
