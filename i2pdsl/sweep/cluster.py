"""Jobs on a Dask cluster: the same functions, wherever its workers run."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from i2pdsl.sweep.jobs import Job
from i2pdsl.sweep.pool import DIED
from i2pdsl.sweep.work import Outcome, plan_job, run_job

EXTRA = "--scheduler needs dask.distributed, which is not installed: pip install 'i2pdsl[sweep]'"
PATIENCE = "60s"  # until the scheduler answers


def run_on_cluster(jobs: Sequence[Job], address: str) -> Iterator[tuple[Job, Any]]:
    """Jobs with their outcomes, as they finish. Worlds are planned first, each by one worker.

    A job whose worker dies is done by another; Dask gives up one that has killed several. What is
    not done when this is closed is cancelled.

    Raises ModuleNotFoundError where dask.distributed is not installed; OSError where no scheduler
    answers.
    """
    try:
        from distributed import Client, as_completed
        from distributed.scheduler import KilledWorker
    except ModuleNotFoundError as missing:
        raise ModuleNotFoundError(EXTRA, name=missing.name) from None
    with Client(address, timeout=PATIENCE, set_as_default=False) as client:
        plans = {
            job.planning: client.submit(plan_job, job, key=f"i2p-plan-{job.planning}")
            for job in jobs
        }
        futures = {
            client.submit(_after, plans[job.planning], job, key=f"i2p-{job.key}"): job
            for job in jobs
        }
        try:
            for future in as_completed(futures, loop=client.loop):
                job = futures[future]
                if future.status == "finished":
                    yield job, future.result()
                elif isinstance(future.exception(), KilledWorker):
                    yield job, Outcome(error=DIED, lasts=False)
                else:
                    yield job, Outcome(error=str(future.exception())[:300], lasts=False)
                future.release()
        finally:
            client.cancel([*futures, *plans.values()])


def _after(planned: str | None, job: Job) -> Outcome:
    """A job, once its world is planned."""
    return run_job(job)
