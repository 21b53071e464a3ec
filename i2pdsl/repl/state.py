"""What a session knows at a moment: never changed, only replaced, so that `undo` is easy."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any

from i2pdsl.language.check import TypedStory
from i2pdsl.language.forms import Word
from i2pdsl.render.characters import Ink
from i2pdsl.repl.program import Program
from i2pdsl.repl.words import commands_with
from i2pdsl.worlds.find import find_spec
from i2pdsl.worlds.kind import Spec
from i2pdsl.worlds.kinds import kind_of
from i2pdsl.worlds.record import Kept, Trajectory

SCORED = (  # what a script's objective depends on
    *("world", "settings", "frames", "objective", "weights", "assumption", "audiences"),
    *("requirements", "pins"),
)
SEARCHED = (*SCORED, "start", "allow", "search")  # and what a search does


def same_story(one: TypedStory, other: TypedStory, parts: Iterable[str] = SEARCHED) -> bool:
    """Whether two stories agree in some parts: names that nothing uses make no other story."""
    return all(getattr(one, part) == getattr(other, part) for part in parts)


@dataclass(frozen=True)
class Suggestion:
    """Frames that could come next: the turns in words, the longer script, its score, and the
    story's requirements that it breaks, as they are written."""

    told: str
    path: Trajectory
    score: float
    broken: tuple[str, ...] = ()


@dataclass(frozen=True)
class State:
    """A story and a script.

    Attributes:
        program: the statements.
        typed: what they come to, missing ones filled in.
        path: the script's actions and states; None before there is one.
        score: its objective, where a search or a file says it.
        seed: of the search.
        is_owed: a story was opened, and its script is made when it is first asked about.
        suggestions: of the last `suggest`, for this very script.
        kept: frames that a descent shall keep; where actions have names the program says which.
    """

    program: Program
    typed: TypedStory = field(compare=False)
    path: Trajectory | None = None
    score: float | None = None
    seed: int = 0
    is_owed: bool = False
    suggestions: tuple[Suggestion, ...] = ()
    kept: Kept | None = None

    def paid(self, solved: State) -> State:
        """The state with the script that was found since, if it owes the same one."""
        same = self.is_owed and self.seed == solved.seed and same_story(self.typed, solved.typed)
        if not same:
            return self
        return replace(self, path=solved.path, score=solved.score, is_owed=False)

    @property
    def spec(self) -> Spec | None:
        """Its world as data; None where that is not found any more."""
        return self.program.known or find_spec(self.typed.world, self.program.folder)

    @property
    def commands(self) -> tuple[Word, ...]:
        """The session's commands, `play` in the words of its world."""
        spec = self.spec
        play = None if spec is None else kind_of(spec).play(self.typed.vocabulary)
        return commands_with(play)

    def command(self, name: str) -> Word | None:
        """What a command does."""
        return next((word for word in self.commands if word.name == name), None)

    def about(self) -> dict[str, Any]:
        """What a script file says of its story.

        What is missing yet is filled in, since the file's readers need a whole story to know its
        names, its assumption and its audience.
        """
        bare = all(part.keyword == "world" for part in self.program.parts)
        source = None if bare else self.typed.source.text
        return {
            "name": self.typed.name,
            "file": self.program.name,
            "source": source,
            "seed": self.seed,
        }


@dataclass
class Desk:
    """What lies before a session: its story and script, and how they were before.

    Attributes:
        state: the story and script as they are now.
        past: the states that `undo` brings back, each with the line that changed it.
        ink: what frames are drawn with.
    """

    state: State
    past: list[tuple[str, State]] = field(default_factory=list)
    ink: Ink = field(default_factory=Ink)

    def pay(self, solved: State) -> None:
        """Gives a script to the earlier states that owe the same one: `undo` searches nothing."""
        self.past = [(line, old.paid(solved)) for line, old in self.past]
