"""What can be asked of a state or a frame of a plane."""

from __future__ import annotations

import math
from typing import Any

from i2pdsl.worlds.plane.dynamics import limited
from i2pdsl.worlds.plane.geometry import direction, norm
from i2pdsl.worlds.plane.tables import Tables, each
from i2pdsl.worlds.plane.vocabulary import MISSED
from i2pdsl.worlds.plane.ways import ways_to_places

Array = Any

PREDICATE_SOFTNESS = 0.2  # units over which the smooth step of a predicate rises
TOUCH = 0.05  # units between the edges of two that touch
NEAR = 0.25  # of its radius: as far from a point is one still at it
MOVED = 0.005  # units in a frame that are seen as a motion
SLOWLY = 0.25  # of the speed that one likes: half as still as no motion at all
SIGHT = 1.0  # units by which a free line of sight counts as free
FACING = math.cos(math.pi / 4)  # of the largest angle between a motion and what it faces


def _smooth(holds: Array, margin: Array) -> Array:
    """1 where something holds, else 0.

    Exact; but JAX differentiates a smooth step of the margin in its place, so that a descent
    feels in which direction to go.
    """
    xp = margin.__array_namespace__()
    exact = xp.where(holds, 1.0, 0.0)
    if xp.__name__ == "numpy":
        return exact
    from jax.lax import stop_gradient

    smooth = 1 / (1 + xp.exp(xp.clip(-margin / PREDICATE_SOFTNESS, -30.0, 30.0)))
    return smooth + stop_gradient(exact - smooth)


def _spot(tables: Tables, places: list[Array], spot: Any) -> Array:
    """Where another character, a place or a point is, [..., 2]."""
    if isinstance(spot, int):
        return places[spot]
    return tables.places[spot[0]] if len(spot) == 1 else spot


def _within(tables: Tables, who: int, here: Array, place: Any) -> Array:
    """By how many units a character is within a place, or near enough to a point, [...]."""
    if len(place) == 1:
        (number,) = place
        return tables.place_radius[number] - norm(here - tables.places[number])
    return NEAR * tables.radius[who] - norm(here - place)


def _sees(tables: Tables, here: Array, there: Array) -> Array:
    """Whether no wall crosses the straight line between two points."""
    xp = here.__array_namespace__()
    margin = xp.zeros(here.shape[:-1]) + SIGHT
    if not tables.walls.shape[0]:
        return _smooth(margin >= 0, margin)
    first, second = tables.walls[:, 0], tables.walls[:, 1]  # [W, 2]
    line = (there - here)[..., None, :]
    length = norm(line)
    # How far the ends of a wall are to the left of the line, those of the line to the left of it.
    ends = [_left(line, e - here[..., None, :]) / (length + 1e-9) for e in (first, second)]
    wall = second - first
    points = [
        _left(wall, p[..., None, :] - first) for p in (here, xp.broadcast_to(there, here.shape))
    ]
    crossed = (ends[0] * ends[1] < 0) & (points[0] * points[1] < 0)
    aside = xp.minimum(abs(ends[0]), abs(ends[1]))
    margin = xp.minimum(margin, xp.where(crossed, -aside, SIGHT).min(-1))
    return _smooth(margin >= 0, margin)


def _left(a: Array, b: Array) -> Array:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def is_still(after: Array) -> Array:
    """Whether nobody has moved so far that it is seen, [...]."""
    return _squares(_moved(after)).max(-1) < MOVED**2


def stillness(tables: Tables, state: Array, after: Array) -> Array:
    """1 where nobody gets on, 1/2 where one does at the share SLOWLY of the speed that he likes,
    [...]. All are added up: a greatest one would have edges, at which L-BFGS ends. Two frames are
    looked at: who trembles gets nowhere."""
    on = (_moved(state) + _moved(after)) / 2
    return 1 / (1 + (_squares(on) / (SLOWLY * tables.speed) ** 2).sum(-1))


def _moved(after: Array) -> Array:
    """How far all moved in the last frame, [..., 2 n]."""
    return after[..., after.shape[-1] // 2 :]


def _squares(moved: Array) -> Array:
    """The squares of the lengths of n vectors, [..., n]."""
    squares: Array = (moved**2).reshape(*moved.shape[:-1], -1, 2).sum(-1)
    return squares


def feature(
    tables: Tables,
    name: str,
    arguments: tuple[Any, ...],
    state: Array,
    before: Array | None,
    action: Array | None,
) -> Array:
    """A predicate or quantity of a state or frame, [...]."""
    who = arguments[0]
    count = state.shape[-1] // 4
    places = each(state, count)
    here = places[who]
    if name == "at":
        xp = state.__array_namespace__()
        margin = _within(tables, who, here, arguments[1])
        return _smooth(margin >= 0, xp.asarray(margin))
    if name == MISSED:
        xp = state.__array_namespace__()
        return xp.maximum(-_within(tables, who, here, arguments[1]), 0.0)
    if name == "sees":
        return _sees(tables, here, _spot(tables, places, arguments[1]))
    if name in ("touching", "distance"):
        apart = norm(here - _spot(tables, places, arguments[1]))
        if name == "distance":
            return apart
        margin = tables.radius[who] + tables.radius[arguments[1]] + TOUCH - apart
        return _smooth(margin >= 0, margin)
    assert before is not None
    velocity = each(state, 2 * count)[count + who]
    if name in ("moved", "idle"):
        margin = norm(velocity) - MOVED
        moved = _smooth(margin >= 0, margin)
        return moved if name == "moved" else 1 - moved
    if name == "faces":
        then = each(before, count)
        way = _spot(tables, then, arguments[1]) - then[who]
        ahead = (velocity * way).sum(-1) - FACING * norm(velocity) * norm(way)
        xp = state.__array_namespace__()
        margin = xp.minimum(norm(velocity) - MOVED, ahead)
        return _smooth(margin >= 0, margin)
    if name == "speed":
        return norm(velocity)
    speed = tables.speed[who]
    if name == "acceleration":
        last = each(before, 2 * count)[count + who]
        return ((velocity - last) ** 2).sum(-1) / speed**2
    if name == "effort":
        return (limited(tables, who, each(action, count)[who]) ** 2).sum(-1) / speed**2
    if name == "heads":
        then = each(before, count)
        _, way = direction(_spot(tables, then, arguments[1]) - then[who])
        return (limited(tables, who, each(action, count)[who]) * way).sum(-1) / speed
    (place,) = arguments[1]  # progress
    then = each(before, count)[who]
    ways = [ways_to_places(tables, who, at)[..., place] for at in (then, here)]
    return ways[0] - ways[1]
