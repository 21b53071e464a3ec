"""What is our fault ends no session, shows no traceback, and loses nothing."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path

import pytest

from i2pdsl.repl import piped, terminal
from i2pdsl.repl.piped import answer_lines
from i2pdsl.repl.session import Session
from i2pdsl.repl.showing import Reply, Text
from i2pdsl.scripts import Script
from repl.conftest import right


@pytest.fixture(autouse=True)
def state_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr("platformdirs.user_state_path", lambda name: tmp_path / "state" / name)
    return tmp_path / "state" / "i2pdsl" / "faults"


def broken(error: type[Exception]) -> Callable[[str], Reply]:
    def command(rest: str) -> Reply:
        raise error(f"of {rest}\nin two lines")

    return command


@pytest.mark.parametrize("error", [ZeroDivisionError, RecursionError, AssertionError, IndexError])
def test_a_fault_is_said_and_kept(
    session: Session, state_folder: Path, error: type[Exception]
) -> None:
    right(session, "play cheese west!")
    before, past = session.state, list(session.past)
    session._commands["table"] = broken(error)
    for _ in range(2):
        (said,) = session.run("table everything").diagnostics
    assert said.render().splitlines() == [
        f"input:1:1: error[fault]: a fault of i2p, not of yours; the session goes on "
        f"({error.__name__}: of everything in two lines)",
        f"  hint: the details, the story so far, the script: in {session.kept}",
    ]
    assert session.state is before
    assert session.past == past
    (folder,) = state_folder.iterdir()
    assert folder == session.kept
    details = (folder / "details.txt").read_text()
    assert details.count("> table everything\nTraceback") == 2
    assert (folder / "session.story").read_text() == before.program.text
    assert Script.load(folder / "script.json").length == 16
    right(session, "1 + 1")


def test_what_changed_before_a_fault_is_undone(session: Session) -> None:
    def command(rest: str) -> Reply:
        session.statement("let x = 1", [])
        raise ValueError

    before, past = session.state, list(session.past)
    session._commands["table"] = command
    assert session.run("table T").diagnostics[0].code == "fault"
    assert session.state is before
    assert session.past == past


def test_where_nothing_can_be_written(
    session: Session, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "state").write_text("a file")
    session._commands["table"] = broken(KeyError)
    (said,) = session.run("table T").diagnostics
    assert str(said.hint).startswith("the details, the story so far, the script: in ")

    def nowhere(**_: object) -> str:
        raise PermissionError

    monkeypatch.setattr("tempfile.mkdtemp", nowhere)
    session.kept = None
    (said,) = session.run("table T").diagnostics
    assert said.hint == "nothing could be written: `save` the session elsewhere"


def test_faults_in_a_pipe(
    session: Session, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """In the answer as well as in how it is shown."""
    session._commands["table"] = broken(KeyError)
    shown = piped.in_a_line

    def show(what: object) -> str:
        assert not isinstance(what, Text)
        return shown(what)  # type: ignore[arg-type]

    monkeypatch.setattr(piped, "in_a_line", show)
    answer_lines(session, io.StringIO("1 + 1\ntable T\nhelp\n2 + 2\n"))
    out, err = capsys.readouterr()
    assert out.splitlines() == ["2", "4"]
    assert err.count("error[fault]") == 2
    assert "Traceback" not in err


def test_faults_on_a_terminal(
    session: Session, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    session._commands["table"] = broken(KeyError)
    monkeypatch.setattr(terminal, "on_a_terminal", broken(OverflowError))
    assert terminal.answered(session, "table T")
    assert terminal.answered(session, "1 + 1")
    assert not terminal.answered(session, "quit")
    err = capsys.readouterr().err
    assert err.count("error[fault]") == 2
    assert "Traceback" not in err


def test_the_history_takes_any_line(tmp_path: Path) -> None:
    history = terminal.KeptHistory(tmp_path / "history")
    history.store_string("a\udcff\x00")
    assert "+a?\x00" in (tmp_path / "history").read_text()
    terminal.KeptHistory(tmp_path).store_string("a folder, where nothing can be written")
