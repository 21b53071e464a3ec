"""The usual layout: meaning and comments stay, and a second time nothing changes."""

from __future__ import annotations

from pathlib import Path

import pytest

from i2pdsl.errors import Source, StoryError
from i2pdsl.language.format import format_source
from i2pdsl.language.parse import parse
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.kinds import format_world

ROOT = Path(__file__).parents[2]
SHIPPED = sorted((ROOT / "stories").rglob("*.story"))
WORLDS = sorted((ROOT / "stories").rglob("*.world"))
OTHERS = [
    path
    for folder in ("golden", "language")
    for path in sorted((ROOT / "tests" / folder).glob("*.story"))
    if "not-text" not in path.name
]


def neat(text: str) -> str:
    return format_source(Source("neat.story", text))


def comments(text: str) -> list[str]:
    """The comments of a text without a `#` in quotes."""
    return [line.partition("#")[2].strip() for line in text.splitlines() if "#" in line]


def test_a_messy_story() -> None:
    """messy.txt has tabs, trailing spaces and comments everywhere; neat.txt is the layout."""
    folder = Path(__file__).parent
    messy, expected = ((folder / name).read_text() for name in ("messy.txt", "neat.txt"))
    assert neat(messy) == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", ""),
        ("\n\n", ""),
        ("# only a comment", "# only a comment\n"),
        ("# a\n\n\n\n# b", "# a\n\n# b\n"),
        ("let x=1", "let x = 1\n"),
        ("let x=1\n\n\nlet y=2\n", "let x = 1\n\nlet y = 2\n"),
        ("let x=1\nlet y=2", "let x = 1\nlet y = 2\n"),
        ("let x = a*b+c/d-e^f", "let x = a*b + c/d - e^f\n"),
        ("let x = a *b", "let x = a * b\n"),
        ("let x = - 1 - - 1", "let x = -1 - -1\n"),
        ("let x = + 1", "let x = +1\n"),
        ("let x = script [:t-1]", "let x = script[:t-1]\n"),
        ("let x = script[ t - 1 ]", "let x = script[t - 1]\n"),
        ("let x=a<b<=c", "let x = a < b <= c\n"),
        ("let x=not(a and(b or c))", "let x = not (a and (b or c))\n"),
        ("let x = f ( a,b=c )", "let x = f(a, b = c)\n"),
        ("let x = last ( script )", "let x = last(script)\n"),
        ("let x = [at(a,b)@script[t]]", "let x = [at(a, b) @ script[t]]\n"),
        ("let x=entropy(rho|script[:t])", "let x = entropy(rho | script[:t])\n"),
        ("let x=entropy(script[:t],a)", "let x = entropy(script[:t], a)\n"),
        ("let x = (a,b)", "let x = (a, b)\n"),
        ("search beam(starts=5,width=1)", "search beam(starts = 5, width = 1)\n"),
        ("maximize a +\n  b", "maximize a +\n    b\n"),
        ("maximize a\n        + b\n          + c", "maximize a\n    + b\n      + c\n"),
        ("maximize (a +\nb)", "maximize (a +\n    b)\n"),
        ("maximize (\n\n\n\n  a)", "maximize (\n\n    a)\n"),
        ("maximize a # why\n  + b", "maximize a  # why\n    + b\n"),
        ("maximize a\u00a0+\u2003b # ünï · ρ", "maximize a + b  # ünï · ρ\n"),
        ("let x=1\r\n\r\n\r\n# c\r\nlet y=2\r\n", "let x = 1\n\n# c\nlet y = 2\n"),
        ("let x =\n\t\tt\n\t\t\t+ 1", "let x =\n    t\n        + 1\n"),
    ],
)
def test_layout(text: str, expected: str) -> None:
    assert neat(text) == expected
    assert neat(expected) == expected


@pytest.mark.parametrize("path", SHIPPED, ids=lambda p: p.stem)
def test_shipped_stories_are_in_the_usual_layout(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert neat(text) == text


@pytest.mark.parametrize("path", WORLDS, ids=lambda p: p.stem)
def test_shipped_worlds_are_in_the_usual_layout(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert format_world(Source(path.name, text)) == text


def test_formatting_keeps_meaning_and_comments() -> None:
    tried = 0
    for path in [*SHIPPED, *OTHERS]:
        text = path.read_text(encoding="utf-8")
        squeezed = text.replace(" + ", "+").replace(", ", " ,").replace("    ", "\t")
        windows = text.replace("\n", "\r\n")
        for variant in (text, squeezed, windows, text.replace("= ", "=  \t")):
            source = Source(path.name, variant)
            try:
                program = parse(source)
            except StoryError:
                with pytest.raises(StoryError):
                    format_source(source)
                continue
            result = format_source(source)
            assert parse(Source(path.name, result)).statements == program.statements
            assert comments(result) == comments(variant)
            assert format_source(Source(path.name, result)) == result
            assert not any(line != line.rstrip() for line in result.split("\n"))
            assert not any(line.startswith("\t") for line in result.split("\n"))
            tried += 1
    assert tried > 150


def test_documentation_stays_with_its_pattern() -> None:
    text = "# not this\n\n\n#  of p\n# and more\npattern p( x )=x\n"
    (pattern,) = parse(Source("s", neat(text))).statements
    assert pattern == parse(Source("s", text)).statements[0]
    assert getattr(pattern, "documentation", "") == "of p\nand more"


@pytest.mark.parametrize("text", ["let x = ", "lett x = 1", "let x = (1", 'let x = "a', "\x00"])
def test_what_cannot_be_parsed_is_not_formatted(text: str) -> None:
    with pytest.raises(StoryError) as formatted:
        neat(f"let a = 1\n{text}\nlet b = 2 3\n")
    if text != "\x00":
        codes = [d.code for d in formatted.value.diagnostics]
        assert len(codes) == 2
        assert codes[1] == "syntax"


def test_worlds() -> None:
    text = (
        "# a world\n\n\nmap\n\t#.#   \n\t...\n\n\ncharacter   mouse # small\n  success=0.5\n"
        '   goals={ cheese ,none }\n  color="#aabbcc"\ntile cheese\n  cell=( 1,0 )\n'
        "planning\n  order=[mouse]\nrewards\n  move=- 1\n"
    )
    expected = (
        "# a world\n\nmap\n\t#.#\n\t...\n\ncharacter mouse  # small\n    success = 0.5\n"
        '    goals = {cheese, none}\n    color = "#aabbcc"\ntile cheese\n    cell = (1, 0)\n'
        "planning\n    order = [mouse]\nrewards\n    move = -1\n"
    )
    result = format_world(Source("w", text))
    assert result == expected
    assert format_world(Source("w", result)) == result
    before, after = (parse_world(Source("w", x), "w") for x in (text, result))
    assert (before.rows, before.characters, before.tiles) == (
        after.rows,
        after.characters,
        after.tiles,
    )
    with pytest.raises(StoryError):
        format_world(Source("w", "map\n    ...\ncharacter a\n    success 1\n"))


@pytest.mark.parametrize(
    ("messy", "expected"),
    [
        (" width = 12\n  height=8\n", "    width = 12\n    height = 8\n"),
        ("\twidth=12\n  height=8\n", "    width = 12\n    height = 8\n"),
        ("      width=12\n # high\n  height=8\n", "    width = 12\n    # high\n    height = 8\n"),
        (" width=12 height=8\n", "    width = 12 height = 8\n"),
    ],
)
def test_entries_of_a_block_stand_below_each_other(messy: str, expected: str) -> None:
    """However they were indented; what continues an entry keeps its place beside it."""
    text = f"kind = plane\nsize\n{messy}wall\n points = [(0, 4),\n           (5, 4)]\n"
    wall = "wall\n    points = [(0, 4),\n              (5, 4)]\n"
    result = format_world(Source("w", text))
    assert result == f"kind = plane\nsize\n{expected}{wall}"
    assert format_world(Source("w", result)) == result


def test_attitudes_toward_several() -> None:
    neat_one = "character bear\n    toward = {a: {-1, 1}, b: 2}  # two\n"
    for messy in ("toward={a:{-1,1},b:2} # two", "toward = { a : {- 1 ,1} , b :2 }# two"):
        assert format_world(Source("w", f"character bear\n  {messy}\n")) == neat_one
    assert format_world(Source("w", neat_one)) == neat_one
