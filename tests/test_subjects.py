"""What a story speaks of: masks of hypotheses, back in words of latents."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from i2pdsl.language import typed as ty
from i2pdsl.language.story import default_assumption
from i2pdsl.language.vocabulary import Value, Vocabulary
from i2pdsl.objective.subjects import Subject, claims, latents_of, subjects_of
from i2pdsl.render.focus import _changes, _extremes, _with_rest
from i2pdsl.stories import load
from i2pdsl.worlds.find import find_vocabulary

STORIES = Path(__file__).parent.parent / "stories"


def kitchen() -> Vocabulary:
    found = find_vocabulary("kitchen", None)
    assert found is not None
    return found


def mask(words: Vocabulary, **wanted: set[Value]) -> ty.Mask:
    return tuple(all(row.get(x) in vs for x, vs in wanted.items()) for row in words.hypotheses)


@pytest.mark.parametrize("assume", [True, False])
def test_a_conjunction_comes_back_as_it_was_said(assume: bool) -> None:
    """Whether or not everybody is taken to be rational: that follows, and is not said."""
    words = kitchen()
    within = default_assumption(words) if assume else (True,) * len(words.hypotheses)
    for wanted in (
        {"rho": (1.0, 3.0)},
        {"G_cheese": ("pink",)},
        {"G_robot": ("none", "green")},
        {"G_cheese": ("green",), "rho": (-3.0, -1.0)},
    ):
        event = mask(words, **{x: set(vs) for x, vs in wanted.items()})
        found = claims(words, event, within)
        assert found is not None
        assert {x: set(vs) for x, vs in found.items()} == {x: set(vs) for x, vs in wanted.items()}
    assert claims(words, (True,) * len(words.hypotheses), within) == {}


def test_what_is_no_conjunction_has_no_words() -> None:
    words = kitchen()
    either = zip(mask(words, rho={1.0, 3.0}), mask(words, G_cheese={"pink"}), strict=True)
    event = tuple(a != b for a, b in either)
    assert claims(words, event, default_assumption(words)) is None


@pytest.mark.parametrize(
    ("story", "latents"),
    [
        ("kitchen/betrayal", ["rho", "rho"]),
        ("kitchen/mystery", ["G_robot"]),
        ("kitchen/irony", ["G_cheese", "rho", "rho"]),
        ("kitchen/arc", []),
        ("maze/suspenseful", ["rho"]),
        ("plane/chase", ["G_sheep", "G_wolf"]),
        ("hill/mime", ["weight", "will"] * 9),  # told to nine
    ],
)
def test_the_subjects_of_stories(story: str, latents: list[str]) -> None:
    typed = load(STORIES / f"{story}.story").typed
    subjects = subjects_of(typed)
    assert [x for s in subjects for x in latents_of(typed.vocabulary, s)] == latents
    assert len(set(subjects)) == len(subjects) >= 1


def test_turns_of_beliefs_and_fortunes() -> None:
    belief = np.array([0.5, 0.7, 0.9, 0.9, 0.5, 0.1, 0.1, 0.5, 0.3])
    assert _changes(belief) == [(1, True), (5, False)]
    assert _changes(np.full(5, 0.9)) == []
    rising_then_falling = np.array([0.0, 5, 4.5, 10, 9.8, 3, 3.5, 0, 7])
    assert _extremes(rising_then_falling) == [0, 3, 7, 8]
    assert _extremes(np.full(6, 2.0)) == []


def test_what_everybody_knows_all_along_is_not_said_again() -> None:
    """A wish conditions every belief of the story; where conditions differ, they are said."""
    words = kitchen()
    known = mask(words, G_cheese={"pink"})
    events = [Subject(mask(words, rho=vs), known) for vs in ({1.0, 3.0}, {-3.0, -1.0})]
    *same, rest = _with_rest(events)
    assert same == events
    assert claims(words, rest.about, default_assumption(words)) == {"rho": (0.0,)}
    whole = Subject(
        tuple(not any(pair) for pair in zip(events[0].about, known, strict=True)), known
    )
    assert _with_rest([Subject((True,) * len(known), known), whole])[2:] == []
