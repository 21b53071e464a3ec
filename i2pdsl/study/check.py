"""The stories of a study and what it asks about them: names get a meaning, nothing is solved."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

from i2pdsl.errors import Diagnostic, Source, Span, StoryError, did_you_mean, error, first_of
from i2pdsl.language import typed as ty
from i2pdsl.language.people import read_people
from i2pdsl.language.query import check_assumption, check_query
from i2pdsl.language.scope import Module
from i2pdsl.language.statements import read_source
from i2pdsl.language.story import Audience
from i2pdsl.language.vocabulary import Vocabulary
from i2pdsl.stored import stored
from i2pdsl.stories import Story, story_from
from i2pdsl.study.spec import Condition, Method, OneOf, Panel, Study
from i2pdsl.worlds.find import vocabulary_of
from i2pdsl.worlds.kind import Spec
from i2pdsl.worlds.record import read_record


@dataclass(frozen=True)
class Ground:
    """What the films of a condition by a method have in common.

    Attributes:
        story: what is solved; None where scripts are given.
        scripts: the given ones, in order.
        masks: of each answer's event (of the question's alone, where it has one), [H], and
            `assumed` what beliefs are conditioned on.
        module, audiences: what questions may name.
        length: how many frames they have.
    """

    spec: Spec
    story: Story | None
    scripts: tuple[Path, ...]
    masks: tuple[ty.Mask, ...]
    assumed: ty.Mask
    module: Module
    audiences: tuple[Audience, ...]
    length: int

    @property
    def vocabulary(self) -> Vocabulary:
        return vocabulary_of(self.spec)

    def asked(self, question: str, frame: int | None) -> object:
        """What an expression asks after so many frames of a film, or after all of them: two that
        ask the same are equal. Raises StoryError."""
        query = check_query(
            Source("question", question),
            self.vocabulary,
            self.module,
            self.length,
            self.assumed,
            audiences=self.audiences,
        )
        return _after(query.value, self.length if frame is None else frame)


def _after(node: Any, frame: int) -> Any:
    """An expression with a number in the place of a free t."""
    match node:
        case ty.Reduction() | ty.Beats():  # whose t is their own
            return node
        case ty.Moment(first=int(first), frames=frames):
            own = tuple(frames[frame - first : frame - first + 1])
            return replace(node, frames=own, first=None)
        case tuple():
            return tuple(_after(part, frame) for part in node)
        case _ if hasattr(node, "axes"):
            parts = {each.name: _after(getattr(node, each.name), frame) for each in fields(node)}
            return replace(node, **parts)
    return node


def check_study(study: Study) -> dict[tuple[str, str], Ground]:
    """What a study is about, by condition and method. Raises StoryError with all mistakes."""
    problems: list[Diagnostic] = []
    found = {}
    for condition in study.conditions:
        for method in study.methods:
            try:
                found[condition.name, method.name] = _ground(study, condition, method)
            except StoryError as problem:
                problems += problem.diagnostics
    for panel in study.panels:
        for ground in found.values():
            problems += _of_panel(panel, ground.vocabulary)
    if problems:
        raise StoryError(first_of(list(dict.fromkeys(problems))))
    return found


def _ground(study: Study, condition: Condition, method: Method) -> Ground:
    if method.scripts is not None:
        scripts = _scripts(method.scripts / condition.name, method, study.seeds)
        records = [read_record(scripts[seed]) for seed in study.seeds]
        other = next((r for r in records if r.world != records[0].world), None)
        if other is not None:
            message = f"{Path(other.where).name} is of another world than the scripts before it"
            raise error("script", message, method.spans["scripts"])
        given = stored(records[0], scripts[0].parent)
        words = vocabulary_of(given.spec)
        masks, assumed = _masks(study, words, given.module, given.audiences)
        given = given.of_length(len(records[0].frames))
        asked = given.module, given.audiences, len(records[0].frames)
        return Ground(given.spec, None, scripts, masks, assumed, *asked)
    assert condition.story is not None, "the reader misses it"
    with _at(condition.spans["story"], ("no-file",)):
        source = read_source(condition.story)
    settings = (*condition.settings, *method.settings)
    place = method.spans.get("set") or condition.spans.get("set") or condition.spans[""]
    with _at(place, ("set",)):
        story = story_from(source, condition.story.parent, settings)
    told = story.typed
    masks, assumed = _masks(study, told.vocabulary, told.module, told.audiences)
    asked = told.module, told.audiences, told.length
    return Ground(story.spec, story, (), masks, assumed, *asked)


def _scripts(folder: Path, method: Method, seeds: Sequence[int]) -> tuple[Path, ...]:
    """The scripts of a folder, in the order of their names: as many as there are seeds."""
    here = method.spans["scripts"]
    try:
        found = sorted(path for path in folder.iterdir() if path.suffix == ".json")
    except OSError as problem:
        message = f"the folder `{folder.name}` in it cannot be read: {problem.strerror}"
        raise error("no-file", message, here, "a folder for each condition") from None
    if not seeds or len(found) <= max(seeds):
        message = f"`{folder.name}` has {len(found)} scripts, the study wants number {max(seeds)}"
        raise error("no-file", message, here, "`seeds` are their numbers, from 0 on")
    return tuple(found)


@contextmanager
def _at(place: Span, codes: tuple[str, ...]) -> Iterator[None]:
    """Mistakes of the study itself are told at their places there."""
    try:
        yield
    except StoryError as problem:
        moved = [replace(d, span=place) if d.code in codes else d for d in problem.diagnostics]
        raise StoryError(moved) from None


def _masks(
    study: Study, words: Vocabulary, module: Module, audiences: tuple[Audience, ...]
) -> tuple[tuple[ty.Mask, ...], ty.Mask]:
    """The masks of the study's events, and of what is assumed. Raises StoryError."""
    asked, places = study.question, study.question.spans
    problems: list[Diagnostic] = []
    every = (True,) * len(words.hypotheses)

    def mask(text: str, place: Span | None) -> ty.Mask:
        assert place is not None
        try:
            return check_assumption(Source(place.source.name, text), words, module, audiences)
        except StoryError as problem:  # in quotes, in the study's file
            begin = place.start + 1
            here = lambda span: Span(place.source, begin + span.start, begin + span.end)
            problems.extend(replace(d, span=here(d.span)) for d in problem.diagnostics)
            return every

    assumed = mask(asked.assume, places.get("assume", places[""]))
    if study.answers:
        masks = tuple(mask(a.event, a.span) for a in study.answers if a.event)
    else:
        masks = (mask(asked.event, places["event"]),)
    if problems:
        raise StoryError(problems)
    return masks, assumed


def _of_panel(panel: Panel, words: Vocabulary) -> list[Diagnostic]:
    """What is wrong with a panel's settings, in a world; and with its file of people."""
    problems = []
    for key, drawn in panel.settings.items():
        place = panel.spans[key]
        known = [name for name in words.observer_settings if name != "forgetting"]
        if key not in known:
            hint = did_you_mean(key, known)
            message = f"viewers of world {words.world} do not differ in `{key}`"
            problems.append(Diagnostic("study-key", message, place, hint))
            continue
        setting = words.settings[key]
        assert isinstance(drawn, OneOf)
        for value in drawn.values:
            if not setting.holds(value):
                message = f"`{key}` cannot be `{value}`"
                problems.append(Diagnostic("study-value", message, place, setting.possible))
    if panel.people is not None:
        try:
            read_people(panel.people, panel.spans["people"])
        except StoryError as problem:
            problems += problem.diagnostics
    return problems
