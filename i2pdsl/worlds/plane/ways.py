"""How far it is: shortest ways among walls and around each other, and their gradients."""

from __future__ import annotations

from typing import Any, NamedTuple

from i2pdsl.worlds.plane.geometry import direction, norm
from i2pdsl.worlds.plane.tables import Cast, Tables, each

Array = Any


def _cell(scale: Array, rows: int, columns: int, place: Array) -> tuple[Array, Array, Array]:
    """The grid's cell about a place: its four nodes' numbers [..., 4], their shares in a bilinear
    interpolation [..., 4], and the gradients of these [..., 4, 2]."""
    xp = place.__array_namespace__()
    x, y = place[..., 0] * scale[0], place[..., 1] * scale[1]
    column, row = xp.clip(xp.floor(x), 0, columns - 2), xp.clip(xp.floor(y), 0, rows - 2)
    right, up = x - column, y - row
    left, down = 1 - right, 1 - up
    first = (row * columns + column).astype(xp.int32)
    numbers = xp.stack([first, first + 1, first + columns, first + columns + 1], axis=-1)
    shares = xp.stack([left * down, right * down, left * up, right * up], axis=-1)
    east = xp.stack([-down, down, -up, up], axis=-1) * scale[0]
    north = xp.stack([-left, -right, left, right], axis=-1) * scale[1]
    return numbers, shares, xp.stack([east, north], axis=-1)


def detours(tables: Tables, who: int, place: Array) -> tuple[Array, Array]:
    """By how much the ways to all places are longer than straight lines, [..., P], and the
    gradients of that [..., P, 2]."""
    table = tables.detours[who]
    rows, columns, count = table.shape
    numbers, shares, slopes = _cell(tables.detour_scale[who], rows, columns, place)
    found = table.reshape(-1, count)[numbers]  # [..., 4, P]
    longer = (found * shares[..., None]).sum(-2)
    return longer, (found[..., None] * slopes[..., None, :]).sum(-3)


def _pair_detours(tables: Tables, who: int, start: Array, end: Array) -> tuple[Array, Array, Array]:
    """By how much the way between two points is longer than a straight line, [...], and the
    gradients by each of them, [..., 2]. The points may have different leading axes."""
    table = tables.pairs[who]
    rows, columns = table.shape[:2]
    scale = tables.pair_scale[who]
    numbers, shares, slopes = _cell(scale, rows, columns, start)
    others, other_shares, other_slopes = _cell(scale, rows, columns, end)
    pair = numbers[..., :, None] * (rows * columns) + others[..., None, :]
    found = table.reshape(-1)[pair]  # [..., 4, 4]
    by_start = (found * other_shares[..., None, :]).sum(-1)
    by_end = (found * shares[..., :, None]).sum(-2)
    longer = (by_start * shares).sum(-1)
    first = (by_start[..., None] * slopes).sum(-2)
    return longer, first, (by_end[..., None] * other_slopes).sum(-2)


def ways_to_places(tables: Tables, who: int, place: Array) -> Array:
    """The lengths of a character's shortest ways to all places, [..., P]."""
    straight = norm(place[..., None, :] - tables.places)
    return straight + detours(tables, who, place)[0] if tables.walls.shape[0] else straight


def _around(radius: Array, start: Array, end: Array) -> tuple[Array, Array]:
    """The length of the way from a point to one on a circle about the origin that does not cross
    it (straight, or along the tangent and the arc), and its gradient by the first: [...], [..., 2].
    """
    xp = start.__array_namespace__()
    distance, outward = direction(start)
    distance = xp.maximum(distance, 1.001 * radius)
    cross = start[..., 0] * end[..., 1] - start[..., 1] * end[..., 0]
    dot = (start * end).sum(-1)
    angle = xp.arctan2(xp.abs(cross), xp.where((cross == 0) & (dot == 0), 1.0, dot))
    seen = xp.arccos(radius / distance)  # how far round the circle is in sight
    tangent = xp.sqrt(distance**2 - radius**2)
    straight, back = direction(start - end)
    # Away from the end, across the line to the origin.
    side = xp.where(cross > 0, 1.0, -1.0)[..., None]
    sideways = side * xp.stack([outward[..., 1], -outward[..., 0]], axis=-1)
    slope = (tangent / distance)[..., None] * outward + (radius / distance)[..., None] * sideways
    direct = angle < seen
    length = xp.where(direct, straight, tangent + radius * (angle - seen))
    return length, xp.where(direct[..., None], back, slope)


class Outlook(NamedTuple):
    """What characters know from where they are: ways to first order about their places now.

    Where there are no walls, or nobody is social, the parts about them are None.

    Attributes:
        places: where they are, [..., 2] each.
        longer, slope: for each character the detours to all places, [..., P] and [..., P, 2].
        between: for each character the detour to the other, and its gradients by both.
        spots: the social character's ways to where it can help or hinder, [..., 2 P], and their
            gradients by its place, [..., 2 P, 2]; by that of the other where walls are in the way
            they are taken to be opposite.
    """

    places: list[Array]
    longer: tuple[Array, ...] | None
    slope: tuple[Array, ...] | None
    between: tuple[tuple[Array, Array, Array], ...] | None
    spots: tuple[Array, Array] | None


def outlook(tables: Tables, cast: Cast, state: Array) -> Outlook:
    """What characters know from a state."""
    places = each(state, cast.count)
    longer = slope = between = None
    if tables.walls.shape[0]:
        found = [detours(tables, who, places[who]) for who in range(cast.count)]
        longer, slope = tuple(f[0] for f in found), tuple(f[1] for f in found)
        if cast.count == 2:
            between = tuple(_pair_detours(tables, w, places[w], places[1 - w]) for w in (0, 1))
    spots = None
    if cast.social is not None:
        spots = _ways_to_spots(tables, cast.social, places, slope)
    return Outlook(places, longer, slope, between, spots)


def _ways_to_spots(
    tables: Tables, social: int, places: list[Array], slope: tuple[Array, ...] | None
) -> tuple[Array, Array]:
    """How far the social character has to go to where it can push the other towards each place
    (behind it) or keep it away (before it), and the gradients: [..., 2 P], [..., 2 P, 2]."""
    xp = places[0].__array_namespace__()
    me, other = places[social], places[1 - social]
    _, away = direction(other[..., None, :] - tables.places)
    if slope is not None:
        away = direction(away + slope[1 - social])[1]
    touch = tables.radius.sum()
    spots = touch * xp.concatenate([away, -away], axis=-2)  # [..., 2 P, 2], from the other
    me, other = me[..., None, :], other[..., None, :]
    length, gradient = _around(touch, xp.broadcast_to(me - other, spots.shape), spots)
    if slope is None:
        return length, gradient
    longer, by_me, _ = _pair_detours(tables, social, me, other + spots)
    return length + longer, gradient + by_me
