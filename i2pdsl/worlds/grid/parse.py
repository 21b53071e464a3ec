"""From a .world file to a GridSpec, with every mistake of the file in one go."""

from __future__ import annotations

import unicodedata
from collections import Counter
from collections.abc import Callable
from dataclasses import fields as dataclass_fields
from dataclasses import replace
from pathlib import Path
from typing import Any

from i2pdsl.errors import Note, Source, Span, StoryError, did_you_mean, first_of, shorten
from i2pdsl.language.naming import same_name
from i2pdsl.language.settings import LONGEST_STORY
from i2pdsl.language.statements import check_text, read_source
from i2pdsl.language.vocabulary import ASKED
from i2pdsl.worlds.blocks import Block, Value, header
from i2pdsl.worlds.drawings import Files, beside, sprite_color, tile_look
from i2pdsl.worlds.grid.hypotheses import grid_hypotheses
from i2pdsl.worlds.grid.map import MapReader, is_mark
from i2pdsl.worlds.grid.spec import (
    ACTIONS,
    FLOOR,
    GROUNDS,
    NO_GOAL,
    STAY,
    WALL,
    Cell,
    Character,
    GridSpec,
    Look,
    Settings,
    Thing,
    Tile,
)
from i2pdsl.worlds.grid.sprites import Sprites
from i2pdsl.worlds.grid.words import ELSEWHERE, KEYS, NAMED, taken
from i2pdsl.worlds.hypotheses import (
    ATTITUDE,
    MOST_HYPOTHESES,
    attitude_of,
    attitudes_of,
    count_at_most,
    goal_of,
    latents_of,
    rationality_of,
    reading_of,
    readings_of,
    via_of,
)

EVENTS = ("deus",)
TOGETHER = "together"
MOST_CHARACTERS = 4
MOST_OF_ALL = 10**12  # hypotheses, of which viewers hold some
METHODS = ("auto", "exact", "additive")
STATES = ("auto", "listed", "computed")
MOST_AT_ONCE = 12
MOST_ALIKE = 8  # things of a kind: the table of arrangements has each of their orders
_LARGEST = 1e6  # of rewards and attitudes
_TILE_COLORS = ("#e58aa8", "#6fae75", "#6f9fd8", "#e0a458", "#a98bd0", "#5bb5b0")


def load_world(path: Path | str, name: str | None = None) -> GridSpec:
    """Reads a .world file. Raises StoryError with all its mistakes."""
    return parse_world(read_source(path), name or Path(path).stem, beside(Path(path).parent))


def parse_world(source: Source, name: str, files: Files | None = None) -> GridSpec:
    """Parses and checks the text of a world. Raises StoryError with all its mistakes.

    Args:
        files: where its own sprites are; without it they are not looked at.
    """
    check_text(source)
    reader = _Reader(source)
    reader.sprites = Sprites(reader, files)
    reader.read()
    spec = reader.world(name, header(source))
    if reader.problems or spec is None:
        raise StoryError(first_of(sorted(reader.problems, key=lambda d: d.span.start)))
    return spec


class _Reader(MapReader):
    """Turns the blocks of a file into a GridSpec."""

    unknown_symbols = False  # whether the map has symbols of no tile
    together = False  # whether the characters act at the same time
    sprites: Sprites

    def __init__(self, source: Source):
        super().__init__(source)
        self.first: list[tuple[Block, tuple[Cell, ...]]] = []  # who is where at first

    def world(self, name: str, documentation: str) -> GridSpec | None:
        of = lambda keyword: [b for b in self.blocks if b.keyword == keyword]
        whole = Span(self.source, 0, 0)
        if not self.source.text.strip():
            self.problem("empty", "the file is empty", whole, "a world needs a map and a character")
            return None
        if self.rows is None and not self.incomplete:
            self.problem("world-map", "the world has no map", whole, "draw one below `map`")
        self.unique_names()
        rows = self.checked_rows()
        tiles = self.tiles(of("tile"), rows)
        names = tuple(b.name for b in of("object"))
        things = tuple(self.thing(b, rows, names) for b in of("object"))
        thing_names = tuple(t.name for t in things)
        characters = self.characters(of("character"), tiles, thing_names, rows, whole)
        self.check_places()
        characters, things = self.check_carrying(characters, things)
        events = self.events(of("event"), things)
        settings = self.settings(of)
        floor, wall, look = "#f1e8d8", "#7d6b5d", Look()
        for block in of("drawing"):
            self.known_keys(block)
            floor, wall = self.color(block, "floor", floor), self.color(block, "wall", wall)
            frame, ground = self.color(block, "frame", ""), self.word(block, "ground", "", GROUNDS)
            look = Look(frame, ground or look.ground, self.sprites.of(block, "wall_sprite", ""))
        look = replace(look, drawings=tuple(self.sprites.drawings.items()))
        characters = self.ordered(of("planning"), characters)
        spec = GridSpec(
            name,
            tuple(rows),
            tiles,
            characters,
            things,
            events,
            settings,
            floor,
            wall,
            documentation,
            self.source.text,
            look,
            self.walls_between(rows),
            self.together,
        )
        self.check_cast(characters, settings.hypotheses == "literal")
        shares = self.shares(latents_of(characters))
        if shares and not self.problems:
            self.check_prior(shares, grid_hypotheses(spec))
        spec = replace(spec, shares=shares)
        needed = len(characters) + sum(t.count for t in things if not t.may_be_absent)
        if rows and not self.incomplete and len(spec.free_cells) < needed:
            free = len(spec.free_cells)
            message = f"the map has {free or 'no'} free cell{'' if free == 1 else 's'}"
            message = f"{message}, but {needed} {'is' if needed == 1 else 'are'} needed"
            hint = "every character has a cell, and every object that is never absent"
            self.problem("world-map", message, self.map_span, hint)
        return spec

    def check_cast(self, characters: tuple[Character, ...], literal: bool) -> None:
        """Reports a cast of which too much may be true, or latents of one name."""
        at = {block.name: block.span for block in self.blocks if block.keyword == "character"}
        latents: dict[str, str] = {}
        owned = [(each.latent, each.who) for each in attitudes_of(characters)]
        owned += [
            (latent, c) for c, each in readings_of(characters).items() for latent in each.values()
        ]
        for latent, who in owned:
            if latent in latents:
                message = f"`{who}` and `{latents[latent]}` both have a `{latent}`"
                hint = "give one of them a name without `_`"
                self.problem("world-cast", message, at[who], hint)
            latents[latent] = who
        count = count_at_most(characters, literal)
        most = MOST_HYPOTHESES if literal else MOST_OF_ALL
        if count > most:
            message = f"viewers would hold up to {count:,} hypotheses about this cast"
            hint = f"fewer goals or values of attitudes: at most {most:,}"
            self.problem("too-large", message, at[characters[-1].name], hint)

    def walls_between(self, rows: list[str]) -> tuple[tuple[Cell, Cell], ...]:
        """The walls between free cells; beside a cell that is a wall they change nothing."""
        inside = lambda cell: cell[1] < len(rows) and cell[0] < len(rows[cell[1]])
        free = lambda cell: inside(cell) and rows[cell[1]][cell[0]] != WALL
        return tuple(sorted((a, b) for a, b in self.walls if free(a) and free(b)))

    def unique_names(self) -> None:
        seen: dict[str, Span] = {}
        single: dict[str, Span] = {}
        latents, counted = self.latents(), self.counted()
        for block in self.blocks:
            meaning = latents.get(block.name) or counted.get(block.name) or taken(block.name)
            looks = unicodedata.normalize("NFKC", block.name)  # wide letters, ligatures
            if block.keyword not in NAMED:
                if block.keyword in single:
                    note = Note("the first one", single[block.keyword])
                    message = f"a world has only one `{block.keyword}`, this is another"
                    self.problem("duplicate", message, block.span, note=note)
                single.setdefault(block.keyword, block.span)
                continue
            if looks in seen:
                note = Note("the other one", seen[looks])
                message = f"two things have the name `{looks}`"
                self.problem("duplicate", message, block.span, note=note)
                self.unsure.add(block.keyword)
            elif meaning is not None:
                message = f"`{block.name}` is {meaning} and cannot be a name"
                self.problem("reserved", message, block.span, "choose another name")
                if not any(block.name in b.mentioned() for b in self.blocks):
                    self.unsure.add(block.keyword)  # what others mention may be this one
            seen.setdefault(looks, block.span)

    def counted(self) -> dict[str, str]:
        """The names of things that are alike, and what they mean."""
        return {
            f"{block.name}_{number + 1}": f"one of those called `{block.name}`"
            for block in self.blocks
            if block.keyword == "object" and {"count", "symbol"} & set(block.entries)
            for number in range(MOST_ALIKE)
        }

    def latents(self) -> dict[str, str]:
        """The names of what is hidden, and what they mean."""
        found = {}
        for block in self.blocks:
            if block.keyword == "character":
                found[goal_of(block.name)] = f"the latent of `{block.name}`'s goal"
                found[rationality_of(block.name)] = f"the latent of `{block.name}`'s rationality"
                if {"toward", "attitude"} & set(block.entries):
                    found[ATTITUDE] = f"the latent of `{block.name}`'s attitude"
                for toward in self.targets(block):
                    found[attitude_of(block.name, toward)] = found[ATTITUDE]
                if "via" in block.entries:
                    about = f"the latent of where `{block.name}` wants to have been"
                    found[via_of(block.name)] = about
                for key, keyword in (("misreads", "character"), ("supposes", "object")):
                    if key in block.entries:
                        about = f"a latent of what `{block.name}` takes for true"
                        others = (b for b in self.blocks if b.keyword == keyword)
                        found |= {reading_of(block.name, b.name): about for b in others}
        return found

    def targets(self, block: Block) -> list[str]:
        """Whom a character has an attitude to, as it is written."""
        toward = block.entries.get("toward")
        if toward is None:
            return []
        if toward.kind == "mapping":
            written = [who for who, _ in toward.value]
        else:
            written = toward.value if toward.kind == "list" else [toward]
        return [str(who.value) for who in written if who.kind in ("name", "text")]

    def checked_rows(self) -> list[str]:
        rows = self.rows or []
        usual = Counter(len(row) for row, _ in rows).most_common(1)
        for row, span in rows:
            if len(row) != usual[0][0]:
                message = f"this row has {len(row)} cells, the others have {usual[0][0]}"
                self.problem("world-map", message, span, "all rows of a map are equally long")
        self.check_symbols(rows)
        return [row for row, _ in rows]

    def check_symbols(self, rows: list[tuple[str, Span]]) -> None:
        """Reports each symbol of the map that means nothing, once for all its cells."""
        drawn = [
            b
            for b in self.blocks
            if (b.keyword == "tile" and "cell" not in b.entries) or "symbol" in b.entries
        ]
        marks = [self.mark(b) for b in drawn]
        known = {FLOOR, WALL, *(m for m in marks if m is not None)}
        found: dict[str, list[tuple[int, int]]] = {}
        for r, (row, _) in enumerate(rows):
            for c, symbol in enumerate(row):
                if symbol not in known:
                    found.setdefault(symbol, []).append((c, r))
        self.unknown_symbols = bool(found)
        # A tile whose symbol cannot be read may be the one that is drawn here.
        unread = [b for b, mark in zip(drawn, marks, strict=True) if mark is None]
        written = {
            s for b in unread if "symbol" in b.entries for s in b.entries["symbol"].span.text
        }
        open_ = set(found) - written - self.lost_symbols()
        nameless = [b for b in unread if not ("symbol" in b.entries and written & set(found))]
        if len(open_) <= len(nameless) or ("tile" in self.unsure and not open_):
            return
        for symbol in (s for s in found if s in open_):
            self.unknown_symbol(symbol, found[symbol], rows)

    def unknown_symbol(
        self, symbol: str, cells: list[tuple[int, int]], rows: list[tuple[str, Span]]
    ) -> None:
        column, row = cells[0]
        text, span = rows[row]
        at = min(span.start + column * self.step, span.end - 1)
        is_plain = self.step > 1 or len(text) >= len(span.text)
        place = Span(self.source, at, at + 1) if is_plain else span
        written = symbol if symbol.isalnum() else f'"{symbol}"'
        hint = f"a tile? `tile NAME` with `symbol = {written}`; floor is `{FLOOR}`, a wall `{WALL}`"
        count = f"on {len(cells)} cell{'' if len(cells) == 1 else 's'} of the map"
        if len(cells) == 1:
            hint += f"; who stands here is said in the story: `start at(NAME, ({column}, {row}))`"
        self.problem("world-map", f"unknown symbol `{symbol}` {count}", place, hint)

    def mark(self, block: Block) -> str | None:
        """The symbol that a tile has on the map, or None where it has none that is valid."""
        symbol = block.entries.get("symbol")
        if symbol is None or symbol.kind not in ("name", "text", "number"):
            return None
        mark = same_name(symbol.span.text.strip('"'))
        return mark if is_mark(mark) else None

    def tiles(self, blocks: list[Block], rows: list[str]) -> tuple[Tile, ...]:
        tiles: list[Tile] = []
        owner: dict[tuple[int, int], Block] = {}
        for number, block in enumerate(blocks):
            self.known_keys(block)
            sprite = self.sprites.of(block, "sprite", "")
            usual = sprite_color(sprite or tile_look(block.name))
            if not usual or usual in {tile.color for tile in tiles}:
                usual = _TILE_COLORS[number % len(_TILE_COLORS)]
            color = self.color(block, "color", usual)
            cells = self.tile_cells(block, rows)
            for cell in cells:
                if cell in owner:
                    note = Note("the other one", owner[cell].span)
                    message = f"`{block.name}` lies on a cell of `{owner[cell].name}`"
                    self.problem("world-tile", message, block.span, note=note)
                owner[cell] = block
            cost = self.number(
                block, "cost", 0.0, lambda x: abs(x) <= _LARGEST, "between -1e6 and 1e6"
            )
            one_way = self.words(block, "one_way", ACTIONS[:STAY], "direction")
            tiles.append(Tile(block.name, cells, color, sprite, cost, one_way))
        return tuple(tiles)

    def tile_cells(self, block: Block, rows: list[str]) -> tuple[tuple[int, int], ...]:
        symbol, cell = block.entries.get("symbol"), block.entries.get("cell")
        if symbol is None and cell is None and block.damaged:
            return ()
        if (symbol is None) == (cell is None):
            hint = "give `symbol = P`, drawn on the map, or `cell = (column, row)`"
            self.problem("world-tile", f"where does `{block.name}` lie?", block.span, hint)
            return ()
        if symbol is not None:
            mark = self.mark(block)
            if mark is None:
                hint = f"`{WALL}` is a wall and `{FLOOR}` plain floor"
                kind = f"a{'n' if block.keyword == 'object' else ''} {block.keyword}"
                message = f"the symbol of {kind} is a single character of its own"
                self.problem("world-tile", message, symbol.span, hint)
                return ()
            found = tuple(
                (c, r) for r, row in enumerate(rows) for c, s in enumerate(row) if s == mark
            )
            if not found and rows and not self.unknown_symbols:
                hint = "draw it there, or give `cell = (column, row)`"
                self.problem("world-tile", f"`{mark}` does not occur on the map", symbol.span, hint)
            return found
        assert cell is not None
        numbers = [v.value for v in cell.value if v.kind == "number"] if cell.kind == "pair" else []
        if len(numbers) < 2 or any(v != v // 1 for v in numbers):
            hint = "write `cell = (column, row)`, whole numbers that count from 0 at the top left"
            self.problem("world-tile", "this is not a cell", cell.span, hint)
            return ()
        column, row = numbers
        inside = 0 <= row < len(rows) and 0 <= column < len(rows[int(row)])
        if inside and rows[int(row)][int(column)] != WALL:
            return ((int(column), int(row)),)
        if rows:
            hint = "columns and rows count from 0 at the top left"
            where = "on a wall" if inside else "outside the map"
            self.problem(
                "world-tile", f"the {block.keyword} `{block.name}` lies {where}", cell.span, hint
            )
        return ()

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
            elif abs(item.value) > _LARGEST:
                message = "an attitude must be between -1e6 and 1e6"
                self.problem("world-range", message, item.span)
            elif item.value not in numbers:
                numbers[item.value] = None
        if not items:
            hint = "attitude = {-1, 0, 1}"
            self.problem("world-value", "an attitude needs values", value.span, hint)
        return tuple(numbers)

    def events(
        self, blocks: list[Block], things: tuple[Thing, ...]
    ) -> tuple[tuple[str, tuple[str, ...]], ...]:
        found = []
        names = tuple(t.name for t in things)
        may_be_absent = {t.name: t.may_be_absent for t in things}
        for block in blocks:
            self.known_keys(block)
            if block.name not in EVENTS:
                hint = ELSEWHERE.get(block.name) or did_you_mean(block.name, EVENTS)
                self.problem("world-name", f"there is no event `{block.name}`", block.span, hint)
            drops = self.words(block, "drops", names, "object")
            missing = "drops" not in block.entries and not block.damaged
            if missing or ("drops" in block.entries and block.entries["drops"].value == []):
                hint = "give the objects: drops = {table}"
                self.problem("world-block", "what does the event bring?", block.span, hint)
            for name in drops:
                if not may_be_absent[name]:
                    message = f"`{name}` is never absent, so it cannot fall"
                    hint = f"give `{name}` may_be_absent = yes"
                    self.problem("world-cast", message, block.entries["drops"].span, hint)
            found.append((block.name, drops))
        return tuple(found)

    def settings(self, of: Callable[[str], list[Block]]) -> Settings:
        values: dict[str, Any] = {}
        for keyword in ("rewards", "planning", "audience"):
            for block in of(keyword):
                self.known_keys(block)
                for key in KEYS[keyword]:
                    if key in block.entries and key != "order":
                        default = getattr(Settings(), key)
                        values[key] = self.setting(block, key, default)
        return Settings(**values)

    def setting(self, block: Block, key: str, default: Any) -> float | str:
        if key in SETTING_WORDS:
            return self.word(block, key, default, SETTING_WORDS[key])
        valid, range_ = SETTING_RANGES[key]
        number = self.number(block, key, default, valid, range_)
        return int(number) if isinstance(default, int) else number

    def ordered(
        self, blocks: list[Block], characters: tuple[Character, ...]
    ) -> tuple[Character, ...]:
        for block in blocks:
            if "order" not in block.entries:
                continue
            names = tuple(c.name for c in characters)
            value = block.entries["order"]
            if value.kind == "name" and value.value == TOGETHER and TOGETHER not in names:
                self.together = len(characters) == 2
                if not self.together and not self.incomplete:
                    alone = len(characters) == 1
                    message = f"there {'is' if alone else 'are'} {'only one' if alone else 'more'}"
                    message += f" character{'' if alone else 's than two'}"
                    hint = None if alone else "two can act at the same time; or give their order"
                    self.problem("world-value", message, value.span, hint)
                continue
            before = len(self.problems)
            order = self.words(block, "order", names, "character")
            if len(order) == len(characters):
                return tuple(next(c for c in characters if c.name == n) for n in order)
            unsure = self.incomplete or self.unsure or len(characters) > MOST_CHARACTERS
            if len(self.problems) == before and not unsure:
                span = block.entries["order"].span
                both = f"or `order = {TOGETHER}`: both at the same time"
                missing = " and ".join(f"`{name}`" for name in names if name not in order)
                hint = both if len(names) == 2 else f"add {missing}"
                message = "the order must name every character once"
                self.problem("world-value", message, span, hint)
        return characters


def is_count(x: float) -> bool:
    return x == x // 1 and 1 <= x <= MOST_ALIKE


SETTING_WORDS: dict[str, tuple[str, ...]] = {
    "level0": ("uniform", "costs"),
    "hypotheses": ("merged", "literal"),
    "method": METHODS,
    "states": STATES,
}
SETTING_RANGES: dict[str, tuple[Callable[[float], bool], str]] = {
    "end": (lambda x: abs(x) <= _LARGEST, "between -1e6 and 1e6"),
    "goal": (lambda x: abs(x) <= _LARGEST, "between -1e6 and 1e6"),
    "move": (lambda x: abs(x) <= _LARGEST, "between -1e6 and 1e6"),
    "stay": (lambda x: abs(x) <= _LARGEST, "between -1e6 and 1e6"),
    "horizon": (
        lambda x: x == x // 1 and 0 <= x <= LONGEST_STORY,
        f"a whole number from 0 to {LONGEST_STORY}",
    ),
    "at_once": (
        lambda x: x == x // 1 and 2 <= x <= MOST_AT_ONCE,
        f"a whole number from 2 to {MOST_AT_ONCE}",
    ),
    "gamma": (lambda x: 0 <= x < 1, "at least 0 and below 1"),
    "beta": (lambda x: 0 <= x <= 1e3, "between 0 and 1000"),
    "forgetting": (lambda x: 0 <= x <= 0.5, "between 0 and 0.5"),
    "switching": (lambda x: 0 <= x <= 1, "between 0 and 1"),
}
_OF_FILES = {f.name for f in dataclass_fields(Settings)} - {ASKED}  # that is for stories to say
assert set(SETTING_WORDS) | set(SETTING_RANGES) == _OF_FILES
