"""What happens in a plane, and what viewers make of it: pure functions of NumPy or JAX arrays.

States and actions as in worlds/plane/spec.py. n characters, P places, W segments of walls,
K nodes of the quadrature, O observers, H hypotheses. docs/plane.md tells the mathematics.

A frame in which a character moves by u costs it (|u|^2 + s^2) / (2 s), s being the speed that it
likes: the square of its velocity, and the time. So the cost to go of who wants to be somewhere is
the length of the shortest way there, and s is the best speed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

from i2pdsl.audience.filter import log_sum
from i2pdsl.worlds.plane.geometry import nearest_on, norm

Array = Any

SOFTNESS = 0.02  # units over which contact sets in
PREDICATE_SOFTNESS = 0.2  # units over which the smooth step of a predicate rises
TOUCH = 0.05  # units between the edges of two that touch
MOVED = 0.005  # units in a frame that are seen as a motion
SIGHT = 1.0  # units by which a free line of sight counts as free
FACING = math.cos(math.pi / 4)  # of the largest angle between a motion and what it faces
CONTACTS = 2  # rounds of pushing apart in a frame
PI = math.pi


@dataclass(frozen=True)
class Cast:
    """What a compiled program depends on: how many characters there are, which of them has an
    attitude, and how viewers weigh what they see (spec.py, `observer`)."""

    count: int
    social: int | None
    steps: bool
    paths: bool


class Plans(NamedTuple):
    """What one character can be after, M plans, as weights of all costs that there are.

    What can be wanted is, in this order: each place, nothing, and of two characters to be near the
    other or far from it: D in all.

    Attributes:
        own [D, M]: 1 for what it wants.
        theirs [D, M]: its attitude, for what the other wants as it knows.
        spots [2 P, M]: 1 for where it must be to help (p) or hinder (P + p) the other on its way
            to place p.
        rows [M + 1, H]: 1 for its plan under each hypothesis; M: it moves at random.
    """

    own: Array
    theirs: Array
    spots: Array
    rows: Array


class Tables(NamedTuple):
    """The numbers of a plane.

    Attributes:
        size [2]; walls [W, 2, 2]; places [P, 2]; place_radius [P].
        radius, speed, fastest, mass [n].
        detours: for each character [rows, columns, P]: by how much its shortest way to each place
            is longer than the straight line; empty where there are no walls.
        detour_scale [n, 2]: nodes per unit.
        pairs: for each character [rows, columns, rows, columns], the same between any two points;
            empty where there are no walls or nobody else.
        pair_scale [n, 2].
        plans: of each character.
        safe: the distance at which who avoids the other is content.
        beta [O]; by_path [O]: whether an observer weighs the path rather than steps.
        nodes [K, 2]: of a quadrature over the unit disc; log_weights [K].
        log_prior [O, H]; forgetting [O].
    """

    size: Array
    walls: Array
    places: Array
    place_radius: Array
    radius: Array
    speed: Array
    fastest: Array
    mass: Array
    detours: tuple[Array, ...]
    detour_scale: Array
    pairs: tuple[Array, ...]
    pair_scale: Array
    plans: tuple[Plans, ...]
    safe: Array
    beta: Array
    by_path: Array
    nodes: Array
    log_weights: Array
    log_prior: Array
    forgetting: Array


# What happens.


def each(numbers: Array, count: int) -> list[Array]:
    """The first numbers of each character, two by two: [..., 2 n or more] as n of [..., 2]."""
    return [numbers[..., 2 * who : 2 * who + 2] for who in range(count)]


def _soft_depth(gap: Array) -> Array:
    """How far two bodies are pushed apart whose edges are so far apart; smooth at 0."""
    xp = gap.__array_namespace__()
    between = (SOFTNESS - xp.clip(gap, -SOFTNESS, SOFTNESS)) ** 2 / (4 * SOFTNESS)
    return between + xp.maximum(-SOFTNESS - gap, 0.0)


def _direction(apart: Array) -> tuple[Array, Array]:
    """Lengths [...] and unit vectors [..., 2]; 0 where the length is 0."""
    xp = apart.__array_namespace__()
    length = norm(apart)
    return length, apart / xp.where(length > 0, length, 1.0)[..., None]


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
            length, away = _direction(chosen)
            place = place + _soft_depth(length - radius)[..., None] * away
    return xp.clip(place, radius, tables.size - radius)


def _apart(tables: Tables, places: list[Array]) -> list[Array]:
    """Places of two characters that have pushed each other apart, [..., 2] each."""
    distance, way = _direction(places[1] - places[0])
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
            places = _apart(tables, places)
        places = [_out_of_walls(tables, who, at) for who, at in enumerate(places)]
    moved = [after - at for after, at in zip(places, before, strict=True)]
    return xp.concatenate([*places, *moved], axis=-1)


# Ways.


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


def _detours(tables: Tables, who: int, place: Array) -> tuple[Array, Array]:
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
    return straight + _detours(tables, who, place)[0] if tables.walls.shape[0] else straight


def _around(radius: Array, start: Array, end: Array) -> tuple[Array, Array]:
    """The length of the way from a point to one on a circle about the origin that does not cross
    it (straight, or along the tangent and the arc), and its gradient by the first: [...], [..., 2].
    """
    xp = start.__array_namespace__()
    distance, outward = _direction(start)
    distance = xp.maximum(distance, 1.001 * radius)
    cross = start[..., 0] * end[..., 1] - start[..., 1] * end[..., 0]
    dot = (start * end).sum(-1)
    angle = xp.arctan2(xp.abs(cross), xp.where((cross == 0) & (dot == 0), 1.0, dot))
    seen = xp.arccos(radius / distance)  # how far round the circle is in sight
    tangent = xp.sqrt(distance**2 - radius**2)
    straight, back = _direction(start - end)
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
        found = [_detours(tables, who, places[who]) for who in range(cast.count)]
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
    _, away = _direction(other[..., None, :] - tables.places)
    if slope is not None:
        away = _direction(away + slope[1 - social])[1]
    touch = tables.radius.sum()
    spots = touch * xp.concatenate([away, -away], axis=-2)  # [..., 2 P, 2], from the other
    me, other = me[..., None, :], other[..., None, :]
    length, gradient = _around(touch, xp.broadcast_to(me - other, spots.shape), spots)
    if slope is None:
        return length, gradient
    longer, by_me, _ = _pair_detours(tables, social, me, other + spots)
    return length + longer, gradient + by_me


# What it costs.


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


def _by_hypothesis(plans: Plans, found: Array, at_random: Array | float) -> Array:
    """A number of each plan [..., M], and that of moving at random, for each hypothesis."""
    count = plans.own.shape[1]
    return found @ plans.rows[:count] + at_random * plans.rows[count]


def value(tables: Tables, cast: Cast, who: int, state: Array) -> Array:
    """A character's value of a state, minus its cost to go: [..., O, H]; 0 for one that moves at
    random."""
    xp = state.__array_namespace__()
    known = outlook(tables, cast, state)
    found = _by_hypothesis(tables.plans[who], -costs_here(tables, cast, who, known), 0.0)
    return xp.broadcast_to(found[..., None, :], (*state.shape[:-1], *tables.log_prior.shape))


# What viewers make of it.


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
        then = _apart(tables, then)
    ahead = costs_to_go(tables, cast, who, known, then)
    return step_cost(tables, who, tried)[..., None] + ahead


def alternatives(
    tables: Tables, cast: Cast, who: int, known: Outlook, moving: list[Array]
) -> tuple[Array, Array]:
    """The velocities of the quadrature [K, 2], what each costs in each plan [..., K, M]."""
    tried = tables.fastest[who] * tables.nodes
    return tried, lookahead(tables, cast, who, known, moving, tried)


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
            found.append(-beta * spent[..., None, :] - xp.log(2 * PI * tables.speed[who] / beta))
        sensible = found[0]
        if len(found) == 2:
            sensible = xp.where(tables.by_path[:, None], found[1], found[0])
        at_random = -xp.log(PI * tables.fastest[who] ** 2)
        rows.append(_by_hypothesis(tables.plans[who], sensible, at_random))
    return tuple(rows)


# What can be asked of a frame.


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
    """Where another character or a place is, [..., 2]."""
    return places[spot] if isinstance(spot, int) else tables.places[spot[0]]


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
    moved = after[..., after.shape[-1] // 2 :]
    moved = moved.reshape(*moved.shape[:-1], -1, 2)
    return (moved**2).sum(-1).max(-1) < MOVED**2


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
        (place,) = arguments[1]
        margin = tables.place_radius[place] - norm(here - tables.places[place])
        return _smooth(margin >= 0, xp.asarray(margin))
    if name == "sees":
        return _sees(tables, here, _spot(tables, places, arguments[1]))
    if name in ("touching", "distance"):
        apart = norm(here - places[arguments[1]])
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
    (place,) = arguments[1]  # progress
    then = each(before, count)[who]
    ways = [ways_to_places(tables, who, at)[..., place] for at in (then, here)]
    return ways[0] - ways[1]
