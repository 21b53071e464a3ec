"""Shared by all tests: the caches of a test run do not touch the user's."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

os.environ.setdefault("I2PDSL_CACHE", str(Path(tempfile.gettempdir()) / "i2pdsl-test-cache"))

import pytest

from commands_for_tests import Outcome, Run


@pytest.fixture
def i2p(capfd: pytest.CaptureFixture[str]) -> Run:
    """Runs a command in this process."""
    from i2pdsl import cli

    def run(*arguments: str | Path) -> Outcome:
        capfd.readouterr()
        status = cli.run_command([str(a) for a in arguments])
        out, err = capfd.readouterr()
        assert "Traceback" not in err
        return Outcome(status, out, err)

    return run
