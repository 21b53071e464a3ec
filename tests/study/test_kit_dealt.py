"""Lists of films: balanced within each and over all."""

from __future__ import annotations

from collections import Counter

import pytest

from i2pdsl.study.deal import CHECK, dealt

CELLS = {"a": [[n] for n in range(7)], "b": [[n] for n in range(7, 14)], "c": [[14], [15], [16]]}
CELL = {n: name for name, films in CELLS.items() for (n,) in films}


@pytest.mark.parametrize("each", [1, 3, 8, 9])
def test_lists_are_balanced(each: int) -> None:
    lists = dealt(CELLS, each, 60, seed=1)
    assert len({tuple(own) for own in lists}) > 10
    shown: Counter[int] = Counter()
    for own in lists:
        assert own.count(CHECK) == 1
        films = [n for n in own if n != CHECK]
        assert len(set(films)) == len(films) == each, "nothing is shown twice"
        counts = Counter(CELL[n] for n in films)
        assert max(counts.values()) - min(counts[c] for c in CELLS) <= 1
        turns = [{CELL[n] for n in films[k : k + 3]} for k in range(0, each // 3 * 3, 3)]
        if each % 3 == 0:
            assert all(len(turn) == 3 for turn in turns), "all conditions take turns"
        shown.update(films)
        for cell in CELLS.values():  # at any time, not only in the end
            times = [shown[n] for (n,) in cell]
            assert max(times) - min(times) <= 1
    cells = Counter(CELL[n] for own in lists for n in own if n != CHECK)
    assert max(cells.values()) - min(cells.values()) <= 1


def test_every_place_of_a_list_is_any_conditions() -> None:
    lists = dealt(CELLS, 9, 600, seed=2)
    for place in range(9):
        found = Counter(CELL[[n for n in own if n != CHECK][place]] for own in lists)
        assert min(found.values()) > 140, "of 200 that are expected"  # 5 standard deviations


def test_pairs_stand_either_way_round_as_often() -> None:
    pairs = {"a": [[2 * n, 2 * n + 1] for n in range(5)]}
    lists = dealt(pairs, 4, 200, seed=3)
    for own in lists:
        films = [n for n in own if n != CHECK]
        assert len({n // 2 for n in films}) == 4
        assert sum(n % 2 for n in films) == 2
    odd = sum(n % 2 for own in dealt(pairs, 3, 400, seed=4) for n in own if n != CHECK)
    assert 520 < odd < 680  # 600, give or take


def test_long_lists_have_more_checks_spread_over_them() -> None:
    cells = {"a": [[n] for n in range(120)]}
    for own in dealt(cells, 120, 20, seed=5):
        places = [k for k, n in enumerate(own) if n == CHECK]
        assert len(places) == 3
        assert all(20 <= place - 41 * k <= 42 for k, place in enumerate(places))
