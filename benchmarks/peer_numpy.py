"""The work of `peers.py` in NumPy, by hand: whole arrays at once, doubles, no compiler.

S states, P problems, H hypotheses, N scripts side by side, T frames; the rest in peer_arrays.py.
Beliefs are probabilities: forgetting keeps them away from 0.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from peer_arrays import ACTS, EFFECTS, FAILS, STAY, Arrays

Step = Callable[[np.ndarray], np.ndarray]


def weak_sweep(a: Arrays) -> Step:
    """T of the weak one's values [S, G], who expects any answer alike."""
    q, home = float(a.success), a.weak_home.T.astype(float)

    def sweep(v: np.ndarray) -> np.ndarray:
        w = sum(v[after] for after in a.strong_next) / len(a.strong_next)
        best = a.cost[STAY] + a.gamma * w
        for move in range(STAY):
            after = a.gamma * (q * w[a.weak_next[move]] + (1 - q) * w)
            np.maximum(best, a.cost[move] + after, out=best)
        return home + best

    return sweep


def strong_sweep(a: Arrays, policy: np.ndarray, facing: int, problems: np.ndarray) -> Step:
    """T of the strong one's values [S, P'] in problems that face one policy of the weak one.

    Args:
        policy: [S, A, G + 1] of the weak one; the last acts at random.
    """
    pi, home = policy[:, :, facing], a.strong_home[a.strong_goal[problems]].T.astype(float)
    paid = pi @ a.cost + (a.weak_home[facing] if facing < len(a.weak_home) else 0)
    # Nobody is paid what one who acts at random is paid.
    social = np.outer(paid, a.rho[problems])
    moves = a.success * pi.T[:, :, None]

    def sweep(v: np.ndarray) -> np.ndarray:
        w = v + social
        for move in range(STAY):
            w += moves[move] * (v[a.weak_next[move]] - v)
        best = a.cost[STAY] + a.gamma * w
        for move in range(STAY):
            np.maximum(best, a.cost[move] + a.gamma * w[a.strong_next[move]], out=best)
        return home + best

    return sweep


def solved(sweep: Step, v: np.ndarray, gamma: float, tolerance: float) -> tuple[np.ndarray, int]:
    """V with |TV - V| <= tolerance, and the sweeps. The drift that all states have in common is
    taken out (MacQueen 1966), so that the residual is half the range of a sweep's change."""
    sweeps = 0
    while True:
        change = sweep(v) - v
        sweeps += 1
        low, high = change.min(0), change.max(0)
        middle = (low + high) / 2
        if ((high - low) / 2 <= tolerance).all():
            return v + middle / (1 - gamma), sweeps
        v = v + change + middle * gamma / (1 - gamma)


def q_weak(a: Arrays, v: np.ndarray) -> np.ndarray:
    """Q [S, A, G] of the weak one."""
    w = sum(v[after] for after in a.strong_next) / len(a.strong_next)
    after = a.success * w[a.weak_next.T] + (1 - a.success) * w[:, None]
    return a.weak_home.T[:, None] + a.cost[:, None] + a.gamma * after


def q_strong(a: Arrays, policy: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Q [S, A, P] of the strong one."""
    q = np.empty((len(v), len(a.cost), v.shape[1]))
    for facing, problems in a.blocks:
        pi, own = policy[:, :, facing], v[:, problems]
        paid = pi @ a.cost + (a.weak_home[facing] if facing < len(a.weak_home) else 0)
        w = own + np.outer(paid, a.rho[problems])
        for move in range(STAY):
            w += a.success * pi[:, move, None] * (own[a.weak_next[move]] - own)
        home = a.strong_home[a.strong_goal[problems]].T
        q[:, :, problems] = home[:, None] + a.cost[:, None] + a.gamma * w[a.strong_next.T]
    return q


def softmax(a: Arrays, q: np.ndarray) -> np.ndarray:
    """The policies [S, A, P + 1] of Q [S, A, P]; the last acts at random."""
    p = np.empty((*q.shape[:2], q.shape[2] + 1))
    p[..., -1] = 1 / q.shape[1]
    np.exp(a.beta * (q - q.max(1, keepdims=True)), out=p[..., :-1])
    p[..., :-1] /= p[..., :-1].sum(1, keepdims=True)
    return p


def planned(a: Arrays, tolerance: float) -> tuple[np.ndarray, np.ndarray, list[int]]:
    """V of the weak one [S, G] and of the strong one [S, P], and the sweeps of each block."""
    gamma = float(a.gamma)
    none = np.zeros((a.weak_next.shape[1], len(a.weak_home)))
    weak, count = solved(weak_sweep(a), none, gamma, tolerance)
    policy, sweeps = softmax(a, q_weak(a, weak)), [count]
    strong = np.empty((len(weak), len(a.rho)))
    for facing, problems in a.blocks:
        sweep = strong_sweep(a, policy, facing, problems)
        none = np.zeros((len(weak), len(problems)))
        strong[:, problems], count = solved(sweep, none, gamma, tolerance)
        sweeps.append(count)
    return weak, strong, sweeps


def residuals(a: Arrays, weak: np.ndarray, strong: np.ndarray) -> tuple[float, float]:
    """The largest |TV - V| of each, whoever planned them; the strong one's facing the policy of
    these values of the weak one."""
    q = q_weak(a, weak)
    own = np.abs(q.max(1) - weak).max()
    return own, np.abs(q_strong(a, softmax(a, q), strong).max(1) - strong).max()


# ---- The audience --------------------------------------------------------------------------------


def seen(a: Arrays, belief: Any, likelihood: Any) -> Any:
    """Bayes' rule, normalisation and forgetting along the last axis."""
    joint = belief * likelihood
    joint = joint / joint.sum(-1, keepdims=True)
    share = a.forgetting / (joint.shape[-1] - 1)
    return joint * (1 - a.forgetting - share) + share


def posterior(
    a: Arrays, weak: np.ndarray, strong: np.ndarray, starts: np.ndarray, actions: np.ndarray
) -> np.ndarray:
    """P(rho > 0 | script[:t]) of scripts, t = 0..T: [N, T + 1].

    Args:
        weak, strong: policies [S, A, G + 1], [S, A, P + 1].
        starts: [N]. actions: [N, T], 5 times the outcome of the weak one plus the other's action.
    """
    count = len(a.rational)
    belief = np.full((len(starts), count), 1 / count)
    state, found = starts, []
    for t in range(actions.shape[1] + 1):
        found.append(belief @ a.helps / (belief @ a.rational))
        if t < actions.shape[1]:
            own, answer = np.divmod(actions[:, t], len(a.cost))
            belief = seen(a, belief, weak[state, ACTS[own]][:, a.weak_of])
            state = a.weak_next[EFFECTS[own], state]
            belief = seen(a, belief, strong[state, answer][:, a.strong_of])
            state = a.strong_next[answer, state]
    return np.stack(found, axis=1)


# ---- The search ----------------------------------------------------------------------------------


class Ahead:
    """What can follow prefixes in states [M] with beliefs [M, H]: K = 45 children of each."""

    def __init__(
        self, a: Arrays, weak: Any, strong: Any, state: Any, belief: Any, see: Any
    ) -> None:
        reached = a.weak_next[:, state].T  # [M, A]
        first = see(a, belief[:, None], weak[state][..., a.weak_of])
        likelihood = strong[reached][..., a.strong_of]  # [M, A, A, H]
        second = see(a, first[:, ACTS, None], likelihood[:, EFFECTS])
        moved = reached != state[:, None]
        flat = (len(state), len(ACTS) * len(a.cost))
        self.belief = second.reshape(*flat, -1)
        self.state = a.strong_next[:, reached[:, EFFECTS]].transpose(1, 2, 0).reshape(flat)
        wide = lambda x: np.repeat(x, len(a.cost), axis=1)
        self.tried = wide(moved[:, ACTS])
        self.succeeded = self.tried & ~wide(np.tile(FAILS, (len(state), 1)))
        self.valid = wide(moved[:, ACTS] | ~FAILS)


def search(
    a: Arrays,
    weak: np.ndarray,
    strong: np.ndarray,
    starts: np.ndarray,
    length: int,
    width: int,
    offspring: int,
    see: Any = seen,
) -> tuple[np.ndarray, np.ndarray]:
    """The best score [N] of scripts from each start and their actions [N, T].

    What a prefix is worth: sum_t P(rho > 0 | script[:t]) + P(both are rational | script[:t]), and
    -(p_hat - p)^2 for the share p_hat of the weak one's attempts that succeeded.

    Args:
        width: of each start's beam.
        offspring: of a script, at most so many go on. (At first all places of a beam are the same,
            and each offers its share of the children.)
    """
    n, hypotheses, k = len(starts), len(a.rational), len(ACTS) * len(a.cost)
    # The pool is [N, W]: places that are not taken are worth -inf.
    share = np.arange(k) % width == np.arange(width)[:, None]
    state = np.repeat(starts[:, None], width, axis=1)
    belief = np.full((n, width, hypotheses), 1 / hypotheses)
    sums, tried, succeeded = (np.zeros((n, width)) for _ in range(3))
    worth = np.zeros((n, width))
    actions = np.zeros((n, width, length), int)
    rows = np.arange(n)[:, None]
    for t in range(length):
        ahead = Ahead(a, weak, strong, state.reshape(-1), belief.reshape(-1, hypotheses), see)
        rational = ahead.belief @ a.rational
        terms = (ahead.belief @ a.helps / rational + rational).reshape(n, width, k)
        total = sums[..., None] + terms
        tries = tried[..., None] + ahead.tried.reshape(n, width, k)
        successes = succeeded[..., None] + ahead.succeeded.reshape(n, width, k)
        miss = np.where(tries > 0, (successes / np.maximum(tries, 1) - a.success) ** 2, 0)
        alive = ahead.valid.reshape(n, width, k) & (worth[..., None] > -np.inf)
        value = np.where(alive, total - miss, -np.inf)
        value = value if t else np.where(share, value, -np.inf)
        kept = min(offspring, k)
        best = np.argsort(-value, axis=2, kind="stable")[..., :kept]
        parent = np.repeat(np.arange(width), kept)[None]
        child = best.reshape(n, -1)
        order = np.argsort(-value[rows, parent, child], axis=1, kind="stable")
        parent, child = np.broadcast_to(parent, child.shape)[rows, order], child[rows, order]
        at = (rows, parent, child)
        after = ahead.state.reshape(n, width, k)[at]
        minds = ahead.belief.reshape(n, width, k, -1)
        if width > 1:
            alive = ~repeated(value[at], after, minds, at) & (value[at] > -np.inf)
            chosen = np.argsort(~alive, axis=1, kind="stable")[:, :width]
            parent, child = parent[rows, chosen], child[rows, chosen]
            dead = ~alive[rows, chosen]
        else:
            parent, child, dead = parent[:, :1], child[:, :1], np.zeros((n, 1), bool)
        at = (rows, parent, child)
        state, belief = ahead.state.reshape(n, width, k)[at], minds[at]
        sums, tried, succeeded = total[at], tries[at], successes[at]
        worth = np.where(dead, -np.inf, value[at])
        actions = actions[rows, parent]
        actions[..., t] = child
    top = worth.argmax(1)
    return worth[np.arange(n), top], actions[np.arange(n), top]


def repeated(value: np.ndarray, state: np.ndarray, minds: np.ndarray, at: Any) -> np.ndarray:
    """Which of a sorted row of children end as one of the three before them does: in the same
    state, with the same score and the same belief."""
    found = np.zeros(state.shape, bool)
    belief = minds[at]
    for back in (1, 2, 3):
        with np.errstate(invalid="ignore"):  # what cannot happen is worth -inf
            apart = np.abs(value[:, back:] - value[:, :-back])
        near = apart <= 1e-6 * (1 + np.abs(value[:, back:]))
        near &= state[:, back:] == state[:, :-back]
        near &= (np.abs(belief[:, back:] - belief[:, :-back]) <= 1e-6).all(-1)
        found[:, back:] |= near
    return found


def scores(
    a: Arrays, weak: np.ndarray, strong: np.ndarray, starts: np.ndarray, actions: np.ndarray
) -> np.ndarray:
    """What finished scripts are worth, as in `search`: [N]."""
    belief, state = np.full((len(starts), len(a.rational)), 1 / len(a.rational)), starts
    total, tried, succeeded = (np.zeros(len(starts)) for _ in range(3))
    for own, answer in zip(*(x.T for x in np.divmod(actions, len(a.cost))), strict=True):
        belief = seen(a, belief, weak[state, ACTS[own]][:, a.weak_of])
        could = a.weak_next[ACTS[own], state] != state
        tried, succeeded = tried + could, succeeded + (could & ~FAILS[own])
        state = a.weak_next[EFFECTS[own], state]
        belief = seen(a, belief, strong[state, answer][:, a.strong_of])
        state = a.strong_next[answer, state]
        rational = belief @ a.rational
        total += belief @ a.helps / rational + rational
    miss = (succeeded / np.maximum(tried, 1) - a.success) ** 2
    return total - np.where(tried > 0, miss, 0)
