"""A solved story of the kitchen, and sessions that begin with it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from i2pdsl.repl.session import Session
from i2pdsl.repl.showing import Asked, Moved, Plotted, Reply, Tabled, Text
from i2pdsl.scripts import Script
from i2pdsl.stories import Result, load
from searches_for_tests import searching_once
from worlds_for_tests import STORIES

HELP = STORIES / "kitchen" / "help.story"


@pytest.fixture(autouse=True)
def _search_once(search_once: None) -> None:
    """Sessions find what `solved_help` is."""


@pytest.fixture(scope="session")
def solved_help() -> Result:
    """help.story, made in Python."""
    with searching_once():
        return load(HELP).solve(seed=0)


@pytest.fixture(scope="session")
def helped() -> Session:
    """A session in which help.story was opened and asked something."""
    session = Session()
    session.open(str(HELP))
    with searching_once():
        assert not session.run("P(rho > 0 | script[:T])").diagnostics
    session.past.clear()
    return session


@pytest.fixture
def session(helped: Session, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Session:
    """A session with a state of its own, in a folder of its own; what was made is shared."""
    monkeypatch.chdir(tmp_path)
    return copied(helped)


def copied(session: Session) -> Session:
    """Another session in the same state."""
    new = Session()
    new.state, new._workshop = session.state, session.workshop
    return new


def right(session: Session, line: str) -> Reply:
    """The reply to a line that is right."""
    reply = session.run(line)
    assert not reply.diagnostics, "\n".join(d.render() for d in reply.diagnostics)
    return reply


def refused(session: Session, line: str) -> str:
    """What is said about a line that is wrong, and that changes nothing."""
    before, past = session.state, list(session.past)
    reply = session.run(line)
    assert reply.diagnostics
    assert reply.diagnostics[0].severity == "error"
    assert not reply.shown
    assert session.state is before
    assert session.past == past
    return "\n".join(d.render() for d in reply.diagnostics)


def asked(session: Session, question: str) -> np.ndarray:
    """The answer to a question."""
    (shown,) = right(session, question).shown
    assert isinstance(shown, Asked)
    return np.asarray(shown.answer.value)


def shown(session: Session, line: str) -> Asked | Plotted | Tabled | Moved | Text:
    """What a line shows."""
    (found,) = right(session, line).shown
    return found


def saved_and_read(session: Session, folder: Path) -> Script:
    """The session's script by way of a file."""
    right(session, f"save {folder}/saved.json")
    return Script.load(folder / "saved.json")
