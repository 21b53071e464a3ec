"""Whole messages, as people see them: tests/golden/CODE[-VARIANT].story|.world|.query and .txt.

To accept new wording: `pytest tests/language --update-goldens`, then read every difference.
"""

from __future__ import annotations

import ast
import re
import sys
import unicodedata
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest

from i2pdsl.errors import Diagnostic, Source, Span, StoryError, closest
from i2pdsl.language.check import check_query, check_source
from i2pdsl.language.imports import build_module
from i2pdsl.language.parse import parse
from i2pdsl.language.statements import LONGEST_FILE, decode, read_source
from i2pdsl.language.vocabulary import Settings, Vocabulary
from i2pdsl.worlds.find import find_vocabulary
from i2pdsl.worlds.grid.parse import parse_world as parse_grid
from i2pdsl.worlds.kinds import parse_world

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "tests" / "golden"
HELPERS = ("helpers_golden.story", "broken_golden.world", "many_golden.world")
CASES = sorted(
    path
    for path in FOLDER.iterdir()
    if path.suffix in (".story", ".world", ".query") and path.name not in HELPERS
)
# Whose messages are golden.
READERS = (check_source, check_query, read_source, parse_world, parse_grid)
REPORTERS = ("Diagnostic", "error", "problem", "fail", "blame", "warn", "missing")
# Codes that have their own tests; a library's is shown at the import.
ELSEWHERE = {
    "set": "tests of `i2p run --set`",
    "library": "tests/library/test_read.py",
    "too-many": "test_speed_of_checking.py",
    "no-plan": "tests/test_cli_hill.py",
    "no-training": "tests/test_cli_hill.py",
    "command": "tests/repl",
    "unmet": "tests/search/test_requirements.py",
    "positions": "tests/test_positions.py",
}


def find_world(name: str, folder: Path | None, settings: Settings = ()) -> Vocabulary | None:
    """The worlds of the goldens: `smooth` is a kitchen whose actions cannot be listed."""
    if name == "smooth":
        kitchen = find_vocabulary("kitchen", folder)
        assert kitchen is not None
        return replace(kitchen, enumerable=False)
    return find_vocabulary(name, folder, settings)


@cache
def diagnostics(path: Path) -> tuple[Diagnostic, ...]:
    """What is said about a golden file."""
    data = path.read_bytes()
    try:
        source = decode(data, path.name)
        if path.suffix == ".world":
            parse_world(source, path.stem)
            return ()
        if path.suffix == ".query":
            kitchen = find_vocabulary("kitchen")
            assert kitchen is not None
            module = build_module(parse(Source("empty", "let x = 1")), lambda _: None, None)
            return check_query(source, kitchen, module, 5).warnings
        return check_source(source, find_world, FOLDER).warnings
    except StoryError as problem:
        return problem.diagnostics


def shown(problems: tuple[Diagnostic, ...]) -> str:
    text = "\n".join(problem.render() for problem in problems)
    text = text.replace(str(FOLDER) + "/", "").replace(str(ROOT) + "/", "")
    return text + "\n"


@pytest.mark.parametrize("path", CASES, ids=lambda p: p.name)
def test_message_is_golden(path: Path, request: pytest.FixtureRequest) -> None:
    problems = diagnostics(path)
    assert problems, "a golden file must be wrong in some way"
    golden = path.with_suffix(".txt")
    if request.config.getoption("--update-goldens", default=False):
        golden.write_text(shown(problems), encoding="utf-8")
    assert shown(problems) == golden.read_text(encoding="utf-8")


@pytest.mark.parametrize("path", CASES, ids=lambda p: p.name)
def test_first_line_and_underline_agree(path: Path) -> None:
    """`FILE:LINE:COLUMN: error[code]: message`, and carets below exactly what the span holds."""
    for problem in diagnostics(path):
        head, *rest = problem.render().split("\n")
        match = re.fullmatch(r"(.+?):(\d+):(\d+): (error|warning)\[([a-z-]+)\]: (.+)", head)
        assert match, head
        line, column = int(match[2]), int(match[3])
        assert problem.span.source.position(problem.span.start) == (line, column)
        assert match[5] == problem.code
        if rest and "^" in "".join(rest[:2]):
            source_line, carets = rest[0], rest[1]
            start = carets.index("^")
            first = problem.span.text.split("\n")[0]
            if "…" not in source_line and first.isprintable() and first:
                underlined = source_line[start : start + carets.count("^")]
                assert underlined == first.rstrip()


def modules_of(readers: tuple[Callable[..., object], ...]) -> set[Path]:
    """The files that some functions are made of: where they stand, and all of ours that these
    import as they are loaded."""
    found: set[Path] = set()
    waiting = [reader.__module__ for reader in readers]
    while waiting:
        path = Path(str(sys.modules[waiting.pop()].__file__))
        if path not in found:
            found.add(path)
            body = ast.parse(path.read_text(encoding="utf-8")).body
            names = [str(node.module) for node in body if isinstance(node, ast.ImportFrom)]
            waiting += [name for name in names if name.startswith("i2pdsl.")]
    return found


def codes_of(path: Path) -> Iterator[str]:
    """The codes that a module can report."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for function in ast.walk(tree):
        if not isinstance(function, ast.FunctionDef):
            continue
        for call in (n for n in ast.walk(function) if isinstance(n, ast.Call) and n.args):
            name = getattr(call.func, "attr", getattr(call.func, "id", ""))
            first = call.args[0]
            if name not in REPORTERS:
                continue
            if isinstance(first, ast.Constant):
                yield str(first.value)
            elif isinstance(first, ast.Name) and first.id == "code":
                # Chosen among constants of the same function.
                for n in ast.walk(function):
                    if isinstance(n, ast.Constant) and re.fullmatch(r"no-[a-z]+", str(n.value)):
                        yield n.value


def test_every_code_has_a_golden() -> None:
    emitted = {code for path in modules_of(READERS) for code in codes_of(path)} - ELSEWHERE.keys()
    assert len(emitted) > 50, "the codes are not found in the source any more"
    told = {problem.code for path in CASES for problem in diagnostics(path)}
    told |= {"no-file", "too-long"}  # test_files_that_cannot_be_read
    assert told == emitted
    unnamed = {code for code in told if not list(FOLDER.glob(f"{code}*.txt"))}
    assert not unnamed, "the golden files of a code begin with its name"


def test_every_golden_text_belongs_to_a_file() -> None:
    written = {path.stem for path in CASES} | {"no-file", "too-long"}
    assert {path.stem for path in FOLDER.glob("*.txt")} == written
    assert len(CASES) == len({path.stem for path in CASES})


@pytest.mark.parametrize("code", ["no-file", "too-long"])
def test_files_that_cannot_be_read(code: str, request: pytest.FixtureRequest) -> None:
    too_long = Source("long.story", "#" * (LONGEST_FILE + 1))
    with pytest.raises(StoryError) as caught:
        check_source(read_source("not/there.story") if code == "no-file" else too_long, find_world)
    golden = FOLDER / f"{code}.txt"
    if request.config.getoption("--update-goldens", default=False):
        golden.write_text(shown(caught.value.diagnostics), encoding="utf-8")
    assert shown(caught.value.diagnostics) == golden.read_text(encoding="utf-8")


def columns(text: str) -> int:
    """The columns that a text takes in a terminal, by Unicode's tables alone."""
    width = {"W": 2, "F": 2}
    marks = ("Mn", "Me", "Cf")
    return sum(
        0 if unicodedata.category(c) in marks else width.get(unicodedata.east_asian_width(c), 1)
        for c in text
    )


@pytest.mark.parametrize(
    ("line", "wrong"),
    [
        ("let a = sum_t P(G_猫 = 種 | script[:t]) + foo", "foo"),
        ("let a = 種", "種"),
        ("let 한글 = 犬と猫 + foo", "犬と猫"),
        ("let e\u0301te\u0301 = foo", "foo"),
        ('let a = "\N{CAT FACE}\N{PARTY POPPER}" + foo', "foo"),
        ("let ผี = foo", "foo"),
        ("let שלום = foo", "foo"),
        ("let a =\tfoo", "foo"),
        ("let ｗｉｄｅ = foo", "foo"),
    ],
)
def test_carets_stand_under_the_word_in_every_script(line: str, wrong: str) -> None:
    at = line.rindex(wrong)
    source = Source("any.story", f"world fork\n{line}\n")
    place = Span(source, 11 + at, 11 + at + len(wrong))
    problem = Diagnostic("unknown-name", "unknown name", place)
    _, shown, carets = problem.render().split("\n")
    before, _, _ = shown.rpartition(wrong)
    assert carets.index("^") == columns(before)
    assert carets.count("^") == columns(wrong)
    # For programs a column is a character, as ever.
    assert problem.as_json()["column"] == at + 1
    assert problem.as_json()["end_column"] == at + 1 + len(wrong)


def test_a_mark_alone_has_a_caret_under_its_letter() -> None:
    source = Source("any.story", "let a = e\u0301")
    carets = Diagnostic("syntax", "wrong", Span(source, 9, 10)).render().split("\n")[2]
    assert carets == "      |         ^"


def test_hints_never_guess_far() -> None:
    for word, meant in [
        ("colour", "color"), ("gama", "gamma"), ("roh", "rho"), ("forgeting", "forgetting"),
        ("G_chese", "G_cheese"), ("PINK", "pink"), ("forget", "forgetting"), ("goal", "goals"),
        ("probabilty", "probability"), ("ｐｉｎｋ", "pink"),
    ]:  # fmt: skip
        assert closest(word, ["green", "absent", meant]) == meant
    for word, far in [
        ("sees", "pushes"), ("agent", "event"), ("moves", "models"), ("at", "t"), ("ab", "ba"),
        ("start", "stay"), ("door", "order"), ("G_犬", "G_猫"), ("horizon", "rewards"),
    ]:  # fmt: skip
        assert closest(word, ["green", far]) is None, word
    assert closest("ma", ["map", "max"]) is None
    assert closest("max", ["maximize", "maximum"]) is None
    assert closest("x" * 10_000, ["x" * 9_999]) is None
