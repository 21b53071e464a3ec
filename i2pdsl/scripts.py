"""Finished scripts: asked, extended, saved and read."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from i2pdsl.answers import Answer, answer_of
from i2pdsl.errors import Diagnostic, Source, error, shorten, whole_file
from i2pdsl.language import typed as ty
from i2pdsl.language.check import TypedQuery, TypedStory, check_query
from i2pdsl.language.query import check_audience
from i2pdsl.language.scope import Module
from i2pdsl.language.story import USUAL, Audience, Observer, Requirement, watching
from i2pdsl.objective.appended import append_turns
from i2pdsl.objective.effective import Effective, effective_of
from i2pdsl.objective.frame import Frame
from i2pdsl.objective.nearer import Standard, standard
from i2pdsl.objective.replay import evaluate, replay, replay_many
from i2pdsl.objective.requirements import unmet
from i2pdsl.objective.subjects import Subject, subjects_of
from i2pdsl.objective.trust import Trust, apart, off_by
from i2pdsl.objective.windows import appended_turns, story_windows
from i2pdsl.objective.wishes import Wish
from i2pdsl.shown import Shown
from i2pdsl.stored import stored
from i2pdsl.worlds.find import find_spec, vocabulary_of
from i2pdsl.worlds.kind import Spec, Watch
from i2pdsl.worlds.kinds import kind_of
from i2pdsl.worlds.positions import read_positions
from i2pdsl.worlds.ready import ready_world, viewers_of
from i2pdsl.worlds.record import Record, Trajectory, extended, read_record
from i2pdsl.worlds.world import World

if TYPE_CHECKING:
    import pandas


@dataclass(frozen=True)
class Script(Shown):
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
        windows: the stretches of frames that its story treats otherwise than the rest.
        unmet: the requirements of its story that it does not meet.
        subjects: the beliefs that its story speaks of.
        wishes: what it reaches of each, if somebody looked (search/wishes.py).
        audiences: those of its story, whose observers are those of `world`.
        trust: what is known of the error of its world and its viewers, where these are approximate
            and somebody looked (`vouched`).
        nearer: a world that is nearer to exact, and what viewers make of the script there.
    """

    record: Record
    world: World
    trajectory: Trajectory
    module: Module
    assumption: tuple[bool, ...]
    frames: Frame
    warnings: tuple[Diagnostic, ...] = ()
    appended: tuple[ty.Turn, ...] = ()
    windows: tuple[tuple[int, int, str], ...] = ()
    unmet: tuple[Requirement, ...] = ()
    subjects: tuple[Subject, ...] = ()
    wishes: tuple[Wish, ...] = ()
    audiences: tuple[Audience, ...] = (USUAL,)
    trust: Trust | None = None
    nearer: tuple[Standard, Frame] | None = field(default=None, compare=False, repr=False)

    @property
    def score(self) -> float | None:
        """The objective that was reached, as the file has it."""
        return self.record.score

    @property
    def still(self) -> float:
        """The share of frames in which nothing changes that a viewer can see."""
        states = self.trajectory.states
        return float(self.world.is_still(self.world.tables, states[:-1], states[1:]).mean())

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

    @staticmethod
    def from_positions(
        world: str, table: Any, folder: Path | str | None = None, watch: Watch | None = None
    ) -> Script:
        """A script from a table of who was where in which frame (docs/python.md, "Positions").

        >>> script = Script.from_positions("kitchen", "tracked.csv")

        Args:
            world: its name, or the path of its file, looked for in `folder`.
            table: the path of a CSV file with the columns who, frame, x, y and maybe action;
                such columns, of a DataFrame, a record array or a dict; or rows as dicts.

        Raises StoryError, naming the frame and who, where the world does not allow it.
        """
        spec = find_spec(world, None if folder is None else Path(folder))
        if spec is None:
            raise error("no-world", f"there is no world `{shorten(world)}`", whole_file("table"))
        return script_of_positions(spec, table, {}, {}, watch)

    def audience_of(self, viewers: ty.Viewers | None) -> Audience:
        """The audience of some of its observers; without them the one that needs no name."""
        return next((a for a in self.audiences if a.viewers == viewers), self.audiences[0])

    def save(self, path: Path | str) -> Path:
        """Writes the script as JSON, atomically, with what is known of its error."""
        return self.with_error.save(path)

    @property
    def with_error(self) -> Record:
        """The content of its file, with what is known of its error."""
        error = dict(self.record.error)
        if self.trust is not None:
            error["trust"] = self.trust.as_json()
        if self.particles:
            error["particles"] = [asdict(each) for each in self.particles]
        return replace(self.record, error=error)

    def vouched(self, watch: Watch | None = None) -> Script:
        """The script with what is known of its error (docs/approximate.md). Where its world is
        planned exactly and its viewers hold all hypotheses there is nothing to know. Elsewhere it
        is held against plans that are nearer to exact ones, which may take two minutes when they
        are made first, and against viewers who hold other particles, and more.

        Raises StoryError, KeyboardInterrupt.
        """
        if self.trust is not None or not self.length:
            return self
        path = self.shown().trajectory
        found = standard(self.world, self._observers, [path], [self.length], watch or Watch())
        if found is None:  # whatever its file claims
            return replace(self, record=replace(self.record, error={}))
        if found.world is None:
            return replace(self, trust=found.unknown)
        (seen,) = replay_many(found.world, found.paths)
        return self.held_against(found, seen, None)

    def held_against(self, found: Standard, seen: Frame, score: float | None) -> Script:
        """The script with how far its viewers are from others.

        Args:
            seen: what these make of it.
            score: its objective by that.
        """
        spans = tuple(audience.viewers for audience in self.audiences)
        far = apart(self.world.vocabulary, self.assumption, self.frames, seen, spans)
        trust = Trust(found.method, found.told, float(far.max()), score, found.copied)
        return replace(self, trust=trust, nearer=(found, seen))

    @property
    def _observers(self) -> tuple[Observer, ...]:
        """Those of all audiences, ready to watch it."""
        return watching((o for each in self.audiences for o in each.observers), self.length)

    def shown(self) -> Script:
        """The script as viewers see it: with the turns that its story appends, as far as they
        can happen."""
        if not self.appended:
            return self
        path = self.trajectory
        for turn in self.appended:
            state = np.asarray(path.states[-1])
            action, possible = self.world.act(self.world.tables, state, turn)
            if not possible:
                break
            path = extended(self.world, path, [int(action)])
        story, settings = self.record.story, self.record.world["settings"]
        record = make_record(self.world, path, story, settings, self.score)
        record = replace(record, error=self.record.error)
        frames = replay(self.world, path.states, path.actions)
        told = replace(self, record=record, trajectory=path, frames=frames, appended=())
        return replace(told, nearer=None)

    @property
    def particles(self) -> tuple[Effective, ...]:
        """How many particles count, of viewers who hold some hypotheses instead of all."""
        return effective_of(self.audiences, self.frames)

    @property
    def few_particles(self) -> tuple[Diagnostic, ...]:
        """Warnings where few of them count."""
        return tuple(d for d in (each.warning() for each in self.particles) if d is not None)

    def check(self, expression: str, assume: str | None = None) -> TypedQuery:
        """Checks a query; it is also warned where few particles count. Raises StoryError."""
        query = check_query(
            Source("query", expression),
            self.world.vocabulary,
            self.module,
            self.length,
            self.assumption,
            None if assume is None else Source("assume", assume),
            self.audiences,
        )
        if not query.asks_beliefs:
            return query
        return replace(query, warnings=query.warnings + self.few_particles)

    def seen_by(self, audience: str, watch: Watch | None = None) -> Script:
        """The script as other viewers see it: those of `audience` in the place of the story's.
        Audiences of the story that have names keep them, and may be meant by their names.

        >>> script.seen_by("bayesian(given = G_robot = pink)").query("P(rho > 0 | script[:t])")

        Raises StoryError.
        """
        words, source = self.world.vocabulary, Source("audience", audience)
        found = check_audience(source, words, self.module, self.audiences)
        observers = watching((o for each in found for o in each.observers), self.length)
        world = ready_world(self.world.spec, viewers_of(self.world.spec, observers), watch)
        frames = replay(world, self.trajectory.states, self.trajectory.actions)
        seen = replace(self, world=world, frames=frames, audiences=found)
        return replace(seen, record=replace(self.record, error={}), trust=None, nearer=None)

    def query(
        self, expression: str, assume: str | None = None, audience: str | None = None
    ) -> np.ndarray:
        """Asks a question of the audience (language.md, "Queries").

        A number (an array without axes) where the expression has no free t; an array over t
        where it has one; for a bare latent a last axis of the latent's values, in the world's
        order, without the hypotheses in which it plays no part; for several latents an axis each,
        with those hypotheses last.

        >>> script.query("P(rho > 0 | script[:t])")          # [T + 1]
        >>> script.query("P(G_robot | script[:t])")          # [T + 1, values]
        >>> script.query("P(G_robot, rho | script[:t])")     # [T + 1, values + 1, values + 1]
        >>> script.query("next(robot | script[:t])")         # [T + 1, actions]
        >>> script.query("P(R_robot | script[:T])", assume="nothing")
        >>> script.query("P(rho > 0 | script[:t])", audience="bayesian(beta = 1)")

        Raises StoryError.
        """
        return np.asarray(self.ask(expression, assume, audience).value)

    def ask(
        self, expression: str, assume: str | None = None, audience: str | None = None
    ) -> Answer:
        """As `query`, with the frames and the names of the values.

        >>> script.ask("P(G_robot | script[:t])").to_pandas()

        Raises StoryError.
        """
        if audience is not None:
            return self.seen_by(audience).ask(expression, assume)
        query = self.check(expression, assume)
        return replace(self.answer(query), expression=" ".join(expression.split()))

    def evidence(self, assume: str | None = None, audience: str | None = None) -> float:
        """The script's log marginal likelihood, log P(script[:T] | assumption) in nats: the sum of
        log predictive probabilities of all actions (chance and events count nothing), as
        `-sum_t surprise(script[t])` has it. The difference between two audiences is the log of
        their Bayes factor. Of several viewers it is the mean; where bodies move in one step (the
        hill) it is known up to a constant for each frame.

        >>> script.evidence(audience="bayesian(beta = 1)") - script.evidence()

        Raises StoryError.
        """
        return -float(self.query("sum_t surprise(script[t])", assume, audience))

    def answer(self, query: TypedQuery, watch: Watch | None = None) -> Answer:
        """Evaluates a checked query; `watch` is told of what is made to judge the answer."""
        self._check_appended(query)
        with np.errstate(all="ignore"):  # log(0) is an answer: -inf
            found = evaluate(self.world, self.frames, query.value, query.times)
        value = np.asarray(found, dtype=float) + 0.0  # -0 is 0
        judge = partial(self._judged, query, value, watch) if query.asks_beliefs else None
        return replace(answer_of(query, value), judge=judge)

    def _judged(self, query: TypedQuery, value: np.ndarray, watch: Watch | None) -> Trust | None:
        """What is known of the error of an answer."""
        script = self.vouched(watch)
        if script.trust is None or script.nearer is None:
            return script.trust
        found, seen = script.nearer
        if found.world is None or (query.appends and not found.whole):
            return script.trust
        with np.errstate(all="ignore"):
            other = evaluate(found.world, seen, query.value, query.times)
        return replace(script.trust, answer=off_by(value, np.asarray(other, dtype=float)))

    def to_pandas(
        self, *expressions: str, assume: str | None = None, **named: str
    ) -> pandas.DataFrame:
        """Several questions side by side, a row for each frame (tables.py).

        >>> script.to_pandas("P(G_cheese | script[:t])", helps="P(rho > 0 | script[:t])")

        Raises StoryError; ImportError where pandas is not installed.
        """
        from i2pdsl.tables import beliefs_table

        questions = [*((None, e) for e in expressions), *named.items()]
        return beliefs_table([(n, self.ask(e, assume)) for n, e in questions], self.length)

    def frame_table(self) -> pandas.DataFrame:
        """Actions, positions and events, a row for each frame (tables.py).

        Raises ImportError where pandas is not installed.
        """
        from i2pdsl.tables import frame_table

        plain = replace(self, module=Module(Source("table", "")))  # without the story's names
        return frame_table(self.world, self.record, self.length, plain.ask)

    def __repr__(self) -> str:
        name, score = shorten(self.record.title), self.score
        told = f"{name or 'script'}: world {self.world.name}, {self.length} frames"
        return f"<Script {told}{'' if score is None else f', score {score:.4g}'}>"

    def _check_appended(self, query: TypedQuery) -> None:
        """Refuses a question about a turn that cannot follow the script's end."""
        last = self.frames.at(-1)
        for node in ty.walk(query.value):
            if isinstance(node, ty.Moment) and node.turns:
                steps = append_turns(self.world, self.world.tables, node.turns, last)
                for number, (_, possible) in enumerate(steps, self.length + 1):
                    if not possible:
                        message = f"the appended frame {number} cannot happen: its place is taken"
                        raise error("turn", message, whole_file("query"))


def make_record(
    world: World,
    path: Trajectory,
    story: dict[str, Any],
    settings: dict[str, Any],
    score: float | None,
) -> Record:
    """A script file's content from a script in the world's numbers."""
    kind, about = kind_of(world.spec), _about(world.spec, settings)
    start = kind.start_as_json(world, path.start)
    return Record(story, about, score, start, kind.frames_as_json(world, path))


def _about(spec: Spec, settings: dict[str, Any]) -> dict[str, Any]:
    """What a script's file says of its world."""
    about = {"name": spec.name, "source": spec.source or None, "settings": settings}
    drawings = kind_of(spec).drawings(spec)
    return {**about, "drawings": dict(drawings)} if drawings else about


def script_of_positions(
    spec: Spec,
    table: Any,
    about: dict[str, Any],
    settings: dict[str, Any],
    watch: Watch | None = None,
) -> Script:
    """A script of a world, with its settings, from a table of positions. Raises StoryError.

    `about` is what its file says of a story.
    """
    positions, kind = read_positions(table, vocabulary_of(spec)), kind_of(spec)
    told = kind.inferred(kind.rules(spec), positions)
    record = Record(about, _about(spec, settings), None, told.start, told.frames)
    script = script_from(record, None, watch)
    return replace(script, warnings=(*script.warnings, *told.warnings))


def script_of(
    story: TypedStory,
    world: World,
    path: Trajectory,
    frames: Frame,
    about: dict[str, Any],
    score: float | None,
) -> Script:
    """A script of a story from its path, and `frames`, its replay.

    `about` is what its file says of the story.
    """
    record = make_record(world, path, about, dict(story.settings), score)
    turns, windows = appended_turns(story), story_windows(story, len(path.actions))
    return Script(
        record,
        world,
        path,
        story.module,
        story.assumption,
        frames,
        appended=turns,
        windows=windows,
        unmet=unmet(story, world, frames),
        subjects=subjects_of(story),
        audiences=story.audiences,
    )


def script_from(record: Record, folder: Path | None, watch: Watch | None = None) -> Script:
    """A script from the content of its file, held against its world's rules."""
    told = stored(record, folder)
    path = told.read(record)  # before planning, which may take long
    world = ready_world(told.spec, told.viewers, watch)
    told = told.of_length(len(path.actions))
    story = told.story
    frames = replay(world, path.states, path.actions)
    return Script(
        record,
        world,
        path,
        told.module,
        told.assumption,
        frames,
        told.warnings,
        appended_turns(story) if story else (),
        story_windows(story, len(path.actions)) if story else (),
        unmet(story, world, frames) if story else (),
        subjects_of(story) if story else (),
        audiences=told.audiences,
    )
