"""The whole flow: text -> typed story -> world -> objective -> search -> scripts -> answers."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from i2pdsl.audience.replay import replay
from i2pdsl.computing import computing
from i2pdsl.errors import Diagnostic, Source, StoryError, error, whole_file
from i2pdsl.language import ast
from i2pdsl.language.check import Library, TypedStory, check_source, default_assumption
from i2pdsl.language.override import override
from i2pdsl.language.parse import parse_tolerantly
from i2pdsl.language.statements import read_source
from i2pdsl.objective.starts import allowed_starts
from i2pdsl.objective.terms import score_script, story_objective
from i2pdsl.scripts import Answer, Script, extended, script_from, script_of
from i2pdsl.search.candidates import select_different
from i2pdsl.search.naive import depicted_event, hill_rollout, naive_rollout
from i2pdsl.search.record import Trajectory
from i2pdsl.worlds.find import Spec, find_spec, find_vocabulary, world_warnings
from i2pdsl.worlds.grid.world import GridWorld
from i2pdsl.worlds.hill.world import HillWorld
from i2pdsl.worlds.ready import Watch, ready_world, viewers_of
from i2pdsl.worlds.world import Viewer, World

__all__ = ["Answer", "Result", "Script", "Story", "load", "script_from", "story_from"]

RESCORED = 64  # of the best scripts in single precision, scored again to choose candidates
RESCORED_FRAMES = 20_000  # of all of them together, if they are long


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
    if settings:
        words = story_from(source, folder).typed.vocabulary
        method = "beam" if words.enumerable else "descend"
        for name, value in settings:
            source = override(source, name, value, tuple(words.settings), method)
    checked = check_source(source, find_vocabulary, folder)
    if isinstance(checked, Library):
        message = "this is a library of patterns, not a story"
        hint = "a story needs `world`, `length` and `maximize`"
        raise error("library", message, whole_file(source.name), hint)
    return Story(checked, folder)


@dataclass(frozen=True)
class Story:
    """A checked story.

    Attributes:
        typed: what the file says, names resolved.
        folder: where its imports and its world are looked for.
        known: its world, where it is not to be looked for.
    """

    typed: TypedStory
    folder: Path | None = None
    known: Spec | None = None

    @property
    def warnings(self) -> tuple[Diagnostic, ...]:
        """Of the text, and of the world with the story's settings."""
        told = self.typed
        return told.warnings + world_warnings(told.world, self.folder, told)

    @cached_property
    def spec(self) -> Spec:
        """The world's description with the story's settings."""
        spec = self.known or find_spec(self.typed.world, self.folder)
        assert spec is not None
        return spec.with_settings(dict(self.typed.settings))

    @cached_property
    def viewers(self) -> tuple[Viewer, ...]:
        """The audience."""
        return viewers_of(self.spec, self.typed.observers)

    def world(self, watch: Watch | None = None) -> World:
        """The world, planned or trained, as the audience sees it.

        Raises StoryError where it is too large, or nobody has trained its controllers.
        """
        try:
            return ready_world(self.spec, self.viewers, watch)
        except StoryError as problem:
            raise self._at_statement(problem, ast.World) from None

    def _at_statement(self, problem: StoryError, kind: type[ast.Node]) -> StoryError:
        """What is wrong with a world or a search, said at the story's statement."""
        program, _ = parse_tolerantly(self.typed.source)
        spans = [statement.span for statement in program.of(kind)]
        span = spans[0] if spans else whole_file(self.typed.source.name)
        return StoryError([replace(d, span=span) for d in problem.diagnostics])

    def allowed_starts(self, world: World) -> np.ndarray:
        """The states that fulfil the `start`. Raises StoryError where there is none."""
        allowed = allowed_starts(world, self.typed.start)
        if not len(allowed):
            whole = whole_file(self.typed.source.name)
            raise error("start", "no state of the world fulfils the `start` condition", whole)
        return allowed

    def events(self, world: GridWorld) -> tuple[int, ...]:
        """The allowed events, as numbers of `world.moves.events`."""
        entities = world.spec.entities
        return tuple(
            world.moves.events.index(entities.index(thing)) for _, thing in self.typed.allow
        )

    def solve(
        self,
        seed: int = 0,
        candidates: int = 1,
        naive: bool = False,
        watch: Watch | None = None,
    ) -> Result:
        """Finds the script.

        Args:
            seed: of the initial states, or of the chance changes that a descent begins with;
                the result is the same for the same seed.
            candidates: how many visibly different scripts to return, best first. A descent
                returns all that it improved.
            naive: no audience; the characters do what is best for them.

        >>> result = load("stories/kitchen/help.story").solve(seed=0)
        >>> result.script, result.score

        Raises StoryError where no state fulfils the `start`, or the world is too large;
        ValueError for a negative seed or no candidates; NoComputing (a RuntimeError) where JAX
        cannot run, as in a process that was forked while it ran.
        """
        if seed < 0 or candidates < 1:
            raise ValueError("a seed is at least 0, and there is at least one candidate")
        watch = watch or Watch()
        world = self.world(watch)
        if naive or self.typed.search.method == "naive":
            return self._solve(world, seed, candidates, True, watch)
        with computing(watch.say):
            return self._solve(world, seed, candidates, False, watch)

    def _solve(self, world: World, seed: int, candidates: int, naive: bool, watch: Watch) -> Result:
        if isinstance(world, HillWorld):
            return self._on_a_hill(world, seed, naive, watch)
        assert isinstance(world, GridWorld)
        allowed = self.allowed_starts(world)
        if naive:
            found = [self._naive(world, allowed, seed, watch)]
            finished = True
        else:
            found, finished = self._beam(world, allowed, seed, candidates, watch)
        began = time.perf_counter()
        scripts = self._scripts(world, found, seed)
        states = [s.trajectory.states for s in scripts]
        chosen = [scripts[i] for i in select_different(world, states, candidates)]
        watch.add("search", began)
        return Result(tuple(chosen), finished, dict(watch.seconds))

    def __repr__(self) -> str:
        told = self.typed
        return f"<Story {told.name}: world {told.world}, {told.length} frames>"

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> Any:
        from i2pdsl.notebook.display import show_story

        return show_story(self)

    def _on_a_hill(self, world: HillWorld, seed: int, naive: bool, watch: Watch) -> Result:
        plan, finished = self.typed.search, True
        if naive:
            began = time.perf_counter()
            with np.errstate(all="ignore"):  # refused below
                found = [hill_rollout(world, self.typed.length, plan.noise, seed)]
        else:
            from i2pdsl.search.descent import descend

            objective = story_objective(self.typed, world)
            began = time.perf_counter()
            try:
                result = descend(
                    world, objective, self.typed.length, plan, seed, watch.searching, watch.say
                )
            except StoryError as problem:
                raise self._at_statement(problem, ast.Search) from None
            finished = result.finished
            watch.seconds["compile"] = result.compile_seconds
            began += result.compile_seconds
            found = [
                Trajectory(actions.astype(float), states.astype(float))
                for actions, states in zip(result.actions, result.states, strict=True)
            ]
        finite = [path for path in found if np.isfinite(path.states).all()]
        if len(finite) < len(found) and watch.say is not None:
            watch.say(f"{len(found) - len(finite)} scripts are dropped: their motion is not finite")
        if not finite:
            message = "the motion is not finite: the hill is too rough for the simulator's steps"
            raise error("motion", message, whole_file(self.typed.source.name))
        found = finite
        scripts = self._scripts(world, found, seed)
        if not any(s.score is not None and np.isfinite(s.score) for s in scripts):
            raise self._without_value()
        watch.add("search", began)
        return Result(tuple(scripts), finished, dict(watch.seconds))

    def _scripts(self, world: World, found: list[Trajectory], seed: int) -> list[Script]:
        """Scripts from what a search found, best first."""
        scripts = [self._script(world, path, seed) for path in found]
        worth = lambda s: -np.inf if s.score is None or np.isnan(s.score) else s.score
        return sorted(scripts, key=lambda s: -worth(s))

    def _without_value(self) -> StoryError:
        message = "the objective has no finite value for any script that was found"
        hint = "look for a logarithm of 0 or a division by 0"
        return error("objective", message, whole_file(self.typed.source.name), hint)

    def _beam(
        self, world: GridWorld, allowed: np.ndarray, seed: int, candidates: int, watch: Watch
    ) -> tuple[list[Trajectory], bool]:
        from i2pdsl.search.beam import beam_search, draw_starts

        plan, length, events = self.typed.search, self.typed.length, self.events(world)
        objective = story_objective(self.typed, world)
        starts = draw_starts(allowed, plan.starts, seed)
        began = time.perf_counter()
        try:
            found = beam_search(
                world, objective, length, starts, plan.width, events, watch.searching, watch.say
            )
        except StoryError as problem:
            raise self._at_statement(problem, ast.Search) from None
        watch.add("search", began)
        watch.seconds["search"] -= found.compile_seconds
        watch.seconds["compile"] = watch.seconds.get("compile", 0.0) + found.compile_seconds
        count = RESCORED if candidates > 1 else 8
        count = max(candidates, min(count, RESCORED_FRAMES // length))
        best = np.flatnonzero(np.isfinite(found.scores))[:count]
        if not len(best):
            raise self._without_value()
        return [
            trajectory(world, int(found.starts[i]), found.actions[i]) for i in best
        ], found.finished

    def _naive(self, world: GridWorld, allowed: np.ndarray, seed: int, watch: Watch) -> Trajectory:
        rational = np.array(default_assumption(world.vocabulary))
        if self.typed.objective:
            event = depicted_event(self.typed.objective)
            if event is None:
                message = "naive planning needs a story that depicts one event"
                hint = "a story such as `maximize depict(rho > 0)`"
                raise error("naive", message, whole_file(self.typed.source.name), hint)
            rational = rational & np.array(event)
            if not rational.any():
                message = "no rational hypothesis fulfils the depicted event"
                raise error("naive", message, whole_file(self.typed.source.name))
        began = time.perf_counter()
        start, actions, _ = naive_rollout(world, self.typed.length, allowed, rational, seed)
        watch.add("search", began)
        return trajectory(world, start, actions)

    def _script(self, world: World, path: Trajectory, seed: int) -> Script:
        frames = replay(world, path.states, path.actions)
        with np.errstate(all="ignore"):
            score = score_script(self.typed, world, frames)
        source = self.typed.source
        about = {"name": self.typed.name, "file": source.name, "source": source.text, "seed": seed}
        return script_of(self.typed, world, path, frames, about, score)


def trajectory(world: GridWorld, start: int, actions: np.ndarray) -> Trajectory:
    """A script in the world's numbers from its start and its actions."""
    nothing = Trajectory(np.zeros(0, dtype=np.int64), np.array([start], dtype=np.int64))
    return extended(world, nothing, actions)


@dataclass(frozen=True)
class Result:
    """What a search found.

    Attributes:
        candidates: scripts that differ visibly, best first.
        finished: false where the search was interrupted.
        seconds: time of each stage: plan, compile, search.
    """

    candidates: tuple[Script, ...]
    finished: bool
    seconds: dict[str, float]

    @property
    def script(self) -> Script:
        """The best script."""
        return self.candidates[0]

    @property
    def score(self) -> float:
        """Its objective, automatic terms included."""
        return self.script.score or 0.0

    def __repr__(self) -> str:
        return f"<Result: {len(self.candidates)} found, the best {self.script!r}>"

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> Any:
        from i2pdsl.notebook.display import show_result

        return show_result(self)
