"""Who and what is in the world of a .world file: its characters and objects."""

from __future__ import annotations

from dataclasses import replace

from i2pdsl.errors import Note, Source, Span, shorten
from i2pdsl.worlds.blocks import Block, Value
from i2pdsl.worlds.grid.spec import NO_GOAL, Cell, Character, Thing, Tile
from i2pdsl.worlds.grid.tiles import LARGEST, TileReader

MOST_CHARACTERS = 4
MOST_ALIKE = 8  # things of a kind: the table of arrangements has each of their orders


class CastReader(TileReader):
    """Reads characters and objects."""

    def __init__(self, source: Source):
        super().__init__(source)
        self.first: list[tuple[Block, tuple[Cell, ...]]] = []  # who is where at first

    def first_places(self, block: Block, rows: list[str], most: int) -> tuple[Cell, ...]:
        """Where a character or an object is at first, if its block says so."""
        if "symbol" not in block.entries and "cell" not in block.entries:
            return ()
        found = self.tile_cells(block, rows)
        if len(found) > most:
            message = f"`{block.name}` stands on {len(found)} cells of the map"
            hint = "it is only one" if most == 1 else f"at most {most} can be alike"
            self.problem("world-cast", message, block.entries["symbol"].span, hint)
        self.first.append((block, found))
        return found[:most]

    def check_places(self) -> None:
        """Reports who is on another's cell at first."""
        owner: dict[Cell, Block] = {}
        for block, cells in sorted(self.first, key=lambda one: one[0].span.start):
            taken_ = next((owner[cell] for cell in cells if cell in owner), None)
            if taken_ is not None:
                note = Note("the other one", taken_.span)
                message = f"`{block.name}` stands on a cell of `{taken_.name}`"
                self.problem("world-cast", message, block.span, note=note)
            owner.update(dict.fromkeys(cells, block))

    def thing(self, block: Block, rows: list[str], names: tuple[str, ...]) -> Thing:
        self.known_keys(block)
        # Where the word is wrong, `yes` spares a second mistake in the events.
        default = "yes" if "may_be_absent" in block.entries or block.damaged else "no"
        absent = self.word(block, "may_be_absent", default, ("yes", "no")) == "yes"
        sprite = self.sprites.of(block, "sprite", "box")
        range_ = f"a whole number from 1 to {MOST_ALIKE}"
        cells = self.first_places(block, rows, MOST_ALIKE)
        count = int(self.number(block, "count", len(cells) or 1, is_count, range_))
        if cells and count != len(cells):
            span = block.entries["count"].span
            hint = "where their places are drawn, `count` may be left out"
            message = f"`{block.name}` stands on {len(cells)} cells of the map, not {count}"
            self.problem("world-cast", message, span, hint)
        if count > 1 and absent and not block.damaged:
            span = block.keys.get("may_be_absent", block.span)
            hint = "of several that are alike all are always there"
            self.problem("world-cast", f"`{block.name}` cannot be absent", span, hint)
        others = tuple(name for name in names if name != block.name)
        opened = self.words(block, "opened_by", others, "other object")
        color = self.color(block, "color", "#b08a5a")
        return Thing(block.name, absent, count, cells, opened, sprite, color)

    def check_carrying(
        self, characters: tuple[Character, ...], things: tuple[Thing, ...]
    ) -> tuple[tuple[Character, ...], tuple[Thing, ...]]:
        """Characters and things; if what is carried or opened can do something else besides, that
        is a mistake, and nothing is."""
        before, blocks = len(self.problems), {b.name: b for b in self.blocks}
        carried = {name for c in characters for name in c.carries}
        put = {name for c in characters for name in c.puts_down}
        for thing in things:
            if thing.name not in carried and not thing.opened_by:
                continue
            block = blocks[thing.name]
            what = "is carried" if thing.name in carried else "is opened"
            movers = [c.name for c in characters if thing.name in c.pushes + c.pulls]
            wrong = {
                "has no place at first": not thing.cells and thing.name not in put,
                "there are several": thing.count > 1,
                "may be absent": thing.may_be_absent,
                "is opened, too": thing.name in carried and bool(thing.opened_by),
                f"is moved by {' and '.join(movers)}, too": bool(movers),
            }
            for told in (told for told, is_so in wrong.items() if is_so):
                hint = "it stands where `symbol` or `cell` says until it is taken or opened"
                self.problem("world-cast", f"`{thing.name}` {what}, but {told}", block.span, hint)
            for key in (key for key in thing.opened_by if key not in carried):
                message = f"nobody carries `{key}`, which opens `{thing.name}`"
                hint = f"a character has `carries = {key}`"
                self.problem("world-cast", message, block.keys["opened_by"], hint)
        if len(self.problems) == before and not self.incomplete:
            return characters, things
        plain = tuple(replace(c, carries=(), puts_down=()) for c in characters)
        return plain, tuple(replace(thing, opened_by=()) for thing in things)

    def characters(
        self,
        blocks: list[Block],
        tiles: tuple[Tile, ...],
        things: tuple[str, ...],
        rows: list[str],
        whole: Span,
    ) -> tuple[Character, ...]:
        if not blocks and not self.incomplete:
            hint = "add `character NAME`"
            self.problem("world-cast", "the world has no character", whole, hint)
        for block in blocks[MOST_CHARACTERS:]:
            message = f"a world has at most {MOST_CHARACTERS} characters, this is another"
            self.problem("world-cast", message, block.span)
        names = tuple(b.name for b in blocks)
        tile_names = tuple(t.name for t in tiles)
        found = tuple(self.one_character(b, names, tile_names, things, rows) for b in blocks)
        self.check_readings(blocks, found)
        return self.without_circles(blocks, found)

    def without_circles(
        self, blocks: list[Block], found: tuple[Character, ...]
    ) -> tuple[Character, ...]:
        """The characters; if some model each other in a circle that is a mistake, and they model
        nobody."""
        left, names = list(found), {c.name for c in found}
        beside = names
        while beside:  # who models none of the others, or is modelled by none, is in no circle
            modelled = {name for c in left for name in c.models}
            beside = {c.name for c in left if c.name not in modelled or not names & {*c.models}}
            left, names = [c for c in left if c.name not in beside], names - beside
        if not left:
            return found
        last = next(b for b in reversed(blocks) if b.name in names)
        span = next(last.keys[key] for key in ("toward", "models") if key in last.keys)
        *most, final = (f"`{c.name}`" for c in left)
        circle = f"{', '.join(most)} and {final}"
        hint = "whoever has an attitude toward another models it; leave out one of them"
        self.problem("world-cast", f"{circle} model each other in a circle", span, hint)
        return tuple(replace(c, models=(), attitudes=(), misreads=()) for c in found)

    def check_readings(self, blocks: list[Block], found: tuple[Character, ...]) -> None:
        """Nobody can be wrong about what somebody wants who may be wrong about where that is."""
        torn = {c.name for c in found if c.supposes}
        for block, c in zip(blocks, found, strict=True):
            for name in (name for name in c.misreads if name in torn):
                message = f"`{name}` may be wrong itself, so `{c.name}` cannot be wrong about it"
                hint = f"leave out `misreads`, or `supposes` of `{name}`"
                self.problem("world-cast", message, block.keys["misreads"], hint)

    def one_character(
        self,
        block: Block,
        names: tuple[str, ...],
        tiles: tuple[str, ...],
        things: tuple[str, ...],
        rows: list[str],
    ) -> Character:
        self.known_keys(block)
        # Where there are far too many, leaving out its own name for each grows as their square.
        many = len(names) > MOST_CHARACTERS
        others = names if many else tuple(n for n in names if n != block.name)
        success = self.number(
            block, "success", 1.0, lambda p: 0 < p <= 1, "a probability above 0 and up to 1"
        )
        supposes = self.supposes(block, things, tiles)
        objects = tuple(name for name, _ in supposes)
        goals = self.words(block, "goals", (*tiles, *objects, NO_GOAL), "tile") or (NO_GOAL,)
        for name in (name for name in objects if name not in goals and not block.damaged):
            hint = f"add `{name}` to `goals`"
            message = (
                f"`{block.name}` never wants `{name}`, so it tells nobody where it takes it to be"
            )
            self.problem("world-cast", message, block.keys["supposes"], hint)
        pushes = self.words(block, "pushes", (*others, *things), "character or object")
        pulls = self.words(block, "pulls", (*others, *things), "character or object")
        carries = self.words(block, "carries", things, "object")
        puts_down = self.words(block, "puts_down", things, "object")
        for name in (name for name in puts_down if name not in carries):
            message = f"`{block.name}` does not carry `{name}`, and cannot put it down"
            hint = f"add `{name}` to `carries`"
            self.problem("world-cast", message, block.entries["puts_down"].span, hint)
        diagonals = self.word(block, "diagonals", "no", ("yes", "no")) == "yes"
        attitudes = self.attitudes(block, others)
        models = self.words(block, "models", others, "other character")
        if "goals" in block.entries and block.entries["goals"].value == []:
            hint = f"leave the line out, or write `goals = {{{NO_GOAL}}}`"
            span = block.entries["goals"].span
            self.problem("world-value", f"`{block.name}` needs a goal", span, hint)
        toward = tuple(name for name, _ in attitudes)
        modelled = toward + tuple(name for name in models if name not in toward)
        misreads = self.words(block, "misreads", others, "other character")
        for name in (name for name in misreads if name not in modelled):
            hint = f"`{block.name}` models those in `toward` and `models`"
            message = f"`{block.name}` takes `{name}` for nothing, and cannot be wrong about it"
            self.problem("world-cast", message, block.entries["misreads"].span, hint)
        return Character(
            block.name,
            success,
            goals,
            pushes,
            pulls,
            carries,
            tuple(name for name in puts_down if name in carries),
            diagonals,
            attitudes,
            modelled,
            tuple(name for name in misreads if name in modelled),
            supposes,
            self.words(block, "via", tiles, "tile"),
            next(iter(self.first_places(block, rows, 1)), None),
            self.sprites.of(block, "sprite", "blob"),
            self.color(block, "color", "#7c9cc0"),
        )

    def supposes(
        self, block: Block, things: tuple[str, ...], tiles: tuple[str, ...]
    ) -> tuple[tuple[str, tuple[str, ...]], ...]:
        """The objects that a character may be wrong about, and where it may take each to be."""
        value = block.entries.get("supposes")
        if value is None:
            return ()
        if value.kind != "mapping":
            hint = "supposes = {OBJECT: {TILE, TILE}}"
            message = "where an object may be taken to be needs places"
            self.problem("world-value", message, value.span, hint)
            return ()
        found: dict[str, tuple[str, ...]] = {}
        for thing, places in value.value:
            alone = replace(block, entries={"supposes": thing})
            several = replace(block, entries={"supposes": places})
            where = self.words(several, "supposes", tiles, "tile")
            for name in self.words(alone, "supposes", things, "object"):
                if name in found:
                    self.problem("duplicate", f"`{name}` is given twice", thing.span)
                if where:
                    found[name] = where
        return tuple(found.items())

    def attitudes(
        self, block: Block, others: tuple[str, ...]
    ) -> tuple[tuple[str, tuple[float, ...]], ...]:
        """Whom a character has an attitude to, and its values: those of `attitude`, or those that
        stand beside each in `toward`."""
        toward, values = block.entries.get("toward"), block.entries.get("attitude")
        if toward is not None and toward.kind == "mapping":
            if values is not None:
                message = "the values of each attitude stand in `toward`"
                hint = "remove the line, or write `toward = NAME`"
                self.problem("world-cast", message, block.keys["attitude"], hint)
            found: dict[str, tuple[float, ...]] = {}
            for who, several in toward.value:
                alone = replace(block, entries={"toward": who})
                for name in self.words(alone, "toward", others, "other character"):
                    if name in found:
                        self.problem("duplicate", f"`{name}` is given twice", who.span)
                    found[name] = self.numbers(several)
            return tuple(found.items())
        names = self.words(block, "toward", others, "other character")
        if values is None:
            if toward is not None and not block.damaged:
                message = f"`{block.name}` has no attitude toward anyone"
                hint = "give its values: attitude = {-1, 0, 1}"
                if len(names) > 1:
                    each = ", ".join(f"{name}: {{-1, 0, 1}}" for name in names)
                    hint = f"give the values of each: toward = {{{each}}}"
                self.problem("world-cast", message, block.keys["toward"], hint)
            return ()
        if toward is None and not block.damaged:
            hint = "add `toward = NAME` of another character"
            self.problem("world-cast", "an attitude toward whom?", block.keys["attitude"], hint)
        numbers = self.numbers(values)
        return tuple((name, numbers) for name in names)

    def numbers(self, value: Value) -> tuple[float, ...]:
        """The values of an attitude."""
        items = value.value if value.kind == "list" else [value]
        numbers: dict[float, None] = {}
        for item in items:
            if item.kind != "number":
                message = f"an attitude is a number, not `{shorten(item.span.text)}`"
                self.problem("world-value", message, item.span, "attitude = {-1, 0, 1}")
            elif abs(item.value) > LARGEST:
                message = "an attitude must be between -1e6 and 1e6"
                self.problem("world-range", message, item.span)
            elif item.value not in numbers:
                numbers[item.value] = None
        if not items:
            hint = "attitude = {-1, 0, 1}"
            self.problem("world-value", "an attitude needs values", value.span, hint)
        return tuple(numbers)


def is_count(x: float) -> bool:
    return x == x // 1 and 1 <= x <= MOST_ALIKE
