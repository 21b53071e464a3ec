"""Comics show the frames that matter, and no more panels than there is to see."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from i2pdsl.render.key_frames import ALIKE, EVEN, SAME, USUAL, evenly, key_frames, minds
from i2pdsl.render.mind import Panel, Series


def steps(last: int, *jumps: int) -> np.ndarray:
    """A curve that rises by one at each of the given frames."""
    return np.array([sum(t >= jump for jump in jumps) for t in range(last + 1)], float)


def test_key_frames_are_the_change_points_of_a_step_curve() -> None:
    assert key_frames([steps(30, 4, 5, 17, 23)], [], 30, 8) == [0, 4, 5, 17, 23, 30]
    assert key_frames([steps(30, 4, 17), steps(30, 9)], [], 30, 5) == [0, 4, 9, 17, 30]


def test_larger_changes_win() -> None:
    curve = steps(20, 3) + 0.2 * steps(20, 8) + steps(20, 12)
    assert key_frames([curve], [], 20, 4) == [0, 3, 12, 20]


def test_no_two_neighbours_are_alike() -> None:
    """Where nothing is seen nor learnt, a panel fewer tells as much."""
    assert key_frames([steps(25, 3)], [], 25, 8) == [0, 3, 25]
    assert key_frames([np.zeros(26)], [], 25, 8) == [0, 25]
    assert key_frames([np.zeros(26)], [np.linspace(0, 1, 26)], 25, 8) == [0, 25]
    assert key_frames([np.zeros(26)], [np.linspace(0, 1, 26)], 25, 8, {9: 1.0}) == [0, 9, 25]


def test_what_matters_is_shown_for_certain() -> None:
    curve = steps(25, *range(1, 7))
    chosen = key_frames([curve], [], 25, 5, {14: 3.0, 20: 2.0})
    assert {0, 14, 20, 25} <= set(chosen)
    assert len(chosen) == 5
    assert key_frames([curve], [], 25, 3, {14: 3.0, 20: 2.0}) == [0, 14, 25]
    assert key_frames([np.zeros(101)], [], 100, 8, {50: 3.0, 51: 2.0, 99: 1.0}) == [0, 50, 100]


def test_ties_go_to_frames_that_are_worth_seeing() -> None:
    ramp = np.linspace(0, 1, 13)
    assert 5 not in key_frames([ramp], [], 12, 4)
    assert 5 in key_frames([ramp], [], 12, 4, glimpses={5: 0.5})


def test_they_are_the_best_of_all() -> None:
    rng = np.random.default_rng(5)
    for _ in range(5):
        curve, glimpse = rng.uniform(0, 1, 10), int(rng.integers(1, 9))

        def cost(frames: tuple[int, ...], curve: np.ndarray = curve, seen: int = glimpse) -> float:
            held = np.repeat(curve[list(frames[:-1])], np.diff(frames))
            squares = ((curve[:9] - held) ** 2).sum() * USUAL / 10
            uneven = EVEN * (np.diff(frames) ** 2).sum() / 81
            alike = (np.diff(curve[list(frames[:-1])]) ** 2 < SAME).sum()
            return float(squares + uneven + ALIKE * alike - 0.1 * (seen in frames))

        ways = [(0, *inner, 9) for k in range(4) for inner in combinations(range(1, 9), k)]
        chosen = key_frames([curve], [], 9, 5, glimpses={glimpse: 0.1})
        assert chosen == list(min(ways, key=cost))


def test_counts_and_long_stories() -> None:
    assert key_frames([np.zeros(1)], [], 0, 8) == [0]
    assert key_frames([steps(9, 4)], [], 9, 1) == [9]
    assert key_frames([steps(5000, 2000)], [], 5000, 8, {2001: 1.0})[1:-1] == [2001]
    assert len(key_frames([np.full(10, np.nan)], [], 9, 3)) == 2
    with pytest.raises(ValueError, match="at least one"):
        key_frames([np.zeros(3)], [], 2, 0)
    assert evenly(800, 5) == [0, 200, 400, 600, 800]
    assert evenly(1, 5) == [0, 1]


def test_what_the_story_asks_counts_most() -> None:
    rising = np.linspace(0, 1, 4)
    goal = Panel("g", "probability", (Series("a", rising, "#000000"),), latent="G_a")
    other = Panel("h", "probability", (Series("b", rising, "#000000"),), latent="G_b")
    fortune = Panel("f", "value", (Series("a", 50 + 200 * rising, "#000000"),), "value")
    assert [float(np.ptp(c)) for c in minds(goal, (goal, other))] == pytest.approx([1.0, 0.3])
    assert [float(np.ptp(c)) for c in minds(fortune, (fortune, goal))] == pytest.approx([1.0, 0.3])
    assert minds(None, ()) == []
