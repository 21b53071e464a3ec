"""From a .world file to a GridSpec, with every mistake of the file in one go."""

from __future__ import annotations

import unicodedata
from collections.abc import Callable
from dataclasses import fields as dataclass_fields
from dataclasses import replace
from typing import Any

from i2pdsl.errors import Note, Source, Span, StoryError, did_you_mean, first_of
from i2pdsl.language.methods import LONGEST_STORY
from i2pdsl.language.statements import check_text
from i2pdsl.language.vocabulary import ASKED
from i2pdsl.worlds.blocks import Block, header
from i2pdsl.worlds.drawings import Files
from i2pdsl.worlds.grid.cast import MOST_ALIKE, MOST_CHARACTERS, CastReader
from i2pdsl.worlds.grid.hypotheses import grid_hypotheses
from i2pdsl.worlds.grid.spec import (
    GROUNDS,
    Character,
    GridSpec,
    Look,
    Settings,
    Thing,
)
from i2pdsl.worlds.grid.sprites import Sprites
from i2pdsl.worlds.grid.tiles import LARGEST
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
MOST_OF_ALL = 10**12  # hypotheses, of which viewers hold some
METHODS = ("auto", "exact", "additive")
STATES = ("auto", "listed", "computed")
MOST_AT_ONCE = 12


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


class _Reader(CastReader):
    """Turns the blocks of a file into a GridSpec."""

    together = False  # whether the characters act at the same time

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


SETTING_WORDS: dict[str, tuple[str, ...]] = {
    "level0": ("uniform", "costs"),
    "hypotheses": ("merged", "literal"),
    "method": METHODS,
    "states": STATES,
}
SETTING_RANGES: dict[str, tuple[Callable[[float], bool], str]] = {
    "end": (lambda x: abs(x) <= LARGEST, "between -1e6 and 1e6"),
    "goal": (lambda x: abs(x) <= LARGEST, "between -1e6 and 1e6"),
    "move": (lambda x: abs(x) <= LARGEST, "between -1e6 and 1e6"),
    "stay": (lambda x: abs(x) <= LARGEST, "between -1e6 and 1e6"),
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
