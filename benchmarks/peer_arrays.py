"""A world of two as plain arrays, which all peers of `peers.py` are given: its states and moves are
listed, nothing is planned. Needs NumPy only, so that an interpreter without i2pdsl can read it.

One is weak and acts first, the other is strong and answers. S states, A = 5 actions (north, south,
east, west, stay), P problems of the strong one, H hypotheses, B blocks of problems that face the
same policy of the weak one.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

STAY = 4
ACTS = np.array([0, 1, 2, 3, 4, 0, 1, 2, 3])  # of the outcomes of the weak one: five successes,
EFFECTS = np.array([0, 1, 2, 3, 4, 4, 4, 4, 4])  # then four failures, which change nothing
FAILS = np.arange(9) > STAY


class Arrays(NamedTuple):
    """Attributes:
    weak_next, strong_next: int32 [A, S], the state after an action that succeeds.
    weak_home: bool [G, S], whether the weak one is on each of its goals. strong_home: likewise.
    cost: [A]. success, gamma, beta, forgetting: [].
    facing: int [P], the goal of the weak one that each problem believes in, G if it acts at random;
        sorted.
    strong_goal: int [P], in strong_home. rho: [P], how much the weak one's reward counts.
    weak_of, strong_of: int [H], the goal and the problem under a hypothesis; the number of them
        for one who acts at random.
    rational, helps: bool [H]: both are; both are, and rho > 0.
    """

    weak_next: np.ndarray
    strong_next: np.ndarray
    weak_home: np.ndarray
    strong_home: np.ndarray
    cost: np.ndarray
    success: np.ndarray
    gamma: np.ndarray
    beta: np.ndarray
    forgetting: np.ndarray
    facing: np.ndarray
    strong_goal: np.ndarray
    rho: np.ndarray
    weak_of: np.ndarray
    strong_of: np.ndarray
    rational: np.ndarray
    helps: np.ndarray

    @property
    def blocks(self) -> list[tuple[int, np.ndarray]]:
        """The problems that face each policy of the weak one, and which policy that is."""
        return [(int(g), np.flatnonzero(self.facing == g)) for g in np.unique(self.facing)]

    def save(self, path: Path) -> None:
        np.savez(path, **self._asdict())

    @staticmethod
    def load(path: Path) -> Arrays:
        with np.load(path) as found:
            return Arrays(**{name: found[name] for name in Arrays._fields})


@dataclass(frozen=True)
class Task:
    """What is asked of all of them.

    Attributes:
        states: S. tolerance: the Bellman residual that planning is to reach.
        length: T of the search. widths: of its beams. offspring: see peer_numpy.search.
    """

    states: int
    tolerance: float
    length: int
    widths: tuple[int, ...]
    offspring: int


@dataclass(frozen=True)
class Times:
    """Seconds: of processors (of all threads) and of wall clock, the best run of several; and what
    the first run took beyond that, which is compiling."""

    cpu: float
    wall: float
    compile_cpu: float
    compile_wall: float


class Clock:
    """Runs something again and again."""

    def __init__(self, work: Callable[[], Any]) -> None:
        self.work, self.runs = work, list[tuple[float, float]]()
        self.result: Any = None

    def run(self) -> None:
        wall, cpu = time.perf_counter(), time.process_time()
        self.result = self.work()
        self.runs.append((time.process_time() - cpu, time.perf_counter() - wall))

    @property
    def times(self) -> Times:
        first, *later = self.runs
        cpu, wall = (min(column) for column in zip(*(later or [first]), strict=True))
        return Times(cpu, wall, max(0.0, first[0] - cpu), max(0.0, first[1] - wall))


def clocked(works: dict[str, Callable[[], Any]], repeats: int) -> dict[str, Clock]:
    """Runs each once, and then all in turn `repeats` times, so that none has the quieter hour."""
    clocks = {name: Clock(work) for name, work in works.items()}
    for clock in clocks.values():
        clock.run()
    for _ in range(repeats):
        for clock in clocks.values():
            clock.run()
    return clocks


def arrays_of(world: Any) -> tuple[Arrays, np.ndarray]:
    """The arrays of a planned `GridWorld`, and where each of their problems stands in its
    tables: int [P]."""
    from i2pdsl.worlds.grid.problems import Key, costs, on_goal, problem_keys

    spec, tables, dynamics = world.spec, world.tables, world.dynamics
    weak, strong = spec.characters
    assert weak.is_weak, weak
    assert [*dict(strong.attitudes)] == [weak.name], strong
    _, keys = problem_keys(spec)
    (seen,) = zip(*(key.others for key in keys), strict=True)
    facing = [weak.goals.index(s.key.goal) if s.key else len(weak.goals) for s in seen]
    order = np.argsort(facing, kind="stable")
    place = np.append(np.argsort(order), len(order))
    keys_of = lambda goals: [Key(goal) for goal in goals]
    home = lambda who, goals: on_goal(spec, dynamics, who, keys_of(goals))[
        :, dynamics.cells[:, who]
    ]
    rows = world.vocabulary.hypotheses
    rational = np.array([all(v for k, v in row.items() if k.startswith("R_")) for row in rows])
    settings = spec.settings
    return Arrays(
        weak_next=dynamics.successor[0],
        strong_next=dynamics.successor[1],
        weak_home=home(0, weak.goals),
        strong_home=home(1, strong.goals),
        cost=costs(spec, 0),
        success=np.array(weak.success),
        gamma=np.array(settings.gamma),
        beta=np.array(settings.beta),
        forgetting=np.array(settings.forgetting),
        facing=np.array(facing)[order],
        strong_goal=np.array([strong.goals.index(key.goal) for key in keys])[order],
        rho=np.array([float(s.rho or 0) for s in seen])[order],
        weak_of=tables.columns[0][0],
        strong_of=place[tables.columns[1][0]],
        rational=rational,
        helps=rational & np.array([row.get("rho", 0) > 0 for row in rows]),
    ), order
