"""What kinds of listed worlds have in common: all that a kind is asked (worlds/kind.py), derived
from its states, its actions and what its characters like."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import replace
from itertools import combinations
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar

from i2pdsl.errors import Source, StoryError, first_of
from i2pdsl.language.statements import check_text
from i2pdsl.language.story import TypedStory
from i2pdsl.language.vocabulary import Value, Vocabulary
from i2pdsl.worlds.blocks import BlockReader, Syntax, header
from i2pdsl.worlds.drawings import Files
from i2pdsl.worlds.kind import Watch
from i2pdsl.worlds.kind_of_turns import KindOfTurns
from i2pdsl.worlds.listed.words import RANGES, Cell, ListedSettings, ListedSpec

if TYPE_CHECKING:
    import numpy as np

    from i2pdsl.worlds.listed.world import ListedWorld
    from i2pdsl.worlds.record import Record, Trajectory
    from i2pdsl.worlds.world import Viewer

Picture = tuple[Cell, ...]
"""A state: the cell of each character, and then of each thing."""
Hypothesis = Mapping[str, Value]
S = TypeVar("S", bound=ListedSpec)


class ListedKind(KindOfTurns, Generic[S]):
    """A kind whose worlds have so few states that all are listed. Characters act one after the
    other, from cell to cell; everybody can `stay`, which changes nothing.

    Attributes:
        spec: what its worlds are as data.
        syntax: of its files; one that has more blocks than `audience` reads them by `told`.
    """

    spec: ClassVar[type[ListedSpec]]
    syntax = Syntax("world.lark", {"audience": tuple(RANGES)}, ())
    suggested = (1, 20)

    # What it must say. Numbers and words, no arrays.

    @abstractmethod
    def vocabulary(self, spec: S) -> Vocabulary:
        """What the language can say of it (words.py:listed_vocabulary)."""

    @abstractmethod
    def states(self, spec: S) -> Iterable[Picture]:
        """All states, no two of which look alike."""

    @abstractmethod
    def step(self, spec: S, state: Picture, who: str, action: str) -> Picture:
        """The state after a character's action."""

    @abstractmethod
    def worth(self, spec: S, hypothesis: Hypothesis, state: Picture, who: str) -> float:
        """A character's value of a state, if a hypothesis is true: what `V(who)` is."""

    def likes(
        self, spec: S, hypothesis: Hypothesis, state: Picture, who: str, action: str
    ) -> float:
        """How much a character likes an action: it takes one with a probability proportional to
        exp(beta * that). As much as the state after it, unless a kind says otherwise."""
        return self.worth(spec, hypothesis, self.step(spec, state, who, action), who)

    def begins(self, spec: S, state: Picture) -> bool:
        """Whether a script can begin so."""
        return True

    def told(self, reader: BlockReader) -> dict[str, Any]:
        """What a file says of a world besides `audience`, as fields of `spec`; mistakes go to the
        reader."""
        return {}

    def world(self) -> type[ListedWorld]:
        """The class of its worlds: one with predicates of its own, if it has some."""
        from i2pdsl.worlds.listed.world import ListedWorld

        return ListedWorld

    # As data.

    def parse(self, source: Source, name: str, files: Files | None = None) -> S:
        check_text(source)
        reader = BlockReader(source, self.syntax)
        reader.read()
        values: dict[str, float] = {}
        for block in reader.blocks:
            reader.known_keys(block)
            if block.keyword == "audience":
                for key, range_ in RANGES.items():
                    usual = values.get(key, getattr(ListedSettings, key))
                    values[key] = reader.number(block, key, usual, *range_)
        more = self.told(reader)
        if not reader.problems:
            settings = ListedSettings(**values)
            spec: Any = self.spec(name, source.text, header(source), settings, **more)
            words = self.vocabulary(spec)
            shares = reader.shares(words.latents)
            if shares and not reader.problems:
                reader.check_prior(shares, words.hypotheses)
            if not reader.problems:
                return replace(spec, shares=shares)
        raise StoryError(first_of(sorted(reader.problems, key=lambda d: d.span.start)))

    def as_json(self, spec: S) -> dict[str, Any]:
        words = self.vocabulary(spec)
        return {
            "states": len(list(self.states(spec))),
            "characters": [
                {"name": who, "actions": list(words.actions_of(who))} for who in words.characters
            ],
            "objects": [{"name": thing} for thing in words.things],
            "tiles": [
                {"name": name, "cells": [list(c) for c in cells]}
                for name, cells in words.places.items()
            ],
        }

    def in_words(self, spec: S) -> list[str]:
        words = self.vocabulary(spec)
        counts = len(words.free), len(list(self.states(spec))), len(words.hypotheses)
        told = ["{} cells, {} states, {} hypotheses".format(*map("{:,}".format, counts)), ""]
        told += [f"character {c}: {', '.join(words.actions_of(c))}" for c in words.characters]
        return told + [f"object {thing}" for thing in words.things]

    def has_same_rules(self, one: S, other: S) -> bool:
        return replace(one, settings=other.settings) == other

    # Ready to be searched and asked.

    def build(self, spec: S, viewers: tuple[Viewer, ...], watch: Watch) -> ListedWorld:
        from i2pdsl.worlds.listed.build import build_listed

        return build_listed(self, spec, viewers)

    def rules(self, spec: S) -> ListedWorld:
        from i2pdsl.worlds.world import Viewer

        return self.build(spec, (Viewer(spec),), Watch())

    # Scripts.

    def start_as_json(self, world: ListedWorld, state: Any) -> dict[str, Any]:
        from i2pdsl.worlds.listed.script import state_as_json

        return dict(state_as_json(world, state))

    def frames_as_json(self, world: ListedWorld, path: Trajectory) -> tuple[dict[str, Any], ...]:
        from i2pdsl.worlds.listed.script import frames_as_json

        return frames_as_json(world, path)

    def read(self, world: ListedWorld, record: Record) -> Trajectory:
        from i2pdsl.worlds.listed.script import read_listed

        return read_listed(world, record)

    def kept(self, world: ListedWorld, path: Trajectory, first: int, last: int) -> list[str]:
        from i2pdsl.worlds.listed.script import kept_in_words

        return kept_in_words(world, path, first, last)

    def naive(
        self,
        world: ListedWorld,
        story: TypedStory,
        allowed: np.ndarray,
        rational: np.ndarray,
        seed: int,
    ) -> Trajectory:
        from i2pdsl.worlds.listed.script import naive

        return naive(world, story.length, allowed, rational, seed)

    def distance(self, world: ListedWorld, first: np.ndarray, second: np.ndarray) -> float:
        from i2pdsl.worlds.listed.script import distance

        return distance(world, first, second)

    def meet(self, world: ListedWorld, states: np.ndarray) -> bool:
        pairs = list(combinations(range(len(world.vocabulary.characters)), 2))
        cells = world.tables.coordinates[world.tables.cells[states]]
        near = (abs(cells[:, a] - cells[:, b]).sum(-1).min() <= 1 for a, b in pairs)
        return not pairs or any(map(bool, near))

    # By hand.

    def frame_in_words(self, world: ListedWorld, path: Trajectory, frame: int) -> str:
        from i2pdsl.worlds.listed.script import turn_in_words

        return turn_in_words(world, path.actions[frame - 1])[1:-1]

    def continuation_in_words(self, world: ListedWorld, path: Trajectory, first: int) -> str:
        from i2pdsl.worlds.listed.script import turn_in_words

        return " ".join(turn_in_words(world, a) for a in path.actions[first - 1 :])
