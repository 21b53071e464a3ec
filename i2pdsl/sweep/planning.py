"""Jobs on this machine: worlds are planned before the jobs that need them, once, however many
processes begin at once."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from i2pdsl.errors import StoryError
from i2pdsl.sweep.jobs import Job
from i2pdsl.sweep.pool import run_here
from i2pdsl.sweep.work import Outcome, run_job
from i2pdsl.worlds.kind import Watch


def done_here(
    jobs: Sequence[Job], folder: Path, workers: int | None, watch: Watch
) -> Iterator[tuple[Job, Outcome]]:
    """Jobs with their outcomes, as they finish, in so many processes (sweep/pool.py). `folder` is
    that of their results."""
    plan_worlds(jobs, folder, watch)
    yield from run_here(jobs, workers or _usual_workers(), run_job)


def _usual_workers() -> int:
    """One process for two processors: a search computes in several threads."""
    usable = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return max(1, (usable or 1) // 2)


def plan_worlds(jobs: Sequence[Job], folder: Path, watch: Watch) -> None:
    """Makes each world that jobs need ready, so that its plans lie in the cache.

    Shards that work in one folder do it one after the other: all but the first find them there.
    """
    for job in {job.planning: job for job in jobs}.values():
        with _one_at_a_time(folder / f".planning-{job.planning}"), suppress(StoryError):
            job.load().world(watch)  # what is wrong is told as the job's outcome


@contextmanager
def _one_at_a_time(path: Path) -> Iterator[None]:
    """Waits for others who are here; whoever dies leaves. Where files cannot be locked, nobody
    waits."""
    try:
        import fcntl
    except ModuleNotFoundError:  # Windows
        yield
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(path, "a") as file:
        with suppress(OSError):
            fcntl.flock(file, fcntl.LOCK_EX)
        yield
