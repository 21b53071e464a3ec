"""From a .world file to a PlaneSpec, with every mistake of the file in one go."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from i2pdsl.errors import Note, Source, Span, StoryError, first_of, shorten
from i2pdsl.language.builtins import RESERVED, STATEMENT_WORDS
from i2pdsl.language.statements import check_text
from i2pdsl.worlds.blocks import Block, BlockReader, Syntax, Value, header
from i2pdsl.worlds.hypotheses import ATTITUDE, goal_of, latents_of, rationality_of
from i2pdsl.worlds.plane.hypotheses import plane_hypotheses
from i2pdsl.worlds.plane.spec import (
    APPROACH,
    AVOID,
    NO_GOAL,
    Place,
    PlaneCharacter,
    PlaneSettings,
    PlaneSpec,
    Point,
    Wall,
)
from i2pdsl.worlds.plane.vocabulary import ALONE, RANGES, TOGETHER, WORDS

KEYS: dict[str, tuple[str, ...]] = {
    "size": ("width", "height"),
    "wall": ("points", "closed", "color"),
    "place": ("at", "radius", "color"),
    "character": (
        *("at", "radius", "speed", "mass", "goals", "toward", "attitude", "sprite", "color"),
    ),
    "planning": ("beta", "safe"),
    "audience": ("observer", "forgetting", "switching"),
    "drawing": ("floor",),
}
_PLACE_COLORS = ("#e58aa8", "#6fae75", "#6f9fd8", "#e0a458", "#a98bd0", "#5bb5b0")
_CHARACTER_COLORS = ("#5b8db8", "#f2c14e")
_LARGEST = 1e3  # units
_OF_FILES = ("event", "state", "unknown")
_ELSEWHERE = {
    "a plane is not drawn: give its `size`, and walls by their points": "map tile symbol",
    "a wall has points: `wall` with `points = [(0, 4), (5, 4)]`": "line polygon obstacle box "
    "segment room door gap",
    "somewhere to go is a `place`": "goal target spot region zone",
    "someone who acts is a `character`": "agent agents robot person player actor disc",
    "belongs in the story: `start at(WHO, PLACE)`": "start starts position",
    "what costs characters is the time and the square of their velocity (docs/plane.md)": "rewards "
    "reward cost costs move stay gamma discount",
    "who is heavier gives way less: `mass`": "strength force weight push pushes success",
    "it can go twice as fast as it likes, `speed`": "fastest max_speed velocity acceleration",
    "belongs in the story: `length 60`": "length duration frames horizon",
}
_TOLD = {word: told for told, words in _ELSEWHERE.items() for word in words.split()}


def _elsewhere(word: str, block: str) -> str | None:
    owners = [f"`{owner}`" for owner, keys in KEYS.items() if word in keys and owner != block]
    if owners and block:
        return f"`{word}` belongs to {' or '.join(owners)}"
    told = _TOLD.get(word.lower())
    if told is not None:
        return f"`{word}` {told}" if told.startswith("belongs") else told
    return f"`{word}` belongs in the story" if word in STATEMENT_WORDS else None


SYNTAX = Syntax("plane.lark", KEYS, ("place", "character"), elsewhere=_elsewhere)


def parse_plane(source: Source, name: str) -> PlaneSpec:
    """Parses and checks the text of a plane. Raises StoryError with all its mistakes."""
    check_text(source)
    reader = _Reader(source, SYNTAX)
    reader.read()
    spec = reader.plane(name)
    if reader.problems:
        raise StoryError(first_of(sorted(reader.problems, key=lambda d: d.span.start)))
    return spec


def _above_zero(most: float) -> Any:
    return lambda x: 0 < x <= most, f"above 0 and at most {most:g}"


def distance_to(point: Point, segment: tuple[Point, Point]) -> float:
    """The distance of a point to a segment."""
    (x, y), ((ax, ay), (bx, by)) = point, segment
    dx, dy = bx - ax, by - ay
    share = ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy)
    share = min(1.0, max(0.0, share))
    return math.hypot(x - ax - share * dx, y - ay - share * dy)


class _Reader(BlockReader):
    """Turns the blocks of a file into a PlaneSpec."""

    width = height = _LARGEST  # where the size is not known, everything is inside

    def plane(self, name: str) -> PlaneSpec:
        of = lambda keyword: [b for b in self.blocks if b.keyword == keyword]
        for block in self.blocks:
            self.known_keys(block)
        self.unique_names()
        self.size(of("size"))
        walls = tuple(w for w in map(self.wall, of("wall")) if w is not None)
        places = tuple(self.place(b, number) for number, b in enumerate(of("place")))
        characters = self.characters(of("character"), places)
        self.free(of("character"), characters, walls)
        values: dict[str, Any] = {}
        usual: Any = PlaneSettings()
        for block in (*of("planning"), *of("audience")):
            for key in KEYS[block.keyword]:
                default = getattr(usual, key)
                if key in WORDS:
                    values[key] = self.word(block, key, default, WORDS[key])
                else:
                    values[key] = self.number(block, key, default, *RANGES[key])
        floor: str = "#f1e8d8"
        for block in of("drawing"):
            floor = self.color(block, "floor", floor)
        spec = PlaneSpec(
            name, self.width, self.height, walls, places, characters, PlaneSettings(**values),
            floor, header(self.source), self.source.text,
        )  # fmt: skip
        shares = self.shares(latents_of(characters))
        if shares and not self.problems:
            self.check_prior(shares, plane_hypotheses(spec))
        return replace(spec, shares=shares)

    def unique_names(self) -> None:
        seen: dict[str, Span] = {}
        latents = {ATTITUDE}
        for block in self.blocks:
            if block.keyword == "character":
                latents |= {goal_of(block.name), rationality_of(block.name)}
        taken = {*RESERVED, *_OF_FILES, NO_GOAL, APPROACH, AVOID}
        taken |= {p.name for p in (*ALONE, *TOGETHER)} | latents
        for block in self.blocks:
            named = block.keyword in SYNTAX.named
            key = block.name if named else f"{block.keyword} "
            if block.keyword != "wall" and key in seen:
                message = f"two things have the name `{block.name}`"
                if not named:
                    message = f"a world has only one `{block.keyword}`, this is another"
                self.problem(
                    "duplicate", message, block.span, note=Note("the first one", seen[key])
                )
            elif named and block.name in taken:
                message = f"`{block.name}` means something else and cannot be a name"
                self.problem("reserved", message, block.span, "choose another name")
            seen.setdefault(key, block.span)

    def size(self, blocks: list[Block]) -> None:
        if not blocks:
            if not self.incomplete:
                whole, hint = Span(self.source, 0, 0), "`size` with `width = 12` and `height = 8`"
                self.problem("world-size", "how large is the plane?", whole, hint)
            return
        for key in KEYS["size"]:
            if key not in blocks[0].entries and not blocks[0].damaged:
                self.problem("world-size", f"the size has no {key}", blocks[0].span, f"{key} = 8")
        self.width = self.number(blocks[0], "width", self.width, *_above_zero(_LARGEST))
        self.height = self.number(blocks[0], "height", self.height, *_above_zero(_LARGEST))

    def point(self, value: Value, key: str, margin: float = 0.0) -> Point | None:
        """A point of the plane, at least so far from its edge; None where it is none."""
        numbers = (
            [v.value for v in value.value if v.kind == "number"] if value.kind == "pair" else []
        )
        if len(numbers) < 2:
            message = f"`{key}` must be a point, not `{shorten(value.span.text)}`"
            hint = "(x, y), counted from the lower left corner, y upwards"
            self.problem("world-value", message, value.span, hint)
            return None
        x, y = numbers
        inside = margin <= x <= self.width - margin and margin <= y <= self.height - margin
        if not inside:
            size = f"{self.width:g} x {self.height:g}"
            message = f"({x:g}, {y:g}) is outside the plane of {size}"
            if 0 <= x <= self.width and 0 <= y <= self.height:
                message = f"at ({x:g}, {y:g}) it would reach beyond the plane of {size}"
            self.problem("world-place", message, value.span)
            return None
        return float(x), float(y)

    def wall(self, block: Block) -> Wall | None:
        value = block.entries.get("points")
        if value is None:
            if not block.damaged:
                example = "points = [(0, 4), (5, 4)]"
                self.problem("world-wall", "where is this wall?", block.span, example)
            return None
        items = value.value if value.kind == "list" else [value]
        points = [self.point(item, "points") for item in items]
        closed = self.word(block, "closed", "no", ("yes", "no")) == "yes"
        color = self.color(block, "color", "#7d6b5d")
        if None in points:
            return None
        found = Wall(tuple(p for p in points if p is not None), closed, color)
        if len(found.points) < (3 if closed else 2):
            message = f"a {'closed ' if closed else ''}wall has {3 if closed else 2} points or more"
            self.problem("world-wall", message, value.span)
            return None
        if any(a == b for a, b in found.segments):
            message = "a point of a wall stands here twice in a row"
            hint = "`closed = yes` joins the last point to the first" if closed else None
            self.problem("world-wall", message, value.span, hint)
            return None
        return found

    def at(self, block: Block, margin: float = 0.0) -> Point:
        """Where a place or a character is; a wrong one is reported and is in the middle."""
        value = block.entries.get("at")
        middle = self.width / 2, self.height / 2
        if value is None:
            if not block.damaged:
                hint = "at = (x, y), counted from the lower left corner, y upwards"
                self.problem("world-place", f"where is `{block.name}`?", block.span, hint)
            return middle
        return self.point(value, "at", margin) or middle

    def place(self, block: Block, number: int) -> Place:
        color = self.color(block, "color", _PLACE_COLORS[number % len(_PLACE_COLORS)])
        radius = self.number(block, "radius", 0.5, *_above_zero(_LARGEST))
        return Place(block.name, self.at(block), radius, color)

    def characters(
        self, blocks: list[Block], places: tuple[Place, ...]
    ) -> tuple[PlaneCharacter, ...]:
        if not blocks and not self.incomplete:
            whole, hint = Span(self.source, 0, 0), "add `character NAME`"
            self.problem("world-cast", "the world has no character", whole, hint)
        for block in blocks[2:]:
            message = "a world has one or two characters, this is another"
            self.problem("world-cast", message, block.span)
        radii = [self.number(b, "radius", 0.4, *_above_zero(_LARGEST)) for b in blocks]
        names = tuple(b.name for b in blocks)
        goals = (*(p.name for p in places), NO_GOAL)
        goals += (APPROACH, AVOID) if len(blocks) > 1 else ()
        found = tuple(
            self.character(b, number, names, goals, radii) for number, b in enumerate(blocks)
        )
        fond = [b for b, c in zip(blocks, found, strict=True) if c.toward]
        if len(fond) > 1:
            note = Note("the other one", fond[0].keys["toward"])
            message = "only one character can have an attitude"
            self.problem("world-cast", message, fond[1].keys["toward"], note=note)
        return found

    def character(
        self,
        block: Block,
        number: int,
        names: tuple[str, ...],
        known: tuple[str, ...],
        radii: list[float],
    ) -> PlaneCharacter:
        others = tuple(n for n in names if n != block.name)
        goals = self.words(block, "goals", known, "place") or (NO_GOAL,)
        toward = self.words(block, "toward", others, "other character")
        # Nobody may be carried through a wall within a frame.
        most = min(radii) / 3
        usual = min(0.1, most)
        limits = (
            lambda x: 0 < x <= most + 1e-12,
            f"above 0 and at most {most:g}, a third of a radius",
        )
        color = _CHARACTER_COLORS[number % 2]
        return PlaneCharacter(
            block.name,
            self.at(block, radii[number]),
            radii[number],
            self.number(block, "speed", usual, *limits),
            self.number(block, "mass", 1.0, *_above_zero(_LARGEST)),
            goals,
            toward[0] if toward else None,
            self.attitude(block, "toward" in block.entries),
            self.word(block, "sprite", "blob"),
            self.color(block, "color", color),
        )

    def attitude(self, block: Block, has_target: bool) -> tuple[float, ...]:
        value = block.entries.get("attitude")
        if value is None:
            if has_target and not block.damaged:
                message = f"`{block.name}` has no attitude toward anyone"
                hint = "give its values: attitude = {-2, 0, 2}"
                self.problem("world-cast", message, block.keys["toward"], hint)
            return ()
        if not has_target and not block.damaged:
            hint = "add `toward = NAME` of the other character"
            self.problem("world-cast", "an attitude toward whom?", block.keys["attitude"], hint)
        items = value.value if value.kind == "list" else [value]
        for item in items:
            if item.kind != "number" or abs(item.value) > _LARGEST:
                message = f"an attitude is a number up to 1000, not `{shorten(item.span.text)}`"
                self.problem("world-value", message, item.span, "attitude = {-2, 0, 2}")
        if not items:
            hint = "attitude = {-2, 0, 2}"
            self.problem("world-value", "an attitude needs values", value.span, hint)
        numbers = dict.fromkeys(float(i.value) for i in items if i.kind == "number")
        return tuple(numbers)

    def free(
        self, blocks: list[Block], cast: tuple[PlaneCharacter, ...], walls: tuple[Wall, ...]
    ) -> None:
        """Reports characters that begin in a wall or in each other."""
        segments = [part for wall in walls for part in wall.segments]
        for block, c in zip(blocks, cast, strict=True):
            if "at" in block.entries and any(distance_to(c.at, s) < c.radius for s in segments):
                message = f"`{c.name}` (radius {c.radius:g}) would stand in a wall"
                self.problem("world-place", message, block.entries["at"].span)
        if len(cast) == 2 and all("at" in b.entries for b in blocks):
            one, other = cast
            if math.dist(one.at, other.at) < one.radius + other.radius:
                message = f"`{one.name}` and `{other.name}` would overlap"
                self.problem("world-place", message, blocks[1].entries["at"].span)
