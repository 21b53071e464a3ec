"""What is best for the characters of a grid world, and what viewers therefore expect of them.

In NumPy and JAX alike; shapes as in model.py.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from i2pdsl.worlds.grid.arrays import (
    Against,
    Tables,
    arrangement,
    at_goal,
    cell_of,
    continued,
    entries,
    namespace,
)
from i2pdsl.worlds.grid.following import action_count, in_frame, joint, successors, values_after
from i2pdsl.worlds.grid.spec import STAY

Array = Any

MANY = 256  # places: from so many on they are looked for among each other first
AT_ONCE = 8192  # values of an action that are computed side by side: more do not fit the cache


def action_values(tables: Tables, who: int, state: Array) -> Array:
    """Q(s, a) of every planning problem: [..., A, P] (model.md, "Kitchen")."""
    here = arrangement(tables, state)
    on_goal = at_goal(tables, who, here)
    cost = tables.cost[: action_count(tables, who)]
    ground = tables.ground[cell_of(tables, here, who)][..., None, None]
    reward = tables.reward * on_goal[..., None, :] + (cost[:, None] - ground)
    if tables.against is not None:
        return reward + _together_values(tables, tables.against[who][0], who, state)
    if tables.layer is None:
        values = values_after(tables, who, here)
    else:
        after = successors(tables, who, here)
        values = continued(tables, who, in_frame(state - here, after))
    p = tables.success[who]
    expected = p * values + (1 - p) * values[..., STAY : STAY + 1, :]  # who fails stays
    return reward + tables.gamma * expected


def _together_values(tables: Tables, against: Against, who: int, state: Array) -> Array:
    """What one expects besides its own reward: the other's now, and what comes: [..., A, P]."""
    xp = namespace(tables.coordinates)
    other, here = 1 - who, arrangement(tables, state)
    ends = joint(tables, here)[0] + (state - here)[..., None, None]
    future = tables.continuation[who][ends]  # [..., A_1, A_2, P]
    for p, axis in zip(against.success, (-3, -2), strict=True):
        if p is not None:
            future = p * future + (1 - p) * xp.take(future, xp.asarray([STAY]), axis=axis)
    policy = expected_of_other(tables, against, other, state)
    facing = policy[..., None, :, :] if who == 0 else policy[..., :, None, :]
    expected = (facing * future).sum(-2 if who == 0 else -3)
    social = others_reward(tables, against, policy, other, here)
    return (against.rho * social)[..., None, :] + tables.gamma * expected


def expected_of_other(tables: Tables, against: Against, other: int, state: Array) -> Array:
    """P(a | s) of the other in each of one's problems: [..., A, P]."""
    xp = namespace(tables.coordinates)
    if against.problem is None:
        return xp.broadcast_to(against.fixed, (*state.shape, *against.fixed.shape))
    scaled = against.beta * action_values(tables, other, state)
    weights = xp.exp(scaled - xp.max(scaled, axis=-2, keepdims=True))
    policy = (weights / xp.sum(weights, axis=-2, keepdims=True))[..., against.problem]
    return xp.where(against.known, policy, against.fixed)


def others_reward(
    tables: Tables, against: Against, policy: Array, other: int, here: Array
) -> Array:
    """What one expects the other to be paid for its action in an arrangement, [..., P]; 0 where it
    is not seen through.

    Args:
        policy: [..., A, P], of the other.
    """
    xp = namespace(tables.coordinates)
    cost = (policy * tables.cost[: policy.shape[-2], None]).sum(-2)
    cost = cost - tables.ground[cell_of(tables, here, other)][..., None]
    if against.problem is None:
        return cost * 0
    goals = at_goal(tables, other, here)
    return xp.where(against.known, cost + tables.reward * goals[..., against.problem], 0)


def log_policy(tables: Tables, who: int, state: Array) -> Array:
    """log P(a | s, H): softmax of beta Q, uniform for the irrational. [..., A, O, H]."""
    if tables.policies is not None:
        return entries(tables.policies[who], state)
    return by_hypothesis(tables, who, log_softmax(tables, who, state))


def log_softmax(tables: Tables, who: int, state: Array) -> Array:
    """log P(a | s) of every planning problem: [..., A, P]."""
    xp = namespace(tables.coordinates)
    if xp is np:
        each = (_choices(tables, who, some) for some in _few(tables, who, state))
        found = np.concatenate([scaled - total for scaled, total in each], axis=1)
        return np.moveaxis(found, 0, 1).reshape(*state.shape, *found.shape[::2])
    return _softmax(tables, who, state)[0]


def _softmax(tables: Tables, who: int, state: Array) -> tuple[Array, Array]:
    """log P(a | s) and P(a | s) of every planning problem: [..., A, P] each."""
    xp = namespace(tables.coordinates)
    scaled = tables.sharpness[who] * action_values(tables, who, state)
    scaled = scaled - xp.max(scaled, axis=-2, keepdims=True)
    weights = xp.exp(scaled)
    total = xp.sum(weights, axis=-2, keepdims=True)
    return scaled - xp.log(total), weights / total


def _few(tables: Tables, who: int, every: np.ndarray) -> list[np.ndarray]:
    """States, or what belongs to them, [...], as parts [n] that are small enough to be computed in
    the cache."""
    flat, size = every.reshape(-1), max(1, AT_ONCE // max(1, len(tables.sharpness[who])))
    return [flat[first : first + size] for first in range(0, len(flat), size)] or [flat]


def _choices(tables: Tables, who: int, state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """beta Q(s, a) of every planning problem but for what all actions share, [A, n, P], and the log
    of the sum of their exponentials, [n, P]. With the actions in front NumPy sums fastest."""
    plain = tables.against is None and tables.layer is None
    if plain and tables.packed is None and tables.terms is None:
        p, gamma, beta = tables.success[who], tables.gamma, tables.sharpness[who]
        scaled = tables.continuation[who][tables.successor[who][:, state]]
        if p < 1:
            scaled = p * scaled + (1 - p) * scaled[STAY]
        scaled *= gamma * beta
        scaled += tables.cost[: len(scaled), None, None] * beta
    else:
        scaled = np.moveaxis(action_values(tables, who, state), -2, 0) * tables.sharpness[who]
    scaled -= scaled.max(0)
    return scaled, np.log(np.exp(scaled).sum(0))


def log_taken(tables: Tables, who: int, state: Array, act: Array) -> Array:
    """log P(act | s, H), [..., O, H]."""
    xp = namespace(tables.coordinates)
    if xp is not np:
        policy = log_softmax(tables, who, state)
        taken = xp.take_along_axis(policy, act[..., None, None], axis=-2)[..., 0, :]
        return by_hypothesis(tables, who, taken)
    # Many scripts come by the same places, and do the same there.
    count = action_count(tables, who)
    pairs = (state.astype(np.int64) * count + act).reshape(-1)
    which: Any = None
    if len(pairs) >= MANY:
        pairs, which = np.unique(pairs, return_inverse=True)
    found = []
    for some in _few(tables, who, pairs):
        scaled, total = _choices(tables, who, (some // count).astype(state.dtype))
        found.append(scaled[some % count, np.arange(len(some))] - total)
    rows = by_hypothesis(tables, who, np.concatenate(found))
    rows = rows if which is None else rows.take(which, axis=0)
    return rows.reshape(*state.shape, *rows.shape[1:])


def _with_irrational(tables: Tables, each: Array, at_random: float) -> Array:
    """What is known of each planning problem, [..., P], and of who acts at random: [..., P + 1]."""
    xp = namespace(tables.coordinates)
    return xp.concatenate([each, xp.full_like(each[..., :1], at_random)], axis=-1)


def by_problem(tables: Tables, who: int, state: Array, columns: Array) -> tuple[Array, Array]:
    """log P(a | s) and P(a | s) of the problems in some columns, [..., A, O, Q] each."""
    log_policy, policy = _softmax(tables, who, state)
    count = action_count(tables, who)
    log_policy = _with_irrational(tables, log_policy, -math.log(count))
    policy = _with_irrational(tables, policy, 1 / count)
    if columns.shape == (1, policy.shape[-1]):  # one observer, who knows of all problems
        return log_policy[..., None, :], policy[..., None, :]
    return log_policy[..., columns], policy[..., columns]


def by_hypothesis(tables: Tables, who: int, log_probability: Array) -> Array:
    """What is known of each planning problem, [..., P], of each hypothesis: [..., O, H]."""
    xp = namespace(tables.coordinates)
    every = _with_irrational(tables, log_probability, -math.log(action_count(tables, who)))
    # `take` lays them out in this order: sums over them then round alike, of one script or many.
    return xp.take(every, tables.columns[who], axis=-1, mode="clip")


def value(tables: Tables, who: int, state: Array) -> Array:
    """V(s) = max_a Q(s, a) of a character under each hypothesis: [..., O, H].

    0 under hypotheses in which the character is irrational; expectations exclude those.
    """
    xp = namespace(tables.coordinates)
    best = xp.max(action_values(tables, who, state), axis=-2)
    padded = xp.concatenate([best, xp.zeros_like(best[..., :1])], axis=-1)
    return padded[..., tables.columns[who]]
