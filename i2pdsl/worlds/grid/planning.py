"""The planning problems of a grid world: who plans what against whom (model.md, "Kitchen")."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from i2pdsl.computing import computing
from i2pdsl.errors import StoryError, error, whole_file
from i2pdsl.planning import store
from i2pdsl.worlds.grid.dynamics import Dynamics
from i2pdsl.worlds.grid.spec import ACTIONS, STAY, Character, GridSpec
from i2pdsl.worlds.hypotheses import ATTITUDE, goal_of, grid_hypotheses, rationality_of

if TYPE_CHECKING:
    from i2pdsl.planning.value_iteration import Answer, Problem

MakeAnswer = Callable[[int], "Answer"]
"""An answer for a number of problems."""

Key = tuple[str | float | None, ...]
"""A planning problem: (goal,), or for one who models the other (the other's goal, own goal, rho);
the other's goal is None where the other is irrational."""

Report = Callable[[str, int, float, float | None], None]
"""Progress: (stage, sweep, residual, expected number of sweeps or None)."""

TOLERANCE = 1e-4  # Bellman residual, in values


@dataclass(frozen=True)
class Plan:
    """The solved problems of a world.

    Attributes:
        keys: for each character, its problems.
        continuation: for each character float64 [S, P], the value after an action.
        residual: the largest Bellman residual that was reached.
        seconds: the time that solving took, 0 where the plan came from the cache.
    """

    keys: tuple[tuple[Key, ...], ...]
    continuation: tuple[np.ndarray, ...]
    residual: float
    seconds: float = 0.0


def problem_keys(spec: GridSpec) -> tuple[tuple[Key, ...], ...]:
    """The distinct problems of each character, in the order in which hypotheses name them."""
    rows = grid_hypotheses(spec)
    found = []
    for c in spec.characters:
        keys = (problem_of(spec, c, row) for row in rows if row[rationality_of(c.name)])
        found.append(tuple(dict.fromkeys(keys)))
    return tuple(found)


def problem_of(spec: GridSpec, character: Character, row: dict[str, float | str | bool]) -> Key:
    """The problem that a rational character solves under a hypothesis."""
    own = str(row[goal_of(character.name)])
    modeller = spec.modeller
    if modeller is None or modeller.name != character.name:
        return (own,)
    other = next(c for c in spec.characters if c.name != character.name)
    rho = row.get(ATTITUDE)
    believed = row.get(goal_of(other.name))
    return (None if believed is None else str(believed), own, None if rho is None else float(rho))


def estimated_bytes(spec: GridSpec) -> int:
    """Memory that planning takes at its peak: tables, values and their working copies."""
    states = spec.state_count
    entities = len(spec.entities)
    problems = sum(len(keys) for keys in problem_keys(spec))
    moves = 2 * 4 * len(ACTIONS) * len(spec.characters)
    return (
        states * (2 * entities + moves + 8 * problems * 2 + 16 * 8 * 6)
        + 4 * (len(spec.free_cells) + 1) ** entities
    )


def check_memory(spec: GridSpec) -> None:
    """Refuses a world whose tables would not fit, before any work. Raises StoryError."""
    needed, available = estimated_bytes(spec), memory_limit()
    if needed > available or spec.state_count >= 2**31:
        message = (
            f"the world has {spec.state_count:,} states; planning would take "
            f"{needed / 2**30:.1f} GiB of memory, {available / 2**30:.1f} GiB are there"
        )
        hint = "make the map smaller, or take an object away"
        raise error("too-large", message, whole_file(f"{spec.name}.world"), hint)


def memory_limit() -> int:
    """Bytes that may be used: 80 % of the machine's memory, or of the container's share."""
    total = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    for name in ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"):
        try:
            total = min(total, int(Path(name).read_text(encoding="ascii")))
        except (OSError, ValueError):
            continue
    return int(total * 0.8)


def load_or_plan(
    spec: GridSpec,
    dynamics: Callable[[], Dynamics],
    report: Report | None = None,
    say: Callable[[str], None] | None = None,
) -> Plan:
    """The plan from the cache, or solved now and stored there.

    A damaged entry is said and made again.
    """
    keys = problem_keys(spec)
    name = f"{spec.planning_key}-{_digest(keys)}"
    found = store.load(name, say)
    if found is not None:
        right = {f"continuation_{i}": (spec.state_count, len(k)) for i, k in enumerate(keys)}
        if {key: array.shape for key, array in found.items()} == {**right, "residual": ()}:
            return Plan(keys, tuple(found[key] for key in right), float(found["residual"]))
        if say is not None:
            say(f"the cached plan {name} does not fit the world; it is made again")
    check_memory(spec)
    with computing(say):
        plan = solve(spec, dynamics(), report=report)
    content = {f"continuation_{i}": array for i, array in enumerate(plan.continuation)}
    store.save(name, {**content, "residual": np.array(plan.residual)}, say)
    return plan


def _digest(keys: tuple[tuple[Key, ...], ...]) -> str:
    import hashlib

    return hashlib.sha256(json.dumps(keys).encode()).hexdigest()[:8]


def solve(
    spec: GridSpec,
    dynamics: Dynamics,
    tolerance: float = TOLERANCE,
    report: Report | None = None,
) -> Plan:
    """Solves all problems of a world exactly, to a Bellman residual of `tolerance`.

    Raises StoryError if the values do not settle.
    """
    import time

    from i2pdsl.planning.value_iteration import NotConverged, boltzmann
    from i2pdsl.planning.value_iteration import solve as solve_problems

    started = time.perf_counter()
    keys = problem_keys(spec)
    modeller = spec.modeller
    order = sorted(range(len(keys)), key=lambda i: spec.characters[i] == modeller)
    found: dict[int, np.ndarray] = {}
    residual = 0.0
    for who in order:
        c = spec.characters[who]
        other = 1 - who if len(keys) == 2 else None
        if c != modeller or other is None:
            problem = _problem(spec, dynamics, who, keys[who], _level0(spec, dynamics, other))
        else:
            partner = _problem(spec, dynamics, other, keys[other], _level0(spec, dynamics, who))
            policy = boltzmann(partner, found[other], spec.settings.beta)
            answer = _modelled(spec, dynamics, other, keys[other], keys[who], policy)
            problem = _problem(spec, dynamics, who, keys[who], answer)
        try:
            solution = solve_problems(
                problem,
                tolerance=tolerance,
                progress=None if report is None else partial(report, c.name),
            )
        except NotConverged as problem_:
            raise _not_settled(spec, str(problem_)) from None
        found[who] = np.asarray(solution.continuation)
        residual = max(residual, solution.residual)
    arrays = tuple(found[i] for i in range(len(keys)))
    return Plan(keys, arrays, residual, time.perf_counter() - started)


def _not_settled(spec: GridSpec, reason: str) -> StoryError:
    hint = "a gamma nearer to 0 settles faster"
    return error("planning", f"planning did not settle: {reason}", whole_file(spec.name), hint)


def costs(spec: GridSpec) -> np.ndarray:
    """The reward of each action away from the goal: [A]."""
    cost = np.full(len(ACTIONS), spec.settings.move)
    cost[STAY] = spec.settings.stay
    return cost


def on_goal(spec: GridSpec, dynamics: Dynamics, goals: list[str]) -> np.ndarray:
    """Whether each cell is one of a goal's: bool [G, N + 1]; absence and no goal never are."""
    number = {tuple(cell): i for i, cell in enumerate(dynamics.coordinates.tolist())}
    cells = {t.name: [number[c] for c in t.cells] for t in spec.tiles}
    table = np.zeros((len(goals), len(number) + 1), dtype=bool)
    for i, goal in enumerate(goals):
        table[i, cells.get(goal, [])] = True
    return table


def _rewards(
    spec: GridSpec, dynamics: Dynamics, who: int, keys: tuple[Key, ...]
) -> tuple[np.ndarray, np.ndarray]:
    """The goal rewards [S, G] of a character's distinct goals, and each problem's goal [P]."""
    own = [str(key[-2] if len(key) == 3 else key[0]) for key in keys]
    goals = list(dict.fromkeys(own))
    table = on_goal(spec, dynamics, goals) * spec.settings.goal
    reward = table[:, dynamics.cells[:, who]].T
    return np.ascontiguousarray(reward), np.array([goals.index(g) for g in own])


def _problem(
    spec: GridSpec,
    dynamics: Dynamics,
    who: int,
    keys: tuple[Key, ...],
    answer: MakeAnswer | None,
) -> Problem:
    from i2pdsl.planning.value_iteration import Problem

    reward, goal = _rewards(spec, dynamics, who, keys)
    return Problem(
        successor=dynamics.successor[who],
        success=spec.characters[who].success,
        reward=reward,
        cost=costs(spec),
        goal=goal,
        gamma=spec.settings.gamma,
        answer=None if answer is None else answer(len(keys)),
    )


def _level0(spec: GridSpec, dynamics: Dynamics, other: int | None) -> MakeAnswer | None:
    """How one who models nobody believes that the other acts: uniformly, or by the costs."""
    if other is None:
        return None
    from i2pdsl.planning.value_iteration import Answer

    if spec.settings.level0 == "costs":
        weights = np.exp(spec.settings.beta * (costs(spec) - costs(spec).max()))
    else:
        weights = np.ones(len(ACTIONS))
    policy = (weights / weights.sum())[None, :, None]

    def answer(problems: int) -> Answer:
        return Answer(
            successor=dynamics.successor[other],
            success=spec.characters[other].success,
            policy=policy,
            choice=np.zeros(problems, dtype=int),
            social=None,
            rho=np.zeros(problems),
        )

    return answer


def _modelled(
    spec: GridSpec,
    dynamics: Dynamics,
    other: int,
    other_keys: tuple[Key, ...],
    keys: tuple[Key, ...],
    policy: np.ndarray,
) -> MakeAnswer:
    """The modelled one's softmax policies, and a uniform one for where he is irrational."""
    from i2pdsl.planning.value_iteration import Answer, expected_reward

    reward, goal = _rewards(spec, dynamics, other, other_keys)
    social = expected_reward(policy, reward[:, goal], costs(spec))
    models = bool(spec.characters[1 - other].models)
    names = [key[0] for key in other_keys]
    uniform = np.full((1, *policy.shape[1:]), 1 / len(ACTIONS))
    choice = [names.index(key[0]) if key[0] is not None and models else len(names) for key in keys]

    def answer(problems: int) -> Answer:
        return Answer(
            successor=dynamics.successor[other],
            success=spec.characters[other].success,
            policy=np.concatenate([policy, uniform]),
            choice=np.array(choice),
            social=np.concatenate([social, np.zeros((len(social), 1))], axis=1),
            rho=np.array([key[2] or 0.0 for key in keys]),
        )

    return answer
