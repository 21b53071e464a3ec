"""A folder with a study, whose films are made in this process."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from i2pdsl.sweep import planning
from i2pdsl.sweep.jobs import Job
from i2pdsl.sweep.work import run_job
from studies_for_tests import TINY
from worlds_for_tests import with_small_world


@pytest.fixture
def place(tmp_path: Path) -> Path:
    """A folder with a study."""
    folder = with_small_world(tmp_path)
    for name, event in (("help", "rho > 0"), ("hinder", "rho < 0")):
        text = f"world small\nlength 4\nmaximize depict({event})\n"
        (folder / f"{name}.story").write_text(text, encoding="utf-8")
    (folder / "tiny.study").write_text(TINY, encoding="utf-8")
    return folder


@pytest.fixture
def here(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Films are made in this process; the places of those that were."""
    made: list[str] = []

    def done_here(jobs: Sequence[Job], *_: Any) -> Iterator[tuple[Job, Any]]:
        for job in jobs:
            made.append(job.place)
            yield job, run_job(job)

    monkeypatch.setattr(planning, "done_here", done_here)
    return made
