"""Beats, against all the ways to cut a film."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from i2pdsl.errors import Source, StoryError
from i2pdsl.language.check import Library, TypedStory, check_source
from i2pdsl.objective.beats import begun, best, cut, further
from i2pdsl.objective.replay import evaluate, replay
from i2pdsl.objective.wishes import shares
from i2pdsl.stories import Story
from i2pdsl.worlds.grid.world import GridWorld
from stories_for_tests import BARE
from worlds_for_tests import CORRIDOR, planned, trajectory


def cuts(frames: int, count: int, least: int) -> list[tuple[int, ...]]:
    """How many frames each beat may have, in all ways."""
    lengths = itertools.product(range(least, frames + 1), repeat=count)
    return [each for each in lengths if sum(each) == frames]


def worth(values: np.ndarray, lengths: tuple[int, ...]) -> float:
    beats = np.repeat(np.arange(len(lengths)), lengths)
    return float(values[np.arange(len(beats)), beats].sum())


@pytest.mark.parametrize(("count", "least"), [(2, 1), (2, 3), (3, 1), (3, 2), (4, 2)])
def test_the_best_cut_is_found_frame_by_frame(count: int, least: int) -> None:
    frames = 9
    generator = np.random.default_rng(count + least)
    for _ in range(20):
        values = generator.normal(size=(frames, count))
        cells = begun(np, count, least, float)
        for number in range(1, frames + 1):
            cells = further(cells, values[number - 1], least)
            # A prefix is worth the best of those cuts of the whole film that agree with it.
            whole = (worth(values[:number], _first(c, number)) for c in cuts(frames, count, least))
            assert best(cells, frames - number, least) == pytest.approx(max(whole))
        found = np.bincount(cut(values, least), minlength=count)
        assert tuple(found) in cuts(frames, count, least)
        assert worth(values, tuple(found)) == pytest.approx(best(cells, 0, least))


def _first(lengths: tuple[int, ...], frames: int) -> tuple[int, ...]:
    """A cut of a film as one of its first frames."""
    beats = np.repeat(np.arange(len(lengths)), lengths)[:frames]
    return tuple(np.bincount(beats, minlength=len(lengths)))


def world() -> GridWorld:
    return planned(CORRIDOR, "corridor")


def story(*lines: str, length: int = 6) -> TypedStory:
    text = "\n".join((f"world corridor\nlength {length}", *lines))
    checked = check_source(Source("s.story", text), lambda *_: world().vocabulary)
    assert not isinstance(checked, Library)
    return checked


def test_beats_are_sums_that_take_turns() -> None:
    here = world()
    left, right = (
        "depict(G_one = left)",
        "2 * sum_t [moved(one) @ script[t]] - depict(G_one = left)",
    )
    typed = story(f"maximize beats({left}, {right})", f"maximize {left}", f"maximize {right}")
    path = trajectory(here, 2, np.array([3, 3, 4, 2, 0, 2]))
    frames = replay(here, path.states, path.actions)
    both, *each = (value for _, value in typed.objective)
    values = np.stack([shares(here, frames, value)[1:] for value in each], axis=-1)
    expected = max(worth(values, lengths) for lengths in cuts(6, 2, 1))
    assert evaluate(here, frames, both, None) == pytest.approx(expected)
    assert shares(here, frames, both).sum() == pytest.approx(expected)


def test_the_search_reaches_the_best_cut() -> None:
    there = "sum_t [at(one, {}) @ script[t]]".format
    typed = story(
        BARE + f"maximize beats({there('left')}, {there('right')})",
        "start at(one, (1, 0))",
        "search beam(starts = 5, polish = 1)",
        length=8,
    )
    found = Story(typed, known=world().spec).solve(choose="score")
    # A beat has two frames at least: it goes to the right end in those of the first one, or stays
    # at the left end until those of the second one.
    assert found.score == 6


WRONG = {
    "beats(depict(G_one = left))": "takes at least 2 arguments",
    "beats(depict(G_one = left), 3)": "a beat is a sum over all t",
    "beats(depict(G_one = left), mean_t t)": "a beat is a sum over all t",
    "beats(depict(G_one = left), sum_{t in 2..T} t)": "a beat is a sum over all t",
    "sum_t beats(sum_t t, sum_t 1)": "beats cannot stand inside a sum over t",
    "beats(P(G_one = left | script[:t]), sum_t 1)": "`t` means nothing outside a sum",
    "beats(sum_t 1, sum_t 2, sum_t 3, sum_t 4, sum_t 5, sum_t 6, sum_t 7)": "7 beats need 7 frames",
}


@pytest.mark.parametrize("text", WRONG)
def test_what_is_no_beat_is_refused(text: str) -> None:
    with pytest.raises(StoryError) as caught:
        story(f"maximize {text}")
    assert WRONG[text] in str(caught.value)
