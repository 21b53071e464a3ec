"""What a table of judgements asks: its scripts, its questions and its answers in arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from i2pdsl.errors import MOST_SHOWN, Diagnostic, StoryError, error, first_of, whole_file
from i2pdsl.fit.judgements import FIRST, Choice, Judgement, Named, Pair
from i2pdsl.fit.model import PAIR, Asked, Latent
from i2pdsl.fit.viewers import Question
from i2pdsl.language import typed as ty
from i2pdsl.language.query import TypedQuery
from i2pdsl.language.story import USUAL
from i2pdsl.language.vocabulary import Vocabulary, show_value
from i2pdsl.scripts import Script, script_from
from i2pdsl.worlds.kind import Watch
from i2pdsl.worlds.record import read_record

Value = float | str


@dataclass(frozen=True)
class Study:
    """Judgements, and all that the audience needs to be asked the same.

    Attributes:
        people: their names.
        scripts: those that they saw, by the names in the table.
        questions: the cells: what they were asked about which script, after which frame.
        labels: of each cell the script's name, the question and the frame.
        named: what is meant by the names that questions have in the table.
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
    named: Named

    @property
    def deviating(self) -> int:
        """The questions that can lie apart from what viewers would answer: of choices none."""
        return len(self.questions) if (self.asked.options <= 0).any() else 0

    @property
    def unused(self) -> dict[str, float]:
        """The parameters of answers that no answer depends on, with a value that they may have."""
        return {} if (self.asked.options == 0).any() else {"noise": 1.0, "bias": 0.0}

    def labels_of(self, asked: Judgement) -> tuple[str, ...]:
        """The labels among which an answer chose; none if it did not."""
        choice = self.named.get(asked.question)
        return tuple(choice.options) if isinstance(choice, Choice) else ()

    @cached_property
    def alike(self) -> tuple[np.ndarray, ...]:
        """The rows that were asked the same, by everything that was asked."""
        found: dict[tuple[int, ...], list[int]] = {}
        for row, asked in enumerate(np.column_stack([self.asked.options, self.asked.cell])):
            found.setdefault(tuple(asked), []).append(row)
        return tuple(np.array(rows) for rows in found.values())

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
    named: Named | None = None,
    watch: Watch | None = None,
    settings: Mapping[str, Value] | None = None,
    assume: str | None = None,
) -> Study:
    """Reads the scripts of a table and checks its questions.

    Args:
        folder: what paths of scripts are relative to.
        named: what is meant by the names that questions have in the table.
        settings: of all worlds, in place of what the scripts' files say.
        assume: what every belief is conditioned on, in place of what the scripts' stories say.

    Raises StoryError with all mistakes, at the cells that name what is wrong.
    """
    reader = _Reader(named or {}, settings or {}, assume, watch)
    for each in judgements:
        for column, name in each.scripts:
            reader.read(each, column, folder / name)
    reader.problems += _of_other_latents(judgements, reader.scripts)
    if assume is not None and reader.scripts:
        next(iter(reader.scripts.values())).check("T", assume)  # told once, at its own place
    rows = [reader.row(each) for each in judgements]
    if reader.problems:
        told = {(d.message, d.span): d for d in reader.problems}
        raise StoryError(first_of(list(told.values())))
    people = tuple(dict.fromkeys(each.participant for each in judgements))
    return Study(
        tuple(judgements),
        people,
        reader.scripts,
        tuple(reader.questions),
        tuple(reader.cells),
        _in_arrays(judgements, people, rows, named or {}),
        scale,
        named or {},
    )


@dataclass
class _Reader:
    """Reads what judgements are about; collects what is wrong with them."""

    named: Named
    settings: Mapping[str, Value]
    assume: str | None
    watch: Watch | None
    scripts: dict[str, Script] = field(default_factory=dict)
    numbers: dict[str, int] = field(default_factory=dict)
    broken: set[str] = field(default_factory=set)
    cells: dict[tuple[str, str, int], int] = field(default_factory=dict)
    questions: list[Question] = field(default_factory=list)
    problems: list[Diagnostic] = field(default_factory=list)

    def read(self, asked: Judgement, column: str, path: Path) -> None:
        """The script that stands in a column."""
        name = dict(asked.scripts)[column]
        if name in self.scripts or name in self.broken:
            return
        try:
            record = read_record(path)
            changed = {**record.world.get("settings", {}), **self.settings}
            record = replace(record, world={**record.world, "settings": changed})
            self.scripts[name] = script_from(record, path.parent, self.watch)
            self.numbers[name] = len(self.numbers)
        except StoryError as problem:
            self.broken.add(name)
            first = problem.diagnostics[0]
            message = f"this script cannot be read: {first.message}"
            self.problems.append(asked.wrong(column, message, first.hint))

    def row(self, asked: Judgement) -> list[int]:
        """The cells of an answer; none where something is wrong."""
        names = [name for _, name in asked.scripts]
        if any(name not in self.scripts for name in names) or len(self.problems) > MOST_SHOWN:
            return []
        match self.named.get(asked.question):
            case Choice(options):
                texts = list(options.values())
            case Pair(value):
                texts = [value]
            case None:
                texts = [asked.question]
        found = []
        for name in names:
            script = self.scripts[name]
            frame = script.length if asked.frame is None else asked.frame
            if frame > script.length:
                message = f"the script has {script.length} frames"
                self.problems.append(asked.wrong("frame", message))
                return []
            try:
                found += [self.cell(name, text, frame) for text in texts]
            except StoryError as problem:
                first = problem.diagnostics[0]
                self.problems.append(asked.wrong("question", first.message, first.hint))
                return []
        return found

    def cell(self, name: str, text: str, frame: int) -> int:
        """The number of a question about a script. Raises StoryError."""
        key = name, text, frame
        if key not in self.cells:
            script = replace(self.scripts[name], audiences=(USUAL,))
            question = _question(
                script.check(text, self.assume), self.numbers[name], frame, script.length
            )
            self.cells[key] = len(self.questions)
            self.questions.append(question)
        return self.cells[key]


def _of_other_latents(
    judgements: Sequence[Judgement], scripts: Mapping[str, Script]
) -> list[Diagnostic]:
    """Scripts whose hypotheses are not those of the first: one prior cannot serve both."""
    if not scripts:
        return []
    first, *others = scripts
    rows = scripts[first].world.vocabulary.hypotheses
    differ = {n for n in others if scripts[n].world.vocabulary.hypotheses != rows}
    told = {
        name: each.wrong(column, f"its world has other latents than that of `{first}`")
        for each in judgements
        for column, name in each.scripts
        if name in differ
    }
    return list(told.values())


def _question(query: TypedQuery, number: int, frame: int, length: int) -> Question:
    if isinstance(query.value, ty.Belief) and query.value.labels:
        message = "people answer with a number, and this is a distribution"
        raise error("question", message, whole_file("query"), "ask for one event: `P(... | ...)`")
    if query.times is not None and frame not in query.times:
        message = f"this cannot be asked after frame {frame}"
        raise error("question", message, whole_file("query"))
    fixed = [n for n in ty.walk(query.value) if isinstance(n, ty.Moment) and n.first is None]
    looks_ahead = any(max(moment.frames) > frame for moment in fixed)
    if frame < length and (query.times is None or looks_ahead):
        message = f"this looks at frames that nobody has seen after frame {frame}"
        hint = "ask about `script[:t]`, or after the last frame, `T`"
        raise error("question", message, whole_file("query"), hint)
    return Question(number, query.value, query.times, frame)


def _in_arrays(
    judgements: Sequence[Judgement],
    people: tuple[str, ...],
    rows: list[list[int]],
    named: Named,
) -> Asked:
    who = {name: number for number, name in enumerate(people)}
    most = max(map(len, rows))
    options, answers, cells = [], [], []
    for each, row in zip(judgements, rows, strict=True):
        choice = named.get(each.question)
        if each.other is not None:
            # Which of two films stood first does not matter: they are told in one order.
            turned = row[0] > row[1]
            options.append(PAIR)
            answers.append(float((each.answer == FIRST) != turned))
            row = row[::-1] if turned else row
        elif isinstance(choice, Choice):
            options.append(len(choice.options))
            answers.append(float(list(choice.options).index(str(each.answer))))
        else:
            options.append(0)
            answers.append(float(each.answer))
        cells.append(row + row[:1] * (most - len(row)))
    return Asked(
        np.array([who[each.participant] for each in judgements]),
        np.array(cells),
        np.array(options),
        np.array(answers),
    )
