"""A state of a plane in characters: walls, and places and discs with a letter in their middle."""

from __future__ import annotations

from collections.abc import Iterable
from math import cos, pi, sin
from typing import NamedTuple

import numpy as np

from i2pdsl.errors import display_width
from i2pdsl.render.characters import Canvas, Ink, laid_out
from i2pdsl.worlds.plane.spec import PlaneSpec

WALLS, PLACES = 5, 2  # the numbers, and with them colours and letters, of what stands still
ROWS = 22  # at most


class Plan(Canvas):
    """A canvas with letters over its dots."""

    def __init__(self, columns: int, rows: int, ink: Ink):
        super().__init__(columns, rows, ink)
        self.letters: dict[tuple[int, int], str] = {}

    def letter(self, x: float, y: float, sign: str) -> None:
        """A letter, in its colour, at the character of a dot."""
        column, row = round(x) // self.across, round(y) // self.down
        self.letters[min(row, self.rows - 1), min(column, self.columns - 1)] = sign

    def ring(self, x: float, y: float, across: float, down: float, number: int) -> None:
        """An ellipse about a dot."""
        count = max(8, int(4 * (across + down)))
        for k in range(count):
            angle = 2 * pi * k / count
            self.dot(round(x + across * cos(angle)), round(y + down * sin(angle)), number)

    def lines(self) -> list[str]:
        return [
            "".join(
                self.letters.get((r, c)) or self._sign(int(dots), int(owner))
                for c, (dots, owner) in enumerate(zip(row, owners, strict=True))
            ).rstrip()
            for r, (row, owners) in enumerate(zip(self.dots, self.owner, strict=True))
        ]


def plane_in_characters(spec: PlaneSpec, state: np.ndarray, ink: Ink) -> str:
    """The plane with everybody in it, and who is who and where."""
    # A character is about twice as high as it is wide.
    columns = min(72, max(ink.columns - 6, 20))
    rows = max(3, round(columns * spec.height / spec.width / 2))
    if rows > ROWS:
        columns, rows = max(3, round(ROWS * 2 * spec.width / spec.height)), ROWS
    plan = Plan(columns, rows, ink)
    scale = np.array([(plan.size[0] - 1) / spec.width, (plan.size[1] - 1) / spec.height])

    def dot(point: Iterable[float]) -> tuple[float, float]:
        x, y = point
        return x * scale[0], (spec.height - y) * scale[1]

    corners = [(0.0, 0.0), (spec.width, 0.0), (spec.width, spec.height), (0.0, spec.height)]
    edges = zip(corners, (*corners[1:], corners[0]), strict=True)
    for first, second in (*edges, *spec.segments):
        plan.line(*dot(first), *dot(second), WALLS)
    points = state[: 2 * len(spec.characters)].reshape(-1, 2)
    signs = _letters([c.name.upper() for c in spec.characters])
    told = [
        _Spot((x, y), c.radius, number, sign, f"1;{_code(c.color)}", f"{c.name} ({x:.1f}, {y:.1f})")
        for number, (c, (x, y), sign) in enumerate(zip(spec.characters, points, signs, strict=True))
    ]
    names = _letters([p.name.lower() for p in spec.places])
    told += [
        _Spot(p.at, p.radius, PLACES, sign, _code(p.color), p.name)
        for p, sign in zip(spec.places, names, strict=True)
    ]
    for spot in reversed(told):  # discs cover the places that they stand on
        x, y = dot(spot.at)
        plan.ring(x, y, spot.radius * scale[0], spot.radius * scale[1], spot.owner)
        plan.letter(x, y, ink.paint(spot.sign, spot.code))
    legend = [(f"{s.sign} {s.told}", f"{ink.paint(s.sign, s.code)} {s.told}") for s in told]
    lines = ["    " + line for line in plan.lines()]
    return "\n".join((*lines, *laid_out(legend, 2, 4, ink.columns)))


class _Spot(NamedTuple):
    """Something round: where, how large, as whose dots, and how its letter and it are told."""

    at: tuple[float, float]
    radius: float
    owner: int
    sign: str
    code: str
    told: str


def _letters(names: Iterable[str]) -> list[str]:
    """A letter for each, as near to the front of its name as others leave it."""
    found: list[str] = []
    for name in names:
        free = [c for c in name if c.isalnum() and display_width(c) == 1 and c not in found]
        found.append(free[0] if free else "?")
    return found


def _code(color: str) -> str:
    """A colour of the world as a code of ANSI terminals."""
    red, green, blue = (int(color[k : k + 2], 16) for k in (1, 3, 5))
    return f"38;2;{red};{green};{blue}"
