"""A plane with its shortest ways known: the World protocol over plane/tables.py."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import product
from typing import Any

import numpy as np

from i2pdsl.audience.filter import Switching
from i2pdsl.language import typed as ty
from i2pdsl.language.vocabulary import Vocabulary
from i2pdsl.worlds.continuous import ContinuousWorld
from i2pdsl.worlds.hypotheses import ATTITUDE, goal_of, rationality_of
from i2pdsl.worlds.plane import costs, dynamics, features, observers
from i2pdsl.worlds.plane.geometry import (
    MOST_NODES,
    MOST_PAIRS,
    Ways,
    clearance,
    disc,
    regular_grid,
)
from i2pdsl.worlds.plane.hypotheses import plane_hypotheses
from i2pdsl.worlds.plane.naive import walks, wandering
from i2pdsl.worlds.plane.spec import APPROACH, AVOID, NO_GOAL, PlaneCharacter, PlaneSpec
from i2pdsl.worlds.plane.tables import Cast, Plans, Tables
from i2pdsl.worlds.plane.vocabulary import plane_vocabulary
from i2pdsl.worlds.world import Part, Viewer, forgetting_of, log_priors, switching_of

Array = Any

DIRECTIONS, SPEEDS = 16, 3  # of the viewers' quadrature


@dataclass(frozen=True)
class PlaneWorld(ContinuousWorld):
    """A plane as the audience, the objectives and the searches see it.

    Attributes:
        spec: the plane as it is; viewers may believe in other numbers.
        tables: the arrays, in NumPy and doubles (Tables).
    """

    spec: PlaneSpec
    tables: Tables
    cast: Cast

    @cached_property
    def vocabulary(self) -> Vocabulary:
        return plane_vocabulary(self.spec)

    @property
    def action_shape(self) -> tuple[int, ...]:
        """Velocities of all characters."""
        return (2 * self.cast.count,)

    # The protocol (worlds/world.py).

    def program_key(self, turns: tuple[ty.Turn, ...]) -> tuple[Any, ...]:
        return (self.cast,)

    def no_action(self, state: Array) -> Array:
        return state[..., : 2 * self.cast.count] * 0

    def transition(self, tables: Tables, state: Array, action: Array) -> Array:
        return dynamics.transition(tables, self.cast, state, action)

    def log_rows(
        self, tables: Tables, state: Array, action: Array, after: Array
    ) -> tuple[Array, ...]:
        return observers.rows(tables, self.cast, state, action, after)[0]

    def best_rows(
        self, tables: Tables, state: Array, action: Array, after: Array
    ) -> tuple[Array, ...]:
        return observers.rows(tables, self.cast, state, action, after)[1]

    def outcome(
        self, tables: Tables, state: Array, action: Array
    ) -> tuple[Array, tuple[Array, ...], tuple[Array, ...]]:
        after = self.transition(tables, state, action)
        return after, *observers.rows(tables, self.cast, state, action, after)

    def value(self, tables: Tables, who: int, state: Array) -> Array:
        return costs.value(tables, self.cast, who, state)

    def feature(
        self,
        tables: Tables,
        name: str,
        arguments: tuple[Any, ...],
        state: Array,
        before: Array | None = None,
        action: Array | None = None,
    ) -> Array:
        return features.feature(tables, name, arguments, state, before, action)

    def feature_arguments(self, name: str, arguments: tuple[Any, ...]) -> tuple[Any, ...]:
        """The checker's places as numbers of places, its points as arrays [2]."""

        def own(argument: Any) -> Any:
            if isinstance(argument, ty.Point):
                return np.array([argument.x, argument.y])
            if isinstance(argument, tuple):
                return tuple(number for number, _ in argument)
            return argument

        return tuple(map(own, arguments))

    def is_still(self, tables: Tables, state: Array, after: Array) -> Array:
        return features.is_still(after)

    def stillness(self, tables: Tables, state: Array, after: Array) -> Array:
        return features.stillness(tables, state, after)

    def with_audience(self, sharpness: float, forgetting: Array, log_prior: Array) -> PlaneWorld:
        beta = sharpness * self.tables.beta
        told = {"beta": beta, "forgetting": forgetting, "log_prior": log_prior}
        switching = tuple(each.given(log_prior) for each in self.tables.switching)
        return replace(self, tables=self.tables._replace(**told, switching=switching))

    def switching(self, tables: Tables) -> tuple[Switching | None, ...]:
        return tables.switching or (None,) * self.cast.count

    # Beginnings.

    def starts(self, points: Sequence[ty.Point] = (), parts: Sequence[Part] = ()) -> np.ndarray:
        """The first pictures: everybody where the file says, then anybody in the middle of each
        place or at a point instead, as long as nobody overlaps or stands in a wall."""
        cast = self.spec.characters
        options = [
            (c.at, *(place.at for place in self.spec.places), *self._free(c, points)) for c in cast
        ]
        places = np.array(list(product(*options))).reshape(-1, 2 * len(cast))
        if len(cast) == 2:
            apart = np.hypot(*(places[:, :2] - places[:, 2:]).T)
            places = places[apart >= self.tables.radius.sum()]
        return np.concatenate([places, 0 * places], axis=1)

    def _free(self, who: PlaneCharacter, points: Sequence[ty.Point]) -> list[tuple[float, float]]:
        """The points at which a character has room."""
        r, (width, height) = who.radius, self.tables.size
        return [
            (p.x, p.y)
            for p in points
            if r <= p.x <= width - r
            and r <= p.y <= height - r
            and clearance(self.tables.walls, np.array([p.x, p.y])) >= r
        ]

    def guesses(
        self, length: int, seeds: int, noise: float, seed: int, state: np.ndarray
    ) -> np.ndarray:
        """What a descent begins with: everybody does what is best for him under some hypothesis,
        at some pace, not quite steadily; [seeds, length, 2 n].

        Args:
            noise: standard deviation of the changes, in units of the speed that each likes.
            state: where the script goes on from.
        """
        rational = np.flatnonzero(self.rational)
        generator = np.random.default_rng(seed)
        hypotheses = generator.permutation(rational)[np.arange(seeds) % len(rational)]
        pace = generator.choice([0.7, 1.0, 1.4], size=(seeds, self.cast.count))
        changes = wandering(generator, noise, (seeds, length, self.cast.count, 2))
        start = np.repeat(np.asarray(state, float)[None], seeds, axis=0)
        return walks(self.tables, self.cast, start, hypotheses, changes, pace).actions

    @property
    def rational(self) -> np.ndarray:
        """The hypotheses under which nobody moves at random, [H]."""
        return np.all([plans.rows[-1] == 0 for plans in self.tables.plans], axis=0)


def build_plane(spec: PlaneSpec, viewers: tuple[Viewer, ...] | None = None) -> PlaneWorld:
    """Finds the shortest ways among the walls, and puts the viewers' numbers side by side."""
    viewers = viewers or (Viewer(spec),)
    cast = spec.characters
    each = lambda key: np.array([float(getattr(c, key)) for c in cast])
    social = next((i for i, c in enumerate(cast) if c.toward), None)
    steps = [v.spec.settings.observer == "step" for v in viewers]
    detours, detour_scale, pairs, pair_scale = _ways(
        spec.segments, each_radius(spec), tuple(p.at for p in spec.places), spec.width, spec.height
    )
    nodes, weights = disc(DIRECTIONS, SPEEDS)
    words = plane_vocabulary(spec)
    log_prior = log_priors(viewers, words)
    tables = Tables(
        size=np.array([spec.width, spec.height]),
        walls=np.array(spec.segments, float).reshape(-1, 2, 2),
        places=np.array([p.at for p in spec.places], float).reshape(-1, 2),
        place_radius=np.array([p.radius for p in spec.places], float),
        radius=each("radius"),
        speed=each("speed"),
        fastest=each("fastest"),
        mass=each("mass"),
        detours=detours,
        detour_scale=detour_scale,
        pairs=pairs,
        pair_scale=pair_scale,
        plans=tuple(_plans(spec, who, who == social) for who in range(len(cast))),
        safe=np.array(spec.settings.safe),
        beta=np.array([v.sharpness * v.spec.settings.beta for v in viewers]),
        by_path=~np.array(steps),
        nodes=nodes,
        log_weights=np.log(weights),
        log_prior=log_prior,
        forgetting=forgetting_of(viewers, [v.spec.settings.forgetting for v in viewers]),
        switching=switching_of(viewers, words, log_prior),
    )
    return PlaneWorld(spec, tables, Cast(len(cast), social, any(steps), not all(steps)))


def _plans(spec: PlaneSpec, who: int, social: bool) -> Plans:
    """What a character can be after, and in which hypotheses it is."""
    count = len(spec.places)
    options = {
        **{place.name: number for number, place in enumerate(spec.places)},
        NO_GOAL: count,
        APPROACH: count + 1,
        AVOID: count + 2,
    }
    name, other = spec.characters[who].name, spec.characters[1 - who].name if social else None
    keys: list[tuple[int, int, float] | None] = []
    for row in plane_hypotheses(spec):
        if not row[rationality_of(name)]:
            keys.append(None)
            continue
        rho = float(row.get(ATTITUDE, 0.0)) if social else 0.0
        theirs = options[str(row[goal_of(other)])] if other and rho else count
        keys.append((options[str(row[goal_of(name)])], theirs, rho))
    plans = [key for key in dict.fromkeys(keys) if key is not None]
    wants = count + (3 if len(spec.characters) == 2 else 1)
    own, others = np.zeros((2, len(plans), wants))
    spots = np.zeros((len(plans), 2 * count))
    for number, (wanted, theirs, rho) in enumerate(plans):
        own[number, wanted] = 1
        others[number, theirs] = rho
        if rho and theirs < count:
            spots[number, theirs + count * (rho < 0)] = 1
    rows = np.array([len(plans) if key is None else plans.index(key) for key in keys])
    return Plans(
        own=own.T,
        theirs=others.T,
        spots=spots.T,
        rows=np.eye(len(plans) + 1)[rows].T,
    )


def each_radius(spec: PlaneSpec) -> tuple[float, ...]:
    """The radii of the characters."""
    return tuple(c.radius for c in spec.characters)


@lru_cache(maxsize=8)
def _ways(
    segments: tuple[Any, ...],
    radii: tuple[float, ...],
    places: tuple[Any, ...],
    width: float,
    height: float,
) -> tuple[tuple[np.ndarray, ...], np.ndarray, tuple[np.ndarray, ...], np.ndarray]:
    """The detours of each character to all places, and between all points; nodes per unit."""
    if not segments:
        nothing = tuple(np.zeros((0, 0, 0)) for _ in radii)
        return nothing, np.ones((len(radii), 2)), nothing, np.ones((len(radii), 2))
    walls = np.array(segments, float)
    to_places, scales, pairs, pair_scales = [], [], [], []
    for radius in radii:
        ways = Ways(walls, radius, width, height)
        grid = regular_grid(width, height, radius / 3, MOST_NODES)
        detours = ways.detours(grid.nodes, np.array(places, float).reshape(-1, 2))
        to_places.append(detours.reshape(grid.rows, grid.columns, -1))
        scales.append(grid.scale)
        grid = regular_grid(width, height, radius / 1.5, MOST_PAIRS)
        shape = (grid.rows, grid.columns)
        between = ways.detours(grid.nodes, grid.nodes) if len(radii) == 2 else np.zeros((0, 0))
        pairs.append(between.reshape(*shape, *shape) if between.size else between)
        pair_scales.append(grid.scale)
    return tuple(to_places), np.array(scales), tuple(pairs), np.array(pair_scales)
