"""One job of a sweep, done anywhere: what goes in and comes out is plain data."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import Any

from i2pdsl.errors import StoryError
from i2pdsl.sweep.jobs import Job

_one_at_a_time = threading.Lock()  # a worker of a cluster may have several threads


@dataclass(frozen=True)
class Outcome:
    """What became of a job.

    Attributes:
        scripts: the content of each candidate's file.
        candidates: what is told of each: score, panel, still, unmet, trust.
        seconds: time of each stage.
        error: why there is none: what is wrong with the story, in words.
        lasts: whether doing it again would end in the same way.
    """

    scripts: tuple[dict[str, Any], ...] = ()
    candidates: tuple[dict[str, Any], ...] = ()
    seconds: dict[str, float] | None = None
    error: str | None = None
    lasts: bool = True


def run_job(job: Job) -> Outcome:
    """Solves a story. Whatever goes wrong is told in the outcome."""
    with _one_at_a_time:
        try:
            return _solved(job)
        except StoryError as problem:
            return Outcome(error=problem.diagnostics[0].message)
        except (RuntimeError, MemoryError, OSError) as problem:  # of the machine, not the story
            told = str(problem) or type(problem).__name__
            return Outcome(error=" ".join(told.split())[:300], lasts=False)


def _solved(job: Job) -> Outcome:
    manner = job.manner
    found = job.load().solve(
        job.seed, manner.candidates, manner.naive, choose=manner.choose, effort=manner.effort
    )
    chosen = found.candidates[: manner.candidates]  # a descent found more
    told = [
        {
            "score": script.score,
            "panel": {"mean": judgement.mean, "worst": judgement.worst},
            "still": script.still,
            "unmet": [requirement.text for requirement in script.unmet],
            "trust": None if script.trust is None else script.trust.as_json(),
        }
        for script, judgement in zip(chosen, found.judgements, strict=False)
    ]
    documents = tuple(script.with_error.as_json() for script in chosen)
    seconds = {name: round(value, 4) for name, value in found.seconds.items()}
    return Outcome(documents, tuple(told), seconds)


def plan_job(job: Job) -> str | None:
    """Makes the world of a job ready, so that its plans lie in the cache; why that failed."""
    with _one_at_a_time:
        try:
            job.load().world()
        except StoryError:
            return None  # the job itself tells it
        except (RuntimeError, MemoryError, OSError) as problem:
            return str(problem)
    return None
