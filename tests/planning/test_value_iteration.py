"""Value iteration against loops over states, and its promises."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from i2pdsl.planning.problem import (
    Problem,
    Response,
    boltzmann,
    expected_reward,
    q_values,
)
from i2pdsl.planning.value_iteration import NotConverged, padded_states, solve


def random_problem(
    seed: int, gamma: float = 0.9, answers: int = 1, states: int = 40, problems: int = 5
) -> Problem:
    """Random moves, rewards and answers; some actions are blocked, as on a map."""
    rng = np.random.default_rng(seed)

    def successors() -> np.ndarray:
        table = rng.integers(0, states, (5, states))
        table[rng.random((5, states)) < 0.3] = 0
        table = np.where(table == 0, np.arange(states), table)
        table[4] = np.arange(states)
        return table.astype(np.int32)

    found = []
    for _ in range(answers):
        policy = rng.dirichlet(np.ones(5), (3, states)).transpose(0, 2, 1)
        choice = rng.integers(0, 3, problems)
        social, rho = rng.normal(size=(states, 3)), rng.normal(size=problems) * 3
        found.append(Response(successors(), 0.6, policy, choice, social, rho))
    cost = np.array([-1.0, -1.0, -1.0, -1.0, -0.1])
    goal = rng.integers(0, 2, problems)
    return Problem(successors(), 0.7, rng.random((states, 2)), cost, goal, gamma, tuple(found))


def continuation_of(problem: Problem, values: list[float], p: int) -> list[float]:
    """W(s) of one problem, by loops."""
    for answer in reversed(problem.answers):
        k, q = answer.choice[p], answer.success
        found = []
        for s in range(len(values)):
            total = answer.rho[p] * answer.social[s, k] if answer.social is not None else 0.0
            for a in range(5):
                after = q * values[answer.successor[a, s]] + (1 - q) * values[s]
                total += answer.policy[k, a, s if answer.policy.shape[2] > 1 else 0] * after
            found.append(total)
        values = found
    return values


def backup(problem: Problem, w: list[float], p: int) -> list[float]:
    """V(s) = max_b Q(s, b) from W, by loops."""
    m, best = problem.success, []
    for s in range(len(w)):
        options = [
            problem.cost[b] + problem.gamma * (m * w[problem.successor[b, s]] + (1 - m) * w[s])
            for b in range(5)
        ]
        best.append(problem.reward[s, problem.goal[p]] + max(options))
    return best


def by_loops(problem: Problem, p: int) -> list[float]:
    """The continuation of one problem, iterated until nothing changes."""
    values = [0.0] * problem.successor.shape[1]
    for _ in range(3000):
        again = backup(problem, continuation_of(problem, values, p), p)
        change = max(abs(x - y) for x, y in zip(again, values, strict=True))
        values = again
        if change < 1e-13:
            break
    return continuation_of(problem, values, p)


@pytest.mark.parametrize("answers", [0, 1, 3])
@pytest.mark.parametrize("gamma", [0.0, 0.5, 0.9])
def test_agrees_with_loops(gamma: float, answers: int) -> None:
    problem = random_problem(1, gamma, answers, states=25, problems=3)
    found = solve(problem, tolerance=1e-9)
    for p in range(3):
        np.testing.assert_allclose(found.continuation[:, p], by_loops(problem, p), atol=1e-6)


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4, 1e-8])
@pytest.mark.parametrize("gamma", [0.9, 0.99])
def test_the_residual_is_true_and_within_the_tolerance(gamma: float, tolerance: float) -> None:
    problem = random_problem(2, gamma, states=60, problems=4)
    found = solve(problem, tolerance=tolerance)
    worst = 0.0
    for p in range(4):
        values = backup(problem, found.continuation[:, p].tolist(), p)
        again = backup(problem, continuation_of(problem, values, p), p)
        worst = max(worst, *(abs(x - y) for x, y in zip(again, values, strict=True)))
    assert found.residual <= tolerance
    assert found.residual / 3 - 1e-12 <= worst <= found.residual + 1e-12
    assert found.bound == found.residual / (1 - gamma)


def test_problems_do_not_depend_on_their_neighbours() -> None:
    problem = random_problem(3, states=50, problems=20)
    together = solve(problem, tolerance=1e-9).continuation
    for p in (0, 7, 19):
        answers = tuple(
            replace(answer, choice=answer.choice[[p]], rho=answer.rho[[p]])
            for answer in problem.answers
        )
        alone = replace(problem, goal=problem.goal[[p]], answers=answers)
        found = solve(alone, tolerance=1e-9).continuation[:, 0]
        np.testing.assert_allclose(found, together[:, p], atol=1e-7)


def test_parts_that_never_meet_drift_at_their_own_rates() -> None:
    """Two closed classes with different gains: extrapolating one must not spoil the other."""
    states = 20
    ring = np.tile(np.arange(states, dtype=np.int32), (5, 1))
    half = states // 2
    ring[0] = np.concatenate([np.roll(np.arange(half), -1), half + np.roll(np.arange(half), -1)])
    reward = np.zeros((states, 1))
    reward[3], reward[half + 5] = 5.0, -7.0
    cost = np.array([-0.2, -1.0, -1.0, -1.0, -0.3])
    problem = Problem(ring, 0.8, reward, cost, np.zeros(3, int), 0.99)
    found = solve(problem, tolerance=1e-8)
    np.testing.assert_allclose(found.continuation[:, 0], by_loops(problem, 0), atol=1e-5)


def test_a_policy_that_ignores_the_state_can_be_given_once() -> None:
    problem = random_problem(4, states=30, problems=3)
    constant = np.full((3, 5, 1), 0.2)
    full = np.broadcast_to(constant, (3, 5, 30)).copy()
    found = []
    for policy in (constant, full):
        answers = tuple(replace(answer, policy=policy) for answer in problem.answers)
        changed = replace(problem, answers=answers)
        found.append(solve(changed, tolerance=1e-9).continuation)
    np.testing.assert_allclose(found[0], found[1], atol=1e-8)


def test_too_few_sweeps_are_said() -> None:
    with pytest.raises(NotConverged, match="residual"):
        solve(random_problem(5, gamma=0.99), tolerance=1e-6, max_sweeps=30)


def test_progress_is_reported_and_can_interrupt() -> None:
    reports: list[tuple[int, float, float | None]] = []
    solve(random_problem(6), tolerance=1e-8, progress=lambda *args: reports.append(args))
    assert [sweep for sweep, _, _ in reports] == sorted(sweep for sweep, _, _ in reports)
    assert len(reports) > 2
    assert reports[-1][1] < reports[1][1]

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        solve(random_problem(6), progress=interrupt)


def test_policies_are_softmax_of_q() -> None:
    problem = random_problem(7, states=12, problems=2)
    w = solve(problem, tolerance=1e-9).continuation
    policy = boltzmann(problem, w, beta=2.0)
    assert policy.shape == (2, 5, 12)
    np.testing.assert_allclose(policy.sum(1), 1.0)
    m = problem.success
    for p in range(2):
        for s in range(12):
            q = [
                problem.cost[b]
                + problem.gamma * (m * w[problem.successor[b, s], p] + (1 - m) * w[s, p])
                for b in range(5)
            ]
            weights = np.exp(2.0 * (np.array(q) - max(q)))
            np.testing.assert_allclose(policy[p, :, s], weights / weights.sum(), atol=1e-12)
    reward = np.arange(24.0).reshape(12, 2)
    expected = expected_reward(policy, reward, problem.cost)
    assert expected[3, 1] == pytest.approx(reward[3, 1] + policy[1, :, 3] @ problem.cost)


def residual_by_arrays(problem: Problem, continuation: np.ndarray) -> float:
    """max |TV - V| for the V that the continuations imply, where loops would take too long."""
    columns = range(len(problem.goal))
    v = np.stack([q_values(problem, continuation, p).max(0) for p in columns], 1)
    w = v
    for o in reversed(problem.answers):
        assert o.social is not None
        before, w = w, o.rho * o.social[:, o.choice]
        for a, after in enumerate(o.successor):
            moved = o.success * before[after] + (1 - o.success) * before
            w = w + o.policy[o.choice, a].T * moved
    again = np.stack([q_values(problem, w, p).max(0) for p in columns], 1)
    return float(np.abs(again - v).max())


@pytest.mark.parametrize("tolerance", [1e-4, 1e-7])
def test_single_precision_first_ends_in_double(tolerance: float) -> None:
    """Enough states and problems for the coarse stage, which alone would stall above 1e-7."""
    states, problems = 10_000, 12
    rng = np.random.default_rng(0)
    line = np.arange(states)
    problem = Problem(
        successor=np.stack([np.maximum(line - 1, 0), np.minimum(line + 1, states - 1), line]),
        success=0.7,
        reward=(rng.random((states, problems)) < 0.01).astype(float),
        cost=np.array([-1.0, -1.0, -0.1]),
        goal=np.arange(problems),
        gamma=0.95,
        answers=(
            Response(
                successor=rng.integers(0, states, (2, states)),
                success=0.5,
                policy=rng.dirichlet(np.ones(2), (2, states)).transpose(0, 2, 1),
                choice=np.arange(problems) % 2,
                social=rng.normal(size=(states, 2)),
                rho=np.linspace(-3, 3, problems),
            ),
        ),
    )
    found = solve(problem, tolerance=tolerance)
    assert found.residual <= tolerance
    assert found.sweeps < 600
    assert residual_by_arrays(problem, found.continuation) <= found.residual + 1e-11


@pytest.mark.parametrize("gamma", [0.5, 0.99, 0.999])
def test_rings_of_known_value(gamma: float) -> None:
    """In one ring waiting is best, in the other waiting on the paid state; no drift fits both."""
    step = (np.arange(6) + 1) % 6
    reward = np.zeros((12, 1))
    reward[6] = 1.0
    successor = np.stack([np.concatenate([step, step + 6]), np.arange(12)])
    problem = Problem(successor, 1.0, reward, np.array([-1.0, -0.1]), np.zeros(3, int), gamma)
    found = solve(problem, tolerance=1e-9)
    assert residual_by_arrays(problem, found.continuation) <= 1.01e-9
    np.testing.assert_allclose(found.continuation[:6], -0.1 / (1 - gamma), atol=1e-5)
    np.testing.assert_allclose(found.continuation[6], 0.9 / (1 - gamma), atol=1e-5)


def test_no_action_needs_to_stay() -> None:
    problem = random_problem(8, answers=0)
    problem = replace(problem, successor=problem.successor[:4], cost=problem.cost[:4])
    found = solve(problem, tolerance=1e-9)
    assert residual_by_arrays(problem, found.continuation) <= 1.01e-9


def test_a_tolerance_beyond_rounding_is_said() -> None:
    with pytest.raises(NotConverged, match="rounding keeps the residual at"):
        solve(random_problem(1, 0.99), tolerance=1e-18)


def test_the_precision_of_others_stays_as_it_was() -> None:
    import jax.numpy as jnp

    solve(random_problem(9, 0.5))
    assert jnp.ones(2).dtype == jnp.float32


@pytest.mark.parametrize("gamma", [0.0, 0.9, 0.99])
def test_no_value_is_further_from_the_truth_than_the_bound(gamma: float) -> None:
    problem = random_problem(10, gamma, states=30, problems=3)
    found = solve(problem, tolerance=1e-3)
    for p in range(3):
        wrong = np.abs(found.continuation[:, p] - by_loops(problem, p)).max()
        assert wrong <= found.bound + 1e-9


def test_worlds_of_about_one_size_share_a_program() -> None:
    from i2pdsl import programs

    solve(random_problem(11, states=49, problems=4))
    before = len(programs._memory)
    for states, problems in ((50, 3), (56, 20), (53, 1)):
        solve(random_problem(12, states=states, problems=problems))
    assert len(programs._memory) == before
    for count in (1, 2, 5, 100, 930, 3360, 8192, 8193, 208_860, 10**7):
        most = max(2 * count, 1024) if count <= 8192 else 1.125 * count
        assert count <= padded_states(count) <= most
    assert padded_states(208_860) < 1.03 * 208_860


def test_single_states_and_single_problems() -> None:
    problem = Problem(
        np.zeros((2, 1), int), 1.0, np.ones((1, 1)), np.zeros(2), np.zeros(1, int), 0.5
    )
    found = solve(problem, tolerance=1e-9)
    np.testing.assert_allclose(found.continuation, [[2.0]])
