"""Many scripts, questions and audiences at once, answered as one table.

Scripts of one story's world and of one length are a group: their world is made ready once for each
audience, each question is checked once, and all of them are replayed side by side.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import compress, product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from i2pdsl.answers import optional
from i2pdsl.audience.holding import way_of
from i2pdsl.errors import Diagnostic, Source, StoryError
from i2pdsl.folders import script_files
from i2pdsl.language import typed as ty
from i2pdsl.language.addends import addends
from i2pdsl.language.check import TypedQuery, check_query
from i2pdsl.language.forms import BY_NAME
from i2pdsl.language.query import check_audience
from i2pdsl.language.scope import Module
from i2pdsl.language.story import Audience, Observer, watching
from i2pdsl.language.vocabulary import UNKNOWN
from i2pdsl.objective.frame import Frame
from i2pdsl.objective.looks import looks_within
from i2pdsl.objective.many import evaluate_many
from i2pdsl.objective.nearer import standard
from i2pdsl.objective.replay import replay_all
from i2pdsl.objective.trust import Trust, apart, off_by
from i2pdsl.scripts import Script
from i2pdsl.stored import Stored, stored
from i2pdsl.worlds.find import vocabulary_of
from i2pdsl.worlds.kind import Spec, Watch
from i2pdsl.worlds.ready import ready_world, viewers_of
from i2pdsl.worlds.record import Record, Trajectory, parse_record, read_record
from i2pdsl.worlds.world import World

if TYPE_CHECKING:
    import pandas

Askable = Script | Record | str | Path | Mapping[str, Any]
NO_FRAME = -1  # the t of what is asked of no single frame
COLUMNS = np.dtype(
    [
        ("script", object),
        ("question", object),
        ("audience", object),
        ("t", np.int64),
        ("event", object),
        ("value", float),
    ]
)
AT_ONCE = 4096  # frames that are replayed side by side: more is not faster, and takes memory
NUMBERS_AT_ONCE = 1 << 22  # at which a question looks there, where hypotheses are not listed


class Table(np.recarray):
    """A row for each number that was asked for: `table.value`, `table[table.t == 3]`.

    Attributes:
        script: the path as it was given, its name in a mapping, or its number from 0 on.
        question: as it was written, or its name in a mapping.
        audience: as it was written, or its name in a mapping; empty for the story's own.
        t: the frame; -1 where the question has no free t.
        event: of a bare latent the value that the number is the probability of, `G_robot = pink`
            (of several latents `G_robot = pink, rho = 1`, of `next` an action); else empty.
        value: the number; NaN where a turn that the question appends cannot happen.
        warnings: about scripts whose stories are not understood.
    """

    warnings: tuple[Diagnostic, ...] = ()
    _judges: tuple[Callable[[], Trust | None], ...] = ()

    def trust(self) -> tuple[Trust, ...]:
        """What is known of the error of the numbers, where a world is planned approximately or
        viewers hold particles: of the scripts of each world and length, before each audience. It
        is found now (`Script.vouched`), by asking all of it once more."""
        return tuple(t for t in (judge() for judge in self._judges) if t is not None)

    def to_pandas(self) -> pandas.DataFrame:
        """A DataFrame of the same columns, with no t rather than -1.

        Raises ImportError where pandas is not installed.
        """
        pd = optional("pandas")
        columns = {name: pd.array(self[name], dtype="string") for name in ("script", "question")}
        columns["audience"] = pd.array(self["audience"], dtype="string")
        columns["t"] = pd.array(self["t"], dtype="Int64")
        columns["t"][self["t"] == NO_FRAME] = pd.NA
        columns["event"] = pd.array(self["event"], dtype="string")
        return pd.DataFrame({**columns, "value": np.array(self["value"])})


def query(
    scripts: Askable | Iterable[Askable] | Mapping[str, Askable],
    questions: str | Sequence[str] | Mapping[str, str],
    audiences: str | Sequence[str | None] | Mapping[str, str] | None = None,
    assume: str | None = None,
    watch: Watch | None = None,
) -> Table:
    """Asks many scripts many questions before many audiences, at once.

    Rows stand in the order of scripts, then audiences, questions, frames, events.

    >>> i2pdsl.query(["a.json", "b.json"], "P(rho > 0 | script[:t])")
    >>> i2pdsl.query(scripts, {"helps": "P(rho > 0 | script[:T])"}, [None, "bayesian(beta = 1)"])

    Args:
        scripts: scripts, paths of their files or of folders that hold some, or their content (a
            Record, or the JSON document as a dict); or a mapping that gives them names.
        questions: expressions of the language; or a mapping that gives them names.
        audiences: as behind `audience` in a story; None is the story's own, which is asked where
            nothing is given; or a mapping that gives them names.
        assume: another assumption for all of them; 'nothing' drops it.

    Raises StoryError with the mistakes of all scripts, or the first of a question or an audience.
    """
    groups = _groups(_named_scripts(scripts))
    asked = _named(questions)
    viewers = _named([None] if audiences is None else audiences)
    found = [_answer(group, asked, viewers, assume, watch) for group in groups]
    rows = np.concatenate([part for part, *_ in found]) if found else np.zeros(0, COLUMNS)
    order = np.concatenate([numbers for _, numbers, _ in found]) if found else np.zeros(0, int)
    if len(found) > 1:
        rows = rows[np.argsort(order, kind="stable")]
    table = rows.view(np.recarray).view(Table)
    table._judges = tuple(judge for _, _, each in found for judge in each)
    table.warnings = tuple(dict.fromkeys(d for group in groups for d in group.ground.warnings))
    return table


def _named(given: Any) -> dict[str, Any]:
    """Questions or audiences by their names."""
    if isinstance(given, Mapping):
        return dict(given)
    given = [given] if isinstance(given, str) else list(given)
    return {"" if text is None else " ".join(text.split()): text for text in given}


def _named_scripts(scripts: Any) -> list[tuple[str, Askable]]:
    if isinstance(scripts, Mapping) and "frames" not in scripts:
        return [(str(name), script) for name, script in scripts.items()]
    if isinstance(scripts, Script | Record | str | Path | Mapping):
        scripts = [scripts]
    found: list[tuple[str, Askable]] = []
    for number, script in enumerate(scripts):
        if isinstance(script, str | Path):
            found += [(str(path), path) for path in script_files(str(script))]
        else:
            found.append((str(number), script))
    return found


@dataclass(frozen=True)
class _Ground:
    """What the scripts of a group have in common: their world, what questions about them may name,
    what beliefs are conditioned on, and who watches."""

    spec: Spec
    module: Module
    assumption: ty.Mask
    audiences: tuple[Audience, ...]
    warnings: tuple[Diagnostic, ...]

    @staticmethod
    def of(told: Script | Stored, spec: Spec) -> _Ground:
        return _Ground(spec, told.module, told.assumption, told.audiences, told.warnings)

    def seen_by(self, audience: str | None) -> _Ground:
        """The same before another audience; None is the story's own. Raises StoryError."""
        if audience is None:
            return self
        source, words = Source("audience", audience), vocabulary_of(self.spec)
        found = check_audience(source, words, self.module, self.audiences)
        return replace(self, audiences=found)

    def observers(self, length: int) -> tuple[Observer, ...]:
        return watching((o for each in self.audiences for o in each.observers), length)

    def world(self, length: int, watch: Watch | None) -> World:
        return ready_world(self.spec, viewers_of(self.spec, self.observers(length)), watch)


@dataclass
class _Group:
    """Scripts of one story, world and length.

    Attributes:
        names, numbers, paths: of each.
    """

    ground: _Ground
    names: list[str] = field(default_factory=list)
    numbers: list[int] = field(default_factory=list)
    paths: list[Trajectory] = field(default_factory=list)

    @property
    def length(self) -> int:
        return len(self.paths[0].actions)


class _Reader:
    """Reads scripts; the worlds and stories in their files once each."""

    def __init__(self) -> None:
        self.known: dict[Any, Stored] = {}
        self.groups: dict[tuple[int, int], _Group] = {}
        self.numbers: dict[Any, int] = {}  # of worlds with stories
        self.told: dict[tuple[int, ...], tuple[int, Script]] = {}

    def add(self, number: int, name: str, script: Askable) -> None:
        """Puts a script into its group. Raises StoryError."""
        if isinstance(script, Script):
            path, own = script.trajectory, self.number_of(script)
            make = lambda: _Ground.of(script, script.world.spec)
        else:
            record, folder = _record(script), None
            if isinstance(script, str | Path):
                folder = Path(script).parent
            key = _key(record, folder)
            if key not in self.known:
                self.known[key] = stored(record, folder)
            told, own = self.known[key], self.numbers.setdefault(key, len(self.numbers))
            path = told.read(record)
            make = lambda: _Ground.of(told.of_length(len(path.actions)), told.spec)
        place = own, len(path.actions)
        if place not in self.groups:
            self.groups[place] = _Group(make())
        group = self.groups[place]
        group.names.append(name)
        group.numbers.append(number)
        group.paths.append(path)

    def number_of(self, script: Script) -> int:
        """That of a script's world and story."""
        same = tuple(map(id, (script.world, script.module, script.assumption, script.audiences)))
        if same not in self.told:
            key = (_key(script.record, None), script.assumption, script.audiences)
            number = self.numbers.setdefault(key, len(self.numbers))
            self.told[same] = number, script  # which is kept, so that the ids stay its own
        return self.told[same][0]


def _key(record: Record, folder: Path | None) -> tuple[Any, ...]:
    """What a script's world and story depend on."""
    return json.dumps(record.world), record.text, str(record.story.get("file")), folder


def _record(script: Record | str | Path | Mapping[str, Any]) -> Record:
    if isinstance(script, Record):
        return script
    if isinstance(script, str | Path):
        return read_record(script)
    return parse_record(Source("script", json.dumps(script)))


def _groups(scripts: Sequence[tuple[str, Askable]]) -> list[_Group]:
    """The scripts, read. Raises StoryError with the mistakes of all of them."""
    reader = _Reader()
    problems: list[Diagnostic] = []
    for number, (name, script) in enumerate(scripts):
        try:
            reader.add(number, name, script)
        except StoryError as problem:
            problems.extend(problem.diagnostics)
    if problems:
        raise StoryError(problems)
    return list(reader.groups.values())


def _answer(
    group: _Group,
    questions: dict[str, str],
    audiences: dict[str, str | None],
    assume: str | None,
    watch: Watch | None,
) -> tuple[np.ndarray, np.ndarray, list[Callable[[], Trust | None]]]:
    """The rows of a group's scripts, the number of the script of each, and what finds out how
    wrong they are before each audience."""
    heads, parts = [], []
    judges: list[Callable[[], Trust | None]] = []
    for audience, text in audiences.items():
        ground = group.ground.seen_by(text)
        world = ground.world(group.length, watch)
        checked = [_checked(ground, world, q, group.length, assume) for q in questions.values()]
        values = _values(world, group.paths, checked)
        judges.append(partial(_judged, world, ground, group.paths, checked, values, watch))
        for question, query, value in zip(questions, checked, values, strict=True):
            head, value = _rows(query, value)
            head["question"], head["audience"] = question, audience
            heads.append(head)
            parts.append(value)
    head, count = np.concatenate(heads), len(group.paths)
    rows = np.tile(head, count)
    rows["script"] = np.repeat(np.array(group.names, dtype=object), len(head))
    rows["value"] = np.concatenate(parts, axis=1).reshape(-1)
    return rows, np.repeat(group.numbers, len(head)), judges


def _judged(
    world: World,
    ground: _Ground,
    paths: Sequence[Trajectory],
    queries: Sequence[TypedQuery],
    values: Sequence[np.ndarray],
    watch: Watch | None,
) -> Trust | None:
    """What is known of the error of answers about scripts of one world and length."""
    asked = [(q, v) for q, v in zip(queries, values, strict=True) if q.asks_beliefs]
    lengths = [len(path.actions) for path in paths]
    if not asked or not lengths[0]:
        return None
    found = standard(world, ground.observers(lengths[0]), paths, lengths, watch or Watch())
    if found is None:
        return None
    if found.world is None:
        return found.unknown
    spans = tuple(audience.viewers for audience in ground.audiences)
    told = [(q, v) for q, v in asked if found.whole or not q.appends]
    far, off = 0.0, [0.0] * len(told)
    first = 0
    count = min(_together(each, queries) for each in (world, found.world))
    for one, other in zip(_pieces(paths, count), _pieces(found.paths, count), strict=True):
        ours, theirs = _replayed(world, one), _replayed(found.world, other)
        far = max(far, float(apart(world.vocabulary, ground.assumption, ours, theirs, spans).max()))
        for number, (query, value) in enumerate(told):
            again = evaluate_many(found.world, theirs, query.value, query.times)
            off[number] = max(off[number], off_by(value[first : first + len(one)], again))
        first += len(one)
    return Trust(found.method, found.told, far, None, found.copied, max(off, default=None))


def _checked(
    ground: _Ground, world: World, expression: str, length: int, assume: str | None
) -> TypedQuery:
    return check_query(
        Source("query", expression),
        world.vocabulary,
        ground.module,
        length,
        ground.assumption,
        None if assume is None else Source("assume", assume),
        ground.audiences,
    )


def _values(
    world: World, paths: Sequence[Trajectory], queries: Sequence[TypedQuery]
) -> list[np.ndarray]:
    """The value of each question over all paths, [N], [N, n_t], [N, V] or [N, n_t, V]."""
    found: list[list[np.ndarray]] = []
    within = any(looks_within(query.value) for query in queries)
    for piece in _pieces(paths, _together(world, queries)):
        frames = _replayed(world, piece, within)
        found.append([evaluate_many(world, frames, q.value, q.times) for q in queries])
    return [np.concatenate(parts) for parts in zip(*found, strict=True)]


def _together(world: World, queries: Sequence[TypedQuery]) -> int:
    """How many frames are replayed, and asked about, side by side."""
    every = [
        part
        for query in queries
        for node in ty.walk(query.value)
        if isinstance(node, ty.Belief) and BY_NAME[node.form].about == "quantity"
        for part in addends(node.about)
    ]
    held = [each for each in world.holdings(world.tables) if each is not None]
    asked = (way_of(each).asked(each, part) for each in held for part in (*every, ()))
    return min(AT_ONCE, NUMBERS_AT_ONCE // max(asked, default=1))


def _pieces(paths: Sequence[Trajectory], count: int) -> list[Sequence[Trajectory]]:
    """Paths of one length, at a time as many as have so many frames."""
    size = max(1, count // len(paths[0].states))
    return [paths[first : first + size] for first in range(0, len(paths), size)]


def _replayed(world: World, paths: Sequence[Trajectory], within: bool = True) -> Frame:
    states, actions = np.stack([p.states for p in paths]), np.stack([p.actions for p in paths])
    return replay_all(world, states, actions, regret=False, within=within)


def _rows(query: TypedQuery, value: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The rows of one script, all but its values, and the values of each, [N, rows]."""
    axes = query.value.labels if isinstance(query.value, ty.Belief) else ()
    events = [""]
    if axes:
        names = [tuple(f"{axis.name} = {v}" for v in axis.values) for axis in axes]
        events = [", ".join(event) for event in product(*names)]
        known = [all(v != UNKNOWN for v in values) for values in product(*(a.values for a in axes))]
        # What plays no part is told only where there are hypotheses in which it plays none.
        told = np.array(known) | (value > 0).any(tuple(range(value.ndim - 1)))
        events, value = list(compress(events, told)), value[..., told]
    times = [NO_FRAME] if query.times is None else list(query.times)
    head = np.zeros(len(times) * len(events), COLUMNS)
    head["t"] = np.repeat(times, len(events))
    head["event"] = events * len(times)
    return head, value.reshape(len(value), -1)
