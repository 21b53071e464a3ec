"""Checking answers at once: no array library is loaded, and long stories cost little."""

from __future__ import annotations

import gc
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest

from fuzz_for_tests import FULL
from i2pdsl.errors import Source, StoryError
from i2pdsl.language.check import TypedStory, check_source
from i2pdsl.language.format import format_source
from i2pdsl.worlds.find import find_vocabulary
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.kinds import format_world

ROOT = Path(__file__).parents[2]
CHECK = """
import sys, pathlib
from i2pdsl.errors import Source
from i2pdsl.language.check import check_source
from i2pdsl.language.format import format_source
from i2pdsl.language.query import check_query
from i2pdsl.worlds.find import find_vocabulary
for path in sorted(pathlib.Path("stories/kitchen").glob("*.story")):
    source = Source(str(path), path.read_text())
    check_source(source, find_vocabulary, path.parent)
    format_source(source)
heavy = {"jax", "numpy", "matplotlib", "PIL", "scipy"} & set(sys.modules)
print(",".join(sorted(heavy)) or "none")
"""


def seconds(count: int, work: Callable[[], object]) -> float:
    """The least seconds of processor time that some work takes: other programs do not count."""
    times = []
    gc.disable()  # it would look at what other tests have left in memory
    try:
        for _ in range(count):
            began = time.process_time()
            work()
            times.append(time.process_time() - began)
    finally:
        gc.enable()
    return min(times)


def best_of(count: int, text: str) -> float:
    """The least seconds that checking a text takes, after start-up."""
    source = Source("timed.story", text)
    assert isinstance(check_source(source, find_vocabulary), TypedStory)
    return seconds(count, lambda: check_source(source, find_vocabulary))


def test_checking_loads_no_array_library() -> None:
    result = subprocess.run(
        [sys.executable, "-c", CHECK], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert result.stdout.strip() == "none"


@pytest.mark.parametrize("path", sorted((ROOT / "stories" / "kitchen").glob("*.story")))
def test_a_story_is_checked_at_once(path: Path) -> None:
    """In three milliseconds, on a machine that has nothing else to do."""
    assert best_of(5, path.read_text(encoding="utf-8")) < 0.03


@pytest.mark.parametrize(
    "objective",
    [
        "sum_t P(rho > 0 | script[:t])",
        "arc(robot)",
        "twist(rho > 0, rho < 0)",
        "sum_t P(rho > 0 | script[:T-t]) * points((0, 0), (0.3, 1), (1, -1))",
        "sum_t (if 3 <= t <= 50000 then sin(t/T) * surprise(script[t]) else 1/(t - 4))",
        "sum_t P(rho > 0 | script[:abs(t - 5)])",
    ],
)
def test_a_story_of_100_000_frames_is_checked_in_a_second(objective: str) -> None:
    assert best_of(1, f"world kitchen\nlength 100000\nmaximize {objective}") < 2


def test_hundreds_of_statements() -> None:
    lines = [
        f"let e{i} = rho > 0 and G_cheese = pink\n"
        f"# Documentation.\npattern q{i}(x) = depict(x) + {i}\nmaximize q{i}(e{i})\n"
        for i in range(300)
    ]
    assert best_of(1, "world kitchen\nlength 100000\n" + "".join(lines)) < 3


def lines(form: str, count: int) -> str:
    return "".join(form.replace("{i}", str(i)).replace("{j}", str(i + 1)) for i in range(count))


# Of about the same length for the same count; {i} counts, {j} is one more.
REPEATED = {
    "lets": "let a{i} = rho > 0 and G_cheese = pink\n",
    "chain": "let a{j} = a{i} + 1\n",
    "chain of patterns": "pattern a{j}(x) = a{i}(x) + 1\n",
    "circles": "let a{i} = a{i} + 1\n",
    "patterns": "# What it does.\npattern p{i}(x) = sum_t P(x | script[:t])\n",
    "objectives": "maximize arc(robot)\n",
    "duplicates": "let a = rho > 0\n",
    "once": "length 15\n",
    "starts": "start absent(table)\n",
    "imports": "import depict\n",
    "missing imports": "import no{i}\n",
    "brackets": "maximize sum_t P(rho > 0 | script[:t]\n",
    "operators": "maximize 2 t\n",
    "cut short": "let a{i} =\n",
    "misspelt lets": "let name{i} = rho > 0\nmaximize depict(naem{i})\n",
    "misspelt latents": "let name{i} = rhoo > 0\n",
    "misspelt patterns": "pattern name{i}(x) = dipict{i}(y{i})\n",
    "misspelt statements": "maximise depict(rho > 0)\n",
    "quotes": 'import "abc{i}\n',
    "closing": ")\n",
    "opening": "(\n",
    "comments": "let a{i} = 1  # a note\n",
    "blank lines": "\n",
    "carriage returns": "let a{i} = 1\r\n",
    "not ASCII": "let é{i} = 1  # 🤖\n",
    "deep": f"let a{{i}} = {'(' * 60}1{')' * 60}\n",
}
IN_A_LINE = {
    "sum": ("maximize 1", " + 1", ""),
    "product": ("maximize sum_t (t", " * t", ")"),
    "unknown": ("maximize 1", " + x{i}", ""),
    "alternatives": ("maximize depict(rho > 0", " or rho > 0", ")"),
    "set": ("maximize depict(rho in {1", ", 1", "})"),
    "points": ("maximize sum_t points((-1, 0)", ", ({i}, 1)", ")"),
    "parameters": ("pattern p(a", ", p{i}", ") = 1"),
    "turns": ("let s = script", " ++ [cheese: stay, robot: stay]", ""),
    "ifs": ("maximize 1", " + (if T > {i} then 1 else 0)", ""),
}
HEAD = "world kitchen\nlength 15\nmaximize depict(rho > 0)\nlet a0 = 1\n"
WORLD_PARTS = {
    "objects": "object o{i}\n    may_be_absent = yes\n",
    "tiles": "tile t{i}\n    symbol = P\n",
    "events": "object o{i}\n    may_be_absent = yes\nevent e{i}\n    drops = {o{i}}\n",
    "characters": "character c{i}\n",
    "keys": "    key{i} = 1\n",
    "goals": "    goals = {pnk{i}}\n",
    "broken": "tile t{i} = =\n",
    "prose": "line of text {i}\n",
    "maps": "map\n    . . .\n",
}


def grows_as_the_text(work: Callable[[str], object], text: Callable[[int], str]) -> None:
    """Four times the text take about four times as long; twice that is for a busy machine.

    A machine may be slow for one of the two alone, so the least times of a few rounds count.
    """
    size = 10_000 if FULL else 3_000
    short, long = text(size), text(4 * size)
    few = much = float("inf")
    for _ in range(4):
        few, much = (
            min(few, seconds(1, lambda: work(short))),
            min(much, seconds(1, lambda: work(long))),
        )
        if much < 8 * few + size * 3e-5:
            return
    raise AssertionError(f"{size} characters take {few:.2f} s, four times as many {much:.2f} s")


def story_work(text: str) -> None:
    source = Source("long.story", text)
    with suppress(StoryError):
        check_source(source, find_vocabulary, Path("nowhere"))
    with suppress(StoryError):
        format_source(source)


@pytest.mark.parametrize("kind", REPEATED)
def test_many_statements_take_time_as_their_length(kind: str) -> None:
    form = REPEATED[kind]
    grows_as_the_text(story_work, lambda size: HEAD + lines(form, size // len(form)))


@pytest.mark.parametrize("kind", IN_A_LINE)
def test_a_long_line_takes_time_as_its_length(kind: str) -> None:
    first, form, last = IN_A_LINE[kind]
    text = lambda size: f"{HEAD}{first}{lines(form, size // len(form))}{last}\n"
    grows_as_the_text(story_work, text)


@pytest.mark.parametrize("kind", WORLD_PARTS)
def test_a_long_world_takes_time_as_its_length(kind: str) -> None:
    def work(text: str) -> None:
        source = Source("long.world", text)
        with suppress(StoryError):
            parse_world(source, "long")
        with suppress(StoryError):
            format_world(source)

    head = "map\n    .P.\ntile pink\n    symbol = P\ncharacter robot\n    goals = {pink}\n"
    form = WORLD_PARTS[kind]
    grows_as_the_text(work, lambda size: head + lines(form, size // len(form)))


def test_of_many_mistakes_the_first_are_shown_and_the_others_counted() -> None:
    text = HEAD + lines("let b{i} = rhoo{i} > 0\n", 1000)
    with pytest.raises(StoryError) as caught:
        check_source(Source("wrong.story", text), find_vocabulary)
    *found, last = caught.value.diagnostics
    assert len(found) == 200
    assert [d.span.source.position(d.span.start)[0] for d in found] == list(range(5, 205))
    assert (last.code, last.message) == ("too-many", "and 800 more mistakes, from here on")
    assert last.span.source.position(last.span.start)[0] == 205


def test_what_nobody_can_search_for_has_a_limit_with_a_number() -> None:
    wide = lines("maximize arc(robot, scale = {i})\n", 5000)
    factors = f"maximize sum_t ({lines('t * ', 1000)}t)\n"
    for text, limit in ((wide, "150,000 parts"), (factors, "400 factors")):
        with pytest.raises(StoryError, match=limit) as caught:
            check_source(Source("large.story", HEAD + text), find_vocabulary)
        assert [d.code for d in caught.value.diagnostics] == ["nesting"]
