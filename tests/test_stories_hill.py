"""Every story of the hill is made, and meets the expectations written in it.

A file of its own, so that it is made beside the others (`pytest --dist loadfile`). A descent
improves several scripts at once, so one of its seeds is enough where there is little time; it
takes a minute, so that only the honest stories are made then.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from stories_for_tests import HILL, check, name

AT_ONCE = ("honest-light", "honest-heavy")


@pytest.mark.parametrize(
    "path",
    [p if p.stem in AT_ONCE else pytest.param(p, marks=pytest.mark.slow) for p in HILL],
    ids=name,
)
def test_story_meets_its_expectations_on_a_seed(path: Path) -> None:
    check(path, range(1))


@pytest.mark.slow
@pytest.mark.parametrize("path", HILL, ids=name)
def test_story_meets_its_expectations_on_eight_seeds(path: Path) -> None:
    check(path, range(8))
