"""Faults of ours: whatever a line brings to light, the session is kept and goes on."""

from __future__ import annotations

import os
import tempfile
import time
import traceback
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, Protocol

from i2pdsl.errors import Diagnostic, whole_file
from i2pdsl.repl.mistakes import INPUT
from i2pdsl.repl.showing import Reply
from i2pdsl.repl.state import State


class Session(Protocol):
    """What is kept of a session (repl/session.py)."""

    state: State
    kept: Path | None

    @property
    def workshop(self) -> Any: ...

    def run(self, line: str) -> Reply: ...


_TOLD = 120  # characters of an exception in the message; all of it is in the details


def taken(session: Session, line: str, tell: Callable[[Reply], None]) -> bool:
    """Does a line and tells what it came to; False where that ends the session.

    This and `Session.run` are the only places where faults are caught, for both front ends.

    Raises OSError where nothing can be told any more, and KeyboardInterrupt.
    """
    reply = session.run(line)
    try:
        tell(reply)
    except OSError:
        raise  # of the output: whoever read it is gone
    except Exception as problem:
        tell(Reply(diagnostics=(fault(session, line, problem),)))
    return not reply.leaves


def fault(session: Session, line: str, problem: Exception) -> Diagnostic:
    """What to say of an exception that nobody expected; keeps the session and the details."""
    told = " ".join(f"{type(problem).__name__}: {problem}".split())
    told = told if len(told) <= _TOLD else told[: _TOLD - 1] + "…"
    message = f"a fault of i2p, not of yours; the session goes on ({told})"
    return Diagnostic("fault", message, whole_file(INPUT), _kept(session, line, problem))


def _kept(session: Session, line: str, problem: Exception) -> str:
    """Writes details, story and script into a folder of the session's own; says what is where."""
    said, folder = [], session.kept
    for make in (_own_folder, _any_folder):
        with suppress(OSError):
            folder = folder or make()
    if folder is None:
        return "nothing could be written: `save` the session elsewhere"
    session.kept = folder
    with suppress(Exception):
        details = "".join(traceback.format_exception(problem))
        with (folder / "details.txt").open("a", encoding="utf-8", errors="replace") as file:
            file.write(f"> {line[:10_000]}\n{details}\n")
        said.append("the details")
    with suppress(Exception):
        text = session.state.program.text
        (folder / "session.story").write_text(text, encoding="utf-8", errors="replace")
        said.append("the story so far")
    path = session.state.path
    if path is not None and len(path.actions):
        # What is at fault may be needed for this as well.
        with suppress(Exception):
            session.workshop.saved(session, folder / "script.json")
            said.append("the script")
    return f"{', '.join(said)}: in {folder}"


def _own_folder() -> Path:
    from platformdirs import user_state_path

    name = f"{time.strftime('%Y%m%d-%H%M%S')}-{os.getpid()}"
    folder = user_state_path("i2pdsl") / "faults" / name
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def _any_folder() -> Path:
    return Path(tempfile.mkdtemp(prefix="i2p-fault-"))
