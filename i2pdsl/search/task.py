"""What a search is asked, what it answers, and what all searches have in common."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar, Protocol

import numpy as np

from i2pdsl.computing import computing
from i2pdsl.errors import StoryError, error, whole_file
from i2pdsl.language import ast
from i2pdsl.language.story import TypedStory
from i2pdsl.objective.compile import late_from
from i2pdsl.objective.fold import Objective
from i2pdsl.objective.pins import still_to_break
from i2pdsl.objective.starts import allowed_starts
from i2pdsl.objective.terms import story_objective
from i2pdsl.worlds.kind import Watch
from i2pdsl.worlds.record import Kept, Trajectory
from i2pdsl.worlds.world import World

if TYPE_CHECKING:
    from i2pdsl.programs import Program


@dataclass(frozen=True)
class Task:
    """A story in its world, to be searched with so many times the usual effort; for the sake of
    one of its wishes alone, if that has a number. `whole` is the objective of all its wishes, where
    it is there already: requirements take seconds to compile. `kept` are frames of a script for a
    descent to keep."""

    story: TypedStory
    world: World
    watch: Watch
    effort: int = 1
    only: int | None = None
    whole: Objective | None = None
    kept: Kept | None = None

    @cached_property
    def objective(self) -> Objective:
        whole = self.whole or story_objective(self.story, self.world)
        return whole if self.only is None else whole.alone(self.only)

    @cached_property
    def starts(self) -> np.ndarray:
        """The initial states that the story allows, and from which most of what is pinned can be
        kept. Raises StoryError where there is none."""
        allowed = allowed_starts(self.world, self.story.start)
        if not len(allowed):
            whole = whole_file(self.story.source.name)
            raise error("start", "no state of the world fulfils the `start` condition", whole)
        if not self.story.pins or not self.story.vocabulary.enumerable:
            return allowed
        pins = self.objective.params.pins
        if pins is not None:
            breaks = still_to_break(pins, 0, allowed)
        else:
            asked = ((pin.frame, pin.condition) for pin in self.story.pins)
            breaks = late_from(self.world, asked, self.events, allowed)
        return allowed[breaks == breaks.min()]

    @property
    def first(self) -> np.ndarray:
        """Where a script begins that nobody searches for: bodies where their file has them
        if it may be so, others anywhere (drawn with seed 0). Raises StoryError."""
        listed = self.story.vocabulary.enumerable
        return draw_starts(self.starts, 1, 0)[0] if listed else self.starts[0]

    @property
    def events(self) -> tuple[int, ...]:
        """The events that the story allows, in the world's numbers."""
        return self.world.events(self.story.allow)

    @contextmanager
    def searching(self) -> Iterator[None]:
        """Where JAX computes; what is wrong with a search is said at the story's `search`."""
        with computing(self.watch.say):
            try:
                yield
            except StoryError as problem:
                raise self.story.placed(problem, ast.Search) from None


@dataclass(frozen=True)
class Found:
    """What a search found: scripts, and whether it came to its end."""

    paths: list[Trajectory]
    finished: bool = True


def draw_starts(allowed: np.ndarray, count: int, seed: int) -> np.ndarray:
    """`count` different initial states, uniformly from the allowed ones; all if there are fewer."""
    generator = np.random.default_rng(seed)
    if count >= len(allowed):
        return generator.permutation(allowed)
    return generator.choice(allowed, size=count, replace=False)


def draw_more(allowed: np.ndarray, drawn: np.ndarray, effort: int, seed: int) -> np.ndarray:
    """Initial states besides those that were drawn, for more than the usual effort: those of less
    effort are the first of those of more."""
    if effort == 1 or len(drawn) == len(allowed):
        return allowed[:0]
    others = np.setdiff1d(allowed, drawn)
    return np.random.default_rng((seed, 1)).permutation(others)[: (effort - 1) * len(drawn)]


class Search(Protocol):
    """A way to look for the script of a story. The settings that a story gives it, and the worlds
    that it can search, are those of its name in language/methods.py.

    Attributes:
        offers_all: whether all that it finds are candidates, as each came from elsewhere;
            otherwise those are that differ visibly.
        takes_effort: whether it can spend more than usual.
    """

    offers_all: ClassVar[bool]
    takes_effort: ClassVar[bool]

    def prepare(self, task: Task) -> Program | None:
        """Compiles it without running it, so that the next of this shape starts at once; None
        where nothing is compiled. Raises StoryError."""

    def solve(self, task: Task, seed: int, count: int) -> Found:
        """Searches, for at least `count` scripts if there are so many. Ctrl-C ends it early with
        what was found.

        Raises StoryError, and KeyboardInterrupt before anything was found.
        """

    def onward(self, task: Task, path: Trajectory, frames: int) -> list[tuple[Trajectory, float]]:
        """A script with so many frames more, best first, each with what it is worth as a prefix
        of the story. Raises StoryError, KeyboardInterrupt."""
