"""The command `i2p`: its commands, streams and exit statuses, with good and with bad input."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from commands_for_tests import I2P, PATIENCE, Outcome, Run, on_a_terminal, process
from i2pdsl import cli
from i2pdsl.cli import DONE, INTERRUPTED, USAGE, WRONG
from i2pdsl.language.override import override
from i2pdsl.language.statements import Source, StoryError
from i2pdsl.worlds.find import builtin_worlds
from worlds_for_tests import STORIES, kitchen_text, with_small_world

HELP = """world small
length 4
maximize sum_t P(rho > 0 | script[:t])
search beam(starts = 50, polish = 1)
"""
WALK = "world small\nlength 3\nsearch naive\n"
SHORTLY = ("--pace", "10")  # films of fewer pictures


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a small world, two stories and a finished script."""
    folder = with_small_world(tmp_path_factory.mktemp("cli"))
    (folder / "help.story").write_text(HELP, encoding="utf-8")
    (folder / "walk.story").write_text(WALK, encoding="utf-8")
    arguments = ["run", str(folder / "walk.story"), "--out", str(folder), "--format", ""]
    assert cli.run_command(arguments) == DONE
    return folder


@pytest.fixture
def place(shared: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder of one's own with the same stories."""
    for name in ("small.world", "help.story", "walk.story"):
        (tmp_path / name).write_bytes((shared / name).read_bytes())
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(scope="module")
def script(shared: Path) -> Path:
    return shared / "walk" / "script.json"


def hidden(folder: Path) -> list[Path]:
    """What an unfinished write would leave."""
    return [p for p in folder.rglob("*") if p.name.startswith(".")]


# run


def test_run_writes_script_and_pictures(place: Path, i2p: Run) -> None:
    done = i2p("run", "help.story", "--format", "png,html,svg")
    assert done.status == DONE
    heads, wish = done.err.splitlines()
    assert heads.split("  ")[0] == "wish"
    assert wish.startswith("maximize sum_t P(rho > 0 | script[:t])  ")
    lines = done.out.splitlines()
    assert re.fullmatch(
        r"help \(seed 0\): score [\d.]+, panel [\d.]+ \(worst [\d.]+\), still \d+ %", lines[0]
    )
    files = [Path(line.strip()) for line in lines[1:]]
    assert {f.name for f in files} == {
        "script.json", "comic.png", "mind.png", "comic.svg", "mind.svg", "page.html",
    }  # fmt: skip
    assert all(f.stat().st_size > 1000 for f in files)
    assert {f.parent for f in files} == {Path("out/help")}
    assert hidden(place) == []


def test_run_json(place: Path, i2p: Run) -> None:
    done = i2p("run", "walk.story", "--json", "--seed", "2", "--format", "svg", "--out", "here")
    document = json.loads(done.out)
    assert set(document) == {
        "story", "seed", "score", "script", "still", "files", "seconds", "candidates", "wishes",
    }  # fmt: skip
    assert document["story"] == "walk"
    assert document["seed"] == 2
    assert set(document["seconds"]) == {"plan", "compile", "search", "render"}
    assert document["script"] == "here/walk/script.json"
    assert all(Path(p).is_file() for p in document["files"].values())
    stored = json.loads(Path(document["script"]).read_text(encoding="utf-8"))
    assert stored["story"] == {"name": "walk", "file": "walk.story", "source": WALK, "seed": 2}
    assert stored["score"] == document["score"]


@pytest.mark.parametrize(
    ("arguments", "folders"),
    [
        (["walk.story", "--seeds", "0-2"], ["walk/seed-0", "walk/seed-1", "walk/seed-2"]),
        (["walk.story", "--seeds", "4,1,4"], ["walk/seed-4", "walk/seed-1"]),
        (["walk.story", "--seeds", "3"], ["walk"]),
        (["walk.story", "walk2.story"], ["walk", "walk2"]),
        (["walk.story", "walk2.story", "--seeds", "0,7"],
         ["walk/seed-0", "walk/seed-7", "walk2/seed-0", "walk2/seed-7"]),
    ],
)  # fmt: skip
def test_several_are_a_list(
    place: Path, i2p: Run, arguments: list[str], folders: list[str]
) -> None:
    Path("walk2.story").write_text(WALK, encoding="utf-8")
    done = i2p("run", *arguments, "--json", "--format", "")
    assert done.status == DONE
    found = [d["script"] for d in json.loads(done.out)]
    assert found == [f"out/{folder}/script.json" for folder in folders]


def test_candidates_are_written_side_by_side(place: Path, i2p: Run) -> None:
    done = i2p("run", "help.story", "--candidates", "3", "--format", "", "--json")
    document = json.loads(done.out)
    parts = document["candidates"]
    assert document["script"] == parts[0]["script"] == "out/help/script.json"
    assert all(set(p["panel"]) == {"mean", "worst"} and 0 <= p["still"] <= 1 for p in parts)
    (wish,) = document["wishes"]
    assert set(wish) == {"source", "reached", "possible", "frames"}
    assert wish["possible"] >= wish["reached"]
    scored = i2p("run", "help.story", "--candidates", "3", "--choose", "score", "--json")
    scores = [p["score"] for p in json.loads(scored.out)["candidates"]]
    assert scores == sorted(scores, reverse=True)
    assert scores[0] >= parts[0]["score"]
    for number, part in enumerate(parts[1:], 2):
        assert part["script"] == f"out/help/candidate-{number}/script.json"
    assert len(parts) == 3 or "found that differ visibly" in done.err


def test_naive_option(place: Path, i2p: Run) -> None:
    Path("twist.story").write_text(
        "world small\nlength 4\nmaximize twist(rho > 0, rho < 0)\n", encoding="utf-8"
    )
    assert i2p("run", "help.story", "--naive", "--format", "").status == DONE
    done = i2p("run", "twist.story", "help.story", "--naive", "--format", "", "--json")
    assert done.status == WRONG
    assert "twist.story:1:1: error[naive]" in done.err
    assert [d["story"] for d in json.loads(done.out)] == ["help"]  # what was made is kept


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "Missing argument 'STORIES"),
        (["walk.story", "--seed", "1", "--seeds", "2"], "not both"),
        (["walk.story", "--seed", "-1"], "--seed"),
        (["walk.story", "--seed", "one"], "--seed"),
        (["walk.story", "--seeds", "3-1"], "empty or endless"),
        (["walk.story", "--seeds", "0-99999999"], "empty or endless"),
        (["walk.story", "--seeds", "²"], "write 0-19"),
        (["walk.story", "--seeds", "9" * 5000], "write 0-19"),
        (["walk.story", "--seeds", "1,,2"], "write 0-19"),
        (["walk.story", "--seeds", "-3"], "write 0-19"),
        (["walk.story", "--seeds", ""], "write 0-19"),
        (["walk.story", "--format", "bmp"], "formats are png, svg, gif, mp4, html"),
        (["walk.story", "--pace", "0"], "--pace"),
        (["walk.story", "--size", "1920"], "write 1920x1080"),
        (["walk.story", "--size", "²x" + "9" * 5000], "write 1920x1080"),
        (["walk.story", "--size", "641x480"], "even numbers"),
        (["walk.story", "--transparent", "--format", "mp4"], "mp4 cannot be transparent"),
        (["walk.story", "--candidates", "0"], "--candidates"),
        (["walk.story", "--set", "beta"], "is not NAME=VALUE"),
        (["walk.story", "--set", "=1"], "is not NAME=VALUE"),
        (["walk.story", "--set", "beta="], "is not NAME=VALUE"),
        (["walk.story", "--out", "walk.story"], "is a file"),
        (["walk.story", "--colour"], "--colour"),
        (["walk.story", "a/walk.story"], "two stories would go into out/walk"),
    ],
)
def test_wrong_usage_of_run(place: Path, i2p: Run, arguments: list[str], words: str) -> None:
    Path("a").mkdir()
    for name in ("small.world", "walk.story"):
        Path("a", name).write_bytes(Path(name).read_bytes())
    done = i2p("run", *arguments)
    assert done.status == USAGE
    assert done.out == ""
    assert words in done.err
    assert not Path("out").exists()


BAD_FILES: dict[str, tuple[bytes, str]] = {
    "empty.story": (b"", "empty.story:1:1: error[empty]"),
    "comment.story": (b"# nothing\n", "comment.story:1:1: error[empty]"),
    "binary.story": (bytes(range(256)), "error[not-text]"),
    "latin.story": ("world küche\n".encode("latin-1"), "error[not-text]"),
    "goal.story": (b"world small\nlength 3\n", "error[no-objective]"),
    "nowhere.story": (b"world nowhere\nlength 3\nsearch naive\n", "no world `nowhere`"),
    "library.story": (b"pattern p(x) = x\n", "error[library]"),
    "script.story": (b'{"format": "i2p-script"}', "this is a finished script, not a story"),
}


@pytest.mark.parametrize("name", [*BAD_FILES, "missing.story", "folder.story", "/proc/self/mem"])
def test_bad_stories(place: Path, i2p: Run, name: str) -> None:
    Path("folder.story").mkdir()
    content, words = BAD_FILES.get(name, (None, f"{name}:1:1: error[no-file]"))
    if content is not None:
        Path(name).write_bytes(content)
    commands = [["run", name], ["run", name, "--json"]]
    if name != "folder.story":  # of the scripts in a folder one asks with --ask
        commands.append(["query", name, "1"])
    for command in commands:
        done = i2p(*command)
        assert done.status == WRONG
        assert done.out == ""
        assert done.err.startswith(name + ":")
        assert words in done.err


def test_the_mistakes_of_all_stories_are_shown_before_any_is_made(place: Path, i2p: Run) -> None:
    Path("one.story").write_text("world small\n", encoding="utf-8")
    done = i2p("run", "walk.story", "one.story", "missing.story")
    assert done.status == WRONG
    assert "one.story:" in done.err
    assert "missing.story:" in done.err
    assert not Path("out").exists()


def test_a_story_without_a_start_says_so(place: Path, i2p: Run) -> None:
    """The checker finds it; if not, the search does."""
    text = "world small\nlength 3\nstart at(robot, pink) and at(cheese, pink)\nsearch naive\n"
    Path("x.story").write_text(text, encoding="utf-8")
    done = i2p("run", "x.story", "--json")
    assert done.status == WRONG
    assert "error[" in done.err


@pytest.mark.parametrize("out", ["file/out", "/dev/null/out", "/proc/nothing", "taken"])
def test_what_cannot_be_written_is_one_line(place: Path, i2p: Run, out: str) -> None:
    Path("file").write_text("")
    Path("taken").mkdir()
    Path("taken/walk").write_text("")
    done = i2p("run", "walk.story", "--out", out)
    assert done.status == WRONG
    assert done.out == ""
    assert done.err.startswith("error: ")
    assert done.err.count("\n") == 1
    done = i2p("render", "nothing.json", "--out", "file/out")
    assert done.status == WRONG


def test_a_story_called_by_dots_stays_in_its_folder(place: Path, i2p: Run) -> None:
    Path("...story").write_text(WALK, encoding="utf-8")
    assert i2p("run", "...story", "--format", "", "--out", "a/b").status == DONE
    assert [str(p) for p in Path("a").rglob("*.json")] == ["a/b/story/script.json"]


# --set


@pytest.mark.parametrize(
    ("text", "name", "value", "expected"),
    [
        ("world small\nlength 3\n", "length", "7", "world small\nlength 7\n"),
        ("world small\nlength 3", "rationality", "0", "world small\nlength 3\nrationality 0\n"),
        ("rationality 2 # yes\n", "rationality", "0.5", "rationality 0.5 # yes\n"),
        ("world small\n", "beta", "1", "world small(beta = 1)\n"),
        ("world small # the small one\n", "beta", "1", "world small(beta = 1) # the small one\n"),
        ("world small(beta = 2)\n", "beta", "1", "world small(beta = 1)\n"),
        ("world small(beta = 2)\n", "level0", "costs", "world small(beta = 2, level0 = costs)\n"),
        ("world small(\n  beta = 2)\n", "beta", "1", "world small(\n  beta = 1)\n"),
        ("search beam(width = 2)\n", "starts", "9", "search beam(width = 2, starts = 9)\n"),
        ("search beam\n", "width", "9", "search beam(width = 9)\n"),
        ("length 3\n", "width", "9", "length 3\nsearch beam(width = 9)\n"),
        ("let k = 2 * 3\n", "k", "(1 + 1)", "let k = (1 + 1)\n"),
        ("let k = 2 +\n   3 # sum\n", "k", "1", "let k = 1 # sum\n"),
        ("let k = 1\nlet kk = 2\n", "kk", "P(rho > 0 | script)", None),
    ],
)
def test_override(text: str, name: str, value: str, expected: str | None) -> None:
    found = override(Source("x.story", text), name, value, ("beta", "level0"))
    assert found.name == "x.story"
    assert found.text == (expected or text.replace("kk = 2", f"kk = {value}"))


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("lenth", "3", "did you mean `length`?"),
        ("zebra", "3", "known here: beta, k, length, liveliness, luck, naturalness, plausibility"),
        ("length", "3\nminimize 1", "--set length:2:1"),
        ("beta", "1, gamma = 0.5", "--set beta:1:2"),
        ("beta", "1) maximize (2", "--set beta:1:2"),
        ("k", "1 +", "--set k:1:"),
        ("k", "(" * 500, "--set k:1:"),
        ("k", "\x00", "--set k:1:1"),
    ],
)
def test_overrides_that_are_wrong(name: str, value: str, words: str) -> None:
    with pytest.raises(StoryError) as caught:
        override(Source("x.story", "world small\nlet k = 1\n"), name, value, ("beta",))
    assert words in caught.value.diagnostics[0].render()


def test_set_changes_what_is_solved_and_what_is_stored(place: Path, i2p: Run) -> None:
    done = i2p("run", "walk.story", "--set", "length=5", "--set", "forgetting=0.01", "--format", "")
    assert done.status == DONE
    stored = json.loads(Path("out/walk/script.json").read_text(encoding="utf-8"))
    assert len(stored["frames"]) == 5
    assert stored["world"]["settings"] == {"forgetting": 0.01}
    assert stored["story"]["source"] == "world small(forgetting = 0.01)\nlength 5\nsearch naive\n"
    for wrong in ("length=0", "beta=-1", "beta=word", "nothing=1"):
        done = i2p("run", "walk.story", "--set", wrong)
        assert done.status == WRONG
        assert "error[" in done.err


# check and fmt


def test_check_says_everything_on_standard_error(place: Path, i2p: Run) -> None:
    good = i2p("check", "walk.story", "small.world", "walk.story")
    assert good == (DONE, "", "2 files checked: no mistakes\n")
    Path("one.story").write_text("world small\nlength 0\nmaximize rho\n", encoding="utf-8")
    Path("two.world").write_text("nonsense\n", encoding="utf-8")
    bad = i2p("check", ".", "missing.story")
    assert bad.status == WRONG
    assert bad.out == ""
    for name in ("one.story:2:8:", "one.story:3:", "two.world:1:1:", "missing.story:1:1:"):
        assert name in bad.err


def test_check_json_is_one_document_whatever_is_wrong(place: Path, i2p: Run) -> None:
    Path("one.story").write_text("world small\nlength 0\nmaximize rho\n", encoding="utf-8")
    Path("nothing").mkdir()
    done = i2p("check", "nothing", ".", "missing.story", "--json")
    assert done.status == WRONG
    assert done.err == ""
    document = json.loads(done.out)
    assert document["ok"] is False
    assert document["files"] == [
        "help.story", "one.story", "small.world", "walk.story", "missing.story",
    ]  # fmt: skip
    files = {d["file"] for d in document["diagnostics"]}
    assert files == {"nothing", "one.story", "missing.story"}
    for diagnostic in document["diagnostics"]:
        assert {"code", "severity", "message", "hint", "line", "column"} <= set(diagnostic)
    assert json.loads(i2p("check", "walk.story", "--json").out)["ok"] is True


def test_check_of_a_folder_passes_over_what_is_hidden(place: Path, i2p: Run) -> None:
    for folder in (".git", "deep/er", "folder.story"):
        Path(folder).mkdir(parents=True)
    Path(".git/x.story").write_text("nonsense", encoding="utf-8")
    Path("deep/er/y.story").write_text(HELP.replace("small", "kitchen"), encoding="utf-8")
    assert i2p("check", ".").err == "4 files checked: no mistakes\n"


def test_all_stories_that_come_along_are_right(i2p: Run) -> None:
    assert i2p("check", STORIES).status == DONE


def test_fmt(place: Path, i2p: Run) -> None:
    Path("x.story").write_text("world   small\nlength 3\nsearch   naive\n", encoding="utf-8")
    Path("bad.story").write_text("world (\n", encoding="utf-8")
    done = i2p("fmt", "--check", "x.story", "walk.story")
    assert done == (WRONG, "x.story\n", "")
    assert "world   small" in Path("x.story").read_text(encoding="utf-8")
    assert i2p("fmt", "x.story", "walk.story") == (DONE, "x.story\n", "")
    assert Path("x.story").read_text(encoding="utf-8").startswith("world small\nlength 3\n")
    assert i2p("fmt", "x.story") == (DONE, "", "")
    assert i2p("fmt", "bad.story").status == WRONG
    assert Path("bad.story").read_text(encoding="utf-8") == "world (\n"
    assert hidden(place) == []


def test_fmt_from_a_pipe() -> None:
    done = process("fmt", "-", input="# A room.\nmap\n    ..\ncharacter   a  # him\n")
    assert done.out == "# A room.\nmap\n    ..\ncharacter a  # him\n"
    done = process("fmt", "-", input="world   small\nlength 3\nsearch   naive\n")
    assert done == (DONE, WALK, "")


# query and render


def test_query(script: Path, i2p: Run) -> None:
    assert i2p("query", script, "1/3") == (DONE, "0.333333\n", "")
    done = i2p("query", script, "P(rho > 0 | script[:t])")
    assert done.out.splitlines()[0] == "   0 0.428571"
    assert len(done.out.splitlines()) == 4
    table = i2p("query", script, "P(G_robot | script[:t])").out.splitlines()
    assert table[0].split() == ["t", "pink", "green", "none"]
    assert len(table) == 5
    joint = i2p("query", script, "P(G_robot, rho | script[:t])").out.splitlines()
    assert joint[0].split()[:5] == ["t", "G_robot", "rho", "=", "-3"]
    assert [line.split()[:2] for line in joint[1:4]] == [
        ["0", "pink"],
        ["0", "green"],
        ["0", "none"],
    ]
    assert len(joint) == 13
    free = i2p("query", script, "P(rho | script[:0])", "--assume", "nothing").out.splitlines()
    assert free[-1].split() == ["unknown", "0.0882353"]


def test_query_json(script: Path, i2p: Run) -> None:
    def ask(*arguments: str) -> Any:
        done = i2p("query", script, *arguments, "--json")
        assert done.status == DONE
        return json.loads(done.out)

    assert ask("1+1") == {"expr": "1+1", "t": None, "value": 2.0}
    assert ask("P(rho > 0 | script[:t])")["t"] == [0, 1, 2, 3]
    assert ask("[moved(robot) @ script[t]]")["t"] == [1, 2, 3]
    whole = ask("P(rho | script[:2])", "--assume", "nothing")
    assert set(whole["value"]) == {"-3", "-1", "0", "1", "3", "unknown"}
    assert sum(whole["value"].values()) == pytest.approx(1)
    many = ask("P(rho | script[:t])")
    assert [sum(row.values()) for row in many["value"]] == pytest.approx([1] * 4)
    one = ask("P(G_cheese, rho | script[:2])", "--assume", "nothing")["value"]
    goals, attitudes = one["axes"]
    assert goals == {"name": "G_cheese", "values": ["pink", "green", "unknown"]}
    assert attitudes == {"name": "rho", "values": ["-3", "-1", "0", "1", "3", "unknown"]}
    sums = np.array(one["probabilities"]).sum(0)
    assert dict(zip(attitudes["values"], sums, strict=True)) == pytest.approx(whole["value"])
    joint = ask("P(G_cheese, rho | script[:t])")
    assert joint["t"] == [0, 1, 2, 3]
    assert np.shape(joint["value"]["probabilities"]) == (4, 3, 6)
    ahead = ask("next(cheese | script[:t])")["value"]
    assert [set(row) for row in ahead] == [{"north", "south", "east", "west", "stay"}] * 4
    within = ask("P(rho > 0 | script[:t, cheese])")
    assert within["t"] == [1, 2, 3]
    nothing = "P(rho > 0 | script[:t]) - P(rho > 0 | script[:t])"
    assert ask(f"log({nothing})")["value"] == [None] * 4  # JSON has no infinity
    assert ask(f"1 / ({nothing})")["value"] == [None] * 4


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["P("], "query:1:2: error[bracket]"),
        ([""], "query:1:1: error[syntax]"),
        (["rho"], "query:1:1: error[type]"),
        (["P(rho > 0 | script[:9])"], "error["),
        (["1", "--assume", "rho"], "assume:1:1: error[type]"),
        (["1", "--assume", "rho > 5"], "error[impossible]"),
        (["(" * 300], "error["),
    ],
)
def test_questions_that_are_wrong(script: Path, i2p: Run, arguments: list[str], words: str) -> None:
    for extra in ([], ["--json"]):
        done = i2p("query", script, *arguments, *extra)
        assert done.status == WRONG
        assert done.out == ""
        assert words in done.err


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"{}", "this is no i2p script"),
        (b"", "this is no JSON"),
        (b"\xff\xfe", "not UTF-8"),
        (b"world small\n", "this is no JSON"),
        (b"[" * 100_000, "nested too deeply"),
    ],
)
def test_scripts_that_are_none(place: Path, i2p: Run, content: bytes, words: str) -> None:
    Path("x.json").write_bytes(content)
    for command in (["query", "x.json", "1"], ["render", "x.json"]):
        done = i2p(*command)
        assert done.status == WRONG
        assert words in done.err


def test_a_story_where_a_script_is_wanted_is_solved_first(place: Path, i2p: Run) -> None:
    Path("other.txt").write_text(WALK + "let two = 2\n", encoding="utf-8")
    assert i2p("query", "other.txt", "two + 1", "--seed", "3").out == "3\n"
    first = i2p("query", "walk.story", "P(rho > 0 | script[:t])", "--seed", "5").out
    assert i2p("run", "walk.story", "--seed", "5", "--format", "").status == DONE
    assert i2p("query", "out/walk/script.json", "P(rho > 0 | script[:t])").out == first
    done = i2p("render", "walk.story", "--format", "svg", "--json", "--seed", "5")
    assert json.loads(done.out)["files"]["comic.svg"] == "out/walk/comic.svg"


def test_render_for_other_programs(place: Path, script: Path, i2p: Run) -> None:
    options = ("--pace", "2", "--transparent", "--size", "160x160", "--format", "webm,godot")
    done = i2p("render", script, *options, "--out", "game", "--json")
    assert done.status == DONE, done.err
    made = {Path(path).name for path in json.loads(done.out)["files"].values()}
    assert made == {path.name for path in Path("game").iterdir()}
    assert made == {"film.webm", "sprites.png", "sprites.json", "background.png", "timeline.json",
                    "i2p_player.gd"}  # fmt: skip
    told = json.loads(Path("game/timeline.json").read_text(encoding="utf-8"))
    states = [frame["state"] for frame in json.loads(script.read_text())["frames"]]
    for frame, state in zip(told["frames"][1:], states, strict=True):
        assert {name: one["cell"] for name, one in frame["entities"].items()} == state
        assert frame["seconds"] <= 0.9 / 2 * 1.35 + 1e-9


def test_render(place: Path, script: Path, i2p: Run) -> None:
    done = i2p("render", script, "--format", "svg", "--out", "pictures")
    assert done == (DONE, "pictures/comic.svg\npictures/mind.svg\n", "")
    assert i2p("render", script, "--format", "", "--out", "none") == (DONE, "", "")
    copy = place / "deep" / "script.json"
    copy.parent.mkdir()
    copy.write_bytes(script.read_bytes())
    document = json.loads(i2p("render", copy, "--format", "html", "--json").out)
    assert document == {"script": str(copy), "files": {"html": str(copy.parent / "page.html")}}


def test_a_warning_about_the_stored_story_is_shown(place: Path, script: Path, i2p: Run) -> None:
    content = json.loads(script.read_text(encoding="utf-8"))
    content["story"]["source"] = "maximize nothing("
    Path("x.json").write_text(json.dumps(content), encoding="utf-8")
    done = i2p("query", "x.json", "1", "--json")
    assert done.status == DONE
    assert json.loads(done.out)["value"] == 1
    assert "x.json:1:1: warning[stored-story]" in done.err


# What there is.


def test_worlds(place: Path, i2p: Run) -> None:
    names = [line.split()[0] for line in i2p("worlds").out.splitlines()]
    assert "kitchen" in names
    assert [w["name"] for w in json.loads(i2p("worlds", "--json").out)] == names
    text = i2p("worlds", "kitchen").out
    for word in (
        "208,860 states, 34 hypotheses",
        "rho in {-3, -1, 0, 1, 3}",
        "deus(table)",
        "beta",
    ):
        assert word in text
    document = json.loads(i2p("worlds", "kitchen", "--json").out)
    assert document["states"] == 208_860
    assert i2p("worlds", "small").out.startswith("world small\n")
    for wrong, words in [("kitchn", "did you mean `kitchen`?"), ("walk.story", "no world")]:
        done = i2p("worlds", wrong)
        assert done.status == WRONG
        assert words in done.err
    assert i2p("worlds", "n" * 400).status == WRONG


def test_patterns(place: Path, i2p: Run) -> None:
    text = i2p("patterns").out
    assert "depict(event, over = script)\n    " in text
    names = [p["name"] for p in json.loads(i2p("patterns", "--json").out)]
    assert names == sorted(names)
    assert {"arc", "depict", "irony", "twist"} <= set(names)
    Path("library.story").write_text("# Doubles.\npattern twice(x) = 2 * x\n", encoding="utf-8")
    listed = f"twice(x)\n    Doubles.\n    x: number\n    fits {', '.join(builtin_worlds())}\n"
    assert i2p("patterns", "library.story").out == listed
    for wrong in ("walk.story", "missing.story", "/proc/self/mem"):
        assert i2p("patterns", wrong).status == WRONG


def test_plan(place: Path, i2p: Run) -> None:
    i2p("plan", "small")
    document = json.loads(i2p("plan", "small.world", "--json").out)
    assert document["states"] == 392
    assert document["problems"] == 33
    assert document["residual"] <= 1e-5
    assert document["residual"] < document["bound"] <= 1e-2
    assert document["cached"] is True
    assert "read from the cache" in i2p("plan", "small").out
    assert i2p("plan", "walk.story").status == WRONG


def test_usage(i2p: Run) -> None:
    for wrong in ([], ["dance"], ["query", "x"], ["worlds", "a", "b"], ["completion", "tcsh"]):
        done = i2p(*wrong)
        assert done.status == USAGE
        assert done.out == ""
        assert done.err.startswith("Usage: i2p")
    for right in (["--help"], ["-h"], ["run", "-h"], ["--version"]):
        done = i2p(*right)
        assert done.status == DONE
        assert done.err == ""
    assert i2p("--version").out.startswith("i2p, version 0")


def test_every_command_says_what_it_does() -> None:
    for name in cli.COMMANDS:
        command = cli.command_named(name)
        text = CliRunner().invoke(cli.program, [name, "--help"]).output
        assert command.help
        assert text.startswith("Usage: ")


# Processes: streams, pipes, terminals, Ctrl-C.


def modules_after(*arguments: str | Path) -> set[str]:
    code = (
        "import sys; from i2pdsl.cli import run_command; status = run_command(sys.argv[1:]);"
        "print(*sys.modules, file=sys.stderr); sys.exit(status)"
    )
    command = [sys.executable, "-c", code, *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return {name.split(".")[0] for name in done.stderr.split()}


def test_quick_commands_import_only_what_they_need(shared: Path, script: Path) -> None:
    heavy = {"jax", "jaxlib", "matplotlib", "PIL", "scipy", "resvg_py", "imageio_ffmpeg"}
    assert not modules_after("query", script, "P(rho > 0 | script[:t])") & heavy
    assert not modules_after("check", shared / "help.story") & (heavy | {"numpy", "tqdm"})
    assert not modules_after("worlds", "kitchen") & (heavy | {"numpy", "tqdm"})
    assert not modules_after("patterns") & (heavy | {"numpy", "tqdm"})


def test_check_is_quick(shared: Path) -> None:
    used = float("inf")
    for _ in range(3):  # on a busy machine the first may be slow
        before = os.times()
        assert process("check", shared / "help.story").status == DONE
        after = os.times()
        used = after.children_user + after.children_system
        used -= before.children_user + before.children_system
        if used < 1.5:  # of processor time: half a second when the machine is quiet
            return
    raise AssertionError(f"{used:.2f} s")


def test_a_reader_that_has_had_enough() -> None:
    for command in ("worlds kitchen", "--help", "worlds --json"):
        line = f"{sys.executable} -m i2pdsl {command} | true; exit ${{PIPESTATUS[0]}}"
        done = subprocess.run(["bash", "-c", line], capture_output=True, text=True)
        assert (done.returncode, done.stderr) == (DONE, "")


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs /dev/full")
def test_a_full_disk_is_one_line() -> None:
    for command in (["worlds"], ["patterns", "--json"], ["--help"]):
        with open("/dev/full", "w", encoding="utf-8") as full:
            done = subprocess.run([*I2P, *command], stdout=full, stderr=subprocess.PIPE, text=True)
        assert done.returncode == WRONG
        assert done.stderr == "error: No space left on device\n"


def test_closed_streams() -> None:
    for redirection in (">&-", "2>&-", "<&-", ">&- 2>&- <&-"):
        line = f"{sys.executable} -m i2pdsl worlds {redirection}"
        done = subprocess.run(["bash", "-c", line], capture_output=True, text=True)
        assert done.returncode == DONE
        assert "Traceback" not in done.stderr


def test_output_without_unicode(place: Path) -> None:
    environment = {**os.environ, "PYTHONIOENCODING": "ascii"}
    Path("müll.story").write_text(WALK, encoding="utf-8")
    done = process("run", "müll.story", "--format", "", "--json", env=environment)
    assert json.loads(done.out)["story"] == "müll"
    done = process("run", "müll.story", "--format", "", env=environment)
    assert done.status == DONE
    assert "m\\xfcll" in done.out


def test_progress_is_shown_on_a_terminal_only(place: Path, tmp_path: Path) -> None:
    environment = {**os.environ, "I2PDSL_CACHE": str(tmp_path / "cache")}
    status, out, shown = on_a_terminal("plan", "small", "--json", env=environment)
    assert status == DONE
    assert json.loads(out)["cached"] is False
    assert "planning robot" in shown
    command = ["run", "help.story", "--json", "--format", "gif", *SHORTLY]
    status, out, shown = on_a_terminal(*command)
    assert status == DONE
    assert json.loads(out)["story"] == "help"
    assert "searching" in shown
    assert "drawing film.gif" in shown
    done = process("plan", "small", "--json", env=environment)
    assert done.err == ""


def interrupted_planning(command: list[str], folder: Path) -> Outcome:
    """Ctrl-C, as a terminal sends it to the whole group, soon after planning began."""
    cache = folder / "cache"
    with subprocess.Popen(
        [*I2P, *command],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        env={**os.environ, "I2PDSL_CACHE": str(cache)},
    ) as running:
        while not (cache / "plans").is_dir():
            assert running.poll() is None
            time.sleep(0.02)
        time.sleep(0.5)
        os.killpg(running.pid, signal.SIGINT)
        out, err = running.communicate(timeout=PATIENCE)
    assert "Traceback" not in err
    assert "Exception ignored" not in err
    assert list((cache / "plans").iterdir()) == []
    return Outcome(running.returncode, out, err)


def test_interrupted_while_planning(place: Path) -> None:
    done = interrupted_planning(["plan", "kitchen", "--json"], place)
    assert done == (INTERRUPTED, "", "interrupted\n")


def test_interrupted_before_anything_was_found(place: Path) -> None:
    Path("help.story").write_text(HELP.replace("small", "kitchen"), encoding="utf-8")
    done = interrupted_planning(["run", "help.story", "--seeds", "0-3", "--json"], place)
    assert done.status == INTERRUPTED
    assert json.loads(done.out) == []
    assert done.err == "interrupted: nothing was found yet for help\n"
    assert not Path("out").exists()


def test_interrupted_while_searching(
    place: Path, i2p: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Between two blocks of starts: what was found is kept, drawn and said."""
    from i2pdsl.search import beam

    monkeypatch.setattr(beam, "BLOCK_BYTES", 4 * 2**20)
    seen: list[int] = []
    original = beam.beam_search

    def search(*arguments: Any) -> Any:
        def report(done: int, total: int) -> None:
            seen.append(done)
            if len(seen) == 2:
                raise KeyboardInterrupt

        *others, _, say, more = arguments
        return original(*others, report, say, more)

    monkeypatch.setattr(beam, "beam_search", search)
    done = i2p("run", "help.story", "--seeds", "0-3", "--json", "--format", "svg")
    assert done.status == INTERRUPTED
    assert done.err == "interrupted: the best of what was searched so far is kept\n"
    (document,) = json.loads(done.out)
    assert Path(document["script"]).is_file()
    assert set(document["files"]) == {"comic.svg", "mind.svg"}
    assert 0 < seen[0] < 392
    seen.clear()
    done = i2p("query", "help.story", "1")
    assert done.status == INTERRUPTED
    assert done.out == "1\n"
    assert "the best of what was searched so far is used" in done.err


def test_interrupted_while_drawing(
    place: Path, i2p: Run, script: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from i2pdsl.progress import Bars

    def drawing(self: Bars, name: str, done: int, total: int) -> None:
        if done == 3:
            raise KeyboardInterrupt

    monkeypatch.setattr(Bars, "drawing", drawing)
    done = i2p("run", "walk.story", "--format", "mp4,svg", "--json", *SHORTLY)
    assert done.status == INTERRUPTED
    assert "interrupted: the script is kept, not all its pictures are drawn" in done.err
    document = json.loads(done.out)
    assert set(document["files"]) == {"comic.svg", "mind.svg"}
    assert sorted(p.name for p in Path("out/walk").iterdir()) == [
        "comic.svg", "mind.svg", "script.json",
    ]  # fmt: skip
    done = i2p("render", script, "--format", "gif", "--out", "r", "--json", *SHORTLY)
    assert done.status == INTERRUPTED
    assert json.loads(done.out)["files"] == {}
    assert list(Path("r").iterdir()) == []


def test_a_lost_interrupt_is_sent_again() -> None:
    """Python drops what is raised in a callback of the garbage collector; JAX has one."""
    code = (
        "import gc, os, signal, sys, time; from i2pdsl.interrupts import keep_interrupt\n"
        "sys.unraisablehook = keep_interrupt\n"
        "def callback(*_):\n"
        "    gc.callbacks.remove(callback); os.kill(os.getpid(), signal.SIGINT); time.sleep(0.05)\n"
        "gc.callbacks.append(callback)\n"
        "try:\n    gc.collect(); time.sleep(60); print('lost')\n"
        "except KeyboardInterrupt: print('kept')\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.stdout, done.stderr) == ("kept\n", "")


def test_a_full_disk_while_drawing(place: Path, i2p: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    from i2pdsl.render.grid import film

    def full(*_: Any, **__: Any) -> None:
        raise RuntimeError("ffmpeg failed: No space\nleft on device")

    monkeypatch.setattr(film, "save_film", full)
    done = i2p("run", "walk.story", "--format", "gif", "--seeds", "0-1", "--json", *SHORTLY)
    assert done.status == WRONG
    assert done.err == "error: ffmpeg failed: No space left on device\n"
    assert json.loads(done.out) == []
    assert Path("out/walk/seed-0/script.json").is_file()


def test_a_film_that_cannot_be_written(
    place: Path, i2p: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All else is, for each seed; it is said which film, which program, and what there is."""
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", "/no/ffmpeg")
    done = i2p("run", "walk.story", "--format", "svg,gif,mp4", "--seeds", "0-1", "--json", *SHORTLY)
    assert done.status == WRONG
    first, second = json.loads(done.out)
    assert list(first["files"]) == ["comic.svg", "mind.svg"] == list(second["files"])
    assert all(Path(path).is_file() for path in first["files"].values())
    error, written, *_ = done.err.splitlines()
    assert error == (
        "error: film.gif and film.mp4 were not written: ffmpeg failed: /no/ffmpeg (from "
        "IMAGEIO_FFMPEG_EXE) cannot be started: No such file or directory; unset "
        "IMAGEIO_FFMPEG_EXE, or let it name another one"
    )
    assert written == f"written all the same: {', '.join(first['files'].values())}"
    done = i2p("render", first["script"], "--format", "mp4", "--out", "films", *SHORTLY)
    assert done.status == WRONG
    assert done.out == ""
    assert done.err.startswith("error: film.mp4 was not written: ")
    assert list(Path("films").iterdir()) == []


def test_letters_that_no_font_has(place: Path, i2p: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("i2pdsl.render.fonts._found", lambda lacking: ((), lacking))
    Path("猫.story").write_text(Path("walk.story").read_text(encoding="utf-8"), encoding="utf-8")
    done = i2p("run", "猫.story", "--format", "png,svg,html")
    assert done.status == DONE
    assert done.err.splitlines() == [
        "pictures:1:1: warning[font]: no font of this machine has 猫: "
        "these are boxes in the pictures",
        "  hint: install Noto Sans CJK (Debian, Ubuntu: fonts-noto-cjk); "
        "web pages use the fonts of whoever looks at them",
    ]
    done = i2p("render", "out/猫/script.json", "--format", "html")
    assert (done.status, done.err) == (DONE, "")


def test_not_enough_memory_is_one_line(place: Path, i2p: Run) -> None:
    """A world that is too large is refused before any work."""
    text = kitchen_text(tuple("." * 300 for _ in range(300)))
    text = text.replace("symbol = P", "at = {(0, 0)}").replace("symbol = G", "at = {(5, 5)}")
    Path("huge.world").write_text(text, encoding="utf-8")
    Path("huge.story").write_text(WALK.replace("small", "huge"), encoding="utf-8")
    for command in (["plan", "huge"], ["run", "huge.story"], ["worlds", "huge"]):
        done = i2p(*command)
        assert done.status in (DONE, WRONG)
        assert done.status == DONE or "error[" in done.err


# Shell completion.


def completions(line: str, folder: Path) -> list[str]:
    """What a shell is told for an unfinished line."""
    words = line.split(" ")
    environment = {
        **os.environ,
        "_I2P_COMPLETE": "bash_complete",
        "COMP_WORDS": line,
        "COMP_CWORD": str(len(words) - 1),
    }
    done = subprocess.run(
        I2P, capture_output=True, text=True, env=environment, cwd=folder, check=True
    )
    assert done.stderr == ""
    return done.stdout.split()


def test_completion(place: Path) -> None:
    assert {"plain,run", "plain,render"} <= set(completions("i2p r", place))
    assert completions("i2p quer", place) == ["plain,query"]
    assert "plain,--candidates" in completions("i2p run --c", place)
    assert completions("i2p worlds ki", place) == ["plain,kitchen"]
    assert "plain,kitchen" in completions("i2p plan ", place)
    assert completions("i2p run he", place) == ["file,he"]
    assert completions("i2p completion b", place) == ["plain,bash"]
    assert completions("i2p new x --pattern betr", place) == ["plain,betrayal"]
    assert completions("i2p new x --kind ", place) == ["plain,map", "plain,plane", "plain,hill"]


@pytest.mark.parametrize("line", ["i2p new --ki", "i2p new --kind ", "i2p new x --pattern betr"])
def test_completion_of_new_reads_little(line: str, place: Path) -> None:
    """Neither the language nor a kind of world, nor what either needs."""
    code = (
        "import sys\nfrom i2pdsl.cli import main\n"
        "try:\n    main()\nfinally:\n    print(*sys.modules, file=sys.stderr)"
    )
    words = line.split(" ")
    asked = {
        "_I2P_COMPLETE": "bash_complete",
        "COMP_WORDS": line,
        "COMP_CWORD": f"{len(words) - 1}",
    }
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env=os.environ | asked,
        cwd=place, check=True,
    )  # fmt: skip
    assert "plain," in done.stdout
    read = set(done.stderr.split())
    assert "i2pdsl.commands.new" in read
    assert not read & {"numpy", "jax", "scipy", "lark", "i2pdsl.language", "i2pdsl.worlds.kind"}


def test_completion_in_bash(place: Path) -> None:
    """As `eval "$(i2p completion bash)"` sets it up."""
    tool = place / "bin" / "i2p"
    tool.parent.mkdir()
    tool.write_text(f'#!/bin/sh\nexec {sys.executable} -m i2pdsl "$@"\n', encoding="utf-8")
    tool.chmod(0o755)
    lines = (
        'eval "$(i2p completion bash)"; complete -p i2p;'
        "COMP_WORDS=(i2p wor); COMP_CWORD=1; _i2p_completion i2p; echo ${COMPREPLY[*]};"
        "COMPREPLY=(); COMP_WORDS=(i2p worlds kit); COMP_CWORD=2; _i2p_completion i2p;"
        "echo ${COMPREPLY[*]}"
    )
    environment = {**os.environ, "PATH": f"{tool.parent}:{os.environ['PATH']}"}
    done = subprocess.run(
        ["bash", "--norc", "-c", lines], capture_output=True, text=True, env=environment, cwd=place
    )
    assert done.stdout.splitlines()[1:] == ["worlds", "kitchen"]
    assert "_i2p_completion" in done.stdout
    for shell in ("zsh", "fish"):
        assert "i2p" in process("completion", shell).out


def test_fmt_formats_worlds_too(place: Path, i2p: Run) -> None:
    text = "map\n  ..\n  ..\ncharacter a\n  goals={none}\n\n\n\nrewards\n  goal=1\n"
    Path("odd.world").write_text(text, encoding="utf-8")
    done = i2p("fmt", "odd.world")
    assert (done.status, done.out) == (0, "odd.world\n")
    assert "    goals = {none}\n\nrewards\n    goal = 1\n" in Path("odd.world").read_text()
    assert i2p("fmt", "--check", "odd.world").status == 0
    assert i2p("check", "odd.world").status == 0


def test_a_requirement_that_is_not_met_is_said(place: Path, i2p: Run) -> None:
    lines = [
        "world fork",
        "length 1",
        "search naive",
        "require [at(robot, left)] before [idle(robot)]",
    ]
    Path("late.story").write_text("\n".join(lines), encoding="utf-8")
    done = i2p("run", "late.story", "--json", "--format", "svg")
    assert done.status == DONE
    assert json.loads(done.out)["unmet"] == [lines[-1]]
    assert done.err.startswith("late.story:4:1: warning[unmet]: no script was found that meets")


def test_frames_to_keep_need_a_script(place: Path, i2p: Run) -> None:
    Path("s.story").write_text("world fork\nlength 2\nsearch naive", encoding="utf-8")
    assert i2p("run", "s.story", "--frames", "1").status == USAGE
    assert i2p("run", "s.story", "--format", "svg", "--out", "out").status == DONE
    kept = ("run", "s.story", "--keep", "out/s/script.json", "--frames")
    done = i2p(*kept, "3", "--format", "svg")
    assert "frame 3 cannot be kept: the script has 2 frames, the story 2" in done.err
    done = i2p(*kept, "1-2", "--format", "svg", "--json")
    assert done.status == DONE
    assert json.loads(done.out)["unmet"] == []
