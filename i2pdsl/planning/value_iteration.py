"""Exact planning by value iteration, in JAX: arrays in, arrays out.

One family of problems: a *mover* acts, then (if there is one) an *answerer* acts by a fixed
stochastic policy. Shapes: S states, A actions, P problems (one column each), G distinct goals,
K distinct policies of the answerer. Rewards and values are in the story's units, per turn.

    W(s)    = rho social(s) + sum_a policy(a | s) (q V(next_a(s)) + (1 - q) V(s))
    Q(s, b) = reward(s) + cost(b) + gamma (m W(next_b(s)) + (1 - m) W(s))
    V(s)    = max_b Q(s, b)

with m, q the success probabilities of mover and answerer; W = V where nobody answers.

What makes it quick, apart from reading a successor's values for 16 problems as one contiguous
row: a drift common to all states is not iterated but subtracted (White 1963, MacQueen 1966,
DOI 10.1016/0022-247X(66)90060-6), so that values stay small enough for single precision; what
then decays slowly is extrapolated (`_cycle`); problems that have converged leave. Double
precision finishes, and measures the residual that is reported.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import ceil, log
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

Array = Any
Progress = Callable[[int, float, float], None]

WIDTH = 16  # problems in a group: a row of single precision is one cache line
STRIDE = 5  # sweeps between the three values that an extrapolation looks at
CYCLE = 2 * STRIDE
WARM = 0.7  # cycles run for WARM / (1 - gamma) sweeps before the first extrapolation
STALLS = 4  # cycles without contraction, before rounding is blamed
MARGIN = 0.8  # the sweeps end at this part of the tolerance, as single precision is not exact
SAMPLE = 16_384  # states that weigh in an extrapolation
ONE = np.int32(1)


class NotConverged(Exception):
    """The residual did not fall below the tolerance."""


@dataclass(frozen=True)
class Answer:
    """How the other character answers: by a fixed stochastic policy.

    Attributes:
        successor: int [A, S], the state after a successful action (blocked or stay: s itself).
        success: probability q that an action succeeds; else the state stays.
        policy: [K, A, S], or [K, A, 1] where it does not depend on the state.
        choice: int [P], the policy that each problem faces.
        social: [S, K], the answerer's own expected reward under each policy, or None.
        rho: [P], the weight of that reward for the mover.
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
        reward: [S, G], the reward for acting in a state, for each distinct goal.
        cost: [A], added for an action.
        goal: int [P], the goal of each problem.
        gamma: discount factor per turn, 0 <= gamma < 1.
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
    """The continuation W [S, P]: the value after the mover's action, before the answer.

    `residual` is max |TV - V| over states and problems for the V that W implies, measured by a
    sweep in double precision; `sweeps` is the largest number that any problem took.
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
    """Solves V = TV for all columns, to a Bellman residual of `tolerance`.

    Args:
        progress: called every CYCLE sweeps with (sweeps so far, residual, sweeps expected in all).

    Raises NotConverged where `max_sweeps` or rounding keep the residual above the tolerance.
    """
    states, count = problem.successor.shape[1], len(problem.goal)
    run = _Run(problem, max_sweeps, progress)
    todo, residual = np.arange(count), np.full(count, np.inf)
    # The values are h + drift / (1 - gamma); see _Run.
    h, drift = np.zeros((states, count), np.float32), np.zeros(count)
    with jax.enable_x64(True):  # in this thread and block only; all types below are explicit
        coarse = count > 2 and states * count > 100_000  # else single precision gains nothing
        if coarse:
            run.sweep(h, drift, todo, MARGIN * tolerance)
        h = h.astype(np.float64)
        for attempt in range(3):
            if attempt or not coarse:
                run.sweep(h, drift, todo, MARGIN * tolerance / 2**attempt)
            for part in _parts(problem, todo):
                values = h[:, part] + drift[part] / (1 - problem.gamma)
                continuation, residual[part] = _measured(problem, values, part)
                good = residual[part] <= tolerance
                h[:, part[good]] = continuation[:, good]  # the answer takes its place
            todo = np.flatnonzero(~(residual <= tolerance))
            if not todo.size:
                return Solution(h, float(residual.max()), run.sweeps)
    raise NotConverged(f"rounding keeps the residual at {residual.max():.2g}")


@dataclass
class _Run:
    """The iteration, and how many sweeps it has taken.

    A column's values are V = h + drift / (1 - gamma), so that TV - V = T(h) - h - drift. A drift
    in the middle of T(h) - h keeps h small, and makes the residual half the range of T(h) - h.
    """

    problem: Problem
    max_sweeps: int
    progress: Progress | None
    sweeps: int = 0

    def sweep(self, h: np.ndarray, drift: np.ndarray, columns: np.ndarray, target: float) -> None:
        """Sweeps columns of h [S, P], in its precision, until the residual is about `target`, or
        rounding keeps it from falling. Sets h and drift [P] in place."""
        gamma = self.problem.gamma
        watch = _Watch(gamma, target, len(drift), columns)
        while not watch.done.all():
            parts = _parts(self.problem, np.flatnonzero(~watch.done))
            groups = [_group(self.problem, part, h.dtype) for part in parts]
            values = [_start(h[:, group.columns]) for group in groups]
            watch.leaps[:] = False
            effort = _effort(self.problem, parts)
            while effort <= _effort(self.problem, _parts(self.problem, ~watch.done)):
                if self.sweeps + CYCLE > self.max_sweeps:
                    worst = watch.residual[columns].max()
                    raise NotConverged(f"the residual is {worst:.2g} after {self.sweeps} sweeps")
                for i, (c, moves) in enumerate(groups):
                    constant = jnp.asarray(drift[c].astype(h.dtype))
                    values[i], least, most = _cycle(values[i], watch.leaps[c], constant, ONE, moves)
                    low, high = np.asarray(least, float), np.asarray(most, float)
                    drift[c] += gamma * (low + high) / 2  # the next change is gamma times this one
                    watch.update(c, (high - low) / 2)
                self.sweeps += CYCLE
                if self.progress is not None:
                    worst = float(watch.residual[columns].max())
                    left = log(max(worst / target, 1.0)) / -log(max(gamma, 1e-9))
                    self.progress(self.sweeps, worst, self.sweeps + left)
            for part, value in zip(parts, values, strict=True):
                h[:, part] = np.asarray(value.now)[:, : len(part)]


class _Watch:
    """Which columns are done, and which may be extrapolated. All arrays are [P].

    Sweeps alone contract the residual by gamma; an extrapolation may raise it (`_cycle`). Then
    the column is left alone for 2, 4, 8, ... cycles, so that it converges whatever happens. If
    it still does not contract, rounding is in the way, and it is left as it is.
    """

    def __init__(self, gamma: float, target: float, count: int, columns: np.ndarray) -> None:
        self.target = target
        self.contraction = max(gamma, 1e-9) ** (CYCLE / 2)  # half of what a cycle should achieve
        self.residual, self.best = np.full(count, np.inf), np.full(count, np.inf)
        self.done = ~np.isin(np.arange(count), columns)
        self.leaps = np.zeros(count, bool)
        self.wait = np.full(count, ceil(WARM / (1 - gamma) / CYCLE))
        self.strikes, self.stalls = np.zeros(count, int), np.zeros(count, int)

    def update(self, c: np.ndarray, residual: np.ndarray) -> None:
        """Takes the residuals of columns c after a cycle."""
        leapt = self.leaps[c]
        failed = leapt & (residual >= self.residual[c])
        self.strikes[c] += failed
        self.wait[c] = np.where(failed, 2 ** self.strikes[c], np.maximum(self.wait[c] - 1, 0))
        better = leapt | (residual < self.contraction * self.best[c])
        self.stalls[c] = np.where(better, 0, self.stalls[c] + 1)
        self.best[c] = np.where(better, residual, self.best[c])
        self.residual[c] = residual
        self.done[c] |= (residual <= self.target) | (self.stalls[c] >= STALLS)
        self.leaps[c] = ~self.done[c] & (self.wait[c] == 0)


def _parts(problem: Problem, columns: np.ndarray) -> list[np.ndarray]:
    """Cuts columns (numbers or a mask) into groups: of problems that face the same policy, whose
    probabilities are read once for all, unless mixed groups are less work."""
    choice = problem.answer.choice if problem.answer else np.zeros(len(problem.goal), int)
    columns = np.arange(len(choice))[columns]
    columns = columns[np.argsort(choice[columns], kind="stable")]
    cut = lambda c: [c[i : i + WIDTH] for i in range(0, len(c), WIDTH)]
    alike = [p for k in np.unique(choice[columns]) for p in cut(columns[choice[columns] == k])]
    mixed = cut(columns)
    return alike if _effort(problem, alike) <= _effort(problem, mixed) else mixed


def _effort(problem: Problem, parts: list[np.ndarray]) -> int:
    """The relative cost of a sweep over groups of columns (measured)."""
    alike = lambda part: problem.answer is None or np.ptp(problem.answer.choice[part]) == 0
    return sum((4 if len(part) > 2 else 1) if alike(part) else 6 for part in parts)


class _Moves(NamedTuple):
    """What a sweep over W columns reads, on the device. Actions that move nobody are left out."""

    successor: Array  # [A, S]
    cost: Array  # [A]
    stay: Array  # [], the best cost of an action that moves nobody
    success: Array  # []
    gamma: Array  # []
    reward: Array  # [S, W]
    answer: tuple[Array, Array, Array, Array] | None
    # successor [A, S]; q policy [A, S or 1, W or 1]; social [S or 1, W or 1]; rho [W]


class _Group(NamedTuple):
    columns: np.ndarray  # [W], the last ones repeat the first where there are too few
    moves: _Moves


def _group(problem: Problem, columns: np.ndarray, dtype: np.dtype) -> _Group:
    columns = np.resize(columns, WIDTH if len(columns) > 2 else 2)
    real = lambda x: jnp.asarray(np.asarray(x, dtype))
    index = lambda x: jnp.asarray(np.asarray(x, np.int32))
    everywhere = np.arange(problem.successor.shape[1])
    moving = lambda successor: (successor != everywhere).any(1)
    answer, found = problem.answer, None
    if answer is not None:
        moves, choice = moving(answer.successor), answer.choice[columns]
        choice = choice[:1] if np.ptp(choice) == 0 else choice
        policy = np.asarray(answer.policy[:, moves], dtype)[choice].transpose(1, 2, 0)
        social = np.zeros((1, 1)) if answer.social is None else answer.social[:, choice]
        found = (
            index(answer.successor[moves]),
            real(answer.success * policy),
            real(social),
            real(answer.rho[columns]),
        )
    moves = moving(problem.successor)
    return _Group(
        columns,
        _Moves(
            index(problem.successor[moves]),
            real(problem.cost[moves]),
            real(problem.cost[~moves].max(initial=-np.inf)),
            real(problem.success),
            real(problem.gamma),
            real(problem.reward[:, problem.goal[columns]]),
            found,
        ),
    )


def _expectation(value: Array, moves: _Moves) -> Array:
    """W from V: rho social + V + sum_a q policy(a) (V(next_a) - V)."""
    if moves.answer is None:
        return value
    successor, policy, social, rho = moves.answer
    w = value + rho * social
    for a in range(len(successor)):
        w += policy[a] * (value.at[successor[a]].get(mode="promise_in_bounds") - value)
    return w


def _best(w: Array, moves: _Moves) -> Array:
    """V from W: reward + max_b (cost(b) + gamma (m W(next_b) + (1 - m) W))."""
    m, gamma = moves.success, moves.gamma
    best = jnp.full_like(w, -jnp.inf)
    for b in range(len(moves.successor)):
        after = w.at[moves.successor[b]].get(mode="promise_in_bounds")
        best = jnp.maximum(best, moves.cost[b] + gamma * m * after)
    return moves.reward + jnp.maximum(best + gamma * (1 - m) * w, moves.stay + gamma * w)


class _Values(NamedTuple):
    """Where a group stands: h [S, W] now and STRIDE sweeps before, how far to leap on [W]."""

    now: Array
    before: Array
    further: Array


def _start(h: np.ndarray) -> _Values:
    return _Values(jnp.asarray(h), jnp.array(h), jnp.zeros(h.shape[1], h.dtype))


def _sweeps(h: Array, drift: Array | float, n: Array, moves: _Moves) -> Array:
    """h after n sweeps of T - drift.

    A condition that always holds makes XLA compute W once: it would merge W into the reads of it,
    and compute it anew for each of the mover's actions (measured: 2.3 times as slow). For the like
    reason, n is an argument: a single sweep would be merged with what reads its result.
    """

    def sweep(_: Array, h: Array) -> Array:
        w = jax.lax.cond(n > 0, lambda: _expectation(h, moves), lambda: h)
        return _best(w, moves) - drift

    return jax.lax.fori_loop(0, n, sweep, h)


@partial(jax.jit, donate_argnums=0)
def _cycle(
    values: _Values, leaps: Array, drift: Array, one: Array, moves: _Moves
) -> tuple[_Values, Array, Array]:
    """CYCLE sweeps; the least and the largest T(h) - drift - h in the last one [W].

    Before them, columns leap to where they seem to go: to h + c (h - h'), with h', h'' the values
    STRIDE and 2 STRIDE sweeps before h, where c makes |(h - h') + c ((h - h') - (h' - h''))|^2
    least. This is Aitken's extrapolation with one ratio for all states (reduced rank
    extrapolation of rank 1, Sidi 1986, DOI 10.1016/0377-0427(86)90032-1). It removes what
    contracts slowest: once the common drift is gone, the differences between closed classes of
    states, by gamma a sweep. If it comes too early, as best actions still change, it does harm.
    """
    c = jnp.where(leaps, values.further, 0)
    first = values.now + c * (values.now - values.before)
    middle = _sweeps(first, drift, STRIDE * one, moves)
    late = _sweeps(middle, drift, (STRIDE - 1) * one, moves)
    last = _sweeps(late, drift, one, moves)
    z, y, x = (h[:: 1 + len(h) // SAMPLE].astype(jnp.float64) for h in (first, middle, last))
    new, change = x - y, (x - y) - (y - z)
    c = -(new * change).sum(0) / jnp.maximum((change * change).sum(0), 1e-300)
    low, high = (last - late).min(0), (last - late).max(0)
    return _Values(last, middle, c.astype(last.dtype)), low, high


def _measured(
    problem: Problem, values: np.ndarray, columns: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """W [S, columns] of V [S, columns], and max |TV' - V'| of the V' = TV that W implies."""
    c, moves = _group(problem, columns, values.dtype)
    w, residual = _measure(jnp.asarray(np.resize(values.T, (len(c), len(values))).T), ONE, moves)
    return np.asarray(w)[:, : len(columns)], np.asarray(residual)[: len(columns)]


@jax.jit
def _measure(values: Array, one: Array, moves: _Moves) -> tuple[Array, Array]:
    implied = _sweeps(values, 0.0, one, moves)
    again = _sweeps(implied, 0.0, one, moves)
    return _expectation(values, moves), jnp.abs(again - implied).max(0)


def q_values(problem: Problem, continuation: np.ndarray, column: int) -> np.ndarray:
    """Q [A, S] of one problem, from the continuations [S, P]."""
    w, m = np.ascontiguousarray(continuation[:, column]), problem.success
    reward = problem.reward[:, problem.goal[column]]
    q = np.empty(problem.successor.shape)
    for b, successor in enumerate(problem.successor):
        q[b] = reward + problem.cost[b] + problem.gamma * (m * w[successor] + (1 - m) * w)
    return q


def boltzmann(problem: Problem, continuation: np.ndarray, beta: float) -> np.ndarray:
    """The softmax policies, policy(a | s) ~ exp(beta Q(s, a)): [P, A, S], as in `Answer`."""
    policy = np.empty((len(problem.goal), *problem.successor.shape))
    for column, p in enumerate(policy):
        q = q_values(problem, continuation, column)
        np.exp(beta * (q - q.max(0)), out=p)
        p /= p.sum(0)
    return policy


def expected_reward(policy: np.ndarray, reward: np.ndarray, cost: np.ndarray) -> np.ndarray:
    """sum_a policy(a | s) (reward(s) + cost(a)): [S, K], from [K, A, S or 1], [S, K] and [A]."""
    return reward + np.einsum("kas,a->sk", policy, cost)
