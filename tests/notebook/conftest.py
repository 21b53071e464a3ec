"""A shell of IPython in this process, a small story, and Chromium."""

from __future__ import annotations

import atexit
import gc
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from i2pdsl.stories import Result, Script, load
from render.conftest import chromium, open_page, usual

__all__ = ["chromium", "open_page", "usual"]  # fixtures

FRIEND = """world maze
length 6

let friend = rho > 0

maximize depict(friend)
search beam(starts = 50, polish = 1)
"""


class Cell(NamedTuple):
    """What became of a cell."""

    success: bool
    out: str
    err: str
    shown: list[dict[str, Any]]
    value: Any
    error: BaseException | None


class Notebook:
    """Cells run one after the other in one shell."""

    def __init__(self, shell: Any):
        self.shell = shell
        self.names = shell.user_ns

    def run(self, cell: str) -> Cell:
        from IPython.utils.capture import capture_output

        with capture_output() as said:
            done = self.shell.run_cell(cell)
        error = done.error_before_exec or done.error_in_exec
        shown = [output.data for output in said.outputs]
        return Cell(done.success, said.stdout, said.stderr, shown, done.result, error)


@pytest.fixture
def notebook(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Notebook]:
    """A fresh shell in a folder of its own, with the magics loaded."""
    from IPython.core.interactiveshell import InteractiveShell
    from traitlets.config import Config

    monkeypatch.setenv("IPYTHONDIR", str(tmp_path / "ipython"))
    monkeypatch.chdir(tmp_path)
    settings = Config()
    settings.HistoryManager.enabled = False
    shell = InteractiveShell.instance(config=settings)
    book = Notebook(shell)
    assert book.run("%load_ext i2pdsl").success
    yield book
    with monkeypatch.context() as patched:
        patched.setattr(gc, "collect", lambda: 0)  # of all that other tests have left
        shell.atexit_operations()
    atexit.unregister(shell.atexit_operations)  # or it is done once more, and fails
    InteractiveShell.clear_instance()


@pytest.fixture(scope="session")
def friend(tmp_path_factory: pytest.TempPathFactory) -> Result:
    """A solved story in the maze."""
    path = tmp_path_factory.mktemp("friend") / "friend.story"
    path.write_text(FRIEND, encoding="utf-8")
    return load(path).solve(seed=0, candidates=3)


@pytest.fixture(scope="session")
def hill(tmp_path_factory: pytest.TempPathFactory) -> Script:
    """A few frames of the hopper."""
    path = tmp_path_factory.mktemp("hill") / "haul.story"
    path.write_text("world hill(weight = 0.1)\nlength 12\nsearch naive\n", encoding="utf-8")
    return load(path).solve(seed=0).script
