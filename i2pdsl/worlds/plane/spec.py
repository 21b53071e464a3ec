"""A plane as data: its size, walls, places and characters, and what stories may replace of them.
No arrays and no JAX: the checker needs only this.

Lengths are in units of the plane, times in frames. x grows to the east (right), y to the north
(up), (0, 0) is the lower left corner; directions are in degrees, 0 east and 90 north.

States are [..., 4 n] for n characters in the order of the spec: first all positions (x_1, y_1,
x_2, y_2), then how far each moved in the last frame (dx_1, dy_1, dx_2, dy_2; 0 at the start).
Actions are [..., 2 n]: the velocity that each character tries, in units a frame (vx_1, vy_1, ...);
above its greatest speed it is cut to it, and walls and the other character may stop or push it.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any, ClassVar

KIND = "plane"
NO_GOAL = "none"
APPROACH, AVOID = "approach", "avoid"  # the goals to be near the other, and far from it

Point = tuple[float, float]


@dataclass(frozen=True)
class Wall:
    """A line through points, without thickness; closed, it is the outline of a solid block."""

    points: tuple[Point, ...]
    closed: bool = False
    color: str = "#7d6b5d"

    @property
    def segments(self) -> tuple[tuple[Point, Point], ...]:
        """Its straight parts, from point to point."""
        ends = (*self.points, self.points[0]) if self.closed else self.points
        return tuple(pairwise(ends))


@dataclass(frozen=True)
class Place:
    """Somewhere to go: a round spot. Who wants to be there wants to be at its middle."""

    name: str
    at: Point
    radius: float = 0.5
    color: str = "#e58aa8"


@dataclass(frozen=True)
class PlaneCharacter:
    """A disc that acts.

    Attributes:
        at: where it stands at the start, unless the story says otherwise.
        speed: the speed that it likes best, in units a frame; it can go twice as fast.
        mass: of two that push each other, the lighter one gives way more.
        goals: places, `approach`, `avoid` (the other character) and `none`.
        toward: the other character whom it has an attitude to, of the values `attitude`.
    """

    name: str
    at: Point
    radius: float = 0.4
    speed: float = 0.1
    mass: float = 1.0
    goals: tuple[str, ...] = (NO_GOAL,)
    toward: str | None = None
    attitude: tuple[float, ...] = ()
    sprite: str = "blob"
    color: str = "#7c9cc0"

    @property
    def attitudes(self) -> tuple[tuple[str, tuple[float, ...]], ...]:
        return ((self.toward, self.attitude),) if self.toward else ()

    @property
    def misreads(self) -> tuple[str, ...]:
        return ()

    @property
    def via(self) -> tuple[str, ...]:
        return ()

    @property
    def supposes(self) -> tuple[tuple[str, tuple[str, ...]], ...]:
        return ()

    @property
    def fastest(self) -> float:
        """Its greatest speed, in units a frame."""
        return 2 * self.speed


@dataclass(frozen=True)
class PlaneSettings:
    """The numbers of a plane that a story may replace: `world room(beta = 10)`."""

    beta: float = 8.0  # inverse temperature: how sharply characters prefer what costs least
    safe: float = 4.0  # the distance at which who avoids the other is content
    observer: str = "step"  # step | path: whether viewers weigh steps or the path so far
    forgetting: float = 0.005  # the share of belief that is reassigned after each move
    switching: float = 0.0  # the chance that who moved wants something else from then on


@dataclass(frozen=True)
class PlaneSpec:
    """A plane; characters stand in the order of the file. `shares` is what viewers think of latents
    at first: pairs of a value and its weight."""

    name: str
    width: float
    height: float
    walls: tuple[Wall, ...]
    places: tuple[Place, ...]
    characters: tuple[PlaneCharacter, ...]
    settings: PlaneSettings = field(default_factory=PlaneSettings)
    floor: str = "#f1e8d8"
    documentation: str = ""
    source: str = ""
    shares: tuple[tuple[str, tuple[tuple[Any, float], ...]], ...] = ()
    kind: ClassVar[str] = KIND

    @property
    def segments(self) -> tuple[tuple[Point, Point], ...]:
        """The straight parts of all walls; the edge of the plane is none of them."""
        return tuple(part for wall in self.walls for part in wall.segments)

    @property
    def social(self) -> PlaneCharacter | None:
        """The character with an attitude, if there is one."""
        return next((c for c in self.characters if c.toward), None)

    def with_settings(self, changes: dict[str, Any]) -> PlaneSpec:
        """The same plane with some of its numbers replaced."""
        return replace(self, settings=replace(self.settings, **changes))
