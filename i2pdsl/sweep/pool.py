"""Jobs on this machine: processes that are started anew (JAX does not survive a fork), one job at a
time each. One that dies is replaced, and its job done again."""

from __future__ import annotations

import multiprocessing
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from typing import Any

from i2pdsl.sweep.jobs import Job
from i2pdsl.sweep.work import Outcome

TRIES = 3  # of a job whose process dies: it may be what kills it
DIED = "the process that worked on it died"


@dataclass
class _Worker:
    process: Any
    line: Connection
    job: Job | None = None


def run_here(
    jobs: Sequence[Job], count: int, work: Callable[[Job], Any]
) -> Iterator[tuple[Job, Any]]:
    """Jobs with their outcomes, as they finish. What is not done when this is closed is dropped.

    Args:
        count: of processes.
        work: a function of a module, called in them.
    """
    waiting, tries = deque(jobs), dict.fromkeys(jobs, 0)
    workers: list[_Worker] = []
    try:
        while waiting or any(worker.job for worker in workers):
            while waiting and len(workers) < min(count, len(jobs)):
                workers.append(_started(work))
            for worker in workers:
                if worker.job is None and waiting:
                    worker.job = waiting.popleft()
                    with suppress(OSError):  # it died: it is met below
                        worker.line.send(worker.job)
            for line in wait([worker.line for worker in workers if worker.job]):
                worker = next(each for each in workers if each.line is line)
                job = worker.job
                assert job is not None
                try:
                    outcome = worker.line.recv()
                    worker.job = None
                except (EOFError, OSError):
                    workers.remove(worker)
                    worker.process.join()
                    tries[job] += 1
                    if tries[job] < TRIES:
                        waiting.append(job)
                        continue
                    outcome = Outcome(error=DIED, lasts=False)
                yield job, outcome
    finally:
        for worker in workers:
            worker.process.terminate()
        for worker in workers:
            worker.process.join()


def _started(work: Callable[[Job], Any]) -> _Worker:
    """A new process. Ctrl-C, which goes to all processes of a terminal, is ours alone."""
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_serve, args=(theirs, work), daemon=True)
    with _without_interrupts():
        process.start()
    theirs.close()  # so that its death ends the line
    return _Worker(process, ours)


@contextmanager
def _without_interrupts() -> Iterator[None]:
    """What is started here ignores SIGINT from its first moment on."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _serve(line: Connection, work: Callable[[Job], Any]) -> None:
    """The life of a process: jobs in, outcomes out, until the line ends."""
    with suppress(EOFError, OSError):
        while True:
            line.send(work(line.recv()))
