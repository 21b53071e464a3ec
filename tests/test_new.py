"""`i2p new`: what it writes is right, is never put over anything, and can be made at once."""

from __future__ import annotations

import json
import os
import re
import stat
from pathlib import Path

import pytest

from commands_for_tests import Run
from fuzz_for_tests import FULL
from i2pdsl.beginnings.table import table
from i2pdsl.cli import DONE, USAGE, WRONG
from i2pdsl.stories import load
from i2pdsl.worlds.beginnings import Beginning
from i2pdsl.worlds.find import builtin_worlds, find_spec
from i2pdsl.worlds.kinds import beginnings_of
from stories_for_tests import story

EVERY = [(called, b) for called, each in table().items() for b in each.ways]


@pytest.fixture(autouse=True)
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def everything(folder: Path) -> dict[str, bytes]:
    return {
        str(p.relative_to(folder)): os.readlink(p).encode() if p.is_symlink() else p.read_bytes()
        for p in folder.rglob("*")
        if p.is_symlink() or p.is_file()
    }


@pytest.mark.parametrize(
    ("kind", "beginning"), EVERY, ids=[f"{kind}-{b.name}" for kind, b in EVERY]
)
def test_what_is_written_is_right_and_so_is_what_may_be_added(
    kind: str, beginning: Beginning, i2p: Run, place: Path
) -> None:
    assert i2p("new", "mine", "--kind", kind, "--pattern", beginning.name).status == DONE
    path = place / "mine.story"
    text = path.read_text(encoding="utf-8")
    assert load(path).warnings == ()
    assert load(path).typed.length == beginning.length
    assert i2p("fmt", "--check", ".").status == DONE
    assert (place / "mine.world").exists() == (kind != "hill")
    assert all(len(line) <= 100 for line in text.splitlines())
    called = re.findall(r"^maximize (\w+)\(", text, re.MULTILINE)
    assert beginning.pattern in called or not beginning.pattern
    added = re.findall(r"^# ((?:require|start|liveliness|audience) .*)  # ", text, re.MULTILINE)
    assert len(added) >= (3 if kind == "map" else 1)
    for line in added:
        path.write_text(f"{text}\n{line}\n", encoding="utf-8")
        assert load(path).warnings == (), line


def test_each_built_in_world_has_a_story_to_begin_with(i2p: Run, place: Path) -> None:
    """All that fit it are right there too, and the others are refused in words."""
    for world in builtin_worlds() if FULL else ("hill", "house", "kitchen", "meadow"):
        spec = find_spec(world)
        assert spec is not None
        fitting = 0
        for beginning in beginnings_of(spec).ways:
            name = f"{world}-{beginning.name}"
            done = i2p("new", name, "--world", world, "--pattern", beginning.name)
            if done.status == DONE:
                fitting += 1
                assert load(place / f"{name}.story").warnings == ()
                assert not (place / f"{name}.world").exists()
            else:
                assert done.status == WRONG
                assert f"cannot be told in {world}" in done.err
                assert not (place / f"{name}.story").exists()
        if world == "meadow":  # where nobody has an attitude, or chooses between two places
            assert fitting == 0
            assert "--pattern" in i2p("new", "m", "--world", world).err
        else:
            assert fitting >= 2
            assert i2p("new", world, "--world", world).status == DONE


def test_every_standard_pattern_can_be_begun_with(i2p: Run, place: Path) -> None:
    listed = json.loads(i2p("patterns", "--json").out)
    for name in [pattern["name"] for pattern in listed]:
        assert i2p("new", f"a-{name}", "--pattern", name).status == DONE
        text = (place / f"a-{name}.story").read_text(encoding="utf-8")
        load(place / f"a-{name}.story")
        assert f"{name}(" in text


def test_nothing_is_ever_overwritten(i2p: Run, place: Path) -> None:
    assert i2p("new").status == DONE
    (place / "taken.world").write_text("mine", encoding="utf-8")
    (place / "link.story").symlink_to("nowhere")
    before = everything(place)
    for arguments, free in (([], "my-2"), (["taken"], "taken-2"), (["link.story"], "link-2")):
        done = i2p("new", *arguments)
        assert done.status == WRONG
        assert "error[taken]" in done.err
        assert f"a name that is free: {free}.story" in done.err
    assert everything(place) == before
    assert i2p("new", "my-2.story", "--json").status == DONE


def test_who_is_first_keeps_the_name(
    i2p: Run, place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Another process writes the story after we have looked; our world does not stay alone."""
    from i2pdsl import resources

    whole = resources.write_text

    def late(path: Path, text: str, new: bool = False) -> None:
        if path.suffix == ".story":
            path.write_text("theirs", encoding="utf-8")
        whole(path, text, new)

    monkeypatch.setattr(resources, "write_text", late)
    assert "error[taken]" in i2p("new", "race").err
    assert everything(place) == {"race.story": b"theirs"}


def test_where_there_are_no_links_files_are_new_all_the_same(
    i2p: Run, place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def link(*_: object) -> None:
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(os, "link", link)
    assert i2p("new", "one").status == DONE
    assert load(place / "one.story").typed.world == "one"
    (place / "two.story").symlink_to("nowhere")
    assert i2p("new", "two").status == WRONG
    assert set(everything(place)) == {"one.story", "one.world", "two.story"}
    assert stat.S_IMODE((place / "one.story").stat().st_mode) & 0o400


@pytest.mark.parametrize(
    ("arguments", "code", "said"),
    [
        (["x", "--pattern", "betryal"], "no-pattern", "did you mean `betrayal`?"),
        (["x", "--pattern", "../x"], "no-pattern", "--list"),
        (["x", "--kind", "map", "--pattern", "mime"], "no-pattern", "of the kind hill"),
        (["x", "--world", "fork", "--pattern", "betrayal"], "no-pattern", "legible, deceptive"),
        (["x", "--world", "kitchn"], "no-world", "did you mean `kitchen`?"),
        (["x.world"], "name", "NAME.story"),
        (["CON"], "name", "NAME.story"),
        (["a\nb"], "name", "NAME.story"),
        (["kitchen"], "name", "built in"),
        (['a"b'], "name", "--world"),
    ],
)
def test_what_is_refused(arguments: list[str], code: str, said: str, i2p: Run, place: Path) -> None:
    done = i2p("new", *arguments)
    assert done.status == WRONG
    assert f"error[{code}]" in done.err
    assert said in done.err
    assert everything(place) == {}


def test_names_are_those_of_files_and_of_worlds(i2p: Run, place: Path) -> None:
    for name in ("script", "length", "T", "rho", "3ducks", "my duck", "été", "a.b", "in/a/folder"):
        assert i2p("new", name).status == DONE, name
        assert load(place / f"{name}.story").warnings == (), name
    assert i2p("new", "x", "--world", "kitchen", "--kind", "map").status == USAGE


def test_a_world_beside_the_story_can_be_named(i2p: Run, place: Path) -> None:
    assert i2p("new", "films/one").status == DONE
    done = i2p("new", "films/two", "--world", "one", "--pattern", "twist", "--length", "6")
    assert done.status == DONE
    found = load(place / "films/two.story").typed
    assert (found.world, found.length) == ("one", 6)


def test_the_list(i2p: Run, place: Path) -> None:
    rows = json.loads(i2p("new", "--list", "--json").out)
    assert [(row["kind"], row["name"]) for row in rows] == [(k, b.name) for k, b in EVERY]
    assert not any("{" in row["told"] for row in rows)
    shown = i2p("new", "--list", "--kind", "plane").out
    assert "betrayal" in shown
    assert "irony" not in shown
    assert everything(place) == {}


def test_the_world_that_is_written_can_be_planned_and_played(i2p: Run, place: Path) -> None:
    assert i2p("new", "first").status == DONE
    path = place / "first.story"
    path.write_text(path.read_text(encoding="utf-8") + "search naive\n", encoding="utf-8")
    script = load(path).solve().script
    assert script.length == 15
    assert script.query("max_t [moved(duck) @ script[t]]") == 1


@pytest.mark.slow
@pytest.mark.parametrize("name", ["betrayal", "irony", "legible", "deceptive", "icarus"])
def test_the_worlds_tell_what_is_promised(name: str, i2p: Run, place: Path) -> None:
    """Each asks for something else of the world that is written for it."""
    expected = {
        "betrayal": "mean_t (if t <= T/2 then P(rho > 0 | script[:t], G_duck = pond)"
        " else P(rho < 0 | script[:t], G_duck = pond))",
        "irony": "mean_t P(rho < 0 | script[:t], G_duck = nest)",
        "legible": "mean_t P(G_dog = pond | script[:t])",
        "deceptive": "mean_{t in 1..T/2} P(G_dog = nest | script[:t])",
        "icarus": "mean_{t in 8..10} E[V(duck) | script[:t], G_duck = pond]"
        " - mean_{t in 16..18} E[V(duck) | script[:t], G_duck = pond]",
    }[name]
    assert i2p("new", name, "--pattern", name).status == DONE
    value = story(place / f"{name}.story").solve().script.query(expected)
    assert value > (5 if name == "icarus" else 0.85)
