"""A kind of world: all that the rest of the house asks of it besides the World protocol
(worlds/world.py). Each kind is one object in its own folder, and one line of worlds/kinds.py."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

from i2pdsl.errors import Diagnostic, Source, Span, StoryError, error, whole_file
from i2pdsl.language.forms import Word
from i2pdsl.language.scope import Module
from i2pdsl.language.story import TypedStory
from i2pdsl.language.vocabulary import Vocabulary
from i2pdsl.worlds.beginnings import roles_among
from i2pdsl.worlds.blocks import Syntax
from i2pdsl.worlds.drawings import Files

if TYPE_CHECKING:
    import numpy as np

    from i2pdsl.worlds.positions import Inferred, Positions
    from i2pdsl.worlds.record import Record, Trajectory
    from i2pdsl.worlds.world import Viewer, World


@dataclass
class Watch:
    """Where long work reports to; the command line fills in progress bars and messages."""

    planning: Callable[[str, int, float, float | None], None] | None = None
    searching: Callable[[int, int], None] | None = None
    training: Callable[[int, int, dict[str, float]], None] | None = None
    say: Callable[[str], None] | None = None
    seconds: dict[str, float] = field(default_factory=dict)

    def add(self, stage: str, began: float, compiling: float = 0.0) -> None:
        """A stage that began then is done; so much of its time was spent on compiling."""
        spent = time.perf_counter() - began - compiling
        self.seconds[stage] = self.seconds.get(stage, 0.0) + spent
        if compiling:
            self.seconds["compile"] = self.seconds.get("compile", 0.0) + compiling


class Spec(Hashable, Protocol):
    """A world as data: a frozen dataclass, without arrays and JAX."""

    @property
    def kind(self) -> str:
        """A name of worlds/kinds.py."""

    @property
    def name(self) -> str: ...

    @property
    def documentation(self) -> str: ...

    @property
    def source(self) -> str:
        """The text of its file; empty where the name says all."""

    def with_settings(self, changes: dict[str, Any]) -> Spec:
        """The same world with some of its numbers replaced."""


@dataclass(frozen=True)
class Prepared:
    """What `i2p plan` or `i2p train` made: a document, the same in words, and whether it is
    finished."""

    document: dict[str, Any]
    words: str
    finished: bool = True


@dataclass(frozen=True)
class Approximation:
    """How a world is planned that is not planned exactly.

    Attributes:
        method: in words.
        closer: the same world planned by a method nearer to exact planning, if that fits.
        closer_method: that in words; or why there is none.
        copy: a small copy of the world as it is planned, and planned exactly, if there is one.
        told: how small the copy is, in words.
    """

    method: str
    closer: Any | None
    closer_method: str
    copy: tuple[Any, Any] | None
    told: str


Cell = tuple[int, int]
Side = tuple[Cell, Cell]
"""Two neighbouring cells, the northern or western one first."""


@dataclass(frozen=True)
class DrawnMap:
    """A map as a world's file draws it.

    Attributes:
        rows: all equally long, a sign for each cell.
        walls: the sides on which there is one.
        symbols: the signs of tiles, and their names.
        floor, wall: the signs of cells that are nothing else.
    """

    rows: tuple[str, ...]
    walls: tuple[Side, ...]
    symbols: Mapping[str, str]
    floor: str
    wall: str


@dataclass(frozen=True)
class Imported:
    """A world that was drawn for another tool.

    Attributes:
        what: of what tool it is, in words.
        text: of the world's file.
        notes: what is otherwise here, a sentence each.
        who: who acts first.
        goals: what that may want and can get to, the nearest first.
        length: frames that a first story may take.
    """

    what: str
    text: str
    notes: tuple[str, ...]
    who: str
    goals: tuple[str, ...]
    length: int


class Kind(ABC):
    """One kind of world.

    Attributes:
        syntax: of its files.
        suggested: the frames that the REPL's `suggest` adds without a number, and at most.
        acts_by_hypothesis: whether what a hypothesis says decides how characters act, so that
            the naive must be given one.
        catalogued: the built-in worlds in which a catalogue shows patterns, if none is named.
    """

    syntax: ClassVar[Syntax]
    suggested: ClassVar[tuple[int, int]]
    acts_by_hypothesis: ClassVar[bool] = True
    catalogued: ClassVar[tuple[str, ...]] = ()

    # As data: no arrays, no JAX.

    @abstractmethod
    def parse(self, source: Source, name: str, files: Files | None = None) -> Spec:
        """A world from the text of its file. Raises StoryError with all its mistakes.

        Args:
            files: where its own sprites are; without it they are not looked at.
        """

    def map_of(self, source: Source) -> DrawnMap | None:
        """The map that a file draws, to be painted; None where it draws none."""
        return None

    def with_map(self, source: Source, drawn: DrawnMap) -> str:
        """The text of a file with another map."""
        raise NotImplementedError

    def imported(self, source: Source, file: str, name: str, number: int) -> Imported:
        """A world of the text of another tool's map, or of one of several in it, from 1.

        Raises StoryError where it is none, or more than can be said here.

        Args:
            file: what it was read from, to be told.
            name: what the world shall be called.
        """
        raise NotImplementedError

    def drawings(self, spec: Any) -> Mapping[str, str]:
        """What is kept of its own sprites (worlds/drawings.py), by their names."""
        return {}

    def imagined_otherwise(self, spec: Any) -> Any | None:
        """The same world as viewers may also think that it works, for a wide panel
        (objective/panel.py); None where there is nothing of that kind to doubt."""
        return None

    def approximation(self, spec: Any) -> Approximation | None:
        """How it is planned approximately, as the machine allows; None where plans are exact."""
        return None

    def around(
        self, world: Any, viewers: tuple[Viewer, ...], paths: Sequence[Trajectory], watch: Watch
    ) -> tuple[World, list[Trajectory]] | None:
        """The part of an approximate world that is around some scripts, planned exactly, and the
        scripts in its numbers; None where that takes too long."""
        return None

    @abstractmethod
    def vocabulary(self, spec: Any) -> Vocabulary:
        """What the language can say of it."""

    @abstractmethod
    def as_json(self, spec: Any) -> dict[str, Any]:
        """What `i2p worlds --json` says of it, besides its words."""

    @abstractmethod
    def in_words(self, spec: Any) -> list[str]:
        """What `i2p worlds` says of it, in lines."""

    def warnings(
        self, spec: Any, where: str, story: TypedStory | None = None
    ) -> tuple[Diagnostic, ...]:
        """What is odd about it, or about a story in it, without being a mistake."""
        return ()

    def roles(self, spec: Any, words: Vocabulary) -> dict[str, str]:
        """The holes of beginnings (worlds/beginnings.py) that a world can fill, and with what."""
        return roles_among((), words)

    def has_same_rules(self, one: Any, other: Any) -> bool:
        """Whether what can happen is the same in two worlds: only what viewers expect differs."""
        return bool(one == other)

    # Ready to be searched and asked.

    def version(self, spec: Any) -> Hashable:
        """What tells what it is made ready from, from what another has put in its place."""
        return None

    @abstractmethod
    def build(self, spec: Any, viewers: tuple[Viewer, ...], watch: Watch) -> World:
        """The world ready for its viewers: planned, or what it needs found. Raises StoryError."""

    @abstractmethod
    def rules(self, spec: Any) -> World:
        """A world that knows what can happen, not what anyone expects: enough to check a script.

        Raises StoryError.
        """

    def plan(self, spec: Any, watch: Watch) -> Prepared:
        """Solves its planning problems ahead of time (`i2p plan`). Raises StoryError."""
        message = f"world {spec.name} needs no planning"
        raise error("no-plan", message, whole_file(spec.name), "its stories can be run at once")

    def training_settings(self, spec: Any) -> tuple[str, ...]:
        """The settings that decide what is trained (`i2p train`). Raises StoryError."""
        message = f"world {spec.name} needs no training"
        raise error("no-training", message, whole_file(spec.name), "its stories can be run at once")

    def train(
        self, spec: Any, seed: int | None, iterations: int | None, out: str | None, restart: bool,
        watch: Watch,
    ) -> Prepared:  # fmt: skip
        """Trains its controllers. Raises KeyboardInterrupt before there is anything to keep."""
        raise NotImplementedError

    # Scripts.

    @abstractmethod
    def start_as_json(self, world: Any, state: Any) -> dict[str, Any]:
        """A state as a script's file has it."""

    @abstractmethod
    def frames_as_json(self, world: Any, path: Trajectory) -> tuple[dict[str, Any], ...]:
        """The frames of a script's file."""

    @abstractmethod
    def read(self, world: Any, record: Record) -> Trajectory:
        """A script in the world's numbers, held against its rules frame by frame.

        Raises StoryError.
        """

    def inferred(self, world: Any, table: Positions) -> Inferred:
        """The script that a table of positions tells.

        Raises StoryError, naming the frame and who, where the rules do not allow it.
        """
        from i2pdsl.worlds.inferred import inferred_turns

        if not world.vocabulary.enumerable:
            message = f"where somebody is does not say all of a state {world.vocabulary.where}"
            raise error("positions", message, table.place)
        return inferred_turns(self, world, table)

    def begun(self, record: Record) -> str:
        """A condition that describes the first picture of a script; empty where stories have no
        words for it."""
        return ""

    def kept(self, world: Any, path: Trajectory, first: int, last: int) -> list[str]:
        """Statements that pin frames `first`..`last` of a script as they are, or where bodies move
        nearly so; none where stories have no words for that."""
        return []

    def columns(self, words: Vocabulary, record: Record) -> Mapping[str, tuple[list[Any], str]]:
        """The columns of a table of frames 0..T beside those of the world's quantities: values and
        the type that pandas gives them."""
        return {}

    @abstractmethod
    def naive(
        self, world: Any, story: TypedStory, allowed: np.ndarray, rational: np.ndarray, seed: int
    ) -> Trajectory:
        """Characters who do what is best for them, for nobody to see.

        Args:
            allowed: the initial states that the story allows.
            rational: the hypotheses that they may act by, a mask [H].
        """

    @abstractmethod
    def distance(self, world: Any, first: np.ndarray, second: np.ndarray) -> float:
        """How differently two scripts look, of states [T + 1, ...]: 1 where people see it."""

    def meet(self, world: Any, states: np.ndarray) -> bool:
        """Whether its characters come close to each other in a script, of states [T + 1, ...];
        true of one who is alone."""
        return True

    # By hand.

    @abstractmethod
    def play(self, words: Vocabulary) -> Word:
        """What `play` is in one of its worlds: how it is written, what it does, an example."""

    @abstractmethod
    def played(
        self, world: Any, module: Module, path: Trajectory, typed: str
    ) -> tuple[Trajectory, str]:
        """A script with what was typed behind `play`, and that in words, in brackets.

        Raises StoryError with places in Source("play", typed).
        """

    def options(self, words: Vocabulary, before: Sequence[str]) -> list[tuple[str, str]]:
        """What may be typed next behind `play`: texts, and what they are."""
        return []

    @abstractmethod
    def frame_in_words(self, world: Any, path: Trajectory, frame: int) -> str:
        """What the characters do in a frame from 1 on."""

    def continuation_in_words(self, world: Any, path: Trajectory, first: int) -> str:
        """What they do from frame `first` on; empty where that is better not said."""
        return ""


def refused(message: str, typed: str, hint: str | None = None) -> StoryError:
    """A mistake in what was typed behind `play`."""
    source = Source("play", typed)
    return error("command", message, Span(source, 0, len(typed)), hint)
