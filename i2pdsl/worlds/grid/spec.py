"""What a .world file says, as plain data. No arrays and no JAX: the checker needs only this."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from typing import Any, ClassVar

ACTIONS = ("north", "south", "east", "west", "stay")
STAY = 4
OFFSETS = ((0, -1), (0, 1), (1, 0), (-1, 0), (0, 0))  # (column, row), in the order of ACTIONS
NO_GOAL = "none"
WALL = "#"
FLOOR = "."
MOST_SEEN = 2000  # cells of a map on which sight is known: a table has a number for each pair
GROUNDS = ("checker", "boards", "grass", "plain")


@dataclass(frozen=True)
class Tile:
    """A kind of floor that can be a goal; it may lie on several cells (column, row)."""

    name: str
    cells: tuple[tuple[int, int], ...]
    color: str
    sprite: str = ""


@dataclass(frozen=True)
class Character:
    """Someone who acts. `toward` names the other character whom this one has an attitude to."""

    name: str
    success: float = 1.0
    goals: tuple[str, ...] = ()
    pushes: tuple[str, ...] = ()
    toward: str | None = None
    attitude: tuple[float, ...] = ()
    models: str | None = None
    sprite: str = "blob"
    color: str = "#7c9cc0"

    @property
    def is_weak(self) -> bool:
        return self.success < 1.0


@dataclass(frozen=True)
class Thing:
    """An object that stands in the way, and can be pushed by those who push it."""

    name: str
    may_be_absent: bool = False
    sprite: str = "box"
    color: str = "#b08a5a"


@dataclass(frozen=True)
class Look:
    """How a world is drawn, besides its colours.

    Attributes:
        frame: the colour of what lies around the map; empty for one that suits the walls.
        ground: one of GROUNDS.
        wall_sprite: what every wall is drawn as; empty for a block.
        drawings: the own sprites that the file names, and what is kept of them
            (worlds/drawings.py); without those that are not known.
    """

    frame: str = ""
    ground: str = GROUNDS[0]
    wall_sprite: str = ""
    drawings: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Settings:
    """The numbers of a world (model.md), which a story may replace: `world kitchen(beta = 1)`."""

    goal: float = 1.0  # reward for acting on one's goal tile
    move: float = -1.0  # reward of any move, also of one that fails
    stay: float = -0.1  # reward of staying
    gamma: float = 0.99  # discount factor
    beta: float = 2.0  # inverse temperature of the softmax policies
    level0: str = "uniform"  # how the modelled one believes that the other acts: uniform | costs
    forgetting: float = 1e-5  # epsilon, the share of belief that is reassigned after each action
    hypotheses: str = "merged"  # merged | literal (the paper's tuple taken word by word)


@dataclass(frozen=True)
class GridSpec:
    """A grid world. `rows` is the map, `#` a wall; characters stand in the order of acting."""

    kind: ClassVar[str] = "grid"
    name: str
    rows: tuple[str, ...]
    tiles: tuple[Tile, ...]
    characters: tuple[Character, ...]
    things: tuple[Thing, ...] = ()
    events: tuple[tuple[str, tuple[str, ...]], ...] = ()
    settings: Settings = field(default_factory=Settings)
    floor: str = "#f1e8d8"
    wall: str = "#7d6b5d"
    documentation: str = ""
    source: str = ""
    look: Look = field(default_factory=Look)

    @cached_property
    def free_cells(self) -> tuple[tuple[int, int], ...]:
        """The cells without a wall, as (column, row), row by row."""
        return tuple(
            (column, row)
            for row, line in enumerate(self.rows)
            for column, symbol in enumerate(line)
            if symbol != WALL
        )

    @property
    def entities(self) -> tuple[str, ...]:
        """The names of the characters and then of the things: the order of a state's cells."""
        return tuple(c.name for c in self.characters) + tuple(t.name for t in self.things)

    @property
    def state_count(self) -> int:
        """How many states there are: no two on a cell, absent things on none."""
        cells = len(self.free_cells)
        placed = {0: 1}  # number of things present -> number of ways to choose which
        for thing in self.things:
            grown = {k + 1: ways for k, ways in placed.items()}
            if thing.may_be_absent:
                for k, ways in placed.items():
                    grown[k] = grown.get(k, 0) + ways
            placed = grown
        total = 0
        for present, ways in placed.items():
            arrangements = ways
            for k in range(len(self.characters) + present):
                arrangements *= max(0, cells - k)
            total += arrangements
        return total

    @property
    def social(self) -> Character | None:
        """The character with an attitude, if there is one."""
        return next((c for c in self.characters if c.toward), None)

    @property
    def modeller(self) -> Character | None:
        """The character who plans against the other's policy (level 2), if there is one."""
        return self.social or next((c for c in self.characters if c.models), None)

    def character(self, name: str) -> Character:
        return next(c for c in self.characters if c.name == name)

    def with_settings(self, changes: dict[str, Any]) -> GridSpec:
        """The same world with some of its numbers replaced."""
        return replace(self, settings=replace(self.settings, **changes))

    @cached_property
    def planning_key(self) -> str:
        """A digest of all that planning depends on: not of drawing hints or documentation."""
        content = asdict(self)
        for key in ("name", "floor", "wall", "documentation", "source", "events", "look"):
            content.pop(key)
        content["settings"].pop("forgetting")
        content["settings"].pop("hypotheses")
        for group in ("tiles", "characters", "things"):
            for item in content[group]:
                item.pop("color", None)
                item.pop("sprite", None)
        text = json.dumps(content, sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:32]
