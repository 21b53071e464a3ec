"""Commands run in this process or in one of their own."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

I2P = [sys.executable, "-m", "i2pdsl"]


class Outcome(NamedTuple):
    """What a command did."""

    status: int
    out: str
    err: str


Run = Callable[..., Outcome]


def process(*arguments: str | Path, **options: Any) -> Outcome:
    """Runs a command as a process."""
    done = subprocess.run(
        [*I2P, *map(str, arguments)], capture_output=True, text=True, timeout=60, **options
    )
    assert "Traceback" not in done.stderr
    return Outcome(done.returncode, done.stdout, done.stderr)
