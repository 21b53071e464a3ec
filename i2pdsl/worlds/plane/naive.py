"""Characters of a plane who do what is best for them, for nobody to see."""

from __future__ import annotations

import numpy as np

from i2pdsl.worlds.plane.costs import alternatives
from i2pdsl.worlds.plane.dynamics import transition
from i2pdsl.worlds.plane.geometry import disc
from i2pdsl.worlds.plane.tables import Cast, Tables, each
from i2pdsl.worlds.plane.ways import outlook
from i2pdsl.worlds.record import Trajectory

SHARPNESS = 10.0  # inverse temperature per step at the speed that they like: nearly the best
WAVE = 6  # frames over which a change of velocity lasts
_DIRECTIONS, _SPEEDS = 24, 5


def wandering(generator: np.random.Generator, spread: float, shape: tuple[int, ...]) -> np.ndarray:
    """Smooth random changes of this standard deviation over time, the second axis."""
    steps = generator.normal(size=(shape[0], shape[1] + 4 * WAVE, *shape[2:]))
    kernel = np.exp(-0.5 * (np.arange(-2 * WAVE, 2 * WAVE + 1) / WAVE) ** 2)
    kernel /= np.sqrt((kernel**2).sum())
    smooth = np.apply_along_axis(lambda line: np.convolve(line, kernel, "valid"), 1, steps)
    return spread * smooth


def walks(
    tables: Tables,
    cast: Cast,
    start: np.ndarray,
    hypotheses: np.ndarray,
    changes: np.ndarray,
    pace: np.ndarray,
) -> Trajectory:
    """Scripts side by side of characters who act by a hypothesis each, [S, T, 2 n] and states.

    Everybody takes the mean of the velocities that cost least, the other going on as it did.

    Args:
        start: states [S, 4 n].
        hypotheses: [S], under which nobody moves at random.
        changes: of their velocities, in units of the speed that each likes, [S, T, n, 2].
        pace: factors of their velocities, [S, n].
    """
    count = cast.count
    nodes, weights = disc(_DIRECTIONS, _SPEEDS)
    tables = tables._replace(nodes=nodes, log_weights=np.log(weights))
    plans = [p.rows[:, hypotheses].argmax(0)[:, None, None] for p in tables.plans]
    states, actions = [start], []
    for t in range(changes.shape[1]):
        known = outlook(tables, cast, states[-1])
        moving = each(states[-1], 2 * count)[count:]
        chosen = []
        for who in range(count):
            tried, costs = alternatives(tables, cast, who, known, moving)
            cost = np.take_along_axis(costs, plans[who], -1)[..., 0]  # [S, K]
            beta = SHARPNESS / tables.speed[who]
            share = np.exp(tables.log_weights - beta * (cost - cost.min(-1, keepdims=True)))
            share /= share.sum(-1, keepdims=True)
            mean = (share[..., None] * tried).sum(-2)
            change = tables.speed[who] * changes[:, t, who]
            chosen.append(pace[:, who, None] * mean + change)
        actions.append(np.concatenate(chosen, axis=-1))
        states.append(transition(tables, cast, states[-1], actions[-1]))
    return Trajectory(np.stack(actions, axis=1), np.stack(states, axis=1))


def walk(
    tables: Tables,
    cast: Cast,
    start: np.ndarray,
    rational: np.ndarray,
    length: int,
    noise: float,
    seed: int,
) -> Trajectory:
    """One script of characters who act by a hypothesis drawn from a mask [H]."""
    generator = np.random.default_rng(seed)
    hypothesis = generator.choice(np.flatnonzero(rational))
    changes = wandering(generator, noise, (1, length, cast.count, 2))
    pace = np.ones((1, cast.count))
    found = walks(tables, cast, start[None], np.array([hypothesis]), changes, pace)
    return Trajectory(found.actions[0], found.states[0])
