"""Every story told in a plane is made, and meets the expectations written in it."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest

from fuzz_for_tests import examples
from i2pdsl.search import descent
from stories_for_tests import PLANE, check, expectations, name, story

ALONE = [p for p in PLANE if len(story(p).spec.characters) == 1]  # quickly compiled
TOGETHER = [p for p in PLANE if p not in ALONE]


@pytest.mark.parametrize(
    "path",  # `legible` is searched on a map in `make test` (test_stories.py)
    [pytest.param(p, marks=pytest.mark.slow) if p.stem == "legible" else p for p in ALONE],
    ids=name,
)
def test_one_character_meets_its_expectations(path: Path) -> None:
    check(path, range(examples(3)))


def test_a_few_steps_are_enough_to_help(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two scripts of a tenth of the work. Whether the little one is there at the end is chance; it
    is believed to be helped, both are seen to act, and they touch."""
    monkeypatch.setattr(descent, "BRIEF_FRAMES", math.inf)  # more time would go into compiling
    (path,) = (p for p in TOGETHER if p.stem == "help")
    told = story(path)
    plan = replace(told.typed.search, seeds=2, steps=40)
    script = replace(told, typed=replace(told.typed, search=plan)).solve(seed=0).script
    for expected in expectations(path):
        if expected.expression.startswith("mean_t P("):
            value = float(script.query(expected.expression, expected.assume))
            assert expected.holds(value), (expected, value)
    assert float(script.query("sum_t [progress(little, nest) @ script[t]]")) > 0
    assert float(script.query("mean_t [touching(little, big) @ script[t]]")) > 0.1


@pytest.mark.slow
@pytest.mark.parametrize("path", TOGETHER, ids=name)
def test_two_characters_meet_their_expectations(path: Path) -> None:
    check(path, range(3))
