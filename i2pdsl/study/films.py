"""The films of a study: which scripts there are, and making those that are missing.

They are jobs of a sweep (i2pdsl/sweep/): each is a folder with a script and a result that is
written last, so an interrupted study goes on from there, and what has changed is made anew.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

from i2pdsl.study.check import Ground
from i2pdsl.study.spec import Film, Study
from i2pdsl.sweep.jobs import Job, Manner, jobs_of_story
from i2pdsl.sweep.results import Results
from i2pdsl.sweep.work import Outcome

FOLDER = "films"  # in the study's own
Doing = Callable[[Sequence[Job]], Iterator[tuple[Job, Any]]]
"""How jobs are done: their outcomes, as they finish (sweep/pool.py:run_here)."""


class Films:
    """The films of a study, below a folder.

    Attributes:
        broken: what the machine failed at, by the places of the films: it is tried again next time.
    """

    def __init__(
        self, study: Study, grounds: Mapping[tuple[str, str], Ground], folder: Path
    ) -> None:
        self.study, self.grounds, self.folder = study, grounds, folder / FOLDER
        self.jobs = {job.place: job for each in grounds for job in self._jobs(*each)}
        self.results = Results(self.folder, list(self.jobs.values()))
        self.broken: dict[str, str] = {}
        self.results.look()

    def _jobs(self, condition: str, method: str) -> list[Job]:
        told = self.grounds[condition, method].story
        if told is None:
            return []
        manner = Manner(naive=self.study.method(method).naive)
        jobs = jobs_of_story(told, (), self.study.seeds, manner)
        return [replace(j, place=Film(condition, method, j.seed).place) for j in jobs]

    def path(self, film: Film) -> Path | None:
        """The script of a film; None where it is not made."""
        given = self.grounds[film.condition, film.method].scripts
        if given:
            return given[film.seed]
        known = self.results.known.get(film.place)
        if known is None or known["error"] is not None:
            return None
        return self.folder / film.place / "script.json"

    def name(self, film: Film, folder: Path) -> str:
        """The path of its script as a table in a folder has it."""
        path = self.path(film)
        assert path is not None, "nobody answers about a film that is not there"
        return Path(os.path.relpath(path, folder)).as_posix()

    @property
    def made(self) -> int:
        """How many there are."""
        return sum(self.path(film) is not None for film in self.study.films)

    @property
    def in_words(self) -> str:
        return f"{self.made} of {len(self.study.films)} films are there\n  {self.folder}"

    @property
    def missing(self) -> list[Job]:
        """What is yet to be made: seed by seed, so that what there is at any time is balanced."""
        jobs = [job for place, job in self.jobs.items() if place not in self.results.known]
        return sorted(jobs, key=lambda job: self.study.seeds.index(job.seed))

    def make(self, do: Doing, report: Callable[[int, int], None]) -> None:
        """Makes what is missing. Interrupted, it keeps what is there: raises KeyboardInterrupt."""
        jobs = self.missing
        with closing(do(jobs)) as outcomes:  # type: ignore[type-var]  # they are generators
            report(0, len(jobs))
            for number, (job, outcome) in enumerate(outcomes, 1):
                self._keep(job, outcome)
                report(number, len(jobs))

    def _keep(self, job: Job, outcome: Outcome) -> None:
        if outcome.lasts:
            self.results.keep(job, outcome)
        else:
            self.broken[job.place] = outcome.error or "it failed"

    @property
    def wrong(self) -> dict[str, str]:
        """Why films could not be made, by their places."""
        known = {place: found["error"] for place, found in self.results.known.items()}
        return {place: error for place, error in known.items() if error is not None} | self.broken
