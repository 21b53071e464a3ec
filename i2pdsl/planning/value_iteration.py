"""Exact planning by value iteration, in JAX: arrays in, arrays out.

A family of problems that share their moves is solved together, one column each. Columns are
solved in groups, the fastest axis, so that reading a successor's values is one contiguous gather
for all of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

Array = Any
Progress = Callable[[int, float, float | None], None]

GROUP = 16  # columns solved side by side: a cache line of single precision
CHUNK = 60  # sweeps in one compiled call
COARSE = 5e-4  # single precision stops here; rounding would stall it a little below


class NotConverged(Exception):
    """The residual did not fall below the tolerance."""


@dataclass(frozen=True)
class Answer:
    """How the other character answers: by a fixed stochastic policy.

    Attributes:
        successor: int32 [A, S], the state after a successful action.
        success: probability that an action succeeds; else the state stays.
        policy: [K, A, S], or [K, A, 1] where it does not depend on the state.
        choice: int [P], the policy that each problem faces.
        social: [S, K], the answerer's expected reward, or None.
        rho: [P], the weight of that reward.
    """

    successor: np.ndarray
    success: float
    policy: np.ndarray
    choice: np.ndarray
    social: np.ndarray | None
    rho: np.ndarray


@dataclass(frozen=True)
class Problem:
    """P problems of one mover, who has the same moves in all.

    Attributes:
        successor, success: as in Answer, for the mover.
        reward: [S, G], the reward for acting in a state, for each of G goals.
        cost: [A], added for an action.
        goal: int [P], the goal of each problem.
        gamma: discount factor.
        answer: the other's answer to each action, or None.
    """

    successor: np.ndarray
    success: float
    reward: np.ndarray
    cost: np.ndarray
    goal: np.ndarray
    gamma: float
    answer: Answer | None = None


@dataclass(frozen=True)
class Solution:
    """The continuation W [S, P] (the value after an action, before the answer).

    `residual` is max |TV - V|, measured in double precision; `sweeps` counts Bellman sweeps over
    a group of columns.
    """

    continuation: np.ndarray
    residual: float
    sweeps: int


def solve(
    problem: Problem,
    *,
    tolerance: float = 1e-4,
    max_sweeps: int = 100_000,
    progress: Progress | None = None,
) -> Solution:
    """Solves V = max_b Q(., b) to a Bellman residual of `tolerance`, where

        Q(s, b) = reward(s) + cost(b) + gamma (m W(succ_b(s)) + (1 - m) W(s))
        W(s)    = rho social(s) + sum_a policy(a | s) (q V(succ_a(s)) + (1 - q) V(s))

    with m, q the success probabilities of mover and answerer; W = V without an answer.

    Args:
        progress: called with (sweeps so far, residual, sweeps expected in all).

    Raises NotConverged after `max_sweeps`.
    """
    count = len(problem.goal)
    rho = problem.answer.rho if problem.answer is not None else np.zeros(count)
    # Hostile movers (rho < 0) settle slowest; side by side, they keep no others waiting.
    order = np.argsort(rho, kind="stable")
    groups = [order[i : i + GROUP] for i in range(0, count, GROUP)]
    found = np.empty((problem.successor.shape[1], count))
    worst, sweeps = 0.0, 0
    for number, columns in enumerate(groups):
        report = partial(_report, progress, sweeps, len(groups) - number)
        part = _solve_group(problem, columns, tolerance, max_sweeps, report)
        found[:, columns] = part.continuation
        worst, sweeps = max(worst, part.residual), sweeps + part.sweeps
    return Solution(found, worst, sweeps)


def _report(
    progress: Progress | None, before: int, groups: int, done: int, residual: float, expected: float
) -> None:
    """Passes a group's progress on, as if the groups to come took as many sweeps."""
    if progress is not None:
        progress(before + done, residual, before + expected * groups)


class _Arrays(NamedTuple):
    successor: Array
    success: Array
    reward: Array
    cost: Array
    goal: Array
    gamma: Array
    answers: Array
    answer_success: Array
    policy: Array
    choice: Array
    social: Array
    rho: Array


def _arrays(problem: Problem, columns: np.ndarray, dtype: Any) -> _Arrays:
    """The arrays of a group of columns, padded to GROUP; without an answer, a trivial one."""
    number = lambda x: jnp.asarray(np.asarray(x), dtype=dtype)
    index = lambda x: jnp.asarray(np.asarray(x), dtype=jnp.int32)
    full = np.resize(columns, GROUP) if len(problem.goal) > 4 else columns
    answer = problem.answer
    policy = answer.policy if answer else np.ones((1, 0, 1))
    return _Arrays(
        index(problem.successor),
        number(problem.success),
        number(problem.reward.T),
        number(problem.cost),
        index(problem.goal[full]),
        number(problem.gamma),
        index(answer.successor if answer else np.zeros((0, problem.successor.shape[1]))),
        number(answer.success if answer else 1.0),
        number(policy),
        index(answer.choice[full] if answer else np.zeros(len(full))),
        number(answer.social.T if answer and answer.social is not None else np.zeros((1, 1))),
        number(answer.rho[full] if answer else np.zeros(len(full))),
    )


def _pick(rows: Array, choice: Array) -> Array:
    """rows [K, S or 1] at choice [P]: [S or 1, P], without a gather."""
    picked = rows[0][:, None]
    for k in range(1, rows.shape[0]):
        picked = jnp.where(choice == k, rows[k][:, None], picked)
    return picked


def _at(values: Array, index: Array) -> Array:
    return values.at[index].get(mode="promise_in_bounds")


def _continuation(values: Array, x: _Arrays) -> Array:
    """W from V."""
    result = values + x.rho * _pick(x.social, x.choice)
    for a in range(x.answers.shape[0]):
        moved = _at(values, x.answers[a]) - values
        result = result + x.answer_success * _pick(x.policy[:, a], x.choice) * moved
    return result


def _best(continuation: Array, x: _Arrays) -> Array:
    """V from W: the best action's value."""
    best = None
    for b in range(x.successor.shape[0]):
        moved = x.success * _at(continuation, x.successor[b]) + (1 - x.success) * continuation
        value = x.cost[b] + x.gamma * moved
        best = value if best is None else jnp.maximum(best, value)
    return _pick(x.reward, x.goal) + best


def _sweep(values: Array, x: _Arrays) -> Array:
    # The barrier keeps XLA from computing W anew for each of the actions that read it.
    return _best(jax.lax.optimization_barrier(_continuation(values, x)), x)


@partial(jax.jit, static_argnames=("sweeps",), donate_argnums=0)
def _chunk(values: Array, x: _Arrays, sweeps: int) -> tuple[Array, Array]:
    """Some sweeps, and the largest change of the last one for each column."""
    before = jax.lax.fori_loop(0, sweeps - 1, lambda _, v: _sweep(v, x), values)
    after = _sweep(before, x)
    return after, jnp.abs(after - before).max(0)


@jax.jit
def _extrapolate(values: Array, x: _Arrays, columns: Array) -> Array:
    """TV + gamma / (1 - gamma) (TV - V) in the chosen columns.

    Where the last sweep changed a whole closed class of states by the same amount, all later
    sweeps would change it by gamma, gamma^2, ... of that: the sum is added at once (MacQueen
    1966, DOI 10.1016/0022-247X(66)90060-6, for each state instead of a common bound, since
    different closed classes drift at different rates).
    """
    after = _sweep(values, x)
    further = after + x.gamma / (1 - x.gamma) * (after - values)
    return jnp.where(columns, further, after)


@partial(jax.jit, donate_argnums=0)
def _restore(values: Array, kept: Array, columns: Array) -> Array:
    return jnp.where(columns, kept, values)


_continuation_jit = jax.jit(_continuation)


def _solve_group(
    problem: Problem,
    columns: np.ndarray,
    tolerance: float,
    max_sweeps: int,
    report: Callable[[int, float, float], None],
) -> Solution:
    """Solves a group of columns: coarsely in single precision, then in double."""
    width = GROUP if len(problem.goal) > 4 else len(columns)
    values: Array = np.zeros((problem.successor.shape[1], width), dtype=np.float32)
    sweeps, history = 0, [np.inf]
    stages = [(np.float32, COARSE), (np.float64, tolerance)]
    for dtype, goal in stages if tolerance < COARSE else stages[1:]:
        with jax.enable_x64(dtype == np.float64):
            x = _arrays(problem, columns, dtype)
            values = jnp.asarray(np.asarray(values), dtype=dtype)
            kept, before = values, np.full(width, np.inf)
            wait = np.zeros(width, dtype=int)  # chunks to go before extrapolating again
            failures = np.zeros(width, dtype=int)
            stalled = 0
            while True:
                values, size = _chunk(values, x, CHUNK)
                size = np.asarray(size, float)
                sweeps += CHUNK
                worse = size > before
                if worse.any():
                    # The extrapolation was too early: modes that had not died out were amplified.
                    values = _restore(values, kept, jnp.asarray(worse))
                    size = np.where(worse, before, size)
                    failures[worse] += 1
                    wait[worse] = 2 * failures[worse]
                residual = float(size.max())
                report(sweeps, residual, _expected(sweeps, residual, history, tolerance))
                stalled = stalled + 1 if residual > 0.98 * min(history) else 0
                history.append(residual)
                if residual <= goal or (dtype == np.float32 and stalled >= 4):
                    break
                if sweeps >= max_sweeps:
                    message = f"the residual is {residual:.2g} after {sweeps} sweeps"
                    raise NotConverged(message)
                chosen = (wait == 0) & (size > goal)
                wait = np.maximum(wait - 1, 0)
                kept, before = values, np.where(chosen, size, np.inf)
                values = _extrapolate(values, x, jnp.asarray(chosen))
                sweeps += 1
            if dtype == np.float64:
                found = np.asarray(_continuation_jit(values, x))
                return Solution(found[:, : len(columns)], residual, sweeps)
    raise AssertionError("the second stage returns")


def _expected(sweeps: int, residual: float, history: list[float], tolerance: float) -> float:
    """Sweeps in all, if the residual goes on falling as it did."""
    old = history[len(history) // 2]
    chunks = len(history) - len(history) // 2
    if not np.isfinite(old) or residual >= old or residual <= 0:
        return 2.0 * sweeps
    rate = np.log(old / residual) / (chunks * CHUNK)
    return sweeps + max(0.0, np.log(residual / tolerance) / rate)


def boltzmann(problem: Problem, continuation: np.ndarray, beta: float) -> np.ndarray:
    """The softmax policies of all problems: policy(a | s) ~ exp(beta Q(s, a)), [P, A, S]."""
    m, actions = problem.success, problem.successor.shape[0]
    values = np.empty((len(problem.goal), actions, problem.successor.shape[1]))
    for b in range(actions):
        after = m * continuation[problem.successor[b]] + (1 - m) * continuation
        values[:, b] = (beta * (problem.cost[b] + problem.gamma * after)).T
    values -= values.max(axis=1, keepdims=True)
    np.exp(values, out=values)
    values /= values.sum(axis=1, keepdims=True)
    return values


def expected_reward(policy: np.ndarray, reward: np.ndarray, cost: np.ndarray) -> np.ndarray:
    """sum_a policy(a | s) (reward(s) + cost(a)): [S, K] from [K, A, S], [S, K] and [A]."""
    return reward + np.einsum("kas,a->sk", policy, cost)
