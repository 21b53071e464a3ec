"""What it costs: frames, and what is left to pay after them.

A frame in which a character moves by u costs it (|u|^2 + s^2) / (2 s), s being the speed that it
likes: the square of its velocity, and the time. So the cost to go of who wants to be somewhere is
the length of the shortest way there, and s is the best speed.
"""

from __future__ import annotations

from typing import Any

from i2pdsl.worlds.plane.dynamics import pushed_apart
from i2pdsl.worlds.plane.geometry import norm
from i2pdsl.worlds.plane.tables import Cast, Plans, Tables
from i2pdsl.worlds.plane.ways import Outlook, outlook

Array = Any


def _wanted(
    tables: Tables, cast: Cast, who: int, known: Outlook, then: list[Array], weights: Array
) -> Array:
    """A character's costs to go for all that it can want, weighted: [..., K, M]; see costs_to_go.

    Args:
        weights [D, M].
    """
    xp = weights.__array_namespace__()
    here, count = then[who], tables.places.shape[0]
    shift = here - known.places[who][..., None, :]
    cost = norm(here[..., None, :] - tables.places)
    if known.longer is not None and known.slope is not None:
        drift = shift @ xp.swapaxes(known.slope[who], -1, -2)
        cost = cost + known.longer[who][..., None, :] + drift
    total = cost @ weights[:count]
    if cast.count == 2:
        apart = norm(here - then[1 - who])[..., None]
        if known.between is not None:
            longer, mine, theirs = known.between[who]
            other = then[1 - who] - known.places[1 - who][..., None, :]
            drift = shift @ mine[..., None] + other @ theirs[..., None]
            apart = apart + longer[..., None, None] + drift
        near = xp.maximum(apart - tables.radius.sum(), 0.0)
        far = xp.maximum(tables.safe - apart, 0.0)
        total = total + near * weights[count + 1] + far * weights[count + 2]
    return total


def costs_to_go(tables: Tables, cast: Cast, who: int, known: Outlook, then: list[Array]) -> Array:
    """What a character still has to pay in each of its plans where all are at `then`, [..., K, M].

    The social one pays for its own goal, `rho` times what the other has to pay, and for the way to
    where it can help or hinder it. Straight ways are exact; detours and ways to those spots are
    taken to first order about the places where they were looked at.

    Args:
        then: places near those of the outlook, [..., K, 2] each.
    """
    xp = tables.size.__array_namespace__()
    plans = tables.plans[who]
    own = _wanted(tables, cast, who, known, then, plans.own)
    if known.spots is None or who != cast.social:
        return own
    theirs = _wanted(tables, cast, 1 - who, known, then, plans.theirs)
    length, gradient = known.spots
    moved = [now - at[..., None, :] for now, at in zip(then, known.places, strict=True)]
    nearer = (moved[who] - moved[1 - who]) @ xp.swapaxes(gradient, -1, -2)
    ways = xp.maximum(length[..., None, :] + nearer, 0.0)
    return own + theirs + ways @ plans.spots


def costs_here(tables: Tables, cast: Cast, who: int, known: Outlook) -> Array:
    """The same where they are, [..., M]."""
    here = [at[..., None, :] for at in known.places]
    return costs_to_go(tables, cast, who, known, here)[..., 0, :]


def by_hypothesis(plans: Plans, found: Array, at_random: Array | float) -> Array:
    """A number of each plan [..., M], and that of moving at random, for each hypothesis."""
    count = plans.own.shape[1]
    return found @ plans.rows[:count] + at_random * plans.rows[count]


def value(tables: Tables, cast: Cast, who: int, state: Array) -> Array:
    """A character's value of a state, minus its cost to go: [..., O, H]; 0 for one that moves at
    random."""
    xp = state.__array_namespace__()
    known = outlook(tables, cast, state)
    found = by_hypothesis(tables.plans[who], -costs_here(tables, cast, who, known), 0.0)
    return xp.broadcast_to(found[..., None, :], (*state.shape[:-1], *tables.log_prior.shape))


def step_cost(tables: Tables, who: int, velocity: Array) -> Array:
    """What a frame costs a character that tries a velocity, at most its greatest: [...]."""
    speed = tables.speed[who]
    return ((velocity**2).sum(-1) + speed**2) / (2 * speed)


def lookahead(
    tables: Tables, cast: Cast, who: int, known: Outlook, moving: list[Array], tried: Array
) -> Array:
    """What a frame and all after it cost a character in each plan, [..., K, M], if it tries each
    of the velocities [..., K, 2] while the other does as it does. Walls are felt by the ways.

    Args:
        moving: what all do, [..., 2] each.
    """
    moves = [v[..., None, :] for v in moving]
    moves[who] = tried
    then = [at[..., None, :] + v for at, v in zip(known.places, moves, strict=True)]
    if cast.count == 2:
        then = pushed_apart(tables, then)
    ahead = costs_to_go(tables, cast, who, known, then)
    return step_cost(tables, who, tried)[..., None] + ahead


def alternatives(
    tables: Tables, cast: Cast, who: int, known: Outlook, moving: list[Array]
) -> tuple[Array, Array]:
    """The velocities of the quadrature [K, 2], what each costs in each plan [..., K, M]."""
    tried = tables.fastest[who] * tables.nodes
    return tried, lookahead(tables, cast, who, known, moving, tried)
