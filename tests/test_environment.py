"""What the user's environment asks of JAX, of processes and of signals."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import pytest

import i2pdsl
from commands_for_tests import I2P, PATIENCE, Run, process
from i2pdsl.cli import DONE, INTERRUPTED, WRONG, run_command
from i2pdsl.computing import computing

LEFT = (
    "world fork\nlength 3\nmaximize sum_t P(G_robot = left | script[:t])\nsearch beam(polish = 0)\n"
)


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder with a story."""
    monkeypatch.chdir(tmp_path)
    Path("left.story").write_text(LEFT, encoding="utf-8")
    return tmp_path


def solved(variables: dict[str, str]) -> tuple[bytes, str]:
    """The script of the story where these variables are set, and what is said."""
    done = process("run", "left.story", "--format", "", env={**os.environ, **variables})
    assert done.status == DONE, done.err
    said, _, _ = done.err.partition("wish ")  # the table of wishes comes last
    return Path("out/left/script.json").read_bytes(), said


# JAX.


@pytest.fixture(scope="module")
def usual(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The script where nothing is set: that of this process."""
    with pytest.MonkeyPatch.context() as here:
        here.chdir(tmp_path_factory.mktemp("usual"))
        Path("left.story").write_text(LEFT, encoding="utf-8")
        assert run_command(["run", "left.story", "--format", ""]) == DONE
        return Path("out/left/script.json").read_bytes()


def test_other_settings_of_jax_do_no_harm(place: Path, usual: bytes) -> None:
    assert solved({
        "JAX_DEBUG_NANS": "1",
        "JAX_DEFAULT_MATMUL_PRECISION": "bfloat16",
        "JAX_DEFAULT_PRNG_IMPL": "rbg",
        "JAX_DISABLE_JIT": "1",
        "JAX_ENABLE_X64": "1",
        "JAX_LOG_COMPILES": "1",
        "JAX_NO_TRACING": "1",
        "JAX_NUMPY_DTYPE_PROMOTION": "strict",
        "JAX_NUMPY_RANK_PROMOTION": "raise",
        "JAX_TRANSFER_GUARD": "disallow",
        "JAX_COMPILATION_CACHE_DIR": str(place / "left.story" / "nowhere"),
    }) == (usual, "")  # fmt: skip


def test_what_is_not_there_is_said_and_the_cpu_computes(place: Path, usual: bytes) -> None:
    script, said = solved({"JAX_PLATFORMS": "moon", "XLA_FLAGS": "--to_the_moon"})
    assert script == usual
    first, second = said.splitlines()
    assert first == "XLA_FLAGS=--to_the_moon is left out: Unknown flag in XLA_FLAGS: --to_the_moon"
    assert second.startswith("JAX_PLATFORMS=moon cannot be had here (")
    assert second.endswith("; computing on cpu")
    script, said = solved({"JAX_PLATFORMS": "", "JAX_PLATFORM_NAME": "moon"})
    assert script == usual
    assert said.startswith("JAX_PLATFORM_NAME=moon cannot be had here (")
    assert said.count("\n") == 1


@pytest.mark.parametrize(
    ("variable", "value"), [("JAX_ENABLE_X64", "perhaps"), ("JAX_NUMPY_RANK_PROMOTION", "perhaps")]
)
def test_what_jax_cannot_read_is_one_line(place: Path, variable: str, value: str) -> None:
    done = process("run", "left.story", env={**os.environ, variable: value})
    assert done.status == WRONG
    assert done.err.startswith("error: ")
    assert variable in done.err
    assert value in done.err
    assert done.err.count("\n") == 1


def test_settings_of_the_caller_are_as_before(place: Path) -> None:
    usual = i2pdsl.load("left.story").solve().script.record
    before = dict(jax.config.values)
    jax.config.update("jax_numpy_rank_promotion", "raise")
    jax.config.update("jax_compilation_cache_dir", str(place / "theirs"))
    theirs = dict(jax.config.values)
    try:
        with jax.numpy_dtype_promotion("strict"), jax.transfer_guard("disallow"):
            inside = dict(jax.config.values)
            assert i2pdsl.load("left.story").solve().script.record == usual
            assert dict(jax.config.values) == inside
        with computing():
            jax.config.update("jax_compilation_cache_dir", str(place / "ours"))
        assert dict(jax.config.values) == theirs
        with pytest.raises(ValueError, match="rank"):
            jnp.zeros(3) + jnp.zeros((3, 3))
    finally:
        for name in ("jax_numpy_rank_promotion", "jax_compilation_cache_dir"):
            jax.config.update(name, before[name])


# Processes.


FORK = """
import os, sys
import {first}
def score(): return i2pdsl.load("left.story").solve().score
if {warm}: score()
if os.fork() == 0:
    try: print(score() > 5, flush=True)
    except RuntimeError as problem: print(problem, flush=True)
    os._exit(0)
print(os.wait()[1])
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
@pytest.mark.parametrize("warm", [True, False])
def test_a_forked_process_never_hangs(place: Path, warm: bool) -> None:
    code = FORK.format(first="i2pdsl", warm=warm)
    command = [sys.executable, "-W", "ignore", "-c", code]
    done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE)
    said, status = done.stdout.splitlines()
    assert status == "0"
    assert ('multiprocessing.get_context("spawn")' in said) if warm else said == "True"


def test_a_pool_as_the_documentation_makes_it(place: Path) -> None:
    text = (Path(__file__).parent.parent / "docs" / "python.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"```python no-run\n(import multiprocessing\n.*?)```", text, re.DOTALL)
    Path("friend.story").write_text(LEFT, encoding="utf-8")
    Path("pool.py").write_text(code.replace("range(4)", "range(2)"), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "pool.py"], capture_output=True, text=True, timeout=PATIENCE
    )
    assert done.stderr == ""
    first, second = done.stdout.strip("[]\n").split(", ")
    assert float(first) == float(second) > 5


def test_no_imports_on_threads(place: Path) -> None:
    """Some of NumPy must not be imported on two threads: it would fail now and then."""
    hook = (
        "import sys, threading\n"
        "class Main:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        "        if threading.current_thread() is not threading.main_thread():\n"
        "            raise RuntimeError(name)\n"
        "sys.meta_path.insert(0, Main())\n"
    )
    Path("sitecustomize.py").write_text(hook, encoding="utf-8")
    paths = os.pathsep.join([str(place), os.environ.get("PYTHONPATH", "")])
    done = process("run", "left.story", "--format", "png", env={**os.environ, "PYTHONPATH": paths})
    assert (done.status, done.err.partition("wish ")[0]) == (DONE, "")
    assert Path("out/left/mind.png").is_file()


# Signals.


def stopped(name: str, number: int, command: list[str]) -> tuple[int, str]:
    """The status of a command that is sent a signal as it imports a module, and what it says."""
    hook = (
        "import os, sys\n"
        "class Send:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        f"        if name == {name!r}:\n"
        f"            sys.meta_path.remove(self); os.kill(os.getpid(), {number})\n"
        "sys.meta_path.insert(0, Send())\n"
    )
    Path("sitecustomize.py").write_text(hook, encoding="utf-8")
    paths = os.pathsep.join([os.getcwd(), os.environ.get("PYTHONPATH", "")])
    done = process(*command, env={**os.environ, "PYTHONPATH": paths})
    return done.status, done.err


MOMENTS = ["i2pdsl.commands.program", "click", "numpy", "jax", "jax._src.api", "numpy.ma.core"]


@pytest.mark.parametrize("module", MOMENTS)
def test_interrupted_while_something_is_imported(place: Path, module: str) -> None:
    command = ["run", "left.story", "--format", "png"]
    status, said = stopped(module, signal.SIGINT, command)
    assert status == INTERRUPTED
    assert said.startswith("interrupted")
    assert not [p for p in Path().rglob(".*") if p.is_file()]


@pytest.mark.parametrize("module", ["click", "numpy"])
def test_the_end_of_the_terminal_is_an_interrupt(place: Path, module: str) -> None:
    assert stopped(module, signal.SIGHUP, ["check", "left.story"])[0] in (INTERRUPTED, DONE)
    assert stopped(module, signal.SIGHUP, ["run", "left.story"]) == (INTERRUPTED, "interrupted\n")
    status, said = stopped(module, signal.SIGTERM, ["run", "left.story"])
    assert (status, said) == (-signal.SIGTERM, "")


def test_an_ignored_signal_stays_ignored(place: Path) -> None:
    """`nohup`, and what a shell puts into the background."""
    command = f"trap '' HUP INT; {' '.join(I2P)} check left.story & wait $!"
    hook = "import os; os.kill(os.getpid(), 1); os.kill(os.getpid(), 2)\n"
    Path("sitecustomize.py").write_text(hook, encoding="utf-8")
    paths = os.pathsep.join([str(place), os.environ.get("PYTHONPATH", "")])
    environment = {**os.environ, "PYTHONPATH": paths}
    done = subprocess.run(["sh", "-c", command], capture_output=True, text=True, env=environment)
    assert (done.returncode, done.stdout) == (DONE, "")
    assert "no mistakes" in done.stderr


def test_finished_seeds_are_kept_and_counted(
    place: Path, i2p: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    original = i2pdsl.Story.solve

    def solve(self: i2pdsl.Story, seed: int, *others: Any) -> i2pdsl.Result:
        if seed == 2:
            raise KeyboardInterrupt
        return original(self, seed, *others)

    monkeypatch.setattr(i2pdsl.Story, "solve", solve)
    done = i2p("run", "left.story", "--seeds", "0-3", "--format", "")
    assert done.status == INTERRUPTED
    assert "interrupted: nothing was found yet for left\n" in done.err
    assert done.err.endswith("interrupted: 2 of 4 scripts are finished and kept\n")
    assert Path("out/left/seed-1/script.json").is_file()


def test_a_training_that_has_nothing_yet_says_so(
    place: Path, i2p: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    from i2pdsl.worlds.hill import training

    def begun(*_: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(training, "train_hill", begun)
    done = i2p("train", "hill", "--out", "here")
    assert done == (INTERRUPTED, "", "interrupted before there was anything to keep\n")
