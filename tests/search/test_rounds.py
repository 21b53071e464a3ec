"""The order in which a search spends its budget, without searching: scores are made up."""

from __future__ import annotations

import numpy as np
import pytest

from i2pdsl.search.rounds import Block, rounds

COUNT, FRESH, PLACES = 100, 60, 64


def spent(budget: int, width: int = 1, count: int = COUNT) -> list[Block]:
    """The blocks of a search in which a wider beam finds a little more."""
    generator = np.random.default_rng(0)
    worth = generator.normal(size=count + FRESH)
    scores = np.full(count + FRESH, -np.inf)
    found: list[Block] = []
    for blocks in rounds(count, width, PLACES, budget, scores):
        for block in blocks:
            reached = worth[block.starts] + 0.01 * block.width
            scores[block.starts] = np.maximum(scores[block.starts], reached)
        found += blocks
    return found


def told(blocks: list[Block]) -> list[tuple[tuple[int, ...], int, int, bool]]:
    return [(tuple(b.starts.tolist()), b.width, b.alike, b.ahead) for b in blocks]


@pytest.mark.parametrize("width", [1, 5, 64])
def test_more_effort_begins_with_what_less_effort_does(width: int) -> None:
    longest = told(spent(40_000, width))
    for budget in (0, 1, 300, 2000, 9000):
        some = told(spent(budget, width))
        assert some == longest[: len(some)]
        assert len(some) < len(longest)


def test_first_all_starts_once_and_fresh_ones_later() -> None:
    blocks = spent(5000)
    first = np.concatenate([b.starts for b in blocks[:2]])
    assert first.tolist() == list(range(COUNT))
    assert all(b.width == 1 and not b.ahead for b in blocks[:2])
    seen: set[int] = set()
    for block in blocks:
        # Wider beams go to starts that are known.
        assert block.width == 1 or set(block.starts.tolist()) <= seen
        seen |= set(block.starts.tolist())
    assert seen == set(range(COUNT + FRESH))


def test_all_starts_are_looked_at_again_ten_times_as_wide_the_best_first() -> None:
    blocks = spent(COUNT * (1 + 10))
    wider = [b for b in blocks if b.width == 10 and b.alike == 10]
    again = np.concatenate([b.starts for b in wider])
    assert sorted(again.tolist()) == list(range(COUNT))
    worth = np.random.default_rng(0).normal(size=COUNT + FRESH)
    assert again.tolist() == np.argsort(-worth[:COUNT]).tolist()


def test_blocks_fit_and_no_two_do_the_same() -> None:
    blocks = spent(30_000)
    assert all(0 < len(b.starts) * b.width <= PLACES for b in blocks)
    each = [(s, *rest) for starts, *rest in told(blocks) for s in starts]
    assert len(each) == len(set(each))


def test_it_ends_when_all_was_tried() -> None:
    blocks = spent(10**9, count=3)
    assert len(blocks) < 1000
    assert {b.width for b in blocks} >= {1, PLACES}
