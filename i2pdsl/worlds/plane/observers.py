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


def log_rows(
    tables: Tables, cast: Cast, state: Array, action: Array, after: Array
) -> tuple[Array, ...]:
    """log of the density of each character's velocity under each hypothesis, [..., O, H] each.

    `step`: exp(-beta (cost of the frame + cost to go after it)), normalised over all velocities.
    `path`: the same with the cost to go before it as normaliser (and that of a normal
    distribution, so that it can be compared with moving at random), which telescopes to
    exp(-C - V(Q)) / exp(-V(S)) of Dragan, Lee and Srinivasa 2013, DOI 10.1109/HRI.2013.6483603.
    """
    xp = state.__array_namespace__()
    moving = velocities(tables, cast, action)
    known = outlook(tables, cast, state)
    beta = tables.beta[:, None]
    rows = []
    for who in range(cast.count):
        own = moving[who]
        found = []
        if cast.steps:
            chosen = lookahead(tables, cast, who, known, moving, own[..., None, :])
            costs = alternatives(tables, cast, who, known, moving)[1]
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
        at_random = -xp.log(math.pi * tables.fastest[who] ** 2)
        rows.append(by_hypothesis(tables.plans[who], sensible, at_random))
    return tuple(rows)
