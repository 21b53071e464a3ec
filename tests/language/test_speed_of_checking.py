"""Checking answers at once: no array library is loaded, and long stories cost little."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import pytest

from i2pdsl.errors import Source
from i2pdsl.language.check import TypedStory, check_source
from i2pdsl.worlds.find import find_vocabulary

ROOT = Path(__file__).parents[2]
CHECK = """
import sys, pathlib
from i2pdsl.errors import Source
from i2pdsl.language.check import check_source
from i2pdsl.language.format import format_source
from i2pdsl.language.query import check_query
from i2pdsl.worlds.find import find_vocabulary
for path in sorted(pathlib.Path("stories/kitchen").glob("*.story")):
    source = Source(str(path), path.read_text())
    check_source(source, find_vocabulary, path.parent)
    format_source(source)
heavy = {"jax", "numpy", "matplotlib", "PIL", "scipy"} & set(sys.modules)
print(",".join(sorted(heavy)) or "none")
"""


def best_of(count: int, text: str) -> float:
    """The least seconds that checking a text takes, after start-up."""
    source = Source("timed.story", text)
    check_source(source, find_vocabulary)
    times = []
    for _ in range(count):
        began = time.perf_counter()
        assert isinstance(check_source(source, find_vocabulary), TypedStory)
        times.append(time.perf_counter() - began)
    return min(times)


def test_checking_loads_no_array_library() -> None:
    result = subprocess.run(
        [sys.executable, "-c", CHECK], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert result.stdout.strip() == "none"


@pytest.mark.parametrize("path", sorted((ROOT / "stories" / "kitchen").glob("*.story")))
def test_a_story_is_checked_in_ten_milliseconds(path: Path) -> None:
    assert best_of(5, path.read_text(encoding="utf-8")) < 0.01


@pytest.mark.parametrize(
    "objective",
    [
        "sum_t P(rho > 0 | script[:t])",
        "arc(robot)",
        "twist(rho > 0, rho < 0)",
        "sum_t P(rho > 0 | script[:T-t]) * points((0, 0), (0.3, 1), (1, -1))",
        "sum_t (if 3 <= t <= 50000 then sin(t/T) * surprise(script[t]) else 1/(t - 4))",
        "sum_t P(rho > 0 | script[:abs(t - 5)])",
    ],
)
def test_a_story_of_100_000_frames_is_checked_in_a_second(objective: str) -> None:
    assert best_of(2, f"world kitchen\nlength 100000\nmaximize {objective}") < 1


def test_hundreds_of_statements() -> None:
    lines = [
        f"let e{i} = rho > 0 and G_cheese = pink\n"
        f"# Documentation.\npattern q{i}(x) = depict(x) + {i}\nmaximize q{i}(e{i})\n"
        for i in range(300)
    ]
    assert best_of(1, "world kitchen\nlength 100000\n" + "".join(lines)) < 3
