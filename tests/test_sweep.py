"""Sweeps: what is done is kept whatever happens, and is what `solve` finds."""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from commands_for_tests import PATIENCE, Outcome, Run, process
from i2pdsl.stories import load
from i2pdsl.sweep import results as results_module
from i2pdsl.sweep.jobs import Job, Manner, choices_of, list_jobs, shard
from i2pdsl.sweep.pool import DIED, TRIES, run_here
from i2pdsl.sweep.results import Results
from i2pdsl.sweep.work import Outcome as Done
from worlds_for_tests import STORIES, with_small_world

NAIVE = "world small\nlength 3\nmaximize depict(rho > 0)\n"  # needs no compiler


@pytest.fixture(autouse=True)
def is_a_program(monkeypatch: pytest.MonkeyPatch) -> None:
    """A worker of pytest-xdist lacks what every program has, and what new processes ask for."""
    monkeypatch.setattr(sys.modules["__main__"], "__spec__", None, raising=False)


@pytest.fixture
def place(tmp_path: Path) -> Path:
    folder = with_small_world(tmp_path)
    (folder / "one.story").write_text(NAIVE, encoding="utf-8")
    (folder / "two.story").write_text(NAIVE.replace("> 0", "< 0"), encoding="utf-8")
    return folder


@pytest.fixture
def as_csv(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(results_module, "_pyarrow", lambda: False)


def table(folder: Path) -> list[dict[str, str]]:
    with open(folder / "results.csv", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def jobs_of(place: Path, *seeds: int) -> list[Job]:
    return list_jobs([str(place / "one.story")], [], seeds, Manner(naive=True))


def swept(place: Path, i2p: Run, *arguments: str | Path) -> Outcome:
    stories = (place / "one.story", place / "two.story")
    return i2p("sweep", *stories, "--naive", "--out", place / "out", *arguments)


# The list of jobs.


def test_jobs_are_all_combinations(place: Path) -> None:
    paths = [str(place / name) for name in ("one.story", "two.story")]
    settings = [("beta", "0.5,1"), ("weights", "x")]
    assert choices_of([("a", "{1, 2},{3}"), ("b", "f(1, 2)"), ("a", "4")]) == [
        (("a", "{1, 2}"), ("b", "f(1, 2)")),
        (("a", "{3}"), ("b", "f(1, 2)")),
        (("a", "4"), ("b", "f(1, 2)")),
    ]
    jobs = list_jobs(paths, settings[:1], [0, 1, 2], Manner())
    assert len(jobs) == len({job.place for job in jobs}) == len({job.key for job in jobs}) == 12
    assert [job.place for job in jobs[:4]] == [
        *(f"one/beta=0.5/seed-{seed}" for seed in range(3)),
        "one/beta=1/seed-0",
    ]
    assert len({job.planning for job in jobs}) == 2  # of one world
    parts = [shard(jobs, number, 5) for number in range(1, 6)]
    assert sorted(job.place for part in parts for job in part) == sorted(j.place for j in jobs)
    again = list_jobs(paths, settings[:1], [0, 1, 2], Manner())
    assert again == jobs


def test_a_key_is_of_all_that_the_result_depends_on(place: Path) -> None:
    """Also of what is imported and of the world's file."""
    (place / "mood.story").write_text("pattern mood(e) = depict(e)\n", encoding="utf-8")
    text = 'import "mood.story"\nworld small\nlength 3\nmaximize mood(rho > 0)\n'
    (place / "one.story").write_text(text, encoding="utf-8")
    key = lambda **manner: list_jobs([str(place / "one.story")], [], [0], Manner(**manner))[0].key
    first = key()
    assert first == key()
    assert first != key(naive=True)
    (place / "mood.story").write_text("pattern mood(e) = 2 * depict(e)\n", encoding="utf-8")
    assert first != key()
    second, world = key(), place / "small.world"
    world.write_text(world.read_text("utf-8").replace("gamma = 0.9", "gamma = 0.8"), "utf-8")
    assert second != key()


def test_a_key_is_of_the_frames_that_are_kept(place: Path) -> None:
    (place / "desk.world").write_text((STORIES / "worlds/desk.world").read_text("utf-8"), "utf-8")
    text = 'world desk\nlength 9\nmaximize depict(G_hand = left)\npin script[1..2] = "take.json"\n'
    (place / "kept.story").write_text(text, encoding="utf-8")
    keys = set()
    for content in (None, '{"one": 1}', '{"another": 2}'):
        if content is not None:
            (place / "take.json").write_text(content, encoding="utf-8")
        keys.add(list_jobs([str(place / "kept.story")], [], [0], Manner())[0].key)
    assert len(keys) == 3


def test_wrong_stories_are_told_before_anything_runs(place: Path, i2p: Run) -> None:
    (place / "two.story").write_text("world small\nlength 0\n", encoding="utf-8")
    done = swept(place, i2p, "--set", "nobody=1,2")
    assert done.status == 1
    assert "the story has no `nobody` to set" in done.err
    assert not (place / "out").exists()
    (place / "more").mkdir()
    (place / "more" / "one.story").write_text(NAIVE.replace("small", "maze"), encoding="utf-8")
    done = i2p("sweep", place / "one.story", place / "more/one.story", "--out", place / "out")
    assert (done.status, "its results would go where" in done.err) == (1, True)


@pytest.mark.parametrize(
    "arguments",
    ["--shard 0/2", "--shard 3/2", "--shard x", "--workers 2 --scheduler a", "--seeds -1"],
)
def test_wrong_usage_is_told(place: Path, i2p: Run, arguments: str) -> None:
    assert swept(place, i2p, *arguments.split()).status == 2


# On this machine.


@pytest.mark.usefixtures("as_csv")
def test_a_sweep_is_every_story_solved(place: Path, i2p: Run) -> None:
    """And doing it again does nothing; of what has changed it does what has changed."""
    options = ("--seeds", "0-1", "--set", "length=2,3", "--json")
    done = swept(place, i2p, *options)
    assert done.status == 0, done.err
    told = json.loads(done.out)
    assert (told["jobs"], told["done"], told["new"], told["failed"]) == (8, 8, 8, 0)
    rows = table(place / "out")
    assert [(r["story"], r["length"], r["seed"]) for r in rows] == [
        (story, length, seed)
        for story in ("one", "two")
        for length in ("2.0", "3.0")
        for seed in "01"
    ]
    for row in rows[:2]:
        story = load(place / f"{row['story']}.story").with_(length=int(float(row["length"])))
        found = story.solve(int(row["seed"]), naive=True)
        written = json.loads((place / "out" / row["script"]).read_text(encoding="utf-8"))
        assert written["frames"] == json.loads(json.dumps(list(found.script.record.frames)))
        assert float(row["score"]) == found.script.score
        assert float(row["panel_mean"]) == found.judgements[0].mean
        assert row["off_by"] == ""
        assert "trust" not in written
    before = {p: p.stat().st_mtime_ns for p in (place / "out").rglob("*.json")}
    again = swept(place, i2p, *options)
    assert json.loads(again.out)["new"] == 0
    assert before == {p: p.stat().st_mtime_ns for p in (place / "out").rglob("*.json")}
    assert table(place / "out") == rows
    (place / "two.story").write_text(NAIVE.replace("> 0", "= 0"), encoding="utf-8")
    assert json.loads(swept(place, i2p, *options).out)["new"] == 4


@pytest.mark.usefixtures("as_csv")
def test_a_story_that_fails_is_a_row_and_the_others_go_on(place: Path, i2p: Run) -> None:
    (place / "two.story").write_text(NAIVE + "maximize entropy(rho | script[:T])\n", "utf-8")
    done = swept(place, i2p)
    assert done.status == 1
    assert "two/seed-0: naive planning needs a story that depicts one event" in done.err
    rows = table(place / "out")
    assert [(r["story"], r["score"] != "", r["error"] != "") for r in rows] == [
        ("one", True, False),
        ("two", False, True),
    ]


def test_a_table_is_parquet_where_it_can_be(place: Path) -> None:
    """With types, also of what is empty."""
    from pyarrow import parquet

    settings = [("length", "2,3")]
    jobs = list_jobs([str(place / "one.story")], settings, [0], Manner(naive=True))
    results = Results(place / "out", jobs)
    results.keep(jobs[1], Done(error="no"))
    results.write_table()
    told = parquet.read_table(place / "out" / "results.parquet")
    types = {
        name: str(told.schema.field(name).type) for name in ("seed", "score", "length", "error")
    }
    assert types == {"seed": "int64", "score": "double", "length": "double", "error": "string"}
    assert told.to_pylist()[0]["error"] == "no"


@pytest.mark.usefixtures("as_csv")
def test_shards_make_one_table_whoever_ends_last(place: Path) -> None:
    """One that looked before the other's result was there looks again once it has written."""
    jobs = jobs_of(place, 0, 1)
    one, other = Results(place / "out", jobs), Results(place / "out", jobs)
    one.keep(jobs[0], Done(error="first"))
    look, looked = one.look, []

    def look_late() -> None:
        look()
        if not looked:
            other.keep(jobs[1], Done(error="second"))
            other.write_table()
        looked.append(True)

    one.look = look_late  # type: ignore[method-assign]
    one.write_table()
    assert [row["error"] for row in table(place / "out")] == ["first", "second"]


def test_damaged_and_foreign_results_are_none(place: Path) -> None:
    (job,) = jobs_of(place, 0)
    results = Results(place / "out", [job])
    results.keep(job, Done(error="no"))
    file = place / "out" / job.place / "result.json"
    text = file.read_text(encoding="utf-8")
    for wrong in (text[:-20], text.replace(job.key, "0" * 24), "[]", ""):
        file.write_text(wrong, encoding="utf-8")
        again = Results(place / "out", [job])
        again.look()
        assert again.known == {}, wrong


def dies_once(job: Job) -> Done:
    """The second time it is done: this is where the marks of the first are."""
    mark = Path(job.path).parent / f"begun-{job.seed}"
    if job.seed % 2 and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return Done(error=str(job.seed))


def dies(job: Job) -> Done:
    mark = Path(job.path).parent / f"tried-{time.monotonic_ns()}"
    mark.touch()
    os.kill(os.getpid(), signal.SIGKILL)
    raise AssertionError


def test_a_process_that_is_killed_loses_nothing(place: Path) -> None:
    jobs = jobs_of(place, *range(5))
    done = dict(run_here(jobs, 2, dies_once))
    assert {job.seed: outcome.error for job, outcome in done.items()} == {
        seed: str(seed) for seed in range(5)
    }


def test_what_kills_every_process_is_given_up(place: Path) -> None:
    """And may be tried again another time."""
    ((_, outcome),) = run_here(jobs_of(place, 0), 1, dies)
    assert (outcome.error, outcome.lasts) == (DIED, False)
    assert len(list(place.glob("tried-*"))) == TRIES


def test_ctrl_c_keeps_what_is_done(place: Path) -> None:
    """The same command goes on from there."""
    command = [sys.executable, "-m", "i2pdsl", "sweep", str(place / "one.story"), "--naive"]
    command += ["--seeds", "0-60", "--out", str(place / "out"), "--workers", "1"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as running:
        wait_for(running, lambda: any((place / "out").rglob("result.json")))
        running.send_signal(signal.SIGINT)
        _, said = running.communicate(timeout=PATIENCE)
    assert running.returncode == 130, said
    assert "of 61 jobs are done and kept" in said
    kept = len(list((place / "out").rglob("result.json")))
    assert 0 < kept < 61
    again = process(*command[3:], "--seeds", "0-60", "--json")
    told = json.loads(again.out)
    assert (told["done"], told["new"]) == (61, 61 - kept)


def wait_for(running: subprocess.Popen[str], what: Callable[[], bool]) -> None:
    """Until it is so, while a program runs."""
    while not what():
        assert running.poll() is None
        time.sleep(0.02)


# On a cluster.


def test_a_cluster_whose_worker_is_killed_loses_nothing(place: Path) -> None:
    """A scheduler and two workers as processes; one of them is killed in the middle."""
    import socket

    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
    dask = [sys.executable, "-m", "dask"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    serve = ["scheduler", "--host", address, "--no-dashboard"]
    join = ["worker", address, "--nthreads", "1", "--no-nanny", "--no-dashboard"]
    processes = [subprocess.Popen([*dask, *serve], **quiet)]
    processes += [subprocess.Popen([*dask, *join], cwd=place, **quiet) for _ in range(2)]
    command = [sys.executable, "-m", "i2pdsl", "sweep", str(place / "one.story"), "--naive"]
    command += ["--seeds", "0-15", "--scheduler", address, "--out", str(place / "out"), "--json"]
    try:
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as running:
            wait_for(running, lambda: len(list((place / "out").rglob("result.json"))) >= 2)
            processes[1].kill()
            out, _ = running.communicate(timeout=PATIENCE)
        assert running.returncode == 0
    finally:
        for each in processes:
            each.kill()
            each.wait()
    told = json.loads(out)
    assert (told["jobs"], told["done"], told["failed"]) == (16, 16, 0)
    script = json.loads((place / "out/one/seed-7/script.json").read_text(encoding="utf-8"))
    found = load(place / "one.story").solve(7, naive=True).script
    assert script["frames"] == json.loads(json.dumps(list(found.record.frames)))


def test_without_dask_it_is_said_how_to_get_it(
    place: Path, i2p: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    done = swept(place, i2p, "--scheduler", "tcp://127.0.0.1:1")
    assert done.status == 2
    assert "pip install 'i2pdsl[sweep]'" in done.err
