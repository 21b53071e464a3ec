"""`i2p sweep`: many stories, settings and seeds, on one machine or many."""

from __future__ import annotations

import time
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from i2pdsl.commands.arguments import Assignment, Numbers
from i2pdsl.output import DONE, INTERRUPTED, WRONG, check_writable, output, output_json

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from i2pdsl.progress import Bars
    from i2pdsl.results import Choice
    from i2pdsl.sweep.jobs import Job
    from i2pdsl.sweep.results import Results
    from i2pdsl.sweep.work import Outcome

EVERY = 5.0  # seconds after which the table is written anew, if something came


class Shard(click.ParamType):
    """`K/N`: part K, from 1 on, of N."""

    name = "K/N"

    def convert(self, value: Any, param: Any, ctx: Any) -> tuple[int, int]:
        if isinstance(value, tuple):
            return value
        number, slash, count = str(value).partition("/")
        digits = all(part.isascii() and part.isdecimal() for part in (number, count))
        if not slash or not digits or not 1 <= int(number) <= int(count):
            self.fail(f"{value!r} is no part; write 1/8 to 8/8", param, ctx)
        return int(number), int(count)


@click.command()
@click.argument("stories", nargs=-1, required=True, type=click.Path())
@click.option("--seeds", type=Numbers("seeds"), default="0", help="0-19 or 1,4,7; default 0.")
@click.option(
    "--set", "settings", type=Assignment(), multiple=True, help="NAME=V1,V2: each value in turn."
)
@click.option("--out", type=click.Path(file_okay=False), required=True, help="The folder.")
@click.option("--shard", type=Shard(), default="1/1", help="Only part K of N of the jobs.")
@click.option("--workers", type=click.IntRange(1, 1024), default=None, help="Processes here.")
@click.option("--scheduler", default=None, metavar="ADDRESS", help="Of a Dask cluster.")
@click.option("--candidates", type=click.IntRange(1, 100), default=1, help="As for i2p run.")
@click.option("--effort", type=click.IntRange(1, 1000), default=1, help="As for i2p run.")
@click.option(
    "--choose",
    type=click.Choice(["panel", "wide", "score"]),
    default="panel",
    help="As for i2p run.",
)
@click.option("--naive", is_flag=True, help="As for i2p run.")
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def sweep(
    stories: tuple[str, ...],
    seeds: list[int],
    settings: tuple[tuple[str, str], ...],
    out: str,
    shard: tuple[int, int],
    workers: int | None,
    scheduler: str | None,
    candidates: int,
    effort: int,
    choose: Choice,
    naive: bool,
    as_json: bool,
) -> int:
    """Solve stories with all combinations of settings and all seeds; what is done is never done
    again.

    Results go into the folder as they finish, and into its table results.parquet or results.csv.
    """
    from i2pdsl.progress import Bars
    from i2pdsl.sweep.jobs import Manner, list_jobs
    from i2pdsl.sweep.jobs import shard as part_of
    from i2pdsl.sweep.results import Results

    if workers is not None and scheduler is not None:
        raise click.UsageError("--workers are of this machine, --scheduler has its own")
    began, folder = time.perf_counter(), Path(out)
    check_writable(folder)
    jobs = list_jobs(stories, settings, seeds, Manner(candidates, naive, choose, effort))
    mine = part_of(jobs, *shard)
    results = Results(folder, jobs)
    results.look()
    todo = [job for job in mine if job.place not in results.known]
    status, broken = DONE, {}
    try:
        if todo:
            with Bars() as bars:
                outcomes = _outcomes(todo, folder, workers, scheduler, bars)
                broken = _keep(outcomes, results, len(todo), bars)
    except KeyboardInterrupt:
        status = INTERRUPTED
    except ModuleNotFoundError as missing:
        raise click.UsageError(str(missing)) from None
    finally:
        results.write_table()
    there = [job for job in mine if job.place in results.known]
    wrong = {j.place: results.known[j.place]["error"] for j in there} | broken
    wrong = {place: error for place, error in wrong.items() if error is not None}
    for place, error in wrong.items():
        click.echo(f"{place}: {error}", err=True)
    if status == INTERRUPTED:
        told = f"{len(there)} of {len(mine)} jobs are done and kept"
        click.echo(f"interrupted: {told}; the same command goes on from there", err=True)
    elif wrong:
        status = WRONG
    document = {
        "jobs": len(mine),
        "done": len(there),
        "new": len(there) - (len(mine) - len(todo)),
        "failed": len(wrong),
        "table": str(results.table),
        "seconds": round(time.perf_counter() - began, 3),
    }
    if as_json:
        output_json(document)
    else:
        output(
            f"{document['done']} of {document['jobs']} jobs are done, {document['new']} of them now"
        )
        output(f"  {results.table}")
    return status


def _outcomes(
    todo: Sequence[Job], folder: Path, workers: int | None, scheduler: str | None, bars: Bars
) -> Iterator[tuple[Job, Outcome]]:
    """What becomes of each job, as they finish."""
    if scheduler is not None:
        from i2pdsl.sweep.cluster import run_on_cluster

        return run_on_cluster(todo, scheduler)
    from i2pdsl.sweep.planning import done_here

    return done_here(todo, folder, workers, bars.watch)


def _keep(
    outcomes: Iterator[tuple[Job, Outcome]], results: Results, total: int, bars: Bars
) -> dict[str, str]:
    """Keeps results as they come; the jobs that the machine failed at, and why."""
    broken: dict[str, str] = {}
    written = time.monotonic()
    with closing(outcomes):  # type: ignore[type-var]  # they are generators
        bars.sweeping(0, total)
        for number, (job, outcome) in enumerate(outcomes, 1):
            if outcome.lasts:
                results.keep(job, outcome)
            else:
                broken[job.place] = outcome.error or "it failed"
            bars.sweeping(number, total)
            if time.monotonic() - written > EVERY and number < total:
                results.write_table()
                written = time.monotonic()
    return broken
