"""The mixed-effects model on answers whose truth is known."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from fuzz_for_tests import FULL
from i2pdsl.computing import computing

PEOPLE, FILMS = 16, 6
MIDDLE, OWN, TASTE, LOOK = np.array([1.0, -1.0]), 0.6, 0.4, np.array([0.9, 0.9])
CELL = np.repeat([0, 1], FILMS)


@pytest.fixture(scope="module", autouse=True)
def with_jax() -> Iterator[None]:
    with computing():
        yield


def true_shares() -> np.ndarray:
    """Of new people about new films, by numbers drawn."""
    noise = np.random.default_rng(0).normal(size=(400_000, 1))
    wide = np.sqrt(OWN**2 + TASTE**2 + LOOK**2)
    return (1 / (1 + np.exp(-(MIDDLE + wide * noise)))).mean(0)


def simulated(count: int, seed: int) -> np.ndarray:
    """[count, P, F] Answers of people who differ about films that differ."""
    rng = np.random.default_rng(seed)
    films = MIDDLE[CELL] + LOOK[CELL] * rng.normal(size=(count, 1, 2 * FILMS))
    people = OWN * rng.normal(size=(count, PEOPLE, 1))
    tastes = TASTE * rng.normal(size=(count, PEOPLE, 2))[..., CELL]
    odds = films + people + tastes
    return (rng.random(odds.shape) < 1 / (1 + np.exp(-odds))).astype(float)


def intervals(answers: np.ndarray) -> np.ndarray:
    """[3, n, 2] Mean and ends of the model's 95 %, of all sets of answers at once."""
    import jax

    from i2pdsl.programs import LASTING
    from i2pdsl.study import mixed

    person, film = np.indices(answers.shape[1:]).reshape(2, -1)

    def one(given: tuple[jax.Array, jax.Array]) -> jax.Array:
        match, key = given
        return mixed.shares(mixed.sampled((match, person, film, CELL), key, (PEOPLE, 2), chains=1))[
            0
        ]

    keys = jax.random.split(jax.random.PRNGKey(0), len(answers))
    arguments = (answers.reshape(len(answers), -1), keys)
    run = jax.jit(jax.vmap(one)).lower(arguments).compile(compiler_options=LASTING)
    draws = np.asarray(run(arguments))
    return np.array([draws.mean(1), *np.quantile(draws, [0.025, 0.975], axis=1)])


def unclustered(answers: np.ndarray) -> np.ndarray:
    """[2, n, 2] The interval of a share as if all answers were independent of each other."""
    share = np.stack([answers[..., c == CELL].mean((1, 2)) for c in (0, 1)], axis=1)
    half = 1.96 * np.sqrt(share * (1 - share) / (PEOPLE * FILMS))
    return np.array([share - half, share + half])


def test_intervals_cover_the_truth_where_films_are_alike_within(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of 24 intervals of 95 % one or two miss, and seven in one of 4,000 cases. Those that count
    answers as independent are half as long, and miss every third time."""
    from i2pdsl.study import mixed

    if not FULL:  # fewer draws place the ends of an interval about as well
        monkeypatch.setattr(mixed, "WARMUP", 120)
        monkeypatch.setattr(mixed, "DRAWS", 150)
    answers, truth = simulated(12, seed=1), true_shares()
    mean, low, high = intervals(answers)
    assert ((low < truth) & (truth < high)).sum() >= 18
    short_low, short_high = unclustered(answers)
    assert (high - low).mean() > 1.4 * (short_high - short_low).mean()
    share = np.stack([answers[..., c == CELL].mean((1, 2)) for c in (0, 1)], axis=1)
    assert abs(mean - share).max() < 0.1, "people differ little from what is counted"


@pytest.mark.slow
def test_coverage_is_nominal_over_many_studies() -> None:
    answers, truth = simulated(200, seed=2), true_shares()
    _, low, high = intervals(answers)
    covered = (low < truth) & (truth < high)
    assert 0.91 <= covered.mean() <= 0.99
    short_low, short_high = unclustered(answers)
    assert ((short_low < truth) & (truth < short_high)).mean() < 0.8


@pytest.mark.slow
def test_tables_that_are_not_complete() -> None:
    """Everybody sees a third of the films; spreads come out about right."""
    from i2pdsl.study.mixed import estimate

    rng = np.random.default_rng(3)
    cell = np.repeat(np.arange(4), 15)
    odds = np.array([1, -1.5, 0.5, 0])[cell] + 0.8 * rng.normal(size=60) + rng.normal(size=(80, 1))
    matches = (rng.random(odds.shape) < 1 / (1 + np.exp(-odds))).astype(float)
    for person in matches:
        person[rng.permutation(60)[20:]] = np.nan
    found = estimate(matches, cell)
    assert (found.rhat < 1.05, found.ess > 100) == (True, True)
    low, high = np.quantile(found.people, [0.005, 0.995])
    assert low < 1 < high
    raw = np.array([np.nanmean(matches[:, cell == c]) for c in range(4)])
    assert abs(found.share.mean(0) - raw).max() < 0.05
    assert found.share.shape[1:] == found.films.shape[1:] == (4,)
