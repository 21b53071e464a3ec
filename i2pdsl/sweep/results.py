"""The results of a sweep as files: one folder for each job, and one table of all.

A job is done where its folder holds a `result.json` with its key: that is written last, and whole.
So a sweep may be stopped anywhere, and several may work in one folder.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from i2pdsl.resources import atomic_path, write_text
from i2pdsl.sweep.jobs import Job
from i2pdsl.sweep.work import Outcome
from i2pdsl.worlds.record import ERROR, Record

FORMAT, VERSION = "i2p-sweep-result", 1


class Results:
    """What is there of the jobs of a sweep.

    Attributes:
        folder: of the sweep.
        jobs: all of them, not only those of a shard.
        known: what `result.json` says of each that is done, by its place.
        table: the file of the table: Parquet where pyarrow is installed, else CSV.
    """

    def __init__(self, folder: Path, jobs: Sequence[Job]):
        self.folder, self.jobs = folder, jobs
        self.known: dict[str, dict[str, Any]] = {}
        self.table = folder / f"results.{'parquet' if _pyarrow() else 'csv'}"

    def look(self) -> None:
        """Looks for results that are new, whoever left them."""
        for job in self.jobs:
            if job.place not in self.known:
                found = self._read(job)
                if found is not None:
                    self.known[job.place] = found

    def _read(self, job: Job) -> dict[str, Any] | None:
        try:
            text = (self.folder / job.place / "result.json").read_text(encoding="utf-8")
            found = json.loads(text)
        except (OSError, ValueError):
            return None
        is_ours = isinstance(found, dict) and found.get("format") == FORMAT
        return found if is_ours and found.get("key") == job.key else None

    def keep(self, job: Job, outcome: Outcome) -> None:
        """Writes what became of a job: its scripts, and then that it is done."""
        place, told = self.folder / job.place, []
        for number, (script, about) in enumerate(
            zip(outcome.scripts, outcome.candidates, strict=True), 1
        ):
            name = "script.json" if number == 1 else f"candidate-{number}/script.json"
            _record(script).save(place / name)
            told.append({**about, "script": f"{job.place}/{name}"})
        document = {
            "format": FORMAT,
            "version": VERSION,
            "key": job.key,
            "story": job.story,
            "settings": dict(job.settings),
            "seed": job.seed,
            "candidates": told,
            "seconds": outcome.seconds or {},
            "error": outcome.error,
        }
        write_text(place / "result.json", json.dumps(document, ensure_ascii=False) + "\n")
        self.known[job.place] = document

    def write_table(self) -> None:
        """Writes the table of all that is there, and again if more came meanwhile: of several
        writers, the last one has everything."""
        while True:
            self.look()
            count = len(self.known)
            _write(self.table, self.columns())
            self.look()
            if len(self.known) == count:
                return

    def columns(self) -> dict[str, list[Any]]:
        """A row for each candidate, in the order of the jobs; one for a job that failed."""
        names = list(dict.fromkeys(name for job in self.jobs for name, _ in job.settings))
        rows = []
        for job in self.jobs:
            if job.place in self.known:
                rows += _rows(self.known[job.place], job, names)
        heads = ("story", *names, "seed", "candidate", *_FIGURES, "script", "error")
        found = {head: [row.get(head) for row in rows] for head in heads}
        return {**found, **{name: _numbers(found[name]) for name in names}}


_FIGURES = (
    *("score", "panel_mean", "panel_worst", "still", "unmet", "off_by"),
    *("plan_seconds", "compile_seconds", "search_seconds"),
)


def _rows(document: dict[str, Any], job: Job, names: Sequence[str]) -> list[dict[str, Any]]:
    settings = dict(job.settings)
    about = {"story": job.story, "seed": job.seed, **{name: settings.get(name) for name in names}}
    if document["error"] is not None:
        return [{**about, "error": document["error"]}]
    seconds = document["seconds"]
    spent = {f"{s}_seconds": float(seconds.get(s, 0.0)) for s in ("plan", "compile", "search")}
    return [
        {
            **about,
            **spent,
            "candidate": number,
            "score": each["score"],
            "panel_mean": each["panel"]["mean"],
            "panel_worst": each["panel"]["worst"],
            "still": each["still"],
            "unmet": len(each["unmet"]),
            "off_by": (each.get("trust") or {}).get("belief"),
            "script": each["script"],
        }
        for number, each in enumerate(document["candidates"], 1)
    ]


def _numbers(values: list[str | None]) -> list[Any]:
    """The values of a setting as numbers, where all of them are."""
    try:
        return [None if value is None else float(value) for value in values]
    except ValueError:
        return values


def _record(document: dict[str, Any]) -> Record:
    return Record(
        document["story"],
        document["world"],
        document["score"],
        document["start"],
        tuple(document["frames"]),
        error={key: document[key] for key in ERROR if key in document},
    )


def _pyarrow() -> bool:
    from importlib.util import find_spec

    return find_spec("pyarrow") is not None


def _write(path: Path, columns: dict[str, list[Any]]) -> None:
    if path.suffix == ".csv":
        from i2pdsl.tables import as_csv

        write_text(path, as_csv(columns))
        return
    import pyarrow
    from pyarrow import parquet

    types = {name: pyarrow.int64() for name in ("seed", "candidate", "unmet")}
    types |= {name: pyarrow.float64() for name in _FIGURES if name != "unmet"}
    types |= {name: pyarrow.string() for name in ("story", "script", "error")}
    arrays = {n: pyarrow.array(values, types.get(n)) for n, values in columns.items()}
    with atomic_path(path) as temporary:
        parquet.write_table(pyarrow.table(arrays), temporary)
