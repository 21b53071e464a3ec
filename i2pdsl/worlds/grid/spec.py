"""What a .world file says, as plain data. No arrays and no JAX: the checker needs only this."""

from __future__ import annotations

import hashlib
import json
import math
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from typing import Any, ClassVar

from i2pdsl.worlds.hypotheses import MOST_HYPOTHESES, count_at_most

ACTIONS = ("north", "south", "east", "west", "stay")
STAY = 4
DIAGONALS = ("north_east", "south_east", "south_west", "north_west")
PULLS = ("pull_north", "pull_south", "pull_east", "pull_west")
PUTS = ("put_north", "put_south", "put_east", "put_west")
ALL_ACTIONS = ACTIONS + DIAGONALS + PULLS + PUTS
OFFSETS = ((0, -1), (0, 1), (1, 0), (-1, 0), (0, 0))  # (column, row), in the order of ACTIONS
OFFSET_OF = dict(zip(ACTIONS, OFFSETS, strict=True)) | {
    **dict(zip(DIAGONALS, ((1, -1), (1, 1), (-1, 1), (-1, -1)), strict=True)),
    **dict(zip(PULLS, OFFSETS, strict=False)),
    **dict(zip(PUTS, OFFSETS, strict=False)),
}
NO_GOAL = "none"
WALL = "#"
FLOOR = "."
MOST_LISTED = 2**24  # arrangements of which a table is made in any case
MOST_SEEN = 2000  # cells of a map on which sight is known: a table has a number for each pair
Cell = tuple[int, int]  # (column, row)
Shares = tuple[tuple[str, tuple[tuple[Any, float], ...]], ...]
GROUNDS = ("checker", "boards", "grass", "plain")


@dataclass(frozen=True)
class Tile:
    """A kind of floor that can be a goal; it may lie on several cells (column, row).

    Attributes:
        cost: what each action of who stands there costs besides.
        one_way: the only directions in which anything gets onto its cells, and off them; any way
            where there are none.
    """

    name: str
    cells: tuple[tuple[int, int], ...]
    color: str
    sprite: str = ""
    cost: float = 0.0
    one_way: tuple[str, ...] = ()


@dataclass(frozen=True)
class Character:
    """Someone who acts.

    Attributes:
        attitudes: the others whom this one has an attitude to, and how large that may be.
        models: the others whose plans this one sees through; those of `attitudes` are among them.
        misreads: those of them of whom it may be wrong about what they want.
        supposes: the objects that it may want, and the tiles on which it may take each to be.
        via: tiles on one of which it may want to have been first.
        carries: the objects that it takes by stepping on their cells.
        puts_down: those of them that it can put down, or hand over, the first first.
        diagonals: whether it also moves aslant.
    """

    name: str
    success: float = 1.0
    goals: tuple[str, ...] = ()
    pushes: tuple[str, ...] = ()
    pulls: tuple[str, ...] = ()
    carries: tuple[str, ...] = ()
    puts_down: tuple[str, ...] = ()
    diagonals: bool = False
    attitudes: tuple[tuple[str, tuple[float, ...]], ...] = ()
    models: tuple[str, ...] = ()
    misreads: tuple[str, ...] = ()
    supposes: tuple[tuple[str, tuple[str, ...]], ...] = ()
    via: tuple[str, ...] = ()
    cell: Cell | None = None  # where it is at first; None where the story says
    sprite: str = "blob"
    color: str = "#7c9cc0"

    @property
    def is_weak(self) -> bool:
        return self.success < 1.0

    @property
    def actions(self) -> tuple[str, ...]:
        """What it can choose, in the order of ALL_ACTIONS: the pulls only if there is something
        that it pulls, and so on."""
        more = (DIAGONALS, self.diagonals), (PULLS, self.pulls), (PUTS, self.puts_down)
        return ACTIONS + sum((those for those, can in more if can), ())


@dataclass(frozen=True)
class Thing:
    """An object that stands in the way, and can be moved by those who push or pull it.

    Several of a `count` are all alike, so who is who of them is not part of a state. One that is
    `opened_by` others is a door: it is gone once somebody who carries one of those steps into it.
    """

    name: str
    may_be_absent: bool = False
    count: int = 1
    cells: tuple[Cell, ...] = ()  # where they are at first; none where the story says
    opened_by: tuple[str, ...] = ()
    sprite: str = "box"
    color: str = "#b08a5a"

    @property
    def names(self) -> tuple[str, ...]:
        """The names of them all: `box`, or `box_1`, `box_2`, ... in reading order of the map."""
        if self.count == 1:
            return (self.name,)
        return tuple(f"{self.name}_{i + 1}" for i in range(self.count))


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
    end: float = 0.0  # reward for standing on one's goal tile when the time is up (horizon)
    gamma: float = 0.99  # discount factor
    beta: float = 2.0  # inverse temperature of the softmax policies
    level0: str = "uniform"  # how the modelled one believes that the other acts: uniform | costs
    forgetting: float = 1e-5  # epsilon, the share of belief that is reassigned after each action
    switching: float = 0.0  # the chance that who acted wants something else from then on
    horizon: int = 0  # frames that there are in all; 0: planning has no end
    method: str = "auto"  # of planning: auto | exact | additive (additive.py)
    at_once: int = 3  # entities that additive planning plans for together
    states: str = "auto"  # of additive planning: auto | listed | computed (packed.py)
    hypotheses: str = "merged"  # merged | literal (the paper's tuple taken word by word)
    asked: str = ""  # the latents that are kept apart, where all hypotheses are too many


@dataclass(frozen=True)
class GridSpec:
    """A grid world. `rows` is the map, `#` a wall; characters stand in the order of acting. Who
    models whom has no circles.

    Attributes:
        walls: pairs of neighbouring cells between which there is a wall, the northern or western
            one first.
        together: whether both characters choose at the same time (model.py says what follows).
        shares: what viewers think of latents at first: pairs of a value and its weight.
    """

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
    walls: tuple[tuple[Cell, Cell], ...] = ()
    together: bool = False
    shares: Shares = ()

    @cached_property
    def free_cells(self) -> tuple[tuple[int, int], ...]:
        """The cells without a wall, as (column, row), row by row."""
        return tuple(
            (column, row)
            for row, line in enumerate(self.rows)
            for column, symbol in enumerate(line)
            if symbol != WALL
        )

    @cached_property
    def entities(self) -> tuple[str, ...]:
        """The names of the characters and then of the things: the order of a state's cells."""
        return tuple(c.name for c in self.characters) + tuple(
            name for thing in self.things for name in thing.names
        )

    @property
    def placed(self) -> tuple[Cell | None, ...]:
        """Where each entity is at first, as far as the world says so."""
        found = [c.cell for c in self.characters]
        for thing in self.things:
            found += thing.cells or (None,) * thing.count
        return tuple(found)

    @property
    def marks(self) -> tuple[tuple[int, str], ...]:
        """What a state remembers: the number of a character, and a tile where it has been or not.

        A mark is kept as if it were one more thing, which is absent until that character has it.
        """
        return tuple((who, tile) for who, c in enumerate(self.characters) for tile in c.via)

    @property
    def places(self) -> tuple[tuple[int, ...], ...]:
        """The numbers of the cells that each entity and then each mark can be on: those of the free
        cells; then that of absence; then, for what is carried, that of each character who has it.

        A door, or what is taken and not put down, is only where it is at first.
        """
        absent, everywhere = len(self.free_cells), tuple(range(len(self.free_cells)))
        found = [everywhere] * len(self.characters)
        for thing in self.things:
            if self.is_fixed(thing):
                first = self.free_cells.index(thing.cells[0])
                away = (absent,) if thing.opened_by else ()
                holders = self.holders(thing.name)
                found.append((first, *away, *(absent + 1 + who for who in holders)))
            else:
                held = tuple(absent + 1 + who for who in self.holders(thing.name))
                found += [everywhere + (absent,) * thing.may_be_absent + held] * thing.count
        return (*found, *((absent, absent + 1 + who) for who, _ in self.marks))

    def is_fixed(self, thing: Thing) -> bool:
        """Whether something stays where it is at first, until it is taken for good or opened."""
        return self.is_linked(thing) and not any(thing.name in c.puts_down for c in self.characters)

    def is_linked(self, thing: Thing) -> bool:
        """Whether something is a door, or somebody carries it."""
        return bool(thing.opened_by or self.holders(thing.name))

    def holders(self, thing: str) -> tuple[int, ...]:
        """The characters who carry something."""
        return tuple(who for who, c in enumerate(self.characters) if thing in c.carries)

    @property
    def place_count(self) -> int:
        """How many numbers of cells there are: of free ones, of absence, and of being carried."""
        carried = any(c.carries or c.via for c in self.characters)
        return len(self.free_cells) + 1 + carried * len(self.characters)

    @property
    def arrangement_count(self) -> int:
        """How many arrangements of the entities there are, valid or not."""
        return self.place_count ** (len(self.entities) + len(self.marks))

    @property
    def is_sparse(self) -> bool:
        """Whether arrangements are looked for among the valid ones, since a table of all would be
        long; what falls needs the table."""
        alike = math.prod(math.factorial(thing.count) for thing in self.things)
        # Of a limited world nobody knows how few states there are.
        long = MOST_LISTED if self.is_limited else max(MOST_LISTED, 8 * alike * self.state_count)
        return not self.events and long < self.arrangement_count < 2**62

    @property
    def is_limited(self) -> bool:
        """Whether there are only the states that can be reached in time from a single one."""
        return bool(self.settings.horizon) and None not in self.placed

    @property
    def groups(self) -> tuple[tuple[int, ...], ...]:
        """The entities that are alike, as numbers in `entities`, for each thing of several."""
        found, first = [], len(self.characters)
        for thing in self.things:
            if thing.count > 1:
                found.append(tuple(range(first, first + thing.count)))
            first += thing.count
        return tuple(found)

    def numbers_of(self, names: tuple[str, ...]) -> frozenset[int]:
        """The entities that are meant by names of characters and things."""
        kinds = [c.name for c in self.characters]
        kinds += [thing.name for thing in self.things for _ in thing.names]
        return frozenset(i for i, kind in enumerate(kinds) if kind in names)

    @property
    def state_count(self) -> int:
        """How many states there are: no two on a cell, absent things on none, like ones in order
        only. Those of each frame are counted once; where `is_limited`, there are fewer."""
        cells = len(self.free_cells)
        placed = {(0, 0): 1}  # of things that can be anywhere, of those with a cell of their own
        for thing in self.things:
            is_fixed = self.is_fixed(thing)
            away = len(self.holders(thing.name)) + bool(thing.may_be_absent or thing.opened_by)
            grown: dict[tuple[int, int], int] = {}
            for (free, fixed), ways in placed.items():
                there = (free, fixed + 1) if is_fixed else (free + thing.count, fixed)
                grown[there] = grown.get(there, 0) + ways
                if away:
                    grown[free, fixed] = grown.get((free, fixed), 0) + ways * away
            placed = grown
        total = 0
        for (free, fixed), ways in placed.items():
            arrangements = ways
            for k in range(len(self.characters) + free):
                arrangements *= max(0, cells - fixed - k)
            total += arrangements
        alike = math.prod(math.factorial(thing.count) for thing in self.things)
        return total // alike * 2 ** len(self.marks)

    @property
    def frame_count(self) -> int:
        """How many frames planning tells apart: those of the horizon, or all are alike."""
        return max(1, self.settings.horizon)

    @cached_property
    def by_depth(self) -> tuple[Character, ...]:
        """The characters, each after those whom it models; else in the order of acting."""
        found: list[Character] = []
        while len(found) < len(self.characters):
            known = {c.name for c in found}
            found.append(
                next(c for c in self.characters if c not in found and known >= {*c.models})
            )
        return tuple(found)

    @cached_property
    def is_sampled(self) -> bool:
        """Whether there are more hypotheses than anybody can hold."""
        literal = self.settings.hypotheses == "literal"
        return count_at_most(self.characters, literal) > MOST_HYPOTHESES

    def character(self, name: str) -> Character:
        return next(c for c in self.characters if c.name == name)

    def with_settings(self, changes: dict[str, Any]) -> GridSpec:
        """The same world with some of its numbers replaced."""
        whole = {key: int(changes[key]) for key in ("horizon", "at_once") if key in changes}
        changes = changes | whole
        return replace(self, settings=replace(self.settings, **changes))

    @cached_property
    def planning_key(self) -> str:
        """A digest of all that planning depends on: not of drawing hints or documentation."""
        content = asdict(self)
        for key in ("name", "floor", "wall", "documentation", "source", "events", "look", "shares"):
            content.pop(key)
        for key in ("forgetting", "switching", "hypotheses", "asked"):
            content["settings"].pop(key)
        for key in ("method", "at_once", "states"):
            content["settings"].pop(key)
        fixed = {thing.name for thing in self.things if self.is_fixed(thing)}
        # What a world does not use leaves its digest as it was before there was such a thing.
        for holder, key in (
            *((content["settings"], key) for key in ("horizon", "end")),
            *((content, key) for key in ("walls", "together")),
            *(
                (item, key)
                for item in content["characters"]
                for key in (
                    "pulls",
                    "carries",
                    "puts_down",
                    "diagonals",
                    "misreads",
                    "supposes",
                    "via",
                )
            ),
            *((item, "opened_by") for item in content["things"]),
            *((item, key) for item in content["tiles"] for key in ("cost", "one_way")),
            *((item, "cell") for item in content["characters"]),
            *((item, "cells") for item in content["things"]),
        ):
            is_first = key in ("cell", "cells") and holder["name"] not in fixed  # of a place
            if not holder[key] or (is_first and not self.is_limited):
                holder.pop(key)
        for item in content["things"]:
            if item["count"] == 1:
                item.pop("count")
        for group in ("tiles", "characters", "things"):
            for item in content[group]:
                item.pop("color", None)
                item.pop("sprite", None)
        text = json.dumps(content, sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:32]
