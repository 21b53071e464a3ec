"""Shared by all tests: the caches of a test run do not touch the user's."""

from __future__ import annotations

import gc
import os
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

os.environ.setdefault("I2PDSL_CACHE", str(Path(tempfile.gettempdir()) / "i2pdsl-test-cache"))
# Threads of a BLAS wait for each other by spinning: on a busy machine that takes 40 times as long
# as the products of our small matrices.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# What tests compute by JAX themselves is single operations and what is run a few times: most of
# their time goes into compiling. Our own programs have options of their own (programs.py); but
# that all processors make one program takes a quarter more of their time, and all are at work.
os.environ.setdefault(
    "XLA_FLAGS", "--xla_cpu_use_fusion_emitters=false --xla_cpu_parallel_codegen_split_count=1"
)
os.environ.setdefault("JAX_DISABLE_MOST_OPTIMIZATIONS", "1")
# Where it is set, each of a hundred processes would compile our sources anew.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

import pytest

from commands_for_tests import I2P, Outcome, Run

sys.dont_write_bytecode = False

# Files that take longest, begun first where several workers share them (`--dist loadfile`).
LONGEST = (
    *("test_studio_desk", "test_descent", "test_docs", "test_stories", "test_beam", "test_cli"),
    *("test_studio_talk", "test_terminal", "test_catalogue", "test_page", "test_environment"),
    *("test_factors", "test_session", "test_fit", "test_studio_agree", "test_particles"),
    *("test_sweep", "test_pipeline", "test_pictures", "test_kit", "test_cli_hill"),
    *("test_against_reference", "test_three", "test_magic", "test_actor_critic", "test_programs"),
    *("test_computed", "test_notebooks", "test_speed_of_checking", "test_value_iteration"),
    *("test_grid_rules", "test_studio_moving", "test_pins", "test_hill", "test_children"),
)


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(collector: pytest.Collector) -> Iterator[None]:
    """What one worker compiles another need not: every other one collects from the end."""
    report: Any = yield
    worker = getattr(collector.config, "workerinput", {}).get("workerid", "gw0")
    if isinstance(collector, pytest.Directory) and int(worker.removeprefix("gw")) % 2:
        report.result.reverse()
    return report


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if hasattr(config, "workerinput"):
        place = {name: number for number, name in enumerate(LONGEST)}
        items.sort(key=lambda item: (place.get(item.path.stem, len(LONGEST)), item.path))


def pytest_collection_finish(session: pytest.Session) -> None:
    """What is there once all tests are collected stays: the collector of garbage, which would look
    at it hundreds of times, took a seventh of the time of a run."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(20_000, 20, 20)


PLANNED = "I2PDSL_TESTS_PLANNED"  # the name of the file that says that the kitchen is planned
ELSEWHERE = ("test_studio_desk", "test_descent")  # what begins, and does not play in the kitchen


def pytest_configure(config: pytest.Config) -> None:
    """The workers of a run share its cache. The kitchen's plan, which takes longest and which many
    tests need, is made while they collect what there is to test, not by each of them."""
    is_worker = hasattr(config, "workerinput")
    if config.getoption("numprocesses", None) and not is_worker and not config.option.collectonly:
        path = Path(tempfile.mkdtemp()) / "planned"
        os.environ[PLANNED] = str(path)
        config.add_cleanup(lambda: shutil.rmtree(path.parent, ignore_errors=True))
        planning = subprocess.Popen([*I2P, "plan", "kitchen"], stdout=subprocess.DEVNULL)

        def tell() -> None:
            planning.wait()  # if it fails, tests plan for themselves, and say what is wrong
            with suppress(OSError):  # of a run that is over
                path.touch()

        threading.Thread(target=tell, daemon=True).start()


def pytest_runtest_setup(item: pytest.Item) -> None:
    path = os.environ.get(PLANNED)
    if path and hasattr(item.config, "workerinput") and item.path.stem not in ELSEWHERE:
        while not Path(path).exists():
            time.sleep(0.1)


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


@pytest.fixture
def search_once() -> Iterator[None]:
    """For tests that any script will do for."""
    from searches_for_tests import searching_once

    with searching_once():
        yield
