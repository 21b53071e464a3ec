"""Exact planning by value iteration, in JAX: arrays in, arrays out.

What makes it quick, apart from reading a successor's values for 16 problems as one contiguous
row: a drift common to all states is not iterated but subtracted (White 1963, MacQueen 1966,
DOI 10.1016/0022-247X(66)90060-6), so that values stay small enough for single precision; what
then decays slowly is extrapolated (`_cycle`); problems that have converged leave. Double
precision finishes. MacQueen's bounds say how far the result is from the truth: where
T(V) - V lies between l and u everywhere, the true value lies between V + l / (1 - gamma) and
V + u / (1 - gamma); the middle is taken.

Programs are few, and kept on disk: states are filled up to one of few sizes with copies of the
first ones, which change nothing, and problems to whole groups.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import ceil, log
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from i2pdsl.planning.problem import Problem
from i2pdsl.programs import compiled_program, on_devices
from i2pdsl.sizes import padded_size

Array = Any
Progress = Callable[[int, float, float], None]

# Groups of problems: their width, the problems for which it pays, and the relative cost of a sweep
# (measured). 16 numbers in single precision are one cache line, 4 doubles one register.
SINGLE = ((16, 9, 17), (4, 3, 6), (2, 1, 4))
DOUBLE = ((4, 3, 8), (2, 1, 5))
ONE_FOR_ALL = ((16, 1, 1),)  # in small worlds
REGROUP = 0.8  # groups are made anew where this part of the cost would do
STRIDE = 5  # sweeps between the three values that an extrapolation looks at
CYCLE = 2 * STRIDE
STAGES = np.array([STRIDE, STRIDE - 1, 1], np.int32)  # the sweeps of a cycle
LAST = np.array([0, 0, 1], np.int32)  # a single sweep, which returns W
WARM = 0.7  # cycles run for WARM / (1 - gamma) sweeps before the first extrapolation
SETTLE = 5  # cycles in double precision before the rounding of single precision is gone
STALLS = 4  # cycles without contraction, before rounding is blamed
ROUNDING = 5  # of values, in residuals: units in the last place below which no sweep leads
SAMPLE = 16_384  # states that weigh in an extrapolation
SMALL = 8192  # states up to which a single program in double precision does all


class NotConverged(Exception):
    """The residual did not fall below the tolerance."""


@dataclass(frozen=True)
class Solution:
    """The continuation W [S, P]: the value after the mover's action, before the answer.

    `residual` is the largest |TV - V| over states and problems for the V that W belongs to, in
    double precision; no W is further than `bound` from the truth (rounding aside); `sweeps` is the
    largest number that any problem took.
    """

    continuation: np.ndarray
    residual: float
    bound: float
    sweeps: int


def solve(
    problem: Problem,
    *,
    tolerance: float = 1e-4,
    forgiven: float = 0.0,
    max_sweeps: int = 100_000,
    start: np.ndarray | None = None,
    progress: Progress | None = None,
    say: Callable[[str], None] | None = None,
) -> Solution:
    """Solves V = TV for all columns, to a Bellman residual of `tolerance`.

    Args:
        forgiven: a residual that will do where rounding keeps it above the tolerance.
        start: values V [S, P] to begin with.
        progress: called every CYCLE sweeps with (sweeps so far, residual, sweeps expected in all).
        say: is told of damaged programs, which are made again.

    Raises NotConverged where `max_sweeps` or rounding keep the residual above the two.
    """
    states, count = problem.successor.shape[1], len(problem.goal)
    run = _Run(problem, max_sweeps, progress, say)
    # The values are h + drift / (1 - gamma); see _Run.
    h, drift = np.zeros((padded_states(states), count), np.float32), np.zeros(count)
    if start is not None:
        h[:] = start[np.resize(np.arange(states), len(h))]
    with jax.enable_x64(True):  # in this thread and block only; all types below are explicit
        coarse = count > 2 and states > SMALL  # else single precision gains nothing
        if coarse:
            run.sweep(h, drift, tolerance, ceil(WARM / (1 - problem.gamma) / CYCLE))
        h = h.astype(np.float64)
        warm = SETTLE if coarse else ceil(WARM / (1 - problem.gamma) / CYCLE)
        residual = float(run.sweep(h, drift, tolerance, warm).max())
    if not residual <= max(tolerance, forgiven):
        raise NotConverged(f"rounding keeps the residual at {residual:.2g}")
    return Solution(h[:states], residual, residual / (1 - problem.gamma), run.sweeps)


def padded_states(count: int) -> int:
    """The number of states, rounded up so that worlds of about one size share their programs; only
    a little where more states would cost more than compiling."""
    return padded_size(count, 1024, 1 if count <= SMALL else 8)


@dataclass
class _Run:
    """The iteration, and how many sweeps it has taken.

    A column's values are V = h + drift / (1 - gamma), so that TV - V = T(h) - h - drift. A drift
    in the middle of T(h) - h keeps h small, and makes the residual half the range of T(h) - h.
    """

    problem: Problem
    max_sweeps: int
    progress: Progress | None
    say: Callable[[str], None] | None
    sweeps: int = 0

    def sweep(self, h: np.ndarray, drift: np.ndarray, target: float, warm: int) -> np.ndarray:
        """Sweeps h [S, P], in its precision, until the residual is `target` or rounding keeps it
        from falling. Sets h, drift [P] in place; returns the residuals [P].

        In double precision, h becomes the continuation.
        """
        gamma = self.problem.gamma
        watch = _Watch(gamma, target, len(drift), warm, float(np.finfo(h.dtype).eps))
        while not watch.done.all():
            parts = _parts(self.problem, np.flatnonzero(~watch.done), h.dtype)
            groups = _groups(self.problem, parts, h.dtype)
            values = [_start(h[:, group.columns].swapaxes(0, 1)) for group in groups]
            watch.leaps[:] = False
            effort = _effort(self.problem, parts, h.dtype)
            while not watch.done.all() and REGROUP * effort < self.effort(watch, h.dtype):
                if self.sweeps + CYCLE > self.max_sweeps:
                    worst = watch.residual.max()
                    raise NotConverged(f"the residual is {worst:.2g} after {self.sweeps} sweeps")
                for i, group in enumerate(groups):
                    c = group.columns
                    values[i], swept = self.run(group, values[i], watch.leaps[c], drift[c], STAGES)
                    middle, residual = swept.changes()
                    drift[c] += gamma * middle  # the next change is gamma times this one
                    watch.update(c, residual, np.asarray(swept.size, float))
                self.sweeps += CYCLE
                if self.progress is not None:
                    worst = float(watch.residual.max())
                    left = log(max(worst / target, 1.0)) / -log(max(gamma, 1e-9))
                    self.progress(self.sweeps, worst, self.sweeps + left)
            for group, value in zip(groups, values, strict=True):
                c = group.columns
                h[:, c] = np.asarray(value.now).swapaxes(0, 1)
                if h.dtype == np.float64 and watch.done[c].any():
                    _, swept = self.run(group, value, np.zeros(c.shape, bool), drift[c], LAST)
                    middle, residual = swept.changes()
                    level = (drift[c] + middle) / (1 - gamma)
                    for own, w, above, left in zip(c, swept.w, level, residual, strict=True):
                        done = watch.done[own]
                        h[:, own[done]] = np.asarray(w)[:, done] + above[done]
                        watch.residual[own[done]] = left[done]
        return watch.residual

    def effort(self, watch: _Watch, dtype: np.dtype) -> int:
        """What the problems that are not done would cost in new groups."""
        parts = _parts(self.problem, np.flatnonzero(~watch.done), dtype)
        return _effort(self.problem, parts, dtype)

    def run(
        self, group: _Group, values: _Values, leaps: np.ndarray, drift: np.ndarray, stages: Array
    ) -> tuple[_Values, _Swept]:
        """`_cycle` of a group."""
        drift, stages = drift.astype(values.now.dtype), np.tile(stages, (len(drift), 1))
        arguments = (values, leaps, drift, stages, group.moves)
        apart = tuple(range(len(arguments)))
        program = compiled_program(("plan",), _cycle, arguments, _RESULT, self.say, apart=apart)
        moved: tuple[_Values, _Swept] = program.run(*arguments)
        return moved


class _Watch:
    """Which columns are done, and which may be extrapolated. All arrays are [P].

    Sweeps alone contract the residual by gamma; an extrapolation may raise it (`_cycle`). Then
    the column is left alone for 2, 4, 8, ... cycles, so that it converges whatever happens. If
    it still does not contract, rounding is in the way, and it is left as it is.
    """

    def __init__(self, gamma: float, target: float, count: int, warm: int, unit: float) -> None:
        self.target, self.unit = target, unit
        self.contraction = max(gamma, 1e-9) ** (CYCLE / 2)  # half of what a cycle should achieve
        self.residual, self.best = np.full(count, np.inf), np.full(count, np.inf)
        self.done = np.zeros(count, bool)
        self.leaps = np.zeros(count, bool)
        self.wait = np.full(count, warm)
        self.strikes, self.stalls = np.zeros(count, int), np.zeros(count, int)

    def update(self, c: np.ndarray, residual: np.ndarray, size: np.ndarray) -> None:
        """Takes the residuals of columns c after a cycle, and how large their values are."""
        leapt = self.leaps[c]
        failed = leapt & (residual >= self.residual[c])
        self.strikes[c] += failed
        self.wait[c] = np.where(failed, 2 ** self.strikes[c], np.maximum(self.wait[c] - 1, 0))
        better = leapt | (residual < self.contraction * self.best[c])
        self.stalls[c] = np.where(better, 0, self.stalls[c] + 1)
        self.best[c] = np.where(better, residual, self.best[c])
        self.residual[c] = residual
        enough = np.maximum(self.target, ROUNDING * self.unit * size)
        self.done[c] |= (residual <= enough) | (self.stalls[c] >= STALLS)
        self.leaps[c] = ~self.done[c] & (self.wait[c] == 0)


def _parts(problem: Problem, columns: np.ndarray, dtype: np.dtype) -> list[np.ndarray]:
    """Cuts columns into groups: of problems that face the same policies, whose probabilities are
    read once for all, unless the world is small."""
    if _is_small(problem) or not problem.answers:
        return _cut(problem, columns, dtype)
    faced = np.stack([answer.choice[columns] for answer in problem.answers])
    _, alike = np.unique(faced, axis=1, return_inverse=True)
    return [p for k in range(alike.max() + 1) for p in _cut(problem, columns[alike == k], dtype)]


def _cut(problem: Problem, columns: np.ndarray, dtype: np.dtype) -> list[np.ndarray]:
    if not len(columns):
        return []
    width, _ = _shape(problem, columns, dtype)
    return [columns[:width], *_cut(problem, columns[width:], dtype)]


def _shape(problem: Problem, columns: np.ndarray, dtype: np.dtype) -> tuple[int, int]:
    """The width of a group that begins with these problems, and its relative cost."""
    shapes = ONE_FOR_ALL if _is_small(problem) else SINGLE if dtype == np.float32 else DOUBLE
    return next((width, cost) for width, least, cost in shapes if len(columns) >= least)


def _effort(problem: Problem, parts: list[np.ndarray], dtype: np.dtype) -> int:
    """The relative cost of a sweep over groups of columns."""
    return sum(_shape(problem, part, dtype)[1] for part in parts)


def _is_small(problem: Problem) -> bool:
    """Whether a new program would cost more than it saves: then all groups have one shape."""
    return problem.successor.shape[1] <= SMALL


class _Moves(NamedTuple):
    """What a sweep over W columns reads. Actions that move nobody are left out."""

    successor: Array  # [A, S]
    cost: Array  # [A]
    stay: Array  # [], the best cost of an action that moves nobody
    success: Array  # []
    gamma: Array  # []
    reward: Array  # [S, W]
    answers: tuple[tuple[Array, Array, Array, Array], ...]
    # of each: successor [A, S]; q policy [A, S or 1, W or 1]; social [S or 1, W or 1]; rho [W]


class _Group(NamedTuple):
    """What is swept at once: on each of D devices its own W columns."""

    columns: np.ndarray  # [D, W], the last ones repeat others where there are too few
    moves: _Moves  # of each device, [D, ...]


def _groups(problem: Problem, parts: list[np.ndarray], dtype: np.dtype) -> list[_Group]:
    """Parts whose sweeps are one program, as many at once as there are devices."""
    alike: dict[Any, list[tuple[np.ndarray, _Moves]]] = {}
    devices = len(jax.devices())
    found = []
    for part in parts:
        columns, moves = _columns(problem, part, dtype)
        waiting = alike.setdefault(tuple(a.shape for a in jax.tree.leaves(moves)), [])
        waiting.append((columns, moves))
        if len(waiting) == devices:
            found.append(_side_by_side(waiting))
            waiting.clear()
    return found + [_side_by_side([*w, *w[:1] * (devices - len(w))]) for w in alike.values() if w]


def _side_by_side(own: list[tuple[np.ndarray, _Moves]]) -> _Group:
    columns, moves = zip(*own, strict=True)
    stacked = jax.tree.map(lambda *each: np.stack(each), *moves)
    return _Group(np.stack(columns), on_devices(stacked, len(own), apart=True))


def _columns(problem: Problem, columns: np.ndarray, dtype: np.dtype) -> tuple[np.ndarray, _Moves]:
    """The columns [W] of a part, and what a sweep over them reads."""
    small = _is_small(problem)
    columns = np.resize(columns, _shape(problem, columns, dtype)[0])
    everywhere = np.arange(problem.successor.shape[1])
    filled = np.resize(everywhere, padded_states(len(everywhere)))
    real = lambda x: np.asarray(x, dtype)
    index = lambda x: np.asarray(x, np.int32)[:, filled]
    moving = lambda successor: (successor != everywhere).any(1)
    answers = []
    for answer in problem.answers:
        moves, choice = moving(answer.successor), answer.choice[columns]
        if not small and np.ptp(choice) == 0:
            choice = choice[:1]
        policy = answer.success * real(answer.policy[:, moves])[choice].transpose(1, 2, 0)
        social = np.zeros((1, 1)) if answer.social is None else answer.social[:, choice]
        if small:
            shape = (len(everywhere), len(choice))
            policy = np.broadcast_to(policy, (len(policy), *shape))
            social = np.broadcast_to(social, shape)
        found = (
            index(answer.successor[moves]),
            real(policy if policy.shape[1] == 1 else policy[:, filled]),
            real(social if len(social) == 1 else social[filled]),
            real(answer.rho[columns]),
        )
        answers.append(found)
    moves = moving(problem.successor)
    moved = _Moves(
        index(problem.successor[moves]),
        real(problem.cost[moves]),
        real(problem.cost[~moves].max(initial=-np.inf)),
        real(problem.success),
        real(problem.gamma),
        real(problem.reward[np.ix_(filled, problem.goal[columns])]),
        tuple(answers),
    )
    return columns, moved


def _expectation(value: Array, moves: _Moves) -> Array:
    """W from V: for each answerer, the last one first, W + rho social + sum_a q policy(a)
    (W(next_a) - W)."""
    for successor, policy, social, rho in reversed(moves.answers):
        w = value + rho * social
        for a in range(len(successor)):
            w += policy[a] * (value.at[successor[a]].get(mode="promise_in_bounds") - value)
        value = w
    return value


def _best(w: Array, moves: _Moves) -> Array:
    """V from W: reward + max_b (cost(b) + gamma (m W(next_b) + (1 - m) W))."""
    m, gamma = moves.success, moves.gamma
    best = jnp.full_like(w, -jnp.inf)
    for b in range(len(moves.successor)):
        after = w.at[moves.successor[b]].get(mode="promise_in_bounds")
        best = jnp.maximum(best, moves.cost[b] + gamma * m * after)
    return moves.reward + jnp.maximum(best + gamma * (1 - m) * w, moves.stay + gamma * w)


class _Values(NamedTuple):
    """Where a part stands: h [S, W] now and STRIDE sweeps before, how far to leap on [W]."""

    now: Array
    before: Array
    further: Array


class _Swept(NamedTuple):
    """What the last sweep of a cycle did, for the h before it."""

    w: Array  # [S, W], the continuations of h after LAST
    least: Array  # [W], the least T(h) - drift - h
    most: Array  # [W], the largest
    size: Array  # [W], the largest |h|

    def changes(self) -> tuple[np.ndarray, np.ndarray]:
        """The middle and half the range of T(h) - drift - h: [D, W] each, of all devices."""
        low, high = np.asarray(self.least, float), np.asarray(self.most, float)
        return (low + high) / 2, (high - low) / 2


_RESULT = (_Values(0, 0, 0), _Swept(0, 0, 0, 0))


def _start(h: np.ndarray) -> _Values:
    """Where parts begin, of values [D, S, W]."""
    values = _Values(h, h, np.zeros((len(h), h.shape[2]), h.dtype))
    return on_devices(values, len(h), apart=True)


def _cycle(
    values: _Values, leaps: Array, drift: Array, stages: Array, moves: _Moves
) -> tuple[_Values, _Swept]:
    """Sweeps of T - drift, in three stages: those of STAGES, or LAST.

    Before them, columns leap to where they seem to go: to h + c (h - h'), with h', h'' the values
    STRIDE and 2 STRIDE sweeps before h, where c makes |(h - h') + c ((h - h') - (h' - h''))|^2
    least. This is Aitken's extrapolation with one ratio for all states (reduced rank
    extrapolation of rank 1, Sidi 1986, DOI 10.1016/0377-0427(86)90032-1). It removes what
    contracts slowest: once the common drift is gone, the differences between closed classes of
    states, by gamma a sweep. If it comes too early, as best actions still change, it does harm.

    A condition that always holds makes XLA compute W once: it would merge W into the reads of it,
    and compute it anew for each of the mover's actions (measured: 2.3 times as slow). For the like
    reason the numbers of sweeps are an argument: the last would be merged with what reads it.
    """

    def sweep(_: Array, h: Array) -> Array:
        w = jax.lax.cond(stages[2] > 0, lambda: _expectation(h, moves), lambda: h)
        return _best(w, moves) - drift

    c = jnp.where(leaps, values.further, 0)
    first = values.now + c * (values.now - values.before)
    middle = jax.lax.fori_loop(0, stages[0], sweep, first)
    late = jax.lax.fori_loop(0, stages[1], sweep, middle)
    last = jax.lax.fori_loop(0, stages[2], sweep, late)
    z, y, x = (h[:: 1 + len(h) // SAMPLE].astype(jnp.float64) for h in (first, middle, last))
    new, change = x - y, (x - y) - (y - z)
    c = -(new * change).sum(0) / jnp.maximum((change * change).sum(0), 1e-300)
    w = jax.lax.cond(stages[0] > 0, lambda: late, lambda: _expectation(late, moves))
    changed = last - late
    swept = _Swept(w, changed.min(0), changed.max(0), jnp.abs(late).max(0))
    return _Values(last, middle, c.astype(last.dtype)), swept
