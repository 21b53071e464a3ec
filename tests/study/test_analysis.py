"""Shares, their intervals and tests, against what can be computed by hand."""

from __future__ import annotations

from itertools import combinations
from math import comb
from pathlib import Path

import numpy as np
import pytest

from i2pdsl.study.analysis import DRAWS, FLIPS, analyse
from i2pdsl.study.answers import Answers
from i2pdsl.study.parse import load_study, with_seeds
from i2pdsl.study.spec import Study

STUDIES = Path(__file__).parents[2] / "studies"


@pytest.fixture(scope="module")
def kitchen() -> Study:
    return load_study(STUDIES / "kitchen.study")


def answered(study: Study, right: np.ndarray) -> Answers:
    """Answers to the first films of `help` by naive planning, [P, I]: right, wrong or none."""
    items = tuple(item for item in study.items if (item.group, item.method) == ("help", "naive"))
    given = np.where(np.isnan(right), np.nan, 1 - right)  # the first answer is right
    names = tuple(f"p{number}" for number in range(len(right)))
    return Answers(study, names, items[: right.shape[1]], given)


def quantile(count: int, chance: float, level: float) -> float:
    """Of the share of so many draws."""
    upto = np.cumsum(
        [comb(count, k) * chance**k * (1 - chance) ** (count - k) for k in range(count + 1)]
    )
    return float(np.searchsorted(upto, level) / count)


@pytest.mark.parametrize("axis", [0, 1])
def test_where_only_one_side_varies_the_interval_is_the_binomial_bootstraps(
    kitchen: Study, axis: int
) -> None:
    """All participants agree about each film, or each answers all films alike: then the share of a
    draw is binomial."""
    decided = np.array([1.0] * 12 + [0.0] * 8)
    right = np.tile(decided, (7, 1)) if axis == 1 else np.tile(decided[:, None], (1, 9))
    (share,) = analyse(answered(kitchen, right))
    assert share.share == 0.6
    assert share.films == right.shape[1]
    step = 1 / 20  # what the quantile of DRAWS draws may be off by
    assert abs(share.low - quantile(20, 0.6, 0.025)) <= step + 1e-9
    assert abs(share.high - quantile(20, 0.6, 0.975)) <= step + 1e-9


def test_both_films_and_participants_count(kitchen: Study) -> None:
    """With effects of both, the variance of a draw is about the sum of both's."""
    generator = np.random.default_rng(0)
    films, people = generator.normal(0, 1, 20), generator.normal(0, 1, 30)
    right = (films + people[:, None] > 0).astype(float)
    (share,) = analyse(answered(kitchen, right))
    spread = np.sqrt(right.mean(0).var() / 20 + right.mean(1).var() / 30)
    assert share.high - share.low == pytest.approx(2 * 1.96 * spread, rel=0.15)
    assert share.high - share.low > 1.2 * 2 * 1.96 * np.sqrt(0.25 / 600)


def test_answers_that_were_not_asked_for_do_not_count(kitchen: Study) -> None:
    generator = np.random.default_rng(1)
    right = (generator.random((40, 20)) < 0.7).astype(float)
    right[generator.random(right.shape) < 0.5] = np.nan
    (share,) = analyse(answered(kitchen, right))
    assert share.answers == (~np.isnan(right)).sum()
    assert share.share == pytest.approx(np.nanmean(right))
    assert share.each[3] == pytest.approx(np.nanmean(right[:, 3]))
    assert share.given["helping"] == pytest.approx(share.share)
    assert share.given["hindering"] == pytest.approx(1 - share.share)
    assert share.people == 0.06


def test_p_is_that_of_all_exchanges(kitchen: Study) -> None:
    study = with_seeds(kitchen, tuple(range(4)))
    items = tuple(i for i in study.items if i.group == "help" and i.method in ("naive", "told"))
    shares = np.array([0.1, 0.2, 0.5, 0.3, 0.9, 0.4, 0.8, 0.6])
    given = np.where(np.arange(10)[:, None] < 10 * shares - 1e-9, 0.0, 3.0)
    naive, told = analyse(Answers(study, tuple("abcdefghij"), items, given))
    assert naive.comparison is None
    compared = told.comparison
    assert compared is not None
    assert compared.difference == pytest.approx(shares[4:].mean() - shares[:4].mean())
    every = [
        shares[list(own)].mean() - shares[[n for n in range(8) if n not in own]].mean()
        for own in combinations(range(8), 4)
    ]
    exact = np.mean([abs(d) >= compared.difference - 1e-12 for d in every])
    assert compared.p == pytest.approx(exact, abs=4 * np.sqrt(exact / FLIPS))
    assert compared.low < compared.difference < compared.high


def test_pairs_are_compared_with_chance() -> None:
    study = with_seeds(load_study(STUDIES / "hill.study"), tuple(range(6)))
    items = tuple(item for item in study.items if item.group == "heavy_light")
    given = np.zeros((5, 6))
    given[0, 0] = 1.0  # one answer of 30
    (share,) = analyse(Answers(study, tuple("abcde"), items, given))
    assert (share.share, share.people) == (pytest.approx(29 / 30), 0.97)
    assert share.given == {"first": pytest.approx(29 / 30), "second": pytest.approx(1 / 30)}
    assert share.comparison is not None
    assert share.comparison.against == "chance"
    assert share.comparison.difference == pytest.approx(29 / 30 - 0.5)
    assert share.comparison.p == 2 / 64, "two of all ways to exchange films are as far from chance"


def test_the_same_answers_give_the_same_figures(kitchen: Study) -> None:
    right = (np.random.default_rng(2).random((5, 4)) < 0.5).astype(float)
    assert analyse(answered(kitchen, right)) == analyse(answered(kitchen, right))
    assert DRAWS >= 2000
