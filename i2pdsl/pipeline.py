"""The whole flow: text -> typed story -> world -> objective -> search -> scripts -> answers."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from i2pdsl.audience.replay import evaluate, replay
from i2pdsl.errors import (
    Diagnostic,
    Source,
    StoryError,
    did_you_mean,
    error,
    shorten,
    whole_file,
)
from i2pdsl.language import typed as ty
from i2pdsl.language.check import (
    Library,
    TypedQuery,
    TypedStory,
    check_query,
    check_source,
    default_assumption,
)
from i2pdsl.language.scope import Module
from i2pdsl.language.statements import read_source
from i2pdsl.objective.appended import append_turns
from i2pdsl.objective.frame import Frame
from i2pdsl.objective.terms import score_script, story_objective
from i2pdsl.search.candidates import select_different
from i2pdsl.search.naive import depicted_event, naive_rollout
from i2pdsl.search.script import Record, Trajectory, make_record, read_path, read_record
from i2pdsl.worlds.find import find_spec, find_vocabulary
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.grid.spec import GridSpec
from i2pdsl.worlds.grid.vocabulary import grid_vocabulary
from i2pdsl.worlds.grid.world import GridWorld, Viewer, build_world, unplanned_world

RESCORED = 64  # of the best scripts in single precision, scored again to choose candidates


@dataclass
class Watch:
    """Where long work reports to; the command line fills in progress bars and messages."""

    planning: Callable[[str, int, float, float | None], None] | None = None
    searching: Callable[[int, int], None] | None = None
    say: Callable[[str], None] | None = None
    seconds: dict[str, float] = field(default_factory=dict)

    def add(self, stage: str, began: float) -> None:
        self.seconds[stage] = self.seconds.get(stage, 0.0) + time.perf_counter() - began


def load(path: Path | str) -> Story:
    """Reads and checks a story.

    >>> story = load("stories/kitchen/help.story")

    Raises StoryError with every mistake of the file.
    """
    return story_from(read_source(path), Path(path).parent)


def story_from(source: Source, folder: Path | None = None) -> Story:
    """Checks the text of a story; imports and worlds are looked for in `folder`."""
    checked = check_source(source, find_vocabulary, folder)
    if isinstance(checked, Library):
        message = "this is a library of patterns, not a story"
        hint = "a story needs `world`, `length` and `maximize`"
        raise error("library", message, whole_file(source.name), hint)
    return Story(checked, folder)


@lru_cache(maxsize=4)
def _world(spec: GridSpec, viewers: tuple[Viewer, ...]) -> GridWorld:
    return build_world(spec, viewers, _watch.planning, _watch.say)


_watch = Watch()


def ready_world(spec: GridSpec, viewers: tuple[Viewer, ...], watch: Watch | None) -> GridWorld:
    """A planned world; the last few are kept in memory."""
    global _watch  # the cached function must not depend on who watches
    began = time.perf_counter()
    _watch = watch or Watch()
    try:
        return _world(spec, viewers)
    finally:
        _watch.add("plan", began)
        _watch = Watch()


@dataclass(frozen=True)
class Story:
    """A checked story.

    Attributes:
        typed: what the file says, names resolved.
        folder: where its imports and its world are looked for.
    """

    typed: TypedStory
    folder: Path | None = None

    @property
    def warnings(self) -> tuple[Diagnostic, ...]:
        return self.typed.warnings

    @cached_property
    def spec(self) -> GridSpec:
        """The world's description with the story's settings."""
        spec = find_spec(self.typed.world, self.folder)
        assert spec is not None
        return spec.with_settings(dict(self.typed.settings))

    @cached_property
    def viewers(self) -> tuple[Viewer, ...]:
        """The audience."""
        return tuple(
            Viewer(self.spec.with_settings(dict(o.settings)), o.prior) for o in self.typed.observers
        )

    def world(self, watch: Watch | None = None) -> GridWorld:
        """The planned world as the audience sees it."""
        return ready_world(self.spec, self.viewers, watch)

    def solve(
        self,
        seed: int = 0,
        candidates: int = 1,
        naive: bool = False,
        watch: Watch | None = None,
    ) -> Result:
        """Finds the script.

        Args:
            seed: of the initial states; the result is the same for the same seed.
            candidates: how many visibly different scripts to return, best first.
            naive: no audience; the characters do what is best for them.

        >>> result = load("stories/kitchen/help.story").solve(seed=0)
        >>> result.script, result.score

        Raises StoryError where no state fulfils the `start`, or the world is too large;
        ValueError for a negative seed or no candidates.
        """
        if seed < 0 or candidates < 1:
            raise ValueError("a seed is at least 0, and there is at least one candidate")
        watch = watch or Watch()
        world = self.world(watch)
        allowed = world.starts(self.typed.start)
        if not len(allowed):
            whole = whole_file(self.typed.source.name)
            raise error("start", "no state of the world fulfils the `start` condition", whole)
        if naive or self.typed.search.method == "naive":
            found = [self._naive(world, allowed, seed, watch)]
            finished = True
        else:
            found, finished = self._beam(world, allowed, seed, candidates, watch)
        began = time.perf_counter()
        scripts = [self._script(world, t, seed) for t in found]
        scripts.sort(key=lambda s: -(s.score or 0.0))
        states = [s.trajectory.states for s in scripts]
        chosen = [scripts[i] for i in select_different(world, states, candidates)]
        watch.add("search", began)
        return Result(tuple(chosen), finished, dict(watch.seconds))

    def _beam(
        self, world: GridWorld, allowed: np.ndarray, seed: int, candidates: int, watch: Watch
    ) -> tuple[list[Trajectory], bool]:
        from i2pdsl.search.beam import beam_search, draw_starts

        plan, length = self.typed.search, self.typed.length
        entities = world.spec.entities
        events = tuple(
            world.moves.events.index(entities.index(thing)) for _, thing in self.typed.allow
        )
        objective = story_objective(self.typed, world)
        starts = draw_starts(allowed, plan.starts, seed)
        began = time.perf_counter()
        found = beam_search(
            world, objective, length, starts, plan.width, events, watch.searching, watch.say
        )
        watch.add("search", began)
        watch.seconds["search"] -= found.compile_seconds
        watch.seconds["compile"] = watch.seconds.get("compile", 0.0) + found.compile_seconds
        count = RESCORED if candidates > 1 else 8
        best = np.flatnonzero(np.isfinite(found.scores))[:count]
        if not len(best):
            message = "the objective has no finite value for any script that was found"
            hint = "look for a logarithm of 0 or a division by 0"
            raise error("objective", message, whole_file(self.typed.source.name), hint)
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

    def _script(self, world: GridWorld, path: Trajectory, seed: int) -> Script:
        frames = replay(world, path.states, path.actions)
        with np.errstate(all="ignore"):
            score = score_script(self.typed, world, frames)
        source = self.typed.source
        about = {"name": self.typed.name, "file": source.name, "source": source.text, "seed": seed}
        record = make_record(world, path, about, dict(self.typed.settings), score)
        module, assumption = self.typed.module, self.typed.assumption
        turns = appended_turns(self.typed)
        return Script(record, world, path, module, assumption, frames, appended=turns)


def trajectory(world: GridWorld, start: int, actions: np.ndarray) -> Trajectory:
    """A script in the world's numbers from its start and its actions."""
    states = [start]
    for action in actions:
        states.append(int(world.transition(world.tables, np.asarray(states[-1]), action)))
    return Trajectory(start, np.asarray(actions, dtype=np.int64), np.array(states, dtype=np.int64))


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


@dataclass(frozen=True)
class Script:
    """A finished story that can be asked and drawn.

    Attributes:
        record: the content of its file.
        world: the planned world.
        trajectory: states and actions in the world's numbers.
        module: the names that queries may use: lets, patterns, imports of its story.
        assumption: the mask over hypotheses that queries are conditioned on.
        frames: states and beliefs, frame by frame.
        warnings: of its file, where that could not be taken quite as it is.
        appended: the turns that its story appends to it (a flashback's last picture).
    """

    record: Record
    world: GridWorld
    trajectory: Trajectory
    module: Module
    assumption: tuple[bool, ...]
    frames: Frame
    warnings: tuple[Diagnostic, ...] = ()
    appended: tuple[ty.Turn, ...] = ()

    @property
    def score(self) -> float | None:
        """The objective that was reached, as the file has it."""
        return self.record.score

    @property
    def length(self) -> int:
        """T, the number of frames."""
        return len(self.trajectory.actions)

    @staticmethod
    def load(path: Path | str, watch: Watch | None = None) -> Script:
        """Reads a script file and holds it against the rules of its world.

        >>> script = Script.load("script.json")

        Raises StoryError, naming the frame, where the world does not allow what it says.
        """
        return script_from(read_record(path), Path(path).parent, watch)

    def save(self, path: Path | str) -> Path:
        """Writes the script as JSON, atomically."""
        return self.record.save(path)

    def shown(self) -> Script:
        """The script as viewers see it: with the turns that its story appends, as far as they
        can happen."""
        actions, states = list(self.trajectory.actions), list(self.trajectory.states)
        for turn in self.appended:
            action, possible = self.world.act(self.world.tables, np.asarray(states[-1]), turn)
            if not possible:
                break
            actions.append(int(action))
            states.append(
                int(self.world.transition(self.world.tables, np.asarray(states[-1]), action))
            )
        path = Trajectory(self.trajectory.start, np.array(actions), np.array(states))
        story, settings = self.record.story, self.record.world["settings"]
        record = make_record(self.world, path, story, settings, self.score)
        frames = replay(self.world, path.states, path.actions)
        return replace(self, record=record, trajectory=path, frames=frames, appended=())

    def check(self, expression: str, assume: str | None = None) -> TypedQuery:
        """Checks a query. Raises StoryError."""
        return check_query(
            Source("query", expression),
            self.world.vocabulary,
            self.module,
            self.length,
            self.assumption,
            None if assume is None else Source("assume", assume),
        )

    def query(self, expression: str, assume: str | None = None) -> np.ndarray:
        """Asks a question of the audience (language.md, "Queries").

        A number (an array without axes) where the expression has no free t; an array over t
        where it has one; for a bare latent a last axis of the latent's values, in the world's
        order, without the hypotheses in which it plays no part.

        >>> script.query("P(rho > 0 | script[:t])")          # [T + 1]
        >>> script.query("P(G_robot | script[:t])")          # [T + 1, values]
        >>> script.query("P(R_robot | script[:T])", assume="nothing")

        Raises StoryError.
        """
        answer = self.answer(self.check(expression, assume))
        return np.asarray(answer.value)

    def answer(self, query: TypedQuery) -> Answer:
        """Evaluates a checked query."""
        self._check_appended(query)
        with np.errstate(all="ignore"):  # log(0) is an answer: -inf
            found = evaluate(self.world, self.frames, query.value, query.times)
        value = np.asarray(found, dtype=float)
        times = None if query.times is None else list(query.times)
        if not isinstance(query.value, ty.Distribution):
            return Answer(times, value, None, None)
        labels = query.value.partition.labels[:-1]
        return Answer(times, value[..., :-1], labels, value[..., -1])

    def _check_appended(self, query: TypedQuery) -> None:
        """Refuses a question about a turn that cannot follow the script's end."""
        last = Frame(*(part[-1] for part in self.frames))
        for node in ty.walk(query.value):
            if isinstance(node, ty.Moment) and node.turns:
                steps = append_turns(self.world, self.world.tables, node.turns, last)
                for number, (_, possible) in enumerate(steps, self.length + 1):
                    if not possible:
                        message = f"the appended frame {number} cannot happen: its place is taken"
                        raise error("turn", message, whole_file("query"))


def appended_turns(story: TypedStory) -> tuple[ty.Turn, ...]:
    """The longest sequence of turns that a story's objective appends to its script."""
    found: tuple[ty.Turn, ...] = ()
    for _, expression in story.objective:
        for node in ty.walk(expression):
            if isinstance(node, ty.Moment) and len(node.turns) > len(found):
                found = node.turns
    return found


@dataclass(frozen=True)
class Answer:
    """The answer to a query: over `t` if that is not None, and over `labels` for a latent.

    `unknown` is the probability of hypotheses in which the latent plays no part.
    """

    t: list[int] | None
    value: np.ndarray
    labels: tuple[str, ...] | None
    unknown: np.ndarray | None

    def as_json(self) -> Any:
        """The `value` of `i2p query --json`."""
        if self.labels is None:
            return self.value.tolist()
        assert self.unknown is not None
        table = np.concatenate([self.value, self.unknown[..., None]], axis=-1)
        names = (*self.labels, "unknown")
        rows = [dict(zip(names, map(float, row), strict=True)) for row in np.atleast_2d(table)]
        return rows if self.t is not None else rows[0]


def script_from(record: Record, folder: Path | None, watch: Watch | None = None) -> Script:
    """A script from the content of its file, held against its world's rules."""
    spec = _stored_world(record, folder)
    story, warnings = _stored_story(record, spec, folder)
    viewers = (
        tuple(Viewer(spec.with_settings(dict(o.settings)), o.prior) for o in story.observers)
        if story
        else (Viewer(spec),)
    )
    path = read_path(unplanned_world(spec), record)  # before planning, which may take long
    world = ready_world(spec, viewers, watch)
    module = story.module if story else Module(Source("script", ""))
    assumption = story.assumption if story else default_assumption(world.vocabulary)
    frames = replay(world, path.states, path.actions)
    turns = appended_turns(story) if story else ()
    return Script(record, world, path, module, assumption, frames, warnings, turns)


def _stored_world(record: Record, folder: Path | None) -> GridSpec:
    """The world of a script, with its settings. Raises StoryError."""
    name, text = record.world["name"], record.world["source"]
    where = whole_file(record.where)
    try:
        spec = parse_world(Source(f"{name}.world", text), name) if text else find_spec(name, folder)
    except (OSError, ValueError):  # a name that no file can have
        spec = None
    if spec is None:
        raise error("no-world", f"there is no world `{shorten(name)}`", where)
    known = grid_vocabulary(spec).settings
    settings: dict[str, float | str] = {}
    for key, value in record.world["settings"].items():
        if key not in known:
            message = f"world {spec.name} has no setting `{shorten(key)}`"
            raise error("script", message, where, did_you_mean(key, known))
        setting = known[key]
        number = isinstance(value, int | float) and not isinstance(value, bool)
        good = value in setting.choices if setting.choices else number and setting.accepts(value)
        if not good:
            valid = ", ".join(setting.choices) or setting.valid_range or "a number"
            message = f"the setting `{key}` cannot be {shorten(json.dumps(value))}"
            raise error("script", message, where, f"it can be: {valid}")
        settings[key] = value if setting.choices else float(value)
    return spec.with_settings(settings)


def _stored_story(
    record: Record, spec: GridSpec, folder: Path | None
) -> tuple[TypedStory | None, tuple[Diagnostic, ...]]:
    """The story that a script was made from, if its text is there and understood.

    It is read against the script's own world, whatever has become of the .world file since. What
    is said of the story is never an error: it informs. But whoever asks about the script misses
    its names, its assumption and its audience, so a text that is not understood is warned about.
    """
    text, file = record.story.get("source"), record.story.get("file")
    if not isinstance(text, str) or not text.strip():
        return None, ()
    name = file if isinstance(file, str) and file else "story"
    try:
        place = Path(name).parent if Path(name).is_file() else folder
    except OSError:  # a name that no file can have
        place = folder
    vocabulary = grid_vocabulary(spec)
    try:
        checked = check_source(Source(name, text), lambda *_: vocabulary, place)
    except StoryError as problem:
        reason = problem.diagnostics[0].message
    else:
        if isinstance(checked, TypedStory):
            return checked, ()
        reason = "it is a library"
    message = f"the story stored in the script is not understood: {reason}"
    hint = "its names, its assumption and its audience are not used"
    where = whole_file(record.where)
    return None, (Diagnostic("stored-story", message, where, hint, severity="warning"),)


def with_story(script: Script, story: Story) -> Script:
    """The same script asked with another story's names and assumption."""
    return replace(script, module=story.typed.module, assumption=story.typed.assumption)
