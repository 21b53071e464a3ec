"""Every story told on a map is made, and meets the expectations written in it."""

from __future__ import annotations

from pathlib import Path

import pytest

from fuzz_for_tests import examples
from i2pdsl.stories import load
from stories_for_tests import MAPS, PATHS, check, expectations, name

# Each is searched with others of its kind in `make test-all`: told by the same pattern as another
# one, with other values, or in a world of three as another; one is searched in seven lengths; and
# those whose patterns are made of what others have, too. What some of them add is tried on small
# maps: when something happens (test_requirements.py), pins (test_pins.py), walls (test_reach.py).
TWINS = (
    *("rivals", "unmasked", "alliance", "favourite", "matchmaker", "turncoat"),
    "park/shared-secret",
    *("hinder", "indifferent", "misjudged", "flashback-hinder", "icarus", "man-in-a-hole"),
    *("oedipus", "rags-to-riches", "riches-to-rags", "change-of-heart"),
    *("cinderella", "foreshadowing", "from-afar", "flashback-help", "reveal", "surprising"),
    *("guard", "suspenseful", "maze/shared-secret", "doorkeeper"),
    *("the-push", "key-poses", "estate/chase", "helping-hand"),
)


def is_twin(path: Path) -> bool:
    return path.stem in TWINS or name(path) in TWINS


@pytest.mark.parametrize("path", PATHS, ids=name)
def test_story_says_what_it_expects(path: Path) -> None:
    assert expectations(path), "every story carries its expectation"
    assert load(path).warnings == ()


@pytest.mark.parametrize(
    "path",
    [pytest.param(p, marks=pytest.mark.slow) if is_twin(p) else p for p in MAPS],
    ids=name,
)
def test_story_meets_its_expectations_on_a_few_seeds(path: Path) -> None:
    check(path, range(3 if is_twin(path) else examples(3)))


@pytest.mark.slow
@pytest.mark.parametrize("path", MAPS, ids=name)
def test_story_meets_its_expectations_on_eight_seeds(path: Path) -> None:
    check(path, range(8))
