"""What stories under stories/ expect of themselves, and whether a finished script meets it.

A story's comment `# expect EXPR >= NUMBER` (or `<=`) is asked of the finished script; `# expect
assume COND: ...` asks under another assumption. Two words stand for what is seen: `still`, the
share of frames in which nothing moves, and `luck`, the greatest run of luck in nats
(objective/film.py).
The bar is meant for the median over 8 seeds.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from i2pdsl.language.vocabulary import Weights
from i2pdsl.objective.film import film_of
from i2pdsl.stories import Story, load
from searches_for_tests import with_polish
from worlds_for_tests import STORIES

BARE = "".join(f"{term} 0\n" for term in Weights._fields)
"""Statements that leave the objective as it was written."""

BRIEFLY = 3  # of the default's 11

EXPECTATION = re.compile(
    r"^# expect (?:assume (?P<assume>[^:]+): )?(?P<expr>.+) (?P<op>[<>]=) (?P<bar>\S+)$"
)


@dataclass(frozen=True)
class Expectation:
    """One `# expect` line."""

    expression: str
    operator: str
    bar: float
    assume: str | None

    def holds(self, value: float) -> bool:
        return value >= self.bar if self.operator == ">=" else value <= self.bar


def expectations(path: Path) -> list[Expectation]:
    found = []
    for line in path.read_text(encoding="utf-8").splitlines():
        if line.startswith("# expect"):
            match = EXPECTATION.match(line)
            assert match is not None, f"{path}: cannot read {line!r}"
            bar = float(match["bar"])
            found.append(Expectation(match["expr"], match["op"], bar, match["assume"]))
    return found


PATHS = sorted(p for p in STORIES.rglob("*.story") if p.parent.name != "patterns")
HILL = [p for p in PATHS if p.parent.name == "hill"]
PLANE = [p for p in PATHS if p.parent.name == "plane"]
MAPS = [p for p in PATHS if p not in (*HILL, *PLANE)]


def name(path: Path) -> str:
    """Of a test."""
    return f"{path.parent.name}/{path.stem}"


@cache
def story(path: Path) -> Story:
    return with_polish(load(path), BRIEFLY)


@cache
def measured(path: Path, seed: int) -> tuple[float, ...]:
    script = story(path).solve(seed).script
    film = film_of(script.world, script.frames)
    seen = {"still": script.still, "luck": film.luck.max(initial=0.0)}

    def value(asked: Expectation) -> float:
        if asked.expression in seen:
            return float(seen[asked.expression])
        return float(script.query(asked.expression, asked.assume))

    return tuple(map(value, expectations(path)))


def check(path: Path, seeds: range) -> None:
    values = np.array([measured(path, seed) for seed in seeds])
    for number, expectation in enumerate(expectations(path)):
        median = float(np.median(values[:, number]))
        shown = f"{expectation.expression}: median {median:.4f} over {len(seeds)} seeds"
        assert expectation.holds(median), (
            f"{shown}, must be {expectation.operator} {expectation.bar}"
        )
