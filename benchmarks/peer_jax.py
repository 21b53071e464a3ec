"""The work of `peers.py` in JAX, by hand, for one objective and without a language: `jit`, `scan`,
`while_loop`, and rows of values that one gather reads for all problems (`V[next]`).

Needs no i2pdsl. Shapes as in peer_arrays.py and peer_numpy.py.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from peer_arrays import ACTS, EFFECTS, FAILS, STAY, Arrays

Array = Any
STRIDE, STALLS = 5, 4  # sweeps between extrapolated values; cycles that may bring nothing
SMALL = 8192  # states up to which single precision saves less than it takes to compile
PLACES = 256  # beams times width that are searched together


# ---- Planning ------------------------------------------------------------------------------------


def _take(v: Array, states: Array) -> Array:
    return v.at[states].get(mode="promise_in_bounds")


def _solved(
    expect: Any, moves: Any, v: Array, drift: Array, gamma: float, tolerance: float, warm: int
) -> Any:
    """V = h + drift / (1 - gamma) for which half the range of a sweep's change is `tolerance`, or
    until that stops falling: (h, drift, residual, sweeps).

    After `warm` cycles, what decays slowly is extrapolated, column by column (Sidi 1986); a column
    that this does no good waits for 2, 4, 8, ... cycles.
    """
    q, home, cost, successor = moves

    def sweep(h: Array, drift: Array, always: Array) -> Array:
        # Without a condition XLA computes w anew for each gather of it, which takes six times as
        # long (measured; `optimization_barrier` changes nothing on a CPU).
        w = jax.lax.cond(always, lambda: expect(h), lambda: h)
        best = cost[STAY] + gamma * w
        for move in range(STAY):
            after = _take(w, successor[move])
            after = after if q is None else q * after + (1 - q) * w
            best = jnp.maximum(best, cost[move] + gamma * after)
        return home + best - drift

    def cycle(carry: Any) -> Any:
        h, drift, leap, before, wait, strikes, stalls, sweeps = carry
        always = sweeps >= 0
        some = lambda count, h: jax.lax.fori_loop(0, count, lambda _, h: sweep(h, drift, always), h)
        middle = some(STRIDE, h + leap)
        late = some(STRIDE - 1, middle)
        last = sweep(late, drift, always)
        low, high = (last - late).min(0), (last - late).max(0)
        residual, leapt = (high - low) / 2, (leap != 0).any(0)
        failed = leapt & (residual >= before)
        strikes = strikes + failed
        wait = jnp.where(failed, 2**strikes, jnp.maximum(wait - 1, 0))
        new = last - middle
        change = new - (middle - h - leap)
        ratio = -(new * change).sum(0) / jnp.maximum((change * change).sum(0), 1e-30)
        # Below a few units in the last place of the values no sweep leads.
        enough = jnp.maximum(tolerance, 5 * jnp.finfo(h.dtype).eps * jnp.abs(late).max(0))
        leap = jnp.where((wait == 0) & (residual > enough), ratio * new, 0)
        fell = leapt | (residual < gamma**STRIDE * before)
        drift = drift + gamma * (low + high) / 2
        stalls = jnp.where(residual <= enough, STALLS, jnp.where(fell, 0, stalls + 1))
        return last, drift, leap, residual, wait, strikes, stalls, sweeps + 2 * STRIDE

    def go_on(carry: Any) -> Array:
        _, _, _, residual, _, _, stalls, _ = carry
        return ((residual > tolerance) & (stalls < STALLS)).any()

    columns = v.shape[1]
    none = jnp.zeros(columns, int)
    inf = jnp.full(columns, jnp.inf, v.dtype)
    first = (v, drift, jnp.zeros_like(v), inf, none + warm, none, none, 0)
    h, drift, *_, sweeps = jax.lax.while_loop(go_on, cycle, first)
    change = sweep(h, drift, sweeps >= 0) - h
    low, high = change.min(0), change.max(0)
    return h, drift + (low + high) / 2, (high - low).max() / 2, sweeps


@partial(jax.jit, static_argnames=("gamma", "tolerance", "warm"))
def _weak(
    h: Array, drift: Array, moves: Any, other: Array, gamma: float, tolerance: float, warm: int
) -> Any:
    expect = lambda h: sum(_take(h, after) for after in other) / len(other)
    return _solved(expect, moves, h, drift, gamma, tolerance, warm)


@partial(jax.jit, static_argnames=("gamma", "tolerance", "warm"))
def _strong(
    h: Array, drift: Array, moves: Any, answer: Any, gamma: float, tolerance: float, warm: int
) -> Any:
    successor, policy, social, rho = answer

    def expect(h: Array) -> Array:
        w = h + social[:, None] * rho
        for move in range(STAY):
            w += policy[move][:, None] * (_take(h, successor[move]) - h)
        return w

    return _solved(expect, moves, h, drift, gamma, tolerance, warm)


def _in_both(solve: Any, given: Any, count: int, states: int, gamma: float, tol: float) -> Any:
    """In single precision as far as that leads, then in doubles."""
    h, drift = np.zeros((states, count)), np.zeros(count)
    sweeps = []
    late = int(0.7 / (1 - gamma)) // (2 * STRIDE)
    phases = ((np.float32, late), (np.float64, 5)) if states > SMALL else ((np.float64, late),)
    for dtype, warm in phases:
        narrow = lambda x, dtype=dtype: x.astype(dtype) if x.dtype.kind == "f" else x
        h, drift, residual, number = solve(
            *(jax.tree.map(narrow, x) for x in (np.asarray(h), np.asarray(drift), *given)),
            gamma,
            tol,
            warm,
        )
        sweeps.append(int(number))
    assert float(residual) <= tol, residual
    return np.asarray(h) + np.asarray(drift) / (1 - gamma), sweeps


def planned(a: Arrays, tolerance: float) -> tuple[np.ndarray, np.ndarray, list[Any]]:
    """V of the weak one [S, G] and of the strong one [S, P], and the sweeps of each block in single
    precision and in doubles."""
    from peer_numpy import q_weak, softmax

    gamma, states = float(a.gamma), a.weak_next.shape[1]
    home = a.weak_home.T.astype(float)
    moves = (a.success, home, a.cost, a.weak_next)
    weak, count = _in_both(
        _weak, (moves, a.strong_next), len(a.weak_home), states, gamma, tolerance
    )
    policy, sweeps = softmax(a, q_weak(a, weak)), [count]
    strong = np.empty((states, len(a.rho)))
    for facing, problems in a.blocks:
        pi = policy[:, :, facing]
        paid = pi @ a.cost + (a.weak_home[facing] if facing < len(a.weak_home) else 0)
        answer = (a.weak_next, a.success * pi.T.copy(), paid, a.rho[problems])
        home = a.strong_home[a.strong_goal[problems]].T.astype(float)
        given = ((None, home, a.cost, a.strong_next), answer)
        found = _in_both(_strong, given, len(problems), states, gamma, tolerance)
        strong[:, problems], count = found
        sweeps.append(count)
    return weak, strong, sweeps


def policies(a: Arrays, weak: Array, strong: Array) -> tuple[Array, Array]:
    """The policies [S, A, G + 1] and [S, A, P + 1] of values [S, G] and [S, P], in single
    precision: all that posteriors and searches read."""
    blocks = tuple((facing, int(p[0]), int(p[-1]) + 1) for facing, p in a.blocks)
    return _policies(a, weak, strong, blocks)


@partial(jax.jit, static_argnames="blocks")
def _policies(a: Arrays, weak: Array, strong: Array, blocks: Any) -> tuple[Array, Array]:

    def softmax(q: Array) -> Array:
        p = jax.nn.softmax(a.beta * q, axis=1).astype(jnp.float32)
        return jnp.pad(p, ((0, 0), (0, 0), (0, 1)), constant_values=1 / q.shape[1])

    mean = sum(_take(weak, after) for after in a.strong_next) / len(a.strong_next)
    after = a.success * _take(mean, a.weak_next.T) + (1 - a.success) * mean[:, None]
    first = softmax(a.weak_home.T[:, None] + a.cost[:, None] + a.gamma * after)
    parts = []
    for facing, begin, end in blocks:
        problems = slice(begin, end)
        pi, own = first[:, :, facing], strong[:, problems]
        paid = pi @ a.cost + (a.weak_home[facing] if facing < len(a.weak_home) else 0)
        w = own + paid[:, None] * a.rho[problems]
        for move in range(STAY):
            w += a.success * pi[:, move, None] * (_take(own, a.weak_next[move]) - own)
        home = a.strong_home[a.strong_goal[problems]].T
        parts.append(home[:, None] + a.cost[:, None] + a.gamma * _take(w, a.strong_next.T))
    return first, softmax(jnp.concatenate(parts, axis=2))


# ---- The audience --------------------------------------------------------------------------------


def seen(forgetting: Array, belief: Array, likelihood: Array) -> Array:
    """Bayes' rule, normalisation and forgetting along the last axis."""
    joint = belief * likelihood
    joint = joint / joint.sum(-1, keepdims=True)
    share = forgetting / (joint.shape[-1] - 1)
    return joint * (1 - forgetting - share) + share


@partial(jax.jit, static_argnames="see")
def posterior(
    a: Arrays, weak: Array, strong: Array, starts: Array, actions: Array, see: Any = seen
) -> Array:
    """P(rho > 0 | script[:t]) of scripts, t = 0..T: [N, T + 1]; see peer_numpy.posterior."""
    acts, effects = jnp.asarray(ACTS), jnp.asarray(EFFECTS)
    count, n = len(a.rational), len(starts)

    def asked(belief: Array) -> Array:
        return belief @ a.helps / (belief @ a.rational)

    def frame(carry: Any, action: Array) -> Any:
        state, belief = carry
        own, answer = action // len(a.cost), action % len(a.cost)
        belief = see(a.forgetting, belief, weak[state, acts[own]][:, a.weak_of])
        state = a.weak_next[effects[own], state]
        belief = see(a.forgetting, belief, strong[state, answer][:, a.strong_of])
        state = a.strong_next[answer, state]
        return (state, belief), asked(belief)

    first = jnp.full((n, count), 1 / count, weak.dtype)
    _, found = jax.lax.scan(frame, (starts, first), actions.T)
    return jnp.concatenate([asked(first)[None], found]).T


# ---- The search ----------------------------------------------------------------------------------


def _ahead(a: Arrays, weak: Array, strong: Array, state: Array, belief: Array, see: Any) -> Any:
    """The K = 45 children of prefixes in states [M] with beliefs [M, H]: their beliefs [M, K, H],
    states, whether the weak one tried and succeeded, and whether they can happen, [M, K]."""
    reached = a.weak_next[:, state].T
    first = see(a.forgetting, belief[:, None], weak[state][..., a.weak_of])
    likelihood = strong[reached][..., a.strong_of]
    second = see(a.forgetting, first[:, ACTS, None], likelihood[:, EFFECTS])
    moved = (reached != state[:, None])[:, ACTS]
    flat = (len(state), len(ACTS) * len(a.cost))
    wide = lambda x: jnp.repeat(x, len(a.cost), axis=1)
    after = a.strong_next[:, reached[:, EFFECTS]].transpose(1, 2, 0).reshape(flat)
    return second.reshape(*flat, -1), after, wide(moved), wide(moved & ~FAILS), wide(moved | ~FAILS)


@partial(jax.jit, static_argnames=("length", "width", "offspring", "see"))
def _searched(
    a: Arrays,
    weak: Array,
    strong: Array,
    starts: Array,
    length: int,
    width: int,
    offspring: int,
    see: Any = seen,
) -> tuple[Array, Array]:
    n, hypotheses, k = len(starts), len(a.rational), len(ACTS) * len(a.cost)
    kind, rows = weak.dtype, jnp.arange(len(starts))[:, None]
    share = jnp.arange(k) % width == jnp.arange(width)[:, None]
    kept = min(offspring, k)
    asked = jnp.stack([a.helps, a.rational]).T.astype(kind)

    def frame(pool: Any, t: Array) -> Any:
        state, belief, sums, tried, succeeded, worth = pool
        flat = belief.reshape(n * width, hypotheses)
        minds, after, tries, success, valid = (
            x.reshape(n, width, *x.shape[1:])
            for x in _ahead(a, weak, strong, state.reshape(-1), flat, see)
        )
        helps, rational = jnp.moveaxis(minds @ asked, -1, 0)
        total = sums[..., None] + helps / rational + rational
        tries, success = tried[..., None] + tries, succeeded[..., None] + success
        miss = jnp.where(tries > 0, (success / jnp.maximum(tries, 1) - a.success) ** 2, 0)
        alive = valid & (worth[..., None] > -jnp.inf) & ((t > 0) | share)
        value = jnp.where(alive, total - miss, -jnp.inf)
        if width == 1:
            child, parent = value.argmax(2), jnp.zeros((n, 1), int)
            at = (rows, parent, child)
            dead = jnp.zeros((n, 1), bool)
        else:
            best, child = jax.lax.top_k(value, kept)
            parent = jnp.broadcast_to(jnp.arange(width)[:, None], (n, width, kept)).reshape(n, -1)
            order = jnp.argsort(-best.reshape(n, -1), axis=1, stable=True)
            parent, child = parent[rows, order], child.reshape(n, -1)[rows, order]
            at = (rows, parent, child)
            alive = (value[at] > -jnp.inf) & ~_repeated(value[at], after[at], minds[at])
            chosen = jnp.argsort(~alive, axis=1, stable=True)[:, :width]
            parent, child = parent[rows, chosen], child[rows, chosen]
            dead, at = ~alive[rows, chosen], (rows, parent, child)
        worth = jnp.where(dead, -jnp.inf, value[at])
        pool = (after[at], minds[at], total[at], tries[at], success[at], worth)
        return pool, (parent, child)

    zeros = jnp.zeros((n, width), kind)
    first = jnp.full((n, width, hypotheses), 1 / hypotheses, kind)
    pool = (jnp.repeat(starts[:, None], width, axis=1), first, zeros, zeros, zeros, zeros)
    pool, (parents, children) = jax.lax.scan(frame, pool, jnp.arange(length))
    top = pool[-1].argmax(1)

    def back(place: Array, step: Any) -> Any:
        parent, child = step
        return parent[rows[:, 0], place], child[rows[:, 0], place]

    _, actions = jax.lax.scan(back, top, (parents, children), reverse=True)
    return pool[-1][rows[:, 0], top], actions.T


def _repeated(value: Array, state: Array, belief: Array) -> Array:
    """As peer_numpy.repeated."""
    found = jnp.zeros(state.shape, bool)
    for back in (1, 2, 3):
        near = jnp.abs(value[:, back:] - value[:, :-back]) <= 1e-6 * (1 + jnp.abs(value[:, back:]))
        near &= state[:, back:] == state[:, :-back]
        near &= (jnp.abs(belief[:, back:] - belief[:, :-back]) <= 1e-6).all(-1)
        found = found.at[:, back:].set(found[:, back:] | near)
    return found


def search(
    a: Arrays,
    weak: Array,
    strong: Array,
    starts: np.ndarray,
    length: int,
    width: int,
    offspring: int,
    see: Any = seen,
) -> tuple[np.ndarray, np.ndarray]:
    """As peer_numpy.search; a few starts after the other, which stay in the cache."""
    size = max(1, min(len(starts), PLACES // width))
    parts = []
    for i in range(0, len(starts), size):
        block = np.resize(starts[i : i + size], size).astype(np.int32)
        found = _searched(a, weak, strong, block, length, width, offspring, see)
        parts.append([np.asarray(x)[: len(starts) - i] for x in found])
    return np.concatenate([p[0] for p in parts]), np.concatenate([p[1] for p in parts])
