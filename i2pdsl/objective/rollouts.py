"""Rollouts of characters who act as viewers think that they do (sampling.py)."""

from __future__ import annotations

import numpy as np

from i2pdsl.worlds.record import Trajectory
from i2pdsl.worlds.world import World


def rollouts(
    world: World,
    states: np.ndarray,
    observers: np.ndarray,
    courses: np.ndarray,
    luck: np.ndarray,
) -> Trajectory:
    """Rollouts side by side: actions [N, T] and states [N, T + 1].

    Args:
        states, observers: of each, [N].
        courses: the column of `World.turns` by which each action is chosen, [N, T, U] or longer.
        luck: uniform numbers that decide what is done and what succeeds, [N, T].
    """
    each = np.arange(len(states))
    path, actions = [states], []
    for t in range(luck.shape[1]):
        ahead = world.turns(world.tables, path[-1])
        log = sum(
            np.moveaxis(np.asarray(row), (-2, -1), (1, 2))[each, observers, courses[:, t, u]]
            for u, row in enumerate(ahead.log_rows)
        )
        chance = np.asarray(ahead.chance) * ahead.valid  # [N, K]
        weights = np.exp(log).reshape(len(states), -1) * chance
        actions.append(drawn_from(weights, luck[:, t]))
        path.append(np.asarray(world.transition(world.tables, path[-1], actions[-1])))
    return Trajectory(np.stack(actions, axis=1), np.stack(path, axis=1))


def drawn_from(weights: np.ndarray, luck: np.ndarray) -> np.ndarray:
    """A number for each row of weights [N, K], by uniform numbers [N]."""
    sums = weights.cumsum(-1)
    return (luck[:, None] * sums[:, -1:] >= sums).sum(-1)
