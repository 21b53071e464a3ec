"""Stories that share a pattern share its compiled search: each shape is traced once, ever."""

from __future__ import annotations

import hashlib
import hmac
import json
import os
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from commands_for_tests import Run
from i2pdsl import programs, signed
from i2pdsl.computing import computing
from i2pdsl.errors import Source
from i2pdsl.programs import Program, compiled_program
from i2pdsl.search import beam
from i2pdsl.search.searches import Beam, search_of
from i2pdsl.stories import Story, load, story_from
from i2pdsl.worlds.kind import Watch
from searches_for_tests import compiling_briefly

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


def prepared(story: Story, watch: Watch | None = None) -> Program | None:
    return search_of(story.typed).prepare(story.task(watch))


def count_traces(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Notes every program of a search that is traced."""
    traced: list[str] = []

    def noted(key: tuple[Any, ...], *rest: Any, **more: Any) -> Program:
        program = compiled_program(key, *rest, **more)
        if key[0] == "pool" and program.is_new:
            traced.append(repr(key))
        return program

    monkeypatch.setattr(beam, "compiled_program", noted)
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
    first = prepared(story, Watch(searching=lambda *done: seen.append(done)))
    assert first is not None
    assert (first.is_new, seen) == (True, [])
    before = story.solve()
    again = prepared(story)
    assert again is not None
    assert (again.shape, again.is_new) == (first.shape, False)
    assert len(programs._memory) == 1
    np.testing.assert_array_equal(
        story.solve().script.trajectory.actions, before.script.trajectory.actions
    )


def test_a_naive_story_has_no_program(tmp_path: Path) -> None:
    text = "world fork\nlength 3\nsearch naive\n"
    assert prepared(story_from(Source("n.story", text), tmp_path)) is None


def test_an_interrupted_compile_leaves_nothing(
    folder: Path, tmp_path: Path, i2p: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    real, calls = Beam.prepare, []

    def interrupted(*arguments: object) -> object:
        calls.append(1)
        if len(calls) == 3:
            raise KeyboardInterrupt
        return real(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(Beam, "prepare", interrupted)
    target = tmp_path / "moves.i2plib"
    done = i2p("compile", folder, "-o", target)
    assert done.status == 130
    assert "interrupted: no library is written; 1 shape of search are in the cache" in done.err
    assert [p.name for p in tmp_path.iterdir() if "i2plib" in p.name] == []


def solved(text: str, place: Path) -> float:
    return story_from(Source("one.story", text), place).solve().score


def test_a_new_map_of_the_same_shape_compiles_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Other walls, tiles elsewhere, more cells, other numbers: what was compiled serves them."""
    monkeypatch.setenv("I2PDSL_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(programs, "_memory", {})
    cast = (
        "tile a\n    symbol = A\ntile b\n    symbol = B\n"
        "character mouse\n    success = {p}\n    goals = {{a, b}}\n"
        "character cat\n    goals = {{a, none}}\n    pushes = {{mouse, crate}}\n"
        "    toward = mouse\n    attitude = {{-1, 1}}\n"
        "object crate\n    may_be_absent = yes\nevent deus\n    drops = {{crate}}\n"
    )
    maps = ("A...\n    ...B", "..A..\n    .#.#.\n    B....", "......\n    AB....")
    story = (
        "world {name}\nlength 4\nstart absent(crate)\nallow deus(crate)\n"
        "maximize sum_t P(rho > 0 | script[:t]) + max_t [at(mouse, a) @ script[t]]\n"
        "search beam(starts = 20)\n"
    )
    traced: list[str] = []
    for number, (rows, p) in enumerate(zip(maps, (0.6, 0.7, 0.9), strict=True)):
        text = f"map\n    {rows}\n" + cast.format(p=p)
        (tmp_path / f"m{number}.world").write_text(text, encoding="utf-8")
        if number == 1:
            traced = count_traces(monkeypatch)
        with compiling_briefly(places=20):
            assert solved(story.format(name=f"m{number}"), tmp_path) > 4
    assert traced == []


def forged(data: bytes) -> list[bytes]:
    """Programs that nobody compiled: with the digest of a key that all know, with one bit another,
    cut short, empty, without the digest."""
    body = data[32:-100] + bytes(100)
    middle = len(data) // 2
    return [
        hashlib.sha256(body).digest() + body,
        hmac.digest(b"", body, "sha256") + body,
        data[:middle] + bytes([data[middle] ^ 1]) + data[middle + 1 :],
        data[:middle],
        data[:7],
        b"",
        data[32:],
        pickle.dumps(Bomb()),
        hashlib.sha256(pickle.dumps(Bomb())).digest() + pickle.dumps(Bomb()),
    ]


class Bomb:
    """Unpickling it would end the test."""

    def __reduce__(self) -> Any:
        return (pytest.exit, ("a forged program was run",))


def test_what_another_wrote_is_never_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("I2PDSL_CACHE", str(tmp_path))
    said: list[str] = []

    def program() -> programs.Program:
        monkeypatch.setattr(programs, "_memory", {})
        with computing():
            found = doubling(said.append)
            assert found.run(np.arange(3.0, dtype=np.float32)).tolist() == [0, 2, 4]
        return found

    assert program().is_new
    (path,) = (tmp_path / "programs").iterdir()
    data = path.read_bytes()
    for attempt in forged(data):
        path.write_bytes(attempt)
        said.clear()
        assert program().is_new
        assert len(said) == 1
        assert f"the cached program {path.name} is damaged" in said[0]
        assert not program().is_new  # it was made again
    for odd in (os.mkfifo, Path.mkdir):
        path.unlink()
        odd(path)
        said.clear()
        assert program().is_new
        assert any("cannot be read" in message for message in said)
    path.rmdir()


def doubling(say: programs.Say) -> programs.Program:
    """A small program."""
    numbers = np.zeros(3, np.float32)
    return compiled_program(("doubling",), lambda x: 2 * x, (numbers,), 0, say)


def test_the_key_is_the_users_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    signed._key.cache_clear()
    first = signed._key()
    (path,) = (tmp_path / "state" / "i2pdsl").iterdir()
    assert path.stat().st_mode & 0o777 == 0o600
    signed._key.cache_clear()
    assert signed._key() == first
    path.write_bytes(b"short")
    signed._key.cache_clear()
    assert len(signed._key()) == 32
    signed._key.cache_clear()


def test_without_a_place_for_the_key_nothing_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "state").write_text("a file", encoding="utf-8")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    monkeypatch.setattr(programs, "_memory", {})
    monkeypatch.setattr(programs, "_said", set())
    signed._key.cache_clear()
    said: list[str] = []
    with computing():
        assert doubling(said.append).run(np.ones(3, np.float32)).tolist() == [2, 2, 2]
    assert len(said) == 1
    assert "compiled programs are not kept for the next run" in said[0]
    signed._key.cache_clear()
