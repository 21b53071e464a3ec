"""What happens in a plane: all move, push each other apart, and are pushed out of walls."""

from __future__ import annotations

from typing import Any

from i2pdsl.worlds.plane.geometry import crossed, direction, nearest_on, norm
from i2pdsl.worlds.plane.tables import Cast, Tables, each

Array = Any

SOFTNESS = 0.02  # units over which contact sets in
CONTACTS = 2  # rounds of pushing apart in a frame


def _soft_depth(gap: Array) -> Array:
    """How far two bodies are pushed apart whose edges are so far apart; smooth at 0."""
    xp = gap.__array_namespace__()
    between = (SOFTNESS - xp.clip(gap, -SOFTNESS, SOFTNESS)) ** 2 / (4 * SOFTNESS)
    return between + xp.maximum(-SOFTNESS - gap, 0.0)


def _out_of_walls(tables: Tables, who: int, before: Array, place: Array) -> Array:
    """A character's place pushed out of walls, to the side on which it was before, and back into
    the plane: [..., 2]."""
    xp = place.__array_namespace__()
    radius, walls = tables.radius[who], tables.walls
    if walls.shape[0]:
        for _ in range(2):  # in a corner there are two walls
            apart = place[..., None, :] - nearest_on(walls, place)
            sides = xp.where(crossed(walls, before, place), -1.0, 1.0)
            lengths = sides * norm(apart)
            nearest = lengths == lengths.min(-1, keepdims=True)
            chosen = xp.where(nearest, sides, 0.0)[..., None] * apart
            _, away = direction(chosen.sum(-2) / nearest.sum(-1)[..., None])
            place = place + _soft_depth(lengths.min(-1) - radius)[..., None] * away
    return xp.clip(place, radius, tables.size - radius)


def pushed_apart(tables: Tables, places: list[Array]) -> list[Array]:
    """Places of two characters that have pushed each other apart, [..., 2] each."""
    share = tables.mass[1] / tables.mass.sum()
    return _parted(tables, places, share, 1 - share)


def _parted(tables: Tables, places: list[Array], first: Array, second: Array) -> list[Array]:
    """Each gives way by its share [...] of how far the two overlap."""
    distance, way = direction(places[1] - places[0])
    depth = _soft_depth(distance - tables.radius.sum())
    back, forth = (share * depth for share in (first, second))
    return [places[0] - back[..., None] * way, places[1] + forth[..., None] * way]


def _held(tables: Tables, before: list[Array], places: list[Array]) -> list[Array]:
    """The same where walls hold: who is pressed against one does not give way any more."""
    after = [_out_of_walls(tables, who, before[who], at) for who, at in enumerate(places)]
    pressed = [norm(now - at) for now, at in zip(after, places, strict=True)]
    shares = [other / (pressed[0] + pressed[1] + SOFTNESS) for other in reversed(pressed)]
    return _parted(tables, after, *shares)


def limited(tables: Tables, who: int, velocity: Array) -> Array:
    """A velocity [..., 2], cut to the character's greatest speed."""
    xp = velocity.__array_namespace__()
    speed, fastest = norm(velocity), tables.fastest[who]
    above = speed > fastest
    return velocity * xp.where(above, fastest / xp.where(above, speed, 1.0), 1.0)[..., None]


def velocities(tables: Tables, cast: Cast, action: Array) -> list[Array]:
    """What each character tries in a frame, [..., 2] each."""
    return [limited(tables, who, v) for who, v in enumerate(each(action, cast.count))]


def transition(tables: Tables, cast: Cast, state: Array, action: Array) -> Array:
    """The state after a frame, [..., 4 n]."""
    xp = state.__array_namespace__()
    before = each(state, cast.count)
    places = [at + v for at, v in zip(before, velocities(tables, cast, action), strict=True)]
    if cast.count == 2:
        for _ in range(CONTACTS):
            places = _held(tables, before, pushed_apart(tables, places))
    places = [_out_of_walls(tables, who, before[who], at) for who, at in enumerate(places)]
    moved = [after - at for after, at in zip(places, before, strict=True)]
    return xp.concatenate([*places, *moved], axis=-1)
