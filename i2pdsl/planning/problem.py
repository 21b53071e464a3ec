"""Planning problems and what follows from their solutions, in NumPy.

One family of problems: a *mover* acts, then (if there is one) an *answerer* acts by a fixed
stochastic policy. Shapes: S states, A actions, P problems (one column each), G distinct goals,
K distinct policies of the answerer. Rewards and values are in the story's units, per turn.

    W(s)    = rho social(s) + sum_a policy(a | s) (q V(next_a(s)) + (1 - q) V(s))
    Q(s, b) = reward(s) + cost(b) + gamma (m W(next_b(s)) + (1 - m) W(s))
    V(s)    = max_b Q(s, b)

with m, q the success probabilities of mover and answerer; W = V where nobody answers.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Response:
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
        successor, success: as in Response, for the mover.
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
    answer: Response | None = None


def q_values(
    problem: Problem, continuation: np.ndarray, column: int, states: Any = slice(None)
) -> np.ndarray:
    """Q [A, S] of one problem, from the continuations [S, P]; [A, ...] of some states [...]."""
    w, m = continuation[:, column], problem.success
    w = np.ascontiguousarray(w) if isinstance(states, slice) else w  # all are read, or a few
    reward = problem.reward[states, problem.goal[column]]
    q = np.empty((len(problem.cost), *reward.shape))
    for b, successor in enumerate(problem.successor):
        after = m * w[successor[states]] + (1 - m) * w[states]
        q[b] = reward + problem.cost[b] + problem.gamma * after
    return q


def boltzmann(
    problem: Problem, continuation: np.ndarray, beta: float, states: Any = slice(None)
) -> np.ndarray:
    """The softmax policies, policy(a | s) ~ exp(beta Q(s, a)): [P, A, S], as in `Response`, or
    of some states only."""
    count = problem.successor[0, states].size
    policy = np.empty((len(problem.goal), len(problem.successor), count))
    for column, p in enumerate(policy):
        q = q_values(problem, continuation, column, states)
        np.exp(beta * (q - q.max(0)), out=p)
        p /= p.sum(0)
    return policy


def residual_at(problem: Problem, continuation: np.ndarray, states: np.ndarray) -> float:
    """The largest |W' - W| over some states [n], for the W' that the values of W imply.

    The policy [K, A, n] and the social [n, K] of the answer are those of these states.
    """
    worst, answer = 0.0, problem.answer
    for column in range(len(problem.goal)):
        value = lambda at, column=column: q_values(problem, continuation, column, at).max(0)
        w = here = value(states)
        if answer is not None:
            k = answer.choice[column]
            if answer.social is not None:
                w = w + answer.rho[column] * answer.social[:, k]
            for a, successor in enumerate(answer.successor):
                w = w + answer.success * answer.policy[k, a] * (value(successor[states]) - here)
        worst = max(worst, float(np.abs(w - continuation[states, column]).max(initial=0)))
    return worst


def expected_reward(policy: np.ndarray, reward: np.ndarray, cost: np.ndarray) -> np.ndarray:
    """sum_a policy(a | s) (reward(s) + cost(a)): [S, K], from [K, A, S or 1], [S, K] and [A]."""
    return reward + np.einsum("kas,a->sk", policy, cost)
