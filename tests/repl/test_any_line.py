"""Any text at all: a session never raises, and never changes by what is wrong."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from i2pdsl.errors import Diagnostic
from i2pdsl.repl.completing import complete_line
from i2pdsl.repl.curves import Ink
from i2pdsl.repl.piped import entries
from i2pdsl.repl.session import Session
from i2pdsl.repl.showing import in_a_line, on_a_terminal
from repl.conftest import copied

# Not those that plan, search, or write files.
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
    *("P(rho > 0 | script[:t])", "[cheese: west, robot: stay]"),
)


def line() -> st.SearchStrategy[str]:
    """Words of the language and of sessions, whole and cut off; and texts of any kind."""
    rest = st.lists(st.sampled_from(WORDS), max_size=12).map(" ".join)
    first = st.sampled_from((*COMMANDS, *STATEMENTS, ""))
    known = st.tuples(first, rest).map(" ".join)
    return known | st.text(max_size=40) | known.map(lambda s: s[: len(s) // 2])


@pytest.fixture(scope="module")
def somewhere(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    before, folder = Path.cwd(), tmp_path_factory.mktemp("any")
    os.chdir(folder)
    yield folder
    os.chdir(before)


def is_wrong(diagnostics: tuple[Diagnostic, ...]) -> bool:
    return any(d.severity == "error" for d in diagnostics)


@settings(
    max_examples=400,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(lines=st.lists(line(), min_size=1, max_size=4))
def test_any_lines(helped: Session, somewhere: Path, lines: list[str]) -> None:
    session = copied(helped)
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
        for shown in reply.shown:
            assert isinstance(in_a_line(shown), str)
            on_a_terminal(shown, Ink(True, True, 60))
            on_a_terminal(shown, Ink(False, False, 60))
    # What is kept is a story that can be read.
    session.state.program.understood()
    for _ in range(len(session.past)):
        session.run("undo")
    assert session.state.program is helped.state.program


@settings(max_examples=300, deadline=None)
@given(typed=line(), share=st.floats(0, 1))
def test_any_place_can_be_completed(helped: Session, typed: str, share: float) -> None:
    offset = round(share * len(typed))
    for each in complete_line(typed, offset, helped.state):
        assert 0 <= each.start <= each.end <= len(typed)


@given(lines=st.lists(st.text(st.characters(exclude_characters="\r\n"), max_size=12)))
def test_no_line_is_lost(lines: list[str]) -> None:
    assert "\n".join(entries(lines)).split("\n") == (lines or [""])
