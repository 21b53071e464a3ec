"""Stories that share a pattern share its compiled search: each shape is traced once, ever."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from commands_for_tests import Run
from i2pdsl import programs
from i2pdsl.errors import Source
from i2pdsl.pipeline import load, story_from
from i2pdsl.search.prepare import prepare
from i2pdsl.worlds.ready import Watch

PATTERNS = """\
pattern lean(event, weight = 1) = sum_t weight * P(event | script[:t])
pattern turned(first, second, moment) =
    sum_t (if t <= moment then P(first | script[:t]) else P(second | script[:t]))
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """20 stories of two shapes, in a world that is planned at once; an empty cache of programs."""
    cache = tmp_path / "cache"
    monkeypatch.setenv("I2PDSL_CACHE", str(cache))
    place = tmp_path / "many"
    place.mkdir()
    (place / "moves.story").write_text(PATTERNS, encoding="utf-8")
    for number in range(20):
        side = ("left", "right")[number % 2]
        call = f"lean(G_robot = {side}, weight = {1 + number / 10:g})"
        if number >= 10:
            other = ("right", "left")[number % 2]
            call = f"turned(G_robot = {side}, G_robot = {other}, {1 + number % 3})"
        (place / f"s{number:02}.story").write_text(
            "world fork\nlength 4\nstart at(robot, (4, 4))\nimport moves\n"
            f"maximize {call}\nsearch beam(starts = 1, width = 3)\n",
            encoding="utf-8",
        )
    monkeypatch.setattr(programs, "_memory", {})
    return place


def count_traces(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Notes every program that is traced."""
    traced: list[str] = []
    jit = programs.jax.jit

    def noted(function: Any) -> Any:
        traced.append("one")
        return jit(function)

    monkeypatch.setattr(programs.jax, "jit", noted)
    return traced


def test_each_shape_is_traced_once(
    folder: Path, tmp_path: Path, i2p: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    traced = count_traces(monkeypatch)
    library = tmp_path / "moves.i2plib"
    done = i2p("compile", folder, "-o", library, "--json")
    assert done.status == 0, done.err
    said = json.loads(done.out)
    assert len(traced) == said["traced"] == len(said["shapes"]) == 2
    assert sorted(len(shape["stories"]) for shape in said["shapes"]) == [10, 10]
    # Making all stories traces nothing, nor does another process, whose memory is empty.
    programs._memory.clear()
    for path in sorted(folder.glob("s*.story")):
        load(path).solve()
    assert len(traced) == 2
    # And a story of such a shape that is written later, from the library.
    text = (
        "world fork\nlength 4\nstart at(robot, (4, 4))\nimport moves\n"
        "minimize lean(G_robot = right)\nsearch beam(starts = 1, width = 3)\n"
    )
    monkeypatch.setattr(programs, "_memory", {})
    result = story_from(Source("later.story", text), tmp_path).solve()
    assert len(traced) == 2
    beliefs = result.script.query("P(G_robot = left | script[:T])")
    assert beliefs > 0.9
    first = library.read_bytes()
    assert i2p("compile", folder, "-o", library).status == 0
    assert library.read_bytes() == first
    assert len(traced) == 2


def test_preparing_runs_nothing_and_changes_nothing(folder: Path) -> None:
    story = load(folder / "s00.story")
    seen: list[tuple[int, int]] = []
    first = prepare(story, Watch(searching=lambda *done: seen.append(done)))
    assert first is not None
    assert (first.is_new, seen) == (True, [])
    before = story.solve()
    again = prepare(story)
    assert again is not None
    assert (again.shape, again.is_new) == (first.shape, False)
    assert len(programs._memory) == 1
    np.testing.assert_array_equal(
        story.solve().script.trajectory.actions, before.script.trajectory.actions
    )


def test_a_naive_story_has_no_program(tmp_path: Path) -> None:
    text = "world fork\nlength 3\nsearch naive\n"
    assert prepare(story_from(Source("n.story", text), tmp_path)) is None


def test_an_interrupted_compile_leaves_nothing(
    folder: Path, tmp_path: Path, i2p: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    from i2pdsl.search import prepare as module

    real, calls = module.prepare, []

    def interrupted(*arguments: object) -> object:
        calls.append(1)
        if len(calls) == 3:
            raise KeyboardInterrupt
        return real(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(module, "prepare", interrupted)
    target = tmp_path / "moves.i2plib"
    done = i2p("compile", folder, "-o", target)
    assert done.status == 130
    assert "interrupted: no library is written; 1 shape of search are in the cache" in done.err
    assert [p.name for p in tmp_path.iterdir() if "i2plib" in p.name] == []
