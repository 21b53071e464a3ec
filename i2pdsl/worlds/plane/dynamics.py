"""What happens in a plane: all move, push each other apart, and are pushed out of walls."""

from __future__ import annotations

from typing import Any

from i2pdsl.worlds.plane.geometry import direction, nearest_on, norm
from i2pdsl.worlds.plane.tables import Cast, Tables, each

Array = Any

SOFTNESS = 0.02  # units over which contact sets in
CONTACTS = 2  # rounds of pushing apart in a frame


def _soft_depth(gap: Array) -> Array:
    """How far two bodies are pushed apart whose edges are so far apart; smooth at 0."""
    xp = gap.__array_namespace__()
    between = (SOFTNESS - xp.clip(gap, -SOFTNESS, SOFTNESS)) ** 2 / (4 * SOFTNESS)
    return between + xp.maximum(-SOFTNESS - gap, 0.0)


def _out_of_walls(tables: Tables, who: int, place: Array) -> Array:
    """A character's place pushed out of walls, and back into the plane: [..., 2]."""
    xp = place.__array_namespace__()
    radius = tables.radius[who]
    if tables.walls.shape[0]:
        for _ in range(2):  # in a corner there are two walls
            apart = place[..., None, :] - nearest_on(tables.walls, place)
            lengths = norm(apart)
            nearest = lengths == lengths.min(-1, keepdims=True)
            chosen = xp.where(nearest[..., None], apart, 0.0).sum(-2) / nearest.sum(-1)[..., None]
            length, away = direction(chosen)
            place = place + _soft_depth(length - radius)[..., None] * away
    return xp.clip(place, radius, tables.size - radius)


def pushed_apart(tables: Tables, places: list[Array]) -> list[Array]:
    """Places of two characters that have pushed each other apart, [..., 2] each."""
    distance, way = direction(places[1] - places[0])
    depth = _soft_depth(distance - tables.radius.sum())[..., None] * way
    share = tables.mass[1] / tables.mass.sum()
    return [places[0] - share * depth, places[1] + (1 - share) * depth]


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
    for _ in range(CONTACTS if cast.count == 2 else 1):
        if cast.count == 2:
            places = pushed_apart(tables, places)
        places = [_out_of_walls(tables, who, at) for who, at in enumerate(places)]
    moved = [after - at for after, at in zip(places, before, strict=True)]
    return xp.concatenate([*places, *moved], axis=-1)
