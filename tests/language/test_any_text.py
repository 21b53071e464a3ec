"""Any text at all: a StoryError or success, never anything else, and soon.

Deterministic: plain random with fixed seeds, and hypothesis with `derandomize`.
"""

from __future__ import annotations

import random
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fuzz_for_tests import FULL, examples
from i2pdsl.errors import Source, StoryError
from i2pdsl.language.builtins import FUNCTIONS, RESERVED
from i2pdsl.language.check import check_query, check_source
from i2pdsl.language.format import format_source
from i2pdsl.language.parse import parse
from i2pdsl.language.scope import Module
from i2pdsl.language.statements import decode, room_for_nesting
from i2pdsl.worlds.find import find_vocabulary
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.kinds import format_world

ROOT = Path(__file__).parents[2]
KITCHEN = find_vocabulary("kitchen")
STORIES = [
    p.read_text(encoding="utf-8")
    for folder in ("stories", "tests/golden", "tests/language")
    for p in sorted((ROOT / folder).rglob("*.story"))
    if "not-text" not in p.name and p.stat().st_size < 2000
]
WORLD = (ROOT / "stories" / "worlds" / "kitchen.world").read_text(encoding="utf-8")
NAMES = "rho G_cheese G_robot R_robot pink none robot cheese table deus depict arc shown x at moved"
SIGNS = "( ) [ ] { } , : ; | || @ ! .. + ++ - * / ^ < <= = != >= > sum_{t ' ρ \t"
SPACES = ("\n", "\n", "\n    ", "# note\n", "\t")
NUMBERS = ("0", "1", "2.5", "1e400", '"text"')
TOKENS = [*sorted(RESERVED), *sorted(FUNCTIONS), *NAMES.split(), *SIGNS.split(), *SPACES, *NUMBERS]
SETTINGS = settings(
    derandomize=True,
    max_examples=examples(150),
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],
)


def survives(text: str) -> None:
    """Parses, checks and formats; what formats keeps its meaning, and formatting is stable."""
    source = Source("any.story", text)
    with suppress(StoryError):
        check_source(source, find_vocabulary, Path("nowhere"))
    try:
        neat = format_source(source)
    except StoryError:
        return
    assert format_source(Source("neat.story", neat)) == neat
    with room_for_nesting():
        assert parse(Source("neat.story", neat)).statements == parse(source).statements


def survives_as_query(text: str) -> None:
    assert KITCHEN is not None
    with suppress(StoryError):
        check_query(Source("any", text), KITCHEN, Module(Source("none", "")), 4)
    with suppress(StoryError):
        check_query(
            Source("one", "1"), KITCHEN, Module(Source("none", "")), 4, assume=Source("any", text)
        )


def survives_as_world(text: str) -> None:
    source = Source("any.world", text)
    try:
        parse_world(source, "any")
    except StoryError:
        pass
    else:
        assert parse_world(Source("neat", format_world(source)), "any").state_count >= 1
    with suppress(StoryError):
        neat = format_world(source)
        assert format_world(Source("neat", neat)) == neat


def mutated(text: str, dice: random.Random) -> str:
    """A text with a few characters or tokens changed, lost, doubled or moved."""
    for _ in range(dice.randint(1, 4)):
        at = dice.randrange(len(text) + 1)
        end = min(len(text), at + dice.randint(0, 8))
        piece = dice.choice(
            ["", dice.choice(TOKENS), f" {dice.choice(TOKENS)} ", text[at:end] * 2, "\x00", "é "]
        )
        text = text[:at] + piece + text[end:]
    return text


def test_mutated_stories() -> None:
    dice = random.Random(1)
    for _ in range(examples(1000)):
        survives(mutated(dice.choice(STORIES), dice))


def test_mutated_worlds() -> None:
    dice = random.Random(2)
    for _ in range(examples(500)):
        survives_as_world(mutated(WORLD, dice))


def test_mutated_queries() -> None:
    dice = random.Random(3)
    expressions = [
        line.partition(" ")[2]
        for story in STORIES
        for line in story.splitlines()
        if line.startswith("maximize ")
    ]
    assert len(expressions) > 100
    for _ in range(examples(800)):
        survives_as_query(mutated(dice.choice(expressions), dice))


def test_cut_stories_and_worlds() -> None:
    for text in STORIES[:12]:
        for end in range(0, len(text), 9 if FULL else 31):
            survives(text[:end])
            survives(text[end:])
    for end in range(0, len(WORLD), 13 if FULL else 37):
        survives_as_world(WORLD[:end])
        survives_as_world(WORLD[end:])


def test_random_tokens() -> None:
    dice = random.Random(4)
    for _ in range(examples(800)):
        body = " ".join(dice.choices(TOKENS, k=dice.randint(1, 25)))
        survives(f"world kitchen\nlength 5\nmaximize {body}")
        survives(body)
        survives_as_query(body)


@SETTINGS
@given(st.lists(st.sampled_from(TOKENS), max_size=30).map(" ".join))
def test_any_tokens(text: str) -> None:
    survives(f"world kitchen\nlength 5\nmaximize sum_t {text}")
    survives_as_world(text)


@SETTINGS
@given(st.text(max_size=60))
def test_any_characters(text: str) -> None:
    survives(text)
    survives(f"let x = {text}")
    survives_as_query(text)
    survives_as_world(f"map\n    {text}\ncharacter a\n")


@SETTINGS
@given(st.binary(max_size=60))
def test_any_bytes(data: bytes) -> None:
    try:
        data.decode("utf-8")
    except UnicodeDecodeError:
        with pytest.raises(StoryError, match="not-text"):
            decode(data, "bytes.story")
    else:
        survives(decode(data, "bytes.story").text)


OPERATORS = ("+", "-", "*", "/", "^", "<", "=", "and", "or", "in")
EXPRESSIONS = st.recursive(
    st.sampled_from(["1", "t", "T", "rho > 0", "pink", "P(rho > 0 | script[:t])", "last(script)"]),
    lambda inner: st.one_of(
        st.tuples(
            inner, st.sampled_from(["+", "-", "*", "/", "^", "<", "=", "and", "or", "in"]), inner
        ).map(" ".join),
        inner.map(lambda x: f"({x})"),
        inner.map(lambda x: f"-{x}"),
        inner.map(lambda x: f"not {x}"),
        inner.map(lambda x: f"sum_t {x}"),
        inner.map(lambda x: f"depict({x})"),
        inner.map(lambda x: f"script[:{x}]"),
        inner.map(lambda x: f"E[{x} | script[:T]]"),
        st.tuples(inner, inner, inner).map(lambda x: "(if {} then {} else {})".format(*x)),
    ),
    max_leaves=12,
)


@SETTINGS
@given(EXPRESSIONS)
def test_any_expression(text: str) -> None:
    survives(f"world kitchen\nlength 3\nmaximize {text}\nlet unused = {text}")
    survives_as_query(text)


DEEP: dict[str, Callable[[int], str]] = {
    "groups": lambda n: "(" * n + "1" + ")" * n,
    "named": lambda n: "depict(event = " * n + "rho > 0" + ")" * n,
    "open groups": lambda n: "(" * n,
    "calls": lambda n: "abs(" * n + "1" + ")" * n,
    "patterns": lambda n: "depict(" * n + "rho > 0" + ")" * n,
    "nots": lambda n: "P(" + "not " * n + "rho > 0 | script[:T])",
    "signs": lambda n: "- " * n + "1",
    "powers": lambda n: "1 ^ " * n + "1",
    "ifs": lambda n: "if T > 1 then 1 else " * n + "1",
    "conditions": lambda n: "if " * n + "T > 1" + " then T > 1 else T > 1" * n,
    "sums": lambda n: "sum_t " * n + "1",
    "indices": lambda n: "script[:" * n + "1" + "]" * n,
    "after": lambda n: "script" + "[1]" * n,
    "appended": lambda n: "script" + " ++ [cheese: stay, robot: stay]" * n,
    "terms": lambda n: "1 + " * n + "1",
    "factors": lambda n: "T * " * n + "1",
    "chain": lambda n: "P(" + "0 < " * n + "rho | script[:T])",
    "alternatives": lambda n: "P(" + "rho > 0 or " * n + "rho > 0 | script[:T])",
    "sets": lambda n: "P(rho in {" + "1, " * n + "1} | script[:T])",
    "arguments": lambda n: "max(" + "1, " * n + "1)",
    "quotes": lambda n: '"' * n,
    "names": lambda n: "x" * n,
    "digits": lambda n: "9" * n,
}


@pytest.mark.parametrize("kind", DEEP)
@pytest.mark.parametrize("count", [150, 10_000])
def test_deep_and_long_texts(kind: str, count: int) -> None:
    text = f"world kitchen\nlength 5\nmaximize {DEEP[kind](count)}"
    began = time.process_time()
    with suppress(StoryError):
        check_source(Source("deep.story", text), find_vocabulary)
    assert time.process_time() - began < 5
    if count < 1000:
        survives(text)
        survives_as_query(DEEP[kind](count))


@pytest.mark.parametrize("kind", ["groups", "calls", "nots", "signs", "powers", "ifs", "sums"])
def test_nesting_of_150_is_fine_and_of_250_an_error(kind: str) -> None:
    def codes(count: int) -> set[str]:
        text = f"world kitchen\nlength 5\nmaximize {DEEP[kind](count)}"
        try:
            check_source(Source("deep.story", text), find_vocabulary)
        except StoryError as problem:
            return {d.code for d in problem.diagnostics}
        return set()

    assert codes(150) == ({"nested-sum"} if kind == "sums" else set())
    assert codes(250) == {"nesting"}


def test_a_line_of_a_megabyte() -> None:
    for text in ("maximize " + "1 + " * 250_000, "x" * 1_000_000, "#" * 1_000_000, "(" * 1_000_000):
        for run in (survives, survives_as_query, survives_as_world):
            run(text)


@pytest.mark.parametrize(
    "doubling",
    [
        ["pattern p{i}(x) = p{j}(x) + p{j}(x)", "pattern p40(x) = x", "maximize sum_t p0(t)"],
        ["pattern p{i}(x) = p{j}(x + x)", "pattern p40(x) = x", "maximize sum_t p0(t)"],
        ["let p{i} = p{j} * p{j}", "let p40 = t", "maximize sum_t p0"],
        ["let p{i} = p{j} and p{j}", "let p40 = rho > 0", "maximize depict(p0)"],
        ["let p{i} = p{j} + p{j}", "let p40 = 1", "maximize 1"],
    ],
)
def test_patterns_that_grow_without_bound_end_in_an_error(doubling: list[str]) -> None:
    line, *rest = doubling
    lines = [line.replace("{i}", str(i)).replace("{j}", str(i + 1)) for i in range(40)]
    text = "\n".join(["world kitchen", "length 5", *lines, *rest])
    began = time.process_time()
    with pytest.raises(StoryError) as caught:
        check_source(Source("grows.story", text), find_vocabulary)
    assert {d.code for d in caught.value.diagnostics} == {"nesting"}
    assert time.process_time() - began < 5


def test_text_that_is_no_story() -> None:
    """A page of prose gives a page of messages, not a book."""
    text = "\n".join(f"line {i} of something else entirely" for i in range(500))
    with pytest.raises(StoryError) as caught:
        check_source(Source("prose.story", text), find_vocabulary)
    assert len(caught.value.diagnostics) == 10
