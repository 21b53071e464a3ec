"""Any text at all: a session never raises, and never changes by what is wrong."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from i2pdsl.errors import Diagnostic
from i2pdsl.render.characters import Ink
from i2pdsl.repl.completing import complete_line
from i2pdsl.repl.piped import entries
from i2pdsl.repl.session import Session
from i2pdsl.repl.showing import in_a_line, on_a_terminal
from repl.conftest import copied

# Not those that plan or search.
COMMANDS = (
    *("story", "show", "plot", "table", "play", "accept", "rewind", "forget", "undo", "help"),
    *("quit", "exit", "load"),
)
STATEMENTS = (
    *("let", "pattern", "import", "assume", "maximize", "minimize", "length", "start", "allow"),
    "rationality",
)
WORDS = (
    *("P", "E", "V", "KL", "entropy", "surprise", "suspense", "sum_t", "mean_t", "sum_{t", "in"),
    *("script", "t", "T", "last", "rho", "G_cheese", "G_robot", "R_cheese", "R_robot", "pink"),
    *("green", "none", "cheese", "robot", "table", "deus", "friend", "depict", "twist", "at"),
    *("absent", "adjacent", "pushes", "moved", "north", "west", "west!", "stay", "nothing", "not"),
    *("and", "or", "if", "then", "else", "abs", "min", "max", "pi", "points", "let", "x", "f(x)"),
    *'()[]{}|@:,=<>+-*/^!#"',
    *("||", "++", "!=", "<=", "..", "[:t]", "[:T]", "[1]", "[:t-1]", "0", "1", "7", "99", "0.5"),
    *("1e9", "-1", "one.story", "\n", "\n  ", "\x00", "\t", "é", "∑", "x = 1", "f(x) = x"),
    *("P(rho > 0 | script[:t])", "[cheese: west, robot: stay]", "P(rho | script[:t-1])"),
    *("9223372036854775808", "1.7e308", "-1.7e308", "1e-320", "1e400", "9" * 400, "10^308", "0/0"),
    *("99999999999999999999", "-0", "٣", "²", "1_000", "0x10", "NaN", "inf"),
)
# None leads out of the folder. What is saved is never loaded, or it would be solved.
NAMES = (
    *("a\udcff.story", "a b.story", "#.story", "%s.story", "'.story", '"a"b.story', "a\tb.story"),
    *("x" * 300 + ".story", "no/" * 2000 + "a.story", "one.story/two.story", ".story", "..story"),
    *(
        "\udcff",
        "\udcff.json",
        ".",
        "..",
        "a.png.story",
        "🐭猫.story",
        "a\x00.story",
        "a.tex",
        "~x",
    ),
)
JUNK = (
    "\x1b[31m",
    "\x7f\x08\x00",
    "\ufeff",
    "\u2028",
    "\u202e",
    "e\u0301" * 50,
    "\udc80\udcff",
    bytes(range(256)).decode("latin-1"),
    bytes(range(128, 256)).decode("utf-8", "surrogateescape"),
)


def line() -> st.SearchStrategy[str]:
    """Words of the language and of sessions, whole and cut off; and texts of any kind."""
    rest = st.lists(st.sampled_from(WORDS), max_size=12).map(" ".join)
    first = st.sampled_from((*COMMANDS, *STATEMENTS, ""))
    known = st.tuples(first, rest).map(" ".join)
    files = st.tuples(st.sampled_from(("load ", "save _")), st.sampled_from(NAMES)).map("".join)
    odd = st.tuples(first, st.sampled_from((*NAMES, *JUNK)), rest).map(" ".join)
    return known | files | odd | st.text(max_size=40) | known.map(lambda s: s[: len(s) // 2])


@pytest.fixture(scope="module")
def somewhere(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    before, folder = Path.cwd(), tmp_path_factory.mktemp("any")
    os.chdir(folder)
    yield folder
    os.chdir(before)


@pytest.fixture(scope="module")
def bare() -> Session:
    """A session whose script has no frames."""
    session = Session()
    assert not session.run("P(rho > 0 | script[:T])").diagnostics
    session.past.clear()
    return session


def is_wrong(diagnostics: tuple[Diagnostic, ...]) -> bool:
    return any(d.severity == "error" for d in diagnostics)


@settings(
    max_examples=400,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(lines=st.lists(line(), min_size=1, max_size=4), frames=st.booleans())
def test_any_lines(
    helped: Session, bare: Session, somewhere: Path, lines: list[str], frames: bool
) -> None:
    session = copied(helped if frames else bare)
    begun = session.state
    for typed in lines:
        before, past = session.state, list(session.past)
        reply = session.run(typed)
        if is_wrong(reply.diagnostics):
            assert session.past == past
            assert session.state.program is before.program
            assert session.state.score == before.score
            assert session.state.path is before.path or before.path is None
            assert not reply.shown
            assert not reply.leaves
        for diagnostic in reply.diagnostics:
            assert diagnostic.render()
            # One place would catch it, and keep the session: none is known that gets there.
            assert diagnostic.code != "fault", diagnostic.render()
        for shown in reply.shown:
            assert isinstance(in_a_line(shown), str)
            on_a_terminal(shown, Ink(True, True, 60))
            on_a_terminal(shown, Ink(False, False, 60))
    # What is kept is a story that can be read.
    session.state.program.understood()
    for _ in range(len(session.past)):
        session.run("undo")
    assert session.state.program is begun.program


@settings(max_examples=300, deadline=None)
@given(typed=line(), share=st.floats(0, 1))
def test_any_place_can_be_completed(helped: Session, typed: str, share: float) -> None:
    offset = round(share * len(typed))
    for each in complete_line(typed, offset, helped.state):
        assert 0 <= each.start <= each.end <= len(typed)


@given(lines=st.lists(st.text(st.characters(exclude_characters="\r\n"), max_size=12)))
def test_no_line_is_lost(lines: list[str]) -> None:
    assert "\n".join(entries(lines)).split("\n") == (lines or [""])


LONG = 1_000_000
HUGE = (
    "(" * LONG,
    "1 + " * (LONG // 4),
    "x" * LONG,
    "plot " + "1, " * (LONG // 3),
    "help " + "x" * LONG,
    "# " + "x" * LONG,
    "let x = " + "9" * LONG,
    "save " + "x" * LONG + ".story",
    "forget " + "x" * LONG,
    "suggest " + "9" * LONG,
    "\x00" * LONG,
    "猫" * LONG,
    "P(rho > 0 | script[:t])" + " " * LONG,
)


@pytest.mark.parametrize("typed", HUGE, ids=lambda s: s[:12])
def test_lines_of_a_million_characters(bare: Session, somewhere: Path, typed: str) -> None:
    session = copied(bare)
    began = time.process_time()
    for entry in entries(typed.splitlines()):
        reply = session.run(entry)
        for diagnostic in reply.diagnostics:
            assert diagnostic.code != "fault"
            assert len(diagnostic.render()) < 3000
    assert time.process_time() - began < 20


def test_a_million_lines_that_go_on() -> None:
    """What belongs together is not looked through again for each of its lines."""
    began = time.process_time()
    (found,) = entries(["(", *([" 1 +"] * 100_000)])
    assert found.count("\n") == 100_000
    assert time.process_time() - began < 20
