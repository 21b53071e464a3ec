"""The worker: one job at a time, the newest of its kind, and idle work only when it is quiet."""

from __future__ import annotations

import threading
from concurrent.futures import Future
from typing import Any

import pytest

from i2pdsl.studio import solver as module
from i2pdsl.studio.protocol import CANCELLED, Refusal
from i2pdsl.studio.solver import IDLE, NOW, SOON, Job, Solver
from i2pdsl.worlds.kind import Watch

LONG = 20.0  # seconds that nothing here takes


@pytest.fixture(autouse=True)
def _soon_quiet(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "QUIET", 0.05)


class Endless:
    """Work that says how far it is until somebody stops it."""

    def __init__(self) -> None:
        self.begun = threading.Semaphore(0)

    def __call__(self, watch: Watch) -> None:
        self.begun.release()
        assert watch.searching is not None
        while True:
            watch.searching(0, 1)

    def begins(self) -> None:
        assert self.begun.acquire(timeout=LONG)


def cancelled(future: Future[Any]) -> bool:
    problem = future.exception(LONG)
    return isinstance(problem, Refusal) and problem.kind == CANCELLED


def test_what_a_job_makes_and_what_it_raises() -> None:
    solver = Solver()
    assert solver.submit(Job((1, "a"), NOW, lambda watch: 7)).result(LONG) == 7
    problem = ValueError("no")

    def fails(watch: Watch) -> None:
        raise problem

    assert solver.submit(Job((1, "a"), NOW, fails)).exception(LONG) is problem
    assert solver.submit(Job((1, "a"), NOW, lambda watch: 8)).result(LONG) == 8


def test_a_newer_job_of_the_same_takes_the_place_of_an_older_one() -> None:
    solver, endless = Solver(), Endless()
    old = solver.submit(Job((1, "a"), NOW, endless))
    endless.begins()
    waits = solver.submit(Job((1, "a"), NOW, lambda watch: 1))
    assert cancelled(old)
    assert waits.result(LONG) == 1


def test_jobs_of_others_wait_their_turn() -> None:
    solver, endless, order = Solver(), Endless(), []
    first = solver.submit(Job((1, "a"), NOW, endless))
    endless.begins()
    second = solver.submit(Job((2, "a"), SOON, lambda watch: order.append("soon")))
    third = solver.submit(Job((3, "a"), NOW, lambda watch: order.append("now")))
    assert not second.done()
    assert not third.done()
    solver.stop(lambda owner: owner[0] == 1)
    assert cancelled(first)
    second.result(LONG)
    third.result(LONG)
    assert order == ["now", "soon"]


def test_nobody_waits_for_a_job_that_cannot_hear() -> None:
    """As while something is compiled: a second thread goes on."""
    solver, begun, goes_on = Solver(), threading.Event(), threading.Event()

    def deaf(watch: Watch) -> int:
        begun.set()
        assert goes_on.wait(LONG)
        return 1

    old = solver.submit(Job((1, "a"), NOW, deaf))
    assert begun.wait(LONG)
    assert solver.submit(Job((1, "a"), NOW, lambda watch: 2)).result(LONG) == 2
    assert not old.done()
    goes_on.set()
    assert cancelled(old)


def test_idle_work_gives_way_and_begins_again() -> None:
    solver, endless, finished = Solver(), Endless(), threading.Event()

    def idle(watch: Watch) -> str:
        if not finished.is_set():
            endless(watch)
        return "done"

    best = solver.submit(Job((1, "a"), IDLE, idle))
    endless.begins()
    assert solver.submit(Job((2, "b"), SOON, lambda watch: 3)).result(LONG) == 3
    assert not best.done()
    endless.begins()  # again
    finished.set()
    solver.touch()
    assert best.result(LONG) == "done"


def test_idle_work_that_gave_way_can_be_stopped() -> None:
    solver, endless = Solver(), Endless()
    best = solver.submit(Job((1, "a"), IDLE, endless))
    endless.begins()
    assert solver.submit(Job((1, "a"), NOW, lambda watch: 4)).result(LONG) == 4
    assert cancelled(best)


def test_how_far_a_job_is() -> None:
    told: list[tuple[str, int, int, str]] = []

    def work(watch: Watch) -> None:
        assert watch.searching is not None
        assert watch.planning is not None
        watch.planning("robot", 3, 0.1, 10.0)
        watch.searching(5, 9)

    Solver().submit(Job((1, "a"), NOW, work, lambda *how: told.append(how))).result(LONG)
    assert told == [("planning", 3, 10, "planning robot"), ("searching", 5, 9, "searching")]


def test_it_is_never_quiet_between_two_looks_at_the_clock() -> None:
    """A thread that looks while it is not yet quiet, and then waits, is to wait for no more than
    what was left when it looked."""
    looks: list[float] = []
    late = threading.Event()

    def clock() -> float:
        # At each look of a worker the time of waiting is nearly over, and is over just afterwards.
        if threading.current_thread().name != "i2p-solver":
            return 0.0
        looks.append(module.QUIET - 1e-6 if len(looks) % 2 == 0 else module.QUIET + 1e-6)
        if len(looks) > 1:
            late.set()
        return looks[-1]

    solver = Solver(clock)
    assert solver.submit(Job((1, "a"), NOW, lambda watch: 0)).result(LONG) == 0
    looks.clear()
    assert solver.submit(Job((1, "a"), IDLE, lambda watch: 5)).result(LONG) == 5
    assert late.is_set()
