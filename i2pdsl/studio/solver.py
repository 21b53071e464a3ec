"""One worker: what takes long is done in a thread of its own, one job after the other.

A newer job of the same document takes the place of an older one. A job hears of it when it next
says how far it is (`Watch`), between two blocks of a search or sweeps of planning. While a program
is compiled it says nothing for seconds; so that nobody waits for what nobody wants any more, a
second thread takes over meanwhile. What is done for the sake of a better film, with nobody waiting
for it, gives way to everything else, and begins again afterwards.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Hashable
from concurrent.futures import Future, InvalidStateError
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

from i2pdsl.studio.protocol import CANCELLED, Refusal
from i2pdsl.worlds.kind import Watch

NOW, SOON, IDLE = range(3)
"""How urgent a job is: somebody waits; somebody looks already at something; for better films."""
Owner = tuple[Hashable, Hashable]
"""Who wants something, and about what."""
QUIET = 0.8  # seconds since somebody last did something, until idle work begins
THREADS = 2  # one that works, one that ends


class Stopped(BaseException):
    """Somebody ended a job. No Exception: nothing on its way keeps what was found so far."""


@dataclass(eq=False)
class Job:
    """Something to be done.

    Attributes:
        owner: a newer job of the same owner that is as urgent or more takes its place.
        work: what is done, given how to say how far it is.
        told: is called with the stage, how far it is and the whole, and words.
    """

    owner: Owner
    urgency: int
    work: Callable[[Watch], Any]
    told: Callable[[str, int, int, str], None] = lambda stage, done, total, text: None
    future: Future[Any] = field(default_factory=Future)
    stopped: bool = False
    gives_way: bool = False

    def watch(self) -> Watch:
        return Watch(self._planning, self._searching, None, self._say)

    def _check(self) -> None:
        if self.stopped or self.gives_way:
            raise Stopped

    def _planning(self, who: str, sweep: int, residual: float, expected: float | None) -> None:
        self._check()
        total = int(max(expected or 0, sweep))
        self.told("planning", sweep, total, f"planning {who}")

    def _searching(self, done: int, total: int) -> None:
        self._check()
        self.told("searching", done, total, "searching")

    def _say(self, message: str) -> None:
        self._check()
        self.told("working", 0, 0, message)


class Solver:
    """The worker.

    Args:
        clock: seconds that only grow.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._changed = threading.Condition()
        self._waiting: list[Job] = []
        self._running: list[Job] = []
        self._threads = 0
        self._touched = -math.inf

    def submit(self, job: Job) -> Future[Any]:
        """Has a job done; its future's exception is Refusal where it was ended."""
        with self._changed:
            for other in (*self._waiting, *self._running):
                if other.owner == job.owner and other.urgency >= job.urgency:
                    self._stop(other)
            if job.urgency < IDLE:
                self._make_way()
            self._waiting.append(job)
            if self._threads < THREADS:
                self._threads += 1
                threading.Thread(target=self._run, name="i2p-solver", daemon=True).start()
            self._changed.notify_all()
        return job.future

    def touch(self) -> None:
        """Somebody is doing something: what nobody waits for makes way, and waits a while."""
        with self._changed:
            self._make_way()

    def _make_way(self) -> None:
        self._touched = self._clock()
        for job in self._running:
            job.gives_way = job.gives_way or job.urgency == IDLE

    def stop(self, is_one: Callable[[Owner], bool]) -> None:
        """Ends the jobs of some owners."""
        with self._changed:
            for job in (*self._waiting, *self._running):
                if is_one(job.owner):
                    self._stop(job)
            self._changed.notify_all()

    def _stop(self, job: Job) -> None:
        job.stopped = True
        if job in self._waiting:
            self._waiting.remove(job)
            with suppress(InvalidStateError):
                job.future.set_exception(Refusal(CANCELLED, "something newer was asked"))

    def _next(self) -> Job:
        """The most urgent job, once nobody works on one that is still wanted."""
        with self._changed:
            # The clock is read once a round: were it quiet between two readings, nobody would wake.
            while (job := self._due(now := self._clock())) is None:
                quiet = self._touched + QUIET - now
                self._changed.wait(quiet if self._waiting and quiet > 0 else None)
            self._waiting.remove(job)
            self._running.append(job)
            job.gives_way = False
            return job

    def _due(self, now: float) -> Job | None:
        """The most urgent job that waits; None where it must go on waiting."""
        busy = any(not (job.stopped or job.gives_way) for job in self._running)
        if busy or not self._waiting:
            return None
        job = min(self._waiting, key=lambda each: each.urgency)
        idle = job.urgency == IDLE and now < self._touched + QUIET
        return None if idle else job

    def _run(self) -> None:
        while True:
            job = self._next()
            result: Any = None
            problem: BaseException | None = None
            try:
                result = job.work(job.watch())
            except BaseException as wrong:
                problem = wrong
            with self._changed:
                self._running.remove(job)
                again = isinstance(problem, Stopped) and not job.stopped
                if again:
                    self._waiting.append(job)
                self._changed.notify_all()
            if again:
                continue
            if job.stopped:
                problem = Refusal(CANCELLED, "something newer was asked")
            with suppress(InvalidStateError):  # whoever waited has gone, and cancelled it
                if problem is not None:
                    job.future.set_exception(problem)
                else:
                    job.future.set_result(result)
