"""Every story told on a map is made, and meets the expectations written in it."""

from __future__ import annotations

from pathlib import Path

import pytest

from fuzz_for_tests import examples
from i2pdsl.pipeline import load
from stories_for_tests import MAPS, PATHS, check, expectations, name

SEEDS = examples(3)


@pytest.mark.parametrize("path", PATHS, ids=name)
def test_story_says_what_it_expects(path: Path) -> None:
    assert expectations(path), "every story carries its expectation"
    assert load(path).warnings == ()


@pytest.mark.parametrize("path", MAPS, ids=name)
def test_story_meets_its_expectations_on_a_few_seeds(path: Path) -> None:
    check(path, range(SEEDS))


@pytest.mark.slow
@pytest.mark.parametrize("path", MAPS, ids=name)
def test_story_meets_its_expectations_on_eight_seeds(path: Path) -> None:
    check(path, range(8))
