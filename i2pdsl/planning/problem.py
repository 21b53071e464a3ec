"""Planning problems and what follows from their solutions, in NumPy.

One family of problems: a *mover* acts, then others answer, one after the other, each by a fixed
stochastic policy. Shapes: S states, A actions, P problems (one column each), G distinct goals,
K distinct policies of an answerer. Rewards and values are in the story's units, per turn.

    W_k(s)  = rho social(s) + sum_a policy(a | s) (q W_k+1(next_a(s)) + (1 - q) W_k+1(s))
    Q(s, b) = reward(s) + cost(b) + gamma (m W_1(next_b(s)) + (1 - m) W_1(s))
    V(s)    = max_b Q(s, b)

with k the answerers in their order, V what comes after the last, and m, q the success
probabilities of mover and answerer; W = V where nobody answers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Response:
    """How another character answers: by a fixed stochastic policy.

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
        answers: of the others to each action, in the order in which they act.
    """

    successor: np.ndarray
    success: float
    reward: np.ndarray
    cost: np.ndarray
    goal: np.ndarray
    gamma: float
    answers: tuple[Response, ...] = ()


def q_values(problem: Problem, continuation: np.ndarray, column: int) -> np.ndarray:
    """Q [A, S] of one problem, from the continuations [S, P]."""
    w, m = np.ascontiguousarray(continuation[:, column]), problem.success
    reward = problem.reward[:, problem.goal[column]]
    q = np.empty((len(problem.cost), len(w)))
    for b, successor in enumerate(problem.successor):
        q[b] = reward + problem.cost[b] + problem.gamma * (m * w[successor] + (1 - m) * w)
    return q


def boltzmann(problem: Problem, continuation: np.ndarray, beta: float) -> np.ndarray:
    """The softmax policies, policy(a | s) ~ exp(beta Q(s, a)): [P, A, S], as in `Response`."""
    policy = np.empty((len(problem.goal), *problem.successor.shape))
    for column, p in enumerate(policy):
        q = q_values(problem, continuation, column)
        np.exp(beta * (q - q.max(0)), out=p)
        p /= p.sum(0)
    return policy


def expected_reward(policy: np.ndarray, reward: np.ndarray, cost: np.ndarray) -> np.ndarray:
    """sum_a policy(a | s) (reward(s) + cost(a)): [S, K], from [K, A, S or 1], [S, K] and [A]."""
    return reward + np.einsum("kas,a->sk", policy, cost)
