"""`i2p study` from a file to shares, pictures and a table; interrupted, and going on."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from commands_for_tests import Run
from i2pdsl.sweep import planning
from i2pdsl.sweep.jobs import Job
from i2pdsl.sweep.work import Outcome, run_job


def test_a_study_is_films_answers_and_shares(place: Path, i2p: Run, here: list[str]) -> None:
    out = place / "out"
    done = i2p("study", place / "tiny.study", "--out", out, "--json")
    assert done.status == 0, done.err
    told = json.loads(done.out)
    assert (told["study"], told["films"], told["missing"]) == ("tiny", 16, 0)
    assert [panel["name"] for panel in told["panels"]] == ["viewers", "own"]
    with open(out / "answers-viewers.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 6 * 16
    for share in told["panels"][0]["shares"]:
        place_of = f"films/{share['group']}/{share['method']}/"
        own = [row["answer"] for row in rows if row["script"].startswith(place_of)]
        right = {"help": "helping", "hinder": "hindering"}[share["group"]]
        assert share["share"] == pytest.approx(own.count(right) / len(own))
        assert share["low"] <= share["share"] <= share["high"]
    assert {share["people"] for share in told["panels"][0]["shares"]} == {0.5, None}
    for panel in told["panels"]:
        with Image.open(panel["files"]["picture"]) as picture:
            assert np.asarray(picture.convert("L")).std() > 10
    assert len(here) == 16
    words = i2p("study", place / "tiny.study", "--out", out)
    assert "helping, naive" in words.out
    assert words.out.count("circular") == 1, "of the panel `own`"
    assert len(here) == 16, "what is there is not made again"
    assert not [path for path in out.rglob("*") if path.name.startswith(".i2p")]


def test_more_seeds_change_no_other_answer(place: Path, i2p: Run, here: list[str]) -> None:
    def read() -> dict[tuple[str, str], str]:
        with open(place / "out/answers-viewers.csv", encoding="utf-8") as file:
            return {(r["participant"], r["script"]): r["answer"] for r in csv.DictReader(file)}

    assert i2p("study", place / "tiny.study", "--seeds", "0-1", "--out", place / "out").status == 0
    few = read()
    assert i2p("study", place / "tiny.study", "--out", place / "out").status == 0
    assert (len(few), len(here)) == (6 * 8, 16)
    assert few.items() <= read().items()


def test_interrupted_it_keeps_what_is_there_and_goes_on(
    place: Path, i2p: Run, here: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = i2p("study", place / "tiny.study", "--out", place / "whole", "--json")

    def interrupted(jobs: Sequence[Job], *_: Any) -> Iterator[tuple[Job, Outcome]]:
        for job in jobs[:6]:
            yield job, run_job(job)
        raise KeyboardInterrupt

    in_full = planning.done_here
    monkeypatch.setattr(planning, "done_here", interrupted)
    done = i2p("study", place / "tiny.study", "--out", place / "out", "--json")
    assert (done.status, json.loads(done.out)["missing"]) == (130, 10)
    assert "interrupted: 6 of 16 films are there" in done.err
    assert "the same command goes on from there" in done.err
    made = {f"{c}/{m}/seed-0" for c in ("help", "hinder") for m in ("naive", "short")}
    films = place / "out" / "films"
    kept = {str(path.parent.relative_to(films)) for path in films.rglob("result.json")}
    assert kept == made | {"help/naive/seed-1", "help/short/seed-1"}, "all groups go on together"
    monkeypatch.setattr(planning, "done_here", in_full)
    here.clear()
    again = i2p("study", place / "tiny.study", "--out", place / "out", "--json")
    assert (again.status, len(here)) == (0, 10)
    shares_of = lambda done: [panel["shares"] for panel in json.loads(done.out)["panels"]]
    assert shares_of(again) == shares_of(whole)


def test_films_that_cannot_be_made_are_told(place: Path, i2p: Run, here: list[str]) -> None:
    text = "world small\nlength 4\nmaximize depict(rho > 0)\nmaximize entropy(rho | script[:T])\n"
    (place / "help.story").write_text(text, encoding="utf-8")
    done = i2p("study", place / "tiny.study", "--seeds", "0", "--out", place / "out", "--json")
    assert done.status == 1
    assert "help/naive/seed-0: naive planning needs a story that depicts one event" in done.err
    assert json.loads(done.out)["missing"] == 2
    again = i2p("study", place / "tiny.study", "--seeds", "0", "--out", place / "out")
    assert (again.status, again.err, len(here)) == (1, done.err, 4), "it would fail again"


def test_a_study_without_a_panel_makes_its_films(place: Path, i2p: Run, here: list[str]) -> None:
    text = (place / "tiny.study").read_text(encoding="utf-8")
    (place / "tiny.study").write_text(text[: text.index("panel viewers")], encoding="utf-8")
    done = i2p("study", place / "tiny.study", "--seeds", "0", "--out", place / "out")
    assert (done.status, done.out.split("\n")[0], len(here)) == (0, "4 of 4 films are there", 4)
