"""What is written is there whole or not at all, and killed processes' rests are cleared away."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from commands_for_tests import I2P, PATIENCE, Run
from i2pdsl import resources
from i2pdsl.resources import atomic_path, cache_folder, write_text

KILLED = """
import os, signal, sys
from pathlib import Path
from i2pdsl.resources import atomic_path
with atomic_path(Path(sys.argv[1])) as temporary:
    temporary.write_text("half")
    os.kill(os.getpid(), signal.SIGKILL)
"""


def left_by_a_killed_process(path: Path, age: float) -> Path:
    """A temporary file, as a process leaves it that is killed while it writes."""
    before = set(path.parent.iterdir()) if path.parent.exists() else set()
    done = subprocess.run([sys.executable, "-c", KILLED, str(path)], timeout=PATIENCE)
    assert done.returncode == -signal.SIGKILL
    (rest,) = set(path.parent.iterdir()) - before
    assert rest.suffix == path.suffix, "writers choose their format by it"
    then = time.time() - age
    os.utime(rest, (then, then))
    return rest


@pytest.mark.parametrize("suffix", [".npz", "", ".tar.gz"])
def test_old_temporary_files_are_removed_where_something_is_written(
    suffix: str, tmp_path: Path
) -> None:
    old = left_by_a_killed_process(tmp_path / f"a plan{suffix}", 2 * 3600)
    new = left_by_a_killed_process(tmp_path / f"a plan{suffix}", 60)
    write_text(tmp_path / "other.txt", "x")
    assert not old.exists()
    assert new.exists(), "somebody may be writing it"
    assert {p.name for p in tmp_path.iterdir()} == {new.name, "other.txt"}


def test_in_caches_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import numpy as np

    from i2pdsl.planning import store

    monkeypatch.setenv("I2PDSL_CACHE", str(tmp_path))
    old = left_by_a_killed_process(cache_folder("plans") / "x.npz", 2 * 3600)
    store.save("y", {"a": np.zeros(1)})
    assert not old.exists()


def test_nothing_else_is_removed(tmp_path: Path) -> None:
    """What only looks alike, what is no file of ours, and what links lead to."""
    old = left_by_a_killed_process(tmp_path / "x.txt", 2 * 3600)
    name = old.name
    kept = [
        name[1:], f"my{name}", name.upper(), name.replace("new-", "new-1"),
        ".i2p-new-", ".i2p-new-abc.txt", ".x-abcdefgh.txt",
    ]  # fmt: skip
    for other in kept:
        (tmp_path / other).write_text("mine")
    precious = tmp_path / "precious"
    precious.write_text("mine")
    (tmp_path / ".i2p-new-aaaaaaaa.txt").symlink_to(precious)
    (tmp_path / ".i2p-new-bbbbbbbb").mkdir()
    for path in tmp_path.iterdir():
        if path != old:
            os.utime(path, (1, 1), follow_symlinks=False)
    write_text(tmp_path / "new.txt", "x")
    assert not old.exists()
    assert precious.read_text() == "mine"
    for other in (*kept, ".i2p-new-aaaaaaaa.txt", ".i2p-new-bbbbbbbb"):
        assert os.path.lexists(tmp_path / other), other


def test_a_full_disk_names_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "new" / "a.txt"
    full = OSError(errno.ENOSPC, "No space left on device")
    for problem in (full, OSError(errno.ENOSPC, "No space left on device", "x", None, ".i2p-new-")):
        with pytest.raises(OSError, match="No space left") as caught, atomic_path(path):
            raise problem
        assert caught.value.filename == str(path)
        assert caught.value.errno == errno.ENOSPC
    with pytest.raises(PermissionError) as other, atomic_path(path):
        raise PermissionError(errno.EACCES, "Permission denied", "another.txt")
    assert other.value.filename == "another.txt"

    def refuses(**_: object) -> None:
        raise OSError(errno.EDQUOT, "Disk quota exceeded", str(tmp_path / "new" / ".i2p-new-x"))

    monkeypatch.setattr(resources.tempfile, "mkstemp", refuses)
    with pytest.raises(OSError, match="quota") as caught:
        write_text(path, "x")
    assert caught.value.filename == str(path)
    assert list(path.parent.iterdir()) == []


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
@pytest.mark.parametrize(
    "arguments", [["worlds"], ["worlds", "--json"], ["completion", "bash"], ["fmt", "-"]]
)
def test_full_standard_output(arguments: list[str]) -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [*I2P, *arguments], stdout=full, stderr=subprocess.PIPE, text=True, timeout=PATIENCE,
            input="world kitchen\n",
        )  # fmt: skip
    assert done.returncode == 1
    assert done.stderr == "error: No space left on device\n"


def test_a_picture_that_cannot_be_written_is_named(
    tmp_path: Path, i2p: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One line, whichever library writes."""
    from PIL import Image

    story = tmp_path / "s.story"
    story.write_text("world fork\nlength 2\nmaximize depict(G_robot = left)\n"
                     "search beam(starts = 1, width = 1)\n")  # fmt: skip
    script = tmp_path / "out" / "s" / "script.json"
    assert i2p("run", story, "--out", tmp_path / "out", "--format", "").status == 0

    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Image.Image, "save", full)
    done = i2p("render", script, "--format", "png", "--out", tmp_path / "drawn")
    assert done.status == 1
    assert done.err == f"error: No space left on device: {tmp_path / 'drawn' / 'mind.png'}\n"
    assert [p.name for p in (tmp_path / "drawn").iterdir()] == ["comic.png"]
