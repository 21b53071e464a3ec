"""The numbers of a plane, and what is known of its cast: what all modules about it work on.

States and actions as in worlds/plane/spec.py. n characters, P places, W segments of walls,
K nodes of the quadrature, O observers, H hypotheses. All functions of these are pure, of NumPy or
JAX arrays: what happens (dynamics.py), how far it is (ways.py), what it costs (costs.py), what
viewers make of it (observers.py), what can be asked (features.py). docs/plane.md tells the
mathematics.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

from i2pdsl.audience.filter import Switching

Array = Any


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
        switching: how each character's goal changes after its moves; empty if none does.
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
    switching: tuple[Switching, ...] = ()


def each(numbers: Array, count: int) -> list[Array]:
    """The first numbers of each character, two by two: [..., 2 n or more] as n of [..., 2]."""
    return [numbers[..., 2 * who : 2 * who + 2] for who in range(count)]
