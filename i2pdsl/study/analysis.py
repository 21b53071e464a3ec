"""Shares of matching answers, with intervals, and tests against the baseline.

Both films and participants are samples: another seed gives another film, another panel other
people. So intervals are taken by the pigeonhole bootstrap (Owen 2007, DOI 10.1214/07-AOAS122),
which draws films and participants independently of each other, with replacement. It errs toward
intervals that are too wide, and needs no complete table: people see some of the films.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from itertools import product
from typing import Any

import numpy as np

from i2pdsl.study.answers import Answers

DRAWS = 4000  # of the bootstrap
FLIPS = 9999  # of a test: p is at least 1e-4
FEW = 12  # pairs whose films are exchanged in all ways
LEVEL = 0.95


@dataclass(frozen=True)
class Comparison:
    """A share against that of the baseline, or of pairs against chance.

    Attributes:
        against: the method, or `chance`.
        difference: of the shares, with its interval.
        p: that of a permutation test over films, two-sided.
    """

    against: str
    difference: float
    low: float
    high: float
    p: float


@dataclass(frozen=True)
class Share:
    """How many answers about the films of a group match.

    Attributes:
        group: the condition or the pair, and `method` how its films were made.
        share: of all answers, with its interval of 95 %.
        films: how many films or pairs there were, and `answers` about them.
        each: the share of each film, in their order.
        given: the share of each answer, by name; of a slider the mean position, `mean`.
        people: the share of people, where it is known.
    """

    group: str
    method: str
    share: float
    low: float
    high: float
    films: int
    answers: int
    each: tuple[float, ...]
    given: Mapping[str, float]
    people: float | None
    comparison: Comparison | None

    def as_json(self) -> dict[str, Any]:
        return asdict(self)


def analyse(answers: Answers, seed: int = 0) -> tuple[Share, ...]:
    """The shares of all groups and methods that anything was answered about."""
    study, generator = answers.study, np.random.default_rng(seed)
    whose = _weights(generator, len(answers.participants))
    matches = answers.matches
    columns: dict[tuple[str, str], list[int]] = {}
    for number, item in enumerate(answers.items):
        if not np.isnan(matches[:, number]).all():
            columns.setdefault((item.group, item.method), []).append(number)
    drawn = {key: _drawn(generator, matches[:, own], whose) for key, own in columns.items()}
    each = {key: np.nanmean(matches[:, own], axis=0) for key, own in columns.items()}
    found = []
    for group in study.groups:
        for method in study.methods:
            key = group.name, method.name
            if key not in columns:
                continue
            own = matches[:, columns[key]]
            comparison = None
            if study.pairs:
                deviations = each[key] - 0.5
                spread = drawn[key] - 0.5
                p = flipped(generator, deviations)
                comparison = Comparison("chance", float(np.nanmean(own)) - 0.5, *_ends(spread), p)
            elif (group.name, method.against) in columns:
                other = group.name, method.against
                difference = float(np.nanmean(own) - np.nanmean(matches[:, columns[other]]))
                ends = _ends(drawn[key] - drawn[other])
                p = _permuted(generator, each[key], each[other])
                comparison = Comparison(method.against, difference, *ends, p)
            low, high = _ends(drawn[key])
            found.append(
                Share(
                    group.name,
                    method.name,
                    float(np.nanmean(own)),
                    low,
                    high,
                    len(columns[key]),
                    int((~np.isnan(own)).sum()),
                    tuple(each[key].tolist()),
                    _given(answers, columns[key]),
                    study.figure(group.name, method.name),
                    comparison,
                )
            )
    return tuple(found)


def _weights(generator: np.random.Generator, count: int) -> np.ndarray:
    """How often each of so many is drawn, with replacement, [DRAWS, count]."""
    return generator.multinomial(count, np.full(count, 1 / count), DRAWS).astype(float)


def _drawn(generator: np.random.Generator, matches: np.ndarray, whose: np.ndarray) -> np.ndarray:
    """The share in each draw of films and participants [DRAWS]; NaN where nobody answered."""
    films = _weights(generator, matches.shape[1])
    there = ~np.isnan(matches)
    count = ((whose @ there) * films).sum(1)
    right = ((whose @ np.where(there, matches, 0.0)) * films).sum(1)
    return np.where(count > 0, right / np.maximum(count, 1), np.nan)


def _ends(drawn: np.ndarray) -> tuple[float, float]:
    low, high = np.nanquantile(drawn, [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    return float(low), float(high)


def _permuted(generator: np.random.Generator, first: np.ndarray, second: np.ndarray) -> float:
    """p of the difference of means, films being exchanged between the two at random: exact
    whatever participants have in common, since they stay who they are."""
    every, count = np.concatenate([first, second]), len(first)
    mixed = generator.permuted(np.tile(every, (FLIPS, 1)), axis=1)
    found = mixed[:, :count].mean(1) - mixed[:, count:].mean(1)
    return _p(first.mean() - second.mean(), found)


def flipped(generator: np.random.Generator, deviations: np.ndarray) -> float:
    """p of a mean whose parts may as well have the other sign (the films of a pair exchanged, or
    what a person answered to two methods): in all ways, if these are not many."""
    if len(deviations) <= FEW:
        signs = np.array(list(product([1.0, -1.0], repeat=len(deviations))))[1:]  # but for itself
    else:
        signs = generator.choice([-1.0, 1.0], (FLIPS, len(deviations)))
    return _p(deviations.mean(), (signs * deviations).mean(1))


def _p(reached: float, by_chance: np.ndarray) -> float:
    """The share of what chance gives that is as far from 0; never 0."""
    as_far = np.abs(by_chance) >= abs(reached) - 1e-12
    return float((1 + as_far.sum()) / (1 + len(by_chance)))


def _given(answers: Answers, columns: list[int]) -> dict[str, float]:
    own = answers.given[:, columns]
    own = own[~np.isnan(own)]
    if not answers.names:
        return {"mean": float(own.mean())}
    return {name: float((own == number).mean()) for number, name in enumerate(answers.names)}
