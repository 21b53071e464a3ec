"""Stories as users hold them: read, told with other values, solved, asked. The flow of what is
done is pipeline.py."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

import numpy as np

from i2pdsl import pipeline
from i2pdsl.errors import Diagnostic, Source, error, whole_file
from i2pdsl.language import ast
from i2pdsl.language.check import TypedStory, check_source
from i2pdsl.language.methods import has_audience
from i2pdsl.language.statements import read_source
from i2pdsl.objective.wishes import Wish, doubts
from i2pdsl.results import Choice, Result
from i2pdsl.sampling import Samples, sample
from i2pdsl.scripts import Answer, Script, script_from, script_of_positions
from i2pdsl.search.searches import search_of
from i2pdsl.search.task import Task
from i2pdsl.search.wishes import wishes_of
from i2pdsl.shown import Shown, desk_of
from i2pdsl.worlds.find import find_vocabulary, world_warnings
from i2pdsl.worlds.kind import Spec, Watch
from i2pdsl.worlds.kinds import kind_of
from i2pdsl.worlds.ready import viewers_of
from i2pdsl.worlds.record import Kept, runs_of
from i2pdsl.worlds.world import Viewer, World

if TYPE_CHECKING:
    from i2pdsl.studio.cell import StudioWidget

Value = float | str | Iterable[float]
"""A setting in Python."""

__all__ = ["Answer", "Result", "Script", "Story", "load", "script_from", "story_from"]


def load(path: Path | str) -> Story:
    """Reads and checks a story.

    >>> story = load("stories/kitchen/help.story")

    Raises StoryError with every mistake of the file.
    """
    return story_from(read_source(path), Path(path).parent)


def story_from(
    source: Source, folder: Path | None = None, settings: Sequence[tuple[str, str]] = ()
) -> Story:
    """Checks the text of a story; imports and worlds are looked for in `folder`.

    `settings` are (name, value) pairs that replace values of the text (`i2p run --set`).
    """
    return Story(pipeline.typed(source, folder, settings), folder)


def in_language(value: Value) -> str:
    """A setting that was given in Python, as a story has it."""
    if isinstance(value, str):
        return value
    if isinstance(value, Iterable):
        return f"{{{', '.join(map(in_language, value))}}}"
    return repr(value.item() if isinstance(value, np.generic) else value)


@dataclass(frozen=True)
class Story(Shown):
    """A checked story.

    Attributes:
        typed: what the file says, names resolved.
        folder: where its imports and its world are looked for.
        known: its world, where it is not to be looked for.
        kept: frames of a script that a descent shall keep (`keeping`).
    """

    typed: TypedStory
    folder: Path | None = None
    known: Spec | None = None
    kept: Kept | None = None

    @staticmethod
    def from_text(text: str, folder: Path | str | None = None, **settings: Value) -> Story:
        """A story from its text; imports and worlds are looked for in `folder`.

        `settings` replace values of the text, as with `with_`.

        >>> Story.from_text("world maze\\nlength 6\\nmaximize depict(rho > 0)", beta=1)

        Raises StoryError with every mistake.
        """
        given = [(name, in_language(value)) for name, value in settings.items()]
        return story_from(Source("story", text), None if folder is None else Path(folder), given)

    def with_(self, **settings: Value) -> Story:
        """The story with other values: what `i2p run --set` can replace (language.md, "Setting
        values from outside").

        Numbers are numbers, sets of them any collection, and a text is what would be written.

        >>> story.with_(length=20, beta=1, friend="rho > 0", rationality=0.5)

        Raises StoryError for a name that the story does not have, and a value that it cannot take.
        """
        given = ((name, in_language(value)) for name, value in settings.items())
        return self._retold(pipeline.overridden(self.typed.source, given, self.typed.vocabulary))

    def _retold(self, source: Source) -> Story:
        """The same with another text, in the same world. Raises StoryError."""
        words = self.typed.vocabulary
        find = find_vocabulary if self.known is None else lambda *_: words
        checked = check_source(source, find, self.folder)
        assert isinstance(checked, TypedStory)
        return replace(self, typed=checked)

    @property
    def warnings(self) -> tuple[Diagnostic, ...]:
        """Of the text, and of the world with the story's settings."""
        told = self.typed
        return told.warnings + world_warnings(told.world, self.folder, told)

    @cached_property
    def spec(self) -> Spec:
        """The world's description with the story's settings."""
        return pipeline.described(self.typed, self.folder, self.known)

    @cached_property
    def viewers(self) -> tuple[Viewer, ...]:
        """The audience."""
        return viewers_of(self.spec, self.typed.observers)

    def world(self, watch: Watch | None = None) -> World:
        """The world, planned or trained, as the audience sees it.

        Raises StoryError where it is too large, or nobody has trained its controllers.
        """
        return pipeline.ready(self.typed, self.spec, self.viewers, watch)

    def task(self, watch: Watch | None = None, effort: int = 1) -> Task:
        """The story in its world, to be searched. Raises StoryError as `world` does."""
        told = (self.typed, self.spec, self.viewers, self.folder, self.kept)
        return pipeline.task(*told, watch or Watch(), effort)

    def keeping(self, script: Script, frames: Sequence[int]) -> Story:
        """The story with frames of a script pinned: the rest is solved around them.

        Where actions have names, it is the same story with `pin` statements. Elsewhere a descent
        keeps what is done in these frames, and from which states as far as it can
        (search/descent.py).

        Args:
            frames: their numbers, from 1 on.

        Raises StoryError for frames that one of the two does not have, a script of another world,
        and what contradicts the story's own pins.
        """
        where, kind = whole_file(self.typed.source.name), kind_of(self.spec)
        shorter = min(script.length, self.typed.length)
        wrong = next((f for f in frames if not 1 <= f <= shorter), None)
        if wrong is not None:
            message = f"frame {wrong} cannot be kept: the script has {script.length:,} frames, "
            raise error("keep", f"{message}the story {self.typed.length:,}", where)
        if not kind.has_same_rules(self.spec, script.world.spec):
            message = f"the script happens in another world, {script.world.name}"
            raise error("keep", message, where)
        if not self.typed.vocabulary.enumerable:
            return replace(self, kept=Kept(tuple(frames), script.trajectory))
        lines = [
            line
            for first, last in runs_of(frames)
            for line in kind.kept(script.world, script.trajectory, first, last)
        ]
        source = self.typed.source
        return self._retold(Source(source.name, "\n".join([source.text.rstrip(), "", *lines, ""])))

    def studio(self) -> StudioWidget:
        """The story on its stage in a cell of a notebook: to be played, dragged, drawn, written.

        What hands do is in the widget's `text`; its `story` and `script` are what comes of it.

        Raises StoryError without anywidget (`pip install 'i2pdsl[notebook]'`).
        """
        try:
            desk: StudioWidget = desk_of(self)
        except ImportError as problem:
            message = f"`studio()` needs {problem.name}"
            hint = "pip install 'i2pdsl[notebook]'"
            raise error("notebook", message, whole_file(self.typed.source.name), hint) from None
        return desk

    def script_from_positions(self, table: Any, watch: Watch | None = None) -> Script:
        """What this story's audience sees in a table of positions (`Script.from_positions`): a
        script of its world, with its names. Raises StoryError."""
        told = self.typed
        about = {"name": told.name, "file": told.source.name, "source": told.source.text}
        return script_of_positions(self.spec, table, about, dict(told.settings), watch)

    def solve(
        self,
        seed: int = 0,
        candidates: int = 1,
        naive: bool = False,
        watch: Watch | None = None,
        choose: Choice = "panel",
        effort: int = 1,
    ) -> Result:
        """Finds the script.

        Args:
            seed: of the initial states, or of the chance changes that a descent begins with;
                the result is the same for the same seed.
            candidates: how many visibly different scripts to return, best first. A descent
                returns all that it improved.
            naive: no audience; the characters do what is best for them.
            choose: whose opinion of the candidates counts: that of a `panel` of viewers whom they
                were not made for (objective/panel.py), of a `wide` one, or the `score`.
            effort: about so many times the usual time goes into a beam search. For the same seed
                more effort never makes the best score worse.

        >>> result = load("stories/kitchen/help.story").solve(seed=0)
        >>> result.script, result.score

        Raises StoryError where no state fulfils the `start`, the world is too large, or more effort
        is asked of a search that is no beam; ValueError for a negative seed, no candidates, no
        effort or another choice; NoComputing (a RuntimeError) where JAX cannot run, as in a process
        that was forked while it ran.
        """
        if seed < 0 or candidates < 1 or effort < 1:
            raise ValueError("a seed is at least 0, and candidates and effort are at least 1")
        if choose not in get_args(Choice):
            *others, last = get_args(Choice)
            raise ValueError(f"candidates are chosen by {', '.join(others)} or {last}")
        return pipeline.solved(self.task(watch, effort), seed, candidates, choose, naive)

    def sample(
        self,
        n: int = 1,
        given: str | None = None,
        seed: int = 0,
        assume: str | None = None,
        watch: Watch | None = None,
    ) -> Samples:
        """Scripts of characters who act under hypotheses drawn from the audience's prior
        (sampling.py). `given` is a condition on them; `assume` replaces the story's assumption,
        and 'nothing' drops it.

        >>> story.sample(1000, given="rho = 3 and G_cheese = pink", seed=0).confusion("rho").counts

        Raises StoryError; ValueError for a negative seed or fewer than one script.
        """
        if seed < 0 or n < 1:
            raise ValueError("a seed is at least 0, and there is at least one script")
        return sample(self.typed, self.world(watch), n, seed, given, assume)

    def wishes(
        self, script: Script, seed: int = 0, naive: bool = False, watch: Watch | None = None
    ) -> tuple[tuple[Wish, ...], bool]:
        """What a script of this story reaches of each `maximize` and `minimize`, what the best
        script for that wish alone reaches, and which frames hurt it; and whether nobody
        interrupted. It takes about as long as `solve`.

        Raises StoryError as `solve` does, and KeyboardInterrupt.
        """
        looks = not naive and has_audience(self.typed.search.method)
        search = search_of(self.typed) if looks else None
        task = self.task(watch)
        task = replace(task, story=self.typed.of_length(script.length))
        return wishes_of(task, search, script.frames, seed)

    def doubts(self, script: Script) -> tuple[Diagnostic, ...]:
        """Warnings about what viewers are brought to believe by a script of this story, and about
        its world where that is too approximate."""
        trust = () if script.trust is None else script.trust.warnings(self.typed.place(ast.World))
        return (*doubts(self.typed, script.world, script.frames), *trust)

    def __repr__(self) -> str:
        told = self.typed
        return f"<Story {told.name}: world {told.world}, {told.frames}>"
