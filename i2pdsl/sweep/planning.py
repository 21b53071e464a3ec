"""Worlds are planned before the jobs that need them: once, however many processes begin at once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from i2pdsl.errors import StoryError
from i2pdsl.sweep.jobs import Job
from i2pdsl.worlds.kind import Watch


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
