"""Commands run in this process or in one of their own."""

from __future__ import annotations

import os
import pty
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

I2P = [sys.executable, "-m", "i2pdsl"]
PATIENCE = 600  # seconds after which something hangs, however busy the machine is


class Outcome(NamedTuple):
    """What a command did."""

    status: int
    out: str
    err: str


Run = Callable[..., Outcome]


def process(*arguments: str | Path, **options: Any) -> Outcome:
    """Runs a command as a process."""
    done = subprocess.run(
        [*I2P, *map(str, arguments)], capture_output=True, text=True, timeout=PATIENCE, **options
    )
    assert "Traceback" not in done.stderr
    return Outcome(done.returncode, done.stdout, done.stderr)


def on_a_terminal(
    *arguments: str | Path, until: str = "", sent: int = signal.SIGINT, **options: Any
) -> Outcome:
    """Runs a command with standard output in a pipe and standard error on a terminal.

    As soon as the terminal shows `until` (a bar, say), the command is sent a signal: however busy
    the machine is, there is something by then, and not yet everything.
    """
    leader, follower = pty.openpty()
    with subprocess.Popen(
        [*I2P, *map(str, arguments)], stdout=subprocess.PIPE, stderr=follower, text=True, **options
    ) as running:
        os.close(follower)
        shown, waiting = b"", bool(until)
        while True:
            try:
                part = os.read(leader, 4096)
            except OSError:  # the terminal's other end is closed
                break
            if not part:
                break
            shown += part
            if waiting and until.encode() in shown:
                running.send_signal(sent)
                waiting = False
        assert running.stdout is not None
        out = running.stdout.read()
    os.close(leader)
    err = shown.decode(errors="replace")
    assert "Traceback" not in err
    assert not waiting, err
    return Outcome(running.returncode, out, err)
