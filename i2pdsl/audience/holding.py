"""The two ways to hold beliefs about hypotheses that are not listed: particles, and factors."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from typing import Any, NamedTuple

from i2pdsl.audience import factors, foresight, particles, renewal
from i2pdsl.audience.factors import Factors, FactorTables
from i2pdsl.audience.filter import log_of
from i2pdsl.audience.particles import Swarm, SwarmTables

Array = Any
Holding = Swarm | Factors
HoldingTables = SwarmTables | FactorTables


class Way(NamedTuple):
    """What is done with an observer's numbers and with what he holds: the functions of these names
    in particles.py, or factors.py.

    Attributes:
        belief, log_belief: of rows, as probabilities or as their logs.
        over: what he holds when a frame is over.
        entropy, divergence: of all hypotheses; None where what he holds does not tell.
        doubts: whether no row can get too improbable for single precision.
        stands_on: on how many hypotheses his belief stands; infinity if on all.
        numbers: how many numbers he holds, what a question needs for a moment among them.
        asked: how many a question looks at in each frame that is about the values of those who act
            u-th, at most.
        kept: how many are kept of each frame, where all are remembered.
        carried: how many a script has besides, from frame to frame.
    """

    begun: Callable[..., Any]
    belief: Callable[..., Array]
    log_belief: Callable[..., Array]
    likely: Callable[..., Array]
    mean: Callable[..., Array]
    seen_by: Callable[..., Any]
    over: Callable[..., Any]
    ahead: Callable[..., tuple[Array, Array]]
    expectation: Callable[..., Array]
    entropy: Callable[..., Array] | None
    divergence: Callable[..., Array] | None
    doubts: Callable[[Any], bool]
    stands_on: Callable[[Any], float]
    numbers: Callable[[Any], int]
    asked: Callable[[Any, Collection[int]], int]
    kept: Callable[[Any], int]
    carried: Callable[[Any], int]


_WAYS: dict[type, Way] = {
    SwarmTables: Way(
        particles.begun,
        particles.belief,
        lambda tables, held: log_of(particles.belief(tables, held)),
        lambda tables, held, u, row, _: particles.likely(tables, held, u, row),
        lambda tables, held, u, values, mask, _: particles.mean(tables, held, u, values, mask),
        particles.seen_by,
        renewal.after_frame,
        foresight.ahead,
        lambda tables, held, mask, quantity, _: foresight.expectation(tables, held, mask, quantity),
        None,
        None,
        lambda tables: True,
        lambda tables: float(len(tables.first)),
        lambda tables: len(tables.first),
        lambda tables, _: 2 * tables.first.size,
        lambda tables: tables.first.size + 2 * len(tables.first),
        lambda tables: tables.marks * sum(map(len, tables.columns)),
    ),
    FactorTables: Way(
        factors.begun,
        factors.belief,
        factors.log_belief,
        factors.likely,
        factors.mean,
        factors.seen_by,
        lambda tables, held: held,
        factors.ahead,
        factors.expectation,
        factors.entropy,
        factors.divergence,
        lambda tables: tables.doubts,
        lambda tables: math.inf,
        lambda tables: tables.size + tables.row_of.size,
        lambda tables, whose: tables.points({tables.factor(u) for u in whose}),
        lambda tables: tables.size,
        lambda tables: 0,
    ),
}


def way_of(tables: HoldingTables) -> Way:
    """How an observer with such numbers holds beliefs."""
    return _WAYS[type(tables)]
