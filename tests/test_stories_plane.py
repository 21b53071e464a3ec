"""Every story told in a plane is made, and meets the expectations written in it."""

from __future__ import annotations

from pathlib import Path

import pytest

from fuzz_for_tests import examples
from stories_for_tests import PLANE, check, name, story

ALONE = [p for p in PLANE if len(story(p).spec.characters) == 1]  # quickly compiled
TOGETHER = [p for p in PLANE if p not in ALONE]


@pytest.mark.parametrize("path", ALONE, ids=name)
def test_one_character_meets_its_expectations(path: Path) -> None:
    check(path, range(examples(3)))


@pytest.mark.slow
@pytest.mark.parametrize("path", TOGETHER, ids=name)
def test_two_characters_meet_their_expectations(path: Path) -> None:
    check(path, range(3))
