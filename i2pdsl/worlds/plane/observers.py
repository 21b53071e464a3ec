"""What viewers make of a frame: how likely each velocity is under each hypothesis."""

from __future__ import annotations

import math
from typing import Any

from i2pdsl.audience.filter import log_sum
from i2pdsl.worlds.plane.costs import alternatives, by_hypothesis, costs_here, lookahead, step_cost
from i2pdsl.worlds.plane.dynamics import velocities
from i2pdsl.worlds.plane.tables import Cast, Tables
from i2pdsl.worlds.plane.ways import outlook

Array = Any
Rows = tuple[Array, ...]


def rows(
    tables: Tables, cast: Cast, state: Array, action: Array, after: Array
) -> tuple[Rows, Rows]:
    """log of the density of each character's velocity under each hypothesis, [..., O, H] each, and
    of that of the best velocity.

    `step`: exp(-beta (cost of the frame + cost to go after it)), normalised over all velocities.
    `path`: the same with the cost to go before it as normaliser (and that of a normal
    distribution, so that it can be compared with moving at random), which telescopes to
    exp(-C - V(Q)) / exp(-V(S)) of Dragan, Lee and Srinivasa 2013, DOI 10.1109/HRI.2013.6483603.

    The best is the one that costs least of those of the quadrature and the one taken, to both
    kinds of viewers.
    """
    xp = state.__array_namespace__()
    moving = velocities(tables, cast, action)
    known = outlook(tables, cast, state)
    beta = tables.beta[:, None]
    taken, best = [], []
    for who in range(cast.count):
        own = moving[who]
        chosen = lookahead(tables, cast, who, known, moving, own[..., None, :])  # [..., 1, M]
        costs = alternatives(tables, cast, who, known, moving)[1]
        found = []
        if cast.steps:
            weighed = (
                tables.log_weights - beta[..., None] * xp.swapaxes(costs, -1, -2)[..., None, :, :]
            )
            total = log_sum(weighed) + 2 * xp.log(tables.fastest[who])
            found.append(-beta * chosen - total)
        if cast.paths:
            ahead = outlook(tables, cast, after)
            rise = costs_here(tables, cast, who, ahead) - costs_here(tables, cast, who, known)
            spent = step_cost(tables, who, own)[..., None] + rise
            found.append(
                -beta * spent[..., None, :] - xp.log(2 * math.pi * tables.speed[who] / beta)
            )
        sensible = found[0]
        if len(found) == 2:
            sensible = xp.where(tables.by_path[:, None], found[1], found[0])
        regret = beta * xp.maximum(chosen - costs.min(-2)[..., None, :], 0.0)
        at_random = -xp.log(math.pi * tables.fastest[who] ** 2)
        taken.append(by_hypothesis(tables.plans[who], sensible, at_random))
        best.append(taken[-1] + by_hypothesis(tables.plans[who], regret, 0.0))
    return tuple(taken), tuple(best)
