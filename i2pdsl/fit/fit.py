"""From a table of people's judgements to an audience: `i2p fit`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from pathlib import Path
from typing import Any

import jax
import numpy as np

from i2pdsl.errors import (
    MOST_SHOWN,
    Diagnostic,
    StoryError,
    did_you_mean,
    error,
    first_of,
    whole_file,
)
from i2pdsl.fit.cues import cues
from i2pdsl.fit.judgements import Choice, Judgement
from i2pdsl.fit.model import (
    POSSIBLE,
    RESPONSE,
    USUALLY_VARY,
    VIEWER,
    Asked,
    Cues,
    Latent,
    Model,
    Watching,
)
from i2pdsl.fit.sampling import Draws, Report, alike, draw, modes
from i2pdsl.fit.viewers import Answers, Question, Watched, what_is_seen
from i2pdsl.language import typed as ty
from i2pdsl.language.story import USUAL, check_listed
from i2pdsl.language.vocabulary import Vocabulary, show_value
from i2pdsl.programs import once
from i2pdsl.scripts import Script, script_from
from i2pdsl.worlds.kind import Watch
from i2pdsl.worlds.ready import ready_world
from i2pdsl.worlds.record import read_record
from i2pdsl.worlds.world import Viewer as SpecViewer

Array = Any
Value = float | str
Plan = tuple[tuple[str, Value], ...]
"""How characters plan in a node of the grid: settings of the world with their values."""

MOST_WORSE = 20.0  # nats by which a way of planning may be worse than the best, and still count


@dataclass(frozen=True)
class Study:
    """Judgements, and all that the audience needs to be asked the same.

    Attributes:
        people: their names.
        scripts: those that they saw, by the names in the table.
        questions: the cells: what they were asked about which script, after which frame.
        labels: of each cell the script's name, the question and the frame.
        asked: the rows in arrays.
        scale: what an answer of certainty is in the table.
    """

    judgements: tuple[Judgement, ...]
    people: tuple[str, ...]
    scripts: Mapping[str, Script]
    questions: tuple[Question, ...]
    labels: tuple[tuple[str, str, int], ...]
    asked: Asked
    scale: float

    @property
    def slider_cells(self) -> int:
        """The questions that can lie apart from what viewers would answer: of choices none."""
        return len(self.questions) if (self.asked.options == 0).any() else 0

    @property
    def words(self) -> Vocabulary:
        return next(iter(self.scripts.values())).world.vocabulary

    @property
    def latents(self) -> tuple[Latent, ...]:
        """The latents that questions leave open, but whether somebody is rational."""
        words, masks = self.words, set()
        for question in self.questions:
            masks |= {g.mask for g in ty.walk(question.value) if isinstance(g, ty.Given)}
        possible = [any(column) for column in zip(*masks, strict=True)] if masks else []
        rows = [r for r, p in zip(words.hypotheses, possible, strict=False) if p]
        found = []
        for name in words.latents:
            values = list(dict.fromkeys(row[name] for row in rows if name in row))
            if name in words.rational.values() or len(values) < 2:
                continue
            one_hot = [[float(row.get(name) == v) for v in values] for row in words.hypotheses]
            shown = tuple(show_value(value) for value in values)
            found.append(Latent(name, shown, np.array(one_hot)))
        return tuple(found)


def study(
    judgements: Sequence[Judgement],
    folder: Path,
    scale: float = 1.0,
    choices: Mapping[str, Choice] | None = None,
    watch: Watch | None = None,
    settings: Mapping[str, Value] | None = None,
) -> Study:
    """Reads the scripts of a table and checks its questions.

    Args:
        folder: what paths of scripts are relative to.
        settings: of all worlds, in place of what the scripts' files say.

    Raises StoryError with all mistakes, at the cells that name what is wrong.
    """
    problems: list[Diagnostic] = []
    scripts: dict[str, Script] = {}
    broken: set[str] = set()
    for each in judgements:
        if each.script in scripts or each.script in broken:
            continue
        try:
            path = folder / each.script
            record = read_record(path)
            changed = {**record.world.get("settings", {}), **(settings or {})}
            record = replace(record, world={**record.world, "settings": changed})
            scripts[each.script] = script_from(record, path.parent, watch)
        except StoryError as problem:
            broken.add(each.script)
            first = problem.diagnostics[0]
            message = f"this script cannot be read: {first.message}"
            problems.append(each.wrong("script", message, first.hint))
    problems += _of_other_latents(judgements, scripts)
    cells: dict[tuple[str, str, int], int] = {}
    questions: list[Question] = []
    rows: list[list[int]] = []
    numbers = {name: number for number, name in enumerate(scripts)}
    for each in judgements:
        if each.script not in scripts or len(problems) > MOST_SHOWN:
            continue
        script = scripts[each.script]
        choice = (choices or {}).get(each.question)
        texts = list(choice.options.values()) if choice else [each.question]
        frame = script.length if each.frame is None else each.frame
        if frame > script.length:
            message = f"the script has {script.length} frames"
            problems.append(each.wrong("frame", message))
            continue
        row = []
        for text in texts:
            key = (each.script, text, frame)
            if key not in cells:
                try:
                    question = _question(script, text, numbers[each.script], frame)
                except StoryError as problem:
                    first = problem.diagnostics[0]
                    problems.append(each.wrong("question", first.message, first.hint))
                    break
                cells[key] = len(questions)
                questions.append(question)
            row.append(cells[key])
        rows.append(row)
    if problems:
        raise StoryError(first_of(list({(d.message, d.span): d for d in problems}.values())))
    people = tuple(dict.fromkeys(each.participant for each in judgements))
    return Study(
        tuple(judgements),
        people,
        scripts,
        tuple(questions),
        tuple(cells),
        _in_arrays(judgements, people, rows, choices or {}),
        scale,
    )


def _of_other_latents(
    judgements: Sequence[Judgement], scripts: Mapping[str, Script]
) -> list[Diagnostic]:
    """Scripts whose hypotheses are not those of the first: one prior cannot serve both."""
    if not scripts:
        return []
    first, *others = scripts
    rows = scripts[first].world.vocabulary.hypotheses
    differ = {n for n in others if scripts[n].world.vocabulary.hypotheses != rows}
    return [
        each.wrong("script", f"its world has other latents than that of `{first}`")
        for each in {e.script: e for e in judgements if e.script in differ}.values()
    ]


def _question(script: Script, text: str, number: int, frame: int) -> Question:
    query = replace(script, audiences=(USUAL,)).check(text)
    if isinstance(query.value, ty.Belief) and query.value.labels:
        message = "people answer with a number, and this is a distribution"
        raise error("question", message, whole_file("query"), "ask for one event: `P(... | ...)`")
    if query.times is not None and frame not in query.times:
        message = f"this cannot be asked after frame {frame}"
        raise error("question", message, whole_file("query"))
    fixed = [n for n in ty.walk(query.value) if isinstance(n, ty.Moment) and n.first is None]
    looks_ahead = any(max(moment.frames) > frame for moment in fixed)
    if frame < script.length and (query.times is None or looks_ahead):
        message = f"this looks at frames that nobody has seen after frame {frame}"
        hint = "ask about `script[:t]`, or after the last frame, `T`"
        raise error("question", message, whole_file("query"), hint)
    return Question(number, query.value, query.times, frame)


def _in_arrays(
    judgements: Sequence[Judgement],
    people: tuple[str, ...],
    rows: list[list[int]],
    choices: Mapping[str, Choice],
) -> Asked:
    who = {name: number for number, name in enumerate(people)}
    most = max(map(len, rows))
    options, answers = [], []
    for each in judgements:
        choice = choices.get(each.question)
        if choice is None:
            options.append(0)
            answers.append(float(each.answer))
        else:
            options.append(len(choice.options))
            answers.append(float(list(choice.options).index(str(each.answer))))
    return Asked(
        np.array([who[each.participant] for each in judgements]),
        np.array([row + row[:1] * (most - len(row)) for row in rows]),
        np.array(options),
        np.array(answers),
    )


@dataclass(frozen=True)
class Fitted:
    """What people's judgements say of them.

    Attributes:
        plans: the ways of planning that were considered.
        nodes: what is seen under each of them (viewers.Seen, stacked).
    """

    study: Study
    model: Model
    plans: tuple[Plan, ...]
    nodes: Any = field(repr=False)
    draws: Draws = field(repr=False)


def seen_under(study: Study, plan: Plan, watch: Watch | None = None) -> tuple[list[Watched], Any]:
    """The scripts as viewers see them who think that characters plan in this way."""
    watched = []
    check_listed(study.words, "a fit")
    for script in study.scripts.values():
        spec = script.world.spec.with_settings(dict(plan))
        watched.append(Watched(ready_world(spec, (SpecViewer(spec),), watch), script.trajectory))
    return watched, what_is_seen(watched)


def settings_of(
    study: Study, fixed: Mapping[str, Value], grid: Mapping[str, Sequence[float]]
) -> tuple[dict[str, float], dict[str, Value], dict[str, Value]]:
    """Of what is given, the parameters of the model, the settings of the world as viewers believe
    it works, and those that change what can be believed, for `study`.

    Raises StoryError where a world has no such setting, or none with such a value.
    """
    parameters: dict[str, float] = {}
    settings: dict[str, Value] = {}
    reshaping: dict[str, Value] = {}
    known = study.words.settings
    given: list[tuple[str, Sequence[Value]]] = [*((n, [v]) for n, v in fixed.items())]
    for name, values in [*given, *grid.items()]:
        if (name in VIEWER or name in RESPONSE) and name not in grid:
            (value,) = values
            low, high = POSSIBLE[name]
            if isinstance(value, str) or not low <= value <= high:
                message = (
                    f"`{name}` cannot be {show_value(value)}: it is between {low:g} and {high:g}"
                )
                raise error("setting", message, whole_file("fit"))
            parameters[name] = value
            continue
        if name not in known or (name in grid and known[name].reshapes):
            message = f"there is no parameter, and no setting of the world, called `{name}`"
            hint = did_you_mean(name, {*known, *VIEWER, *RESPONSE})
            if name in known:
                message = (
                    f"`{name}` changes what can be believed, so its values have no common grid"
                )
                hint = f"compare them: `--against {name}={show_value(values[-1])}`"
            raise error("setting", message, whole_file("fit"), hint)
        for value in values:
            if not known[name].holds(value):
                message = f"`{name}` cannot be {show_value(value)}: it is {known[name].possible}"
                raise error("setting", message, whole_file("fit"))
        if name not in grid:
            (reshaping if known[name].reshapes else settings)[name] = values[0]
    return parameters, settings, reshaping


def fit(
    study: Study,
    grid: Mapping[str, Sequence[float]] | None = None,
    fixed: Mapping[str, float] | None = None,
    settings: Mapping[str, Value] | None = None,
    varies: tuple[str, ...] | None = None,
    chains: int = 4,
    warmup: int = 400,
    draws: int = 400,
    seed: int = 0,
    watch: Watch | None = None,
    report: Report | None = None,
) -> Fitted:
    """Fits an audience to judgements. Call it while JAX may compute (computing.py).

    Args:
        grid: settings of how characters plan, each with the values that are tried; all
            combinations are planned, and which of them holds is summed out.
        fixed: parameters that are not fitted, by their names in model.py.
        settings: of the world as viewers believe it works.
        varies: the parameters in which people differ, if not in those of model.USUALLY_VARY.

    Raises KeyboardInterrupt before there is anything to tell.
    """
    base = tuple((settings or {}).items())
    plans = [
        (*base, *zip(grid or (), each, strict=True)) for each in product(*(grid or {}).values())
    ]
    watched, seen = [], []
    for plan in plans:
        those, what = seen_under(study, plan, watch)
        watched.append(those)
        seen.append(what)
    seen = _with_one_chain(seen)
    first = watched[0]
    answers = Answers(first, study.questions)
    log_prior = first[0].world.log_prior(first[0].world.tables)[0]
    given = dict(fixed or {})
    own = {name: given.pop(name) for name in list(given) if name in VIEWER}
    watching = Watching(answers, study.latents, np.asarray(log_prior), own)
    own_ones = USUALLY_VARY if varies is None else varies
    model = Model(watching, len(study.people), given, own_ones, cells=study.slider_cells)
    nodes = jax.tree.map(lambda *parts: np.stack(parts), *seen)
    if len(plans) > 1:
        kept = _plausible(model, nodes, study.asked)
        plans, nodes = [plans[i] for i in kept], jax.tree.map(lambda part: part[kept], nodes)
        model = replace(model, plans=len(plans))
    found = draw(model, nodes, study.asked, chains, warmup, draws, seed, report)
    return Fitted(study, model, tuple(plans), nodes, found)


def _with_one_chain(seen: list[Any]) -> list[Any]:
    """What is seen under several plans, if some of them have goals that change: under the others
    they never do."""
    some = next((each.switching for each in seen if each.switching), ())
    never = tuple(each._replace(share=0 * each.share) for each in some)
    return [each._replace(switching=each.switching or never) for each in seen]


def fit_cues(
    study: Study,
    expressions: Sequence[str],
    chains: int = 4,
    warmup: int = 400,
    draws: int = 400,
    seed: int = 0,
    report: Report | None = None,
) -> Fitted:
    """Fits what can be counted in a film (cues.py) to the same judgements, as a baseline."""
    answering = {"slope": 1.0, "bias": 0.0}  # weights do the same
    model = Model(
        Cues(tuple(expressions)), len(study.people), answering, cells=len(study.questions)
    )
    nodes = cues(study.scripts, study.questions, expressions)[None]
    found = draw(model, nodes, study.asked, chains, warmup, draws, seed, report)
    return Fitted(study, model, ((),), nodes, found)


def _plausible(model: Model, nodes: Any, asked: Asked) -> list[int]:
    """The ways of planning that explain the answers about as well as the best does, or, where
    people differ in them, the answers of somebody: to sum over the others costs time for nothing.
    """
    count = len(jax.tree.leaves(nodes)[0])
    each = jax.tree.map(lambda part: part[:, None], nodes)
    every = np.ones(len(asked.answer))
    points = modes(model, each, asked, np.tile(every, (count, 1)))
    group, groups = replace(model, plans=count).groups(asked)
    row = lambda fit: model.log_likelihoods(alike(model, fit[0]), fit[1], asked)
    rows = np.asarray(once(lambda fits: jax.lax.map(row, fits), (points, nodes)))
    totals = np.array([np.bincount(group, row, groups) for row in rows])  # [N, G]
    if groups == 1:
        return list(np.flatnonzero(totals[:, 0] > totals.max() - MOST_WORSE))
    explained = np.exp(totals - totals.max(0))
    explained /= explained.sum(0)
    return list(np.flatnonzero(explained.sum(1) > 0.5))
