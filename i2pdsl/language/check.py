"""From a parsed program to a typed story: the statements, one by one. No JAX, no planning."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, Protocol

from i2pdsl.errors import (
    Diagnostic,
    Note,
    Source,
    Span,
    StoryError,
    closest,
    did_you_mean,
    first_of,
    shorten,
)
from i2pdsl.language import ast
from i2pdsl.language import typed as ty
from i2pdsl.language.builtins import RESERVED
from i2pdsl.language.elaborate import Elaborator, Stop
from i2pdsl.language.imports import build_module
from i2pdsl.language.methods import LONGEST_STORY, METHODS, MOST_LENGTHS, has_audience
from i2pdsl.language.parse import STATEMENT_WORDS, parse_tolerantly
from i2pdsl.language.pins import read_kept, read_pins
from i2pdsl.language.query import TypedQuery, check_query, read_assumption
from i2pdsl.language.scope import LIBRARY_STATEMENTS, Env
from i2pdsl.language.settings import Settings as SettingsReader
from i2pdsl.language.start import can_start
from i2pdsl.language.statements import room_for_nesting
from i2pdsl.language.story import (
    VIEWERS,
    Audience,
    Library,
    Observer,
    Particles,
    Requirement,
    SearchPlan,
    TypedStory,
    able,
    default_assumption,
    ordered,
    usual_audience,
)
from i2pdsl.language.unused import check_unused
from i2pdsl.language.vocabulary import ASKED, Settings, Vocabulary, Weights
from i2pdsl.resources import data_folder

__all__ = [
    "FindWorld",
    "Library",
    "Observer",
    "SearchPlan",
    "TypedQuery",
    "TypedStory",
    "check_query",
    "check_source",
    "default_assumption",
    "known_worlds",
]


class FindWorld(Protocol):
    """Finds a world's vocabulary by name or path, beside a folder or among the built-in ones."""

    def __call__(
        self, name: str, folder: Path | None, settings: Settings = (), /
    ) -> Vocabulary | None: ...


def check_source(
    source: Source, find_world: FindWorld, folder: Path | None = None
) -> TypedStory | Library:
    """Checks a file. Raises StoryError with every independent mistake."""
    with room_for_nesting():
        program, problems = parse_tolerantly(source)
        checker = _Checker(program, find_world, folder)
        checker.problems.extend(problems)
        result = checker.run()
    errors = [d for d in checker.problems if d.severity == "error"]
    if errors or result is None:
        raise StoryError(first_of(_in_order(errors, source)))
    found = [d for d in checker.problems if d.severity != "error"]
    warnings = tuple(first_of(_in_order(found, source)))
    return replace(result, warnings=warnings)


def _in_order(problems: list[Diagnostic], source: Source) -> list[Diagnostic]:
    """By place, those of the file itself first; without repetitions."""
    unique: dict[object, Diagnostic] = {}
    for d in problems:
        # A mistake in a pattern is one wherever the pattern is used, and so is one in an argument
        # wherever the pattern puts it in.
        what = None if d.notes else (d.code, d.message)
        unique.setdefault((d.span.source.name, d.span, what), d)
    return sorted(
        unique.values(),
        key=lambda d: (d.span.source is not source, d.span.source.name, d.span.start),
    )


_SUMMED = ("rationality", "naturalness", "liveliness")  # automatic terms that sum over frames
_SINGLE = (ast.World, ast.LengthIs, ast.Assume, ast.Search)


class _Checker:
    """Collects the statements of one file."""

    def __init__(self, program: ast.Program, find_world: FindWorld, folder: Path | None):
        self.program = program
        self.find_world = find_world
        self.folder = folder
        self.problems: list[Diagnostic] = []
        self.values: dict[str, ty.Typed] = {}  # of the objectives so far, by their texts

    def problem(
        self, code: str, message: str, span: Span, hint: str | None = None, *notes: Note
    ) -> None:
        self.problems.append(Diagnostic(code, message, span, hint, notes))

    def run(self) -> TypedStory | Library | None:
        program = self.program
        if not program.statements:
            if not self.problems:
                hint = "a story needs `world`, `length` and `maximize`"
                what = "has only comments" if program.source.text.strip() else "is empty"
                self.problem("empty", f"the file {what}", Span(program.source, 0, 0), hint)
            return None
        self.module = build_module(program, self.problems.append, self.folder)
        self.check_single()
        if all(isinstance(s, LIBRARY_STATEMENTS) for s in program.statements):
            if not program.unread:
                check_unused(program, self.module, None, self.problems.append)
                return Library(program.source, program, self.module)
            if not self.might_be_unread("world"):
                return None
        return self.story()

    def check_single(self) -> None:
        for kind in _SINGLE:
            self.only_one(self.program.of(kind))
        audiences = self.program.of(ast.Audience)
        for name in dict.fromkeys(map(_audience, audiences)):
            self.only_one([a for a in audiences if _audience(a) == name])
        for term in Weights._fields:
            self.only_one([w for w in self.program.of(ast.Weight) if w.term == term])

    def only_one(self, statements: list[Any]) -> None:
        for extra in statements[1:]:
            word = extra.span.text.split(None, 1)[0]
            if isinstance(extra, ast.Audience) and extra.called is not None:
                word = f"{word} {extra.called.id}"
            note = Note("the first one", statements[0].span)
            message = f"a story has only one `{word}`, this is another"
            self.problem("duplicate", message, extra.span, None, note)

    def first(self, kind: type[Any]) -> Any:
        return next(iter(self.program.of(kind)), None)

    def might_be_unread(self, *words: str) -> bool:
        """Whether a statement that could not be read may be the one that seems to be missing."""
        for span in self.program.unread:
            text = span.text.split()
            keyword = _meant(text[0]) if text else None
            if keyword is None or keyword in words or any(w in text[1:] for w in words):
                return True
        return False

    def missing(self, code: str, message: str, span: Span, hint: str, *words: str) -> None:
        """Reports that a statement is missing, unless it is there and could not be read."""
        if not self.might_be_unread(*words):
            self.problem(code, message, span, hint)

    def story(self) -> TypedStory | None:
        world: ast.World | None = self.first(ast.World)
        if world is None:
            hint = "add `world kitchen`; a library has only `let`, `pattern` and `import`"
            whole = self.program.statements[0].span
            self.missing("no-world", "the story names no world", whole, hint, "world")
            return None
        search: ast.Search | None = self.first(ast.Search)
        objectives: list[ast.Objective] = self.program.of(ast.Objective)
        lengths = self.lengths(world)
        length = lengths[-1]
        if not objectives and (search is None or has_audience(search.name.id)):
            hint = "add `maximize EXPRESSION`, or `search naive`"
            message = "the story has no objective"
            words = ("maximize", "minimize", "search")
            self.missing("no-objective", message, world.span, hint, *words)
        vocabulary = self.vocabulary(world)
        if vocabulary is None:
            return None
        self.elaborator = Elaborator(vocabulary, length, self.problems.append)
        self.env = Env(self.module)
        self.settings = SettingsReader(self.elaborator, self.env)
        settings = self.settings.read(
            world.settings, vocabulary.settings, f"world {vocabulary.world}"
        )
        if any(vocabulary.settings[name].reshapes for name, _ in settings):
            # Other hypotheses have other masks.
            found = self.find_world(_word(world.name), self.folder, settings)
            self.elaborator.world = found or vocabulary
        elif vocabulary.counts:
            settings = self.keeping_apart(world, vocabulary, settings)
        self.world = self.elaborator.world
        self.check_time(length)
        self.check_own_names()
        self.elaborator.audiences = self.audiences()
        self.elaborator.assumption = self.assumption()
        start = self.start()
        allow = self.allow()
        weights = self.weights()
        self.elaborator.weight = 1.0 if len(lengths) > 1 else None
        asked = self.asked(objectives, allow)
        plan = self.settings.search(search)
        check_unused(self.program, self.module, self.elaborator, self.problems.append)
        story = TypedStory(
            name=Path(self.program.source.name).stem,
            source=self.program.source,
            world=_word(world.name),
            settings=settings,
            vocabulary=self.world,
            length=length,
            start=start,
            allow=allow,
            weights=weights,
            assumption=self.elaborator.assumption,
            audiences=self.elaborator.audiences,
            search=plan,
            module=self.module,
            **asked,
        )
        if len(lengths) == 1:
            return story
        return replace(story, longest=length, lengths=self.each_length(story, lengths, objectives))

    def asked(
        self, objectives: list[ast.Objective], allow: tuple[tuple[str, str], ...]
    ) -> dict[str, Any]:
        """What is asked of the script: of its length."""
        requirements = map(self.requirement, self.program.of(ast.Require))
        return {
            "objective": tuple(o for o in map(self.objective, objectives) if o is not None),
            "requirements": tuple(r for r in requirements if r is not None),
            "pins": read_pins(self.program.of(ast.Pin), self.elaborator, self.env, allow),
            "kept": read_kept(self.program.of(ast.Pin), self.elaborator, self.env, self.folder),
        }

    def each_length(
        self, story: TypedStory, lengths: range, objectives: list[ast.Objective]
    ) -> tuple[TypedStory, ...]:
        """The story of each length. One that has a mistake, as an index that leaves the script, is
        the last that is looked at."""
        statement: ast.LengthIs = self.first(ast.LengthIs)
        if not METHODS[story.search.method].chooses_length:
            message = "a search can choose the length where it is a beam search"
            self.problem("length", message, statement.value, f"`length {lengths[-1]}`")
            return ()
        found = [replace(story, longest=story.length)]
        for length in reversed(lengths[:-1]):
            known = len(self.problems)
            weight = story.length / length
            self.elaborator.length, self.elaborator.weight = length, weight
            self.values.clear()
            asked = self.asked(objectives, story.allow)
            wrong = [d for d in self.problems[known:] if d.severity == "error"]
            del self.problems[known:]
            if wrong:
                note = Note(f"in a story of {length} frames", statement.value)
                self.problems += [replace(d, notes=(*d.notes, note)) for d in wrong]
                break
            weights = {term: weight * getattr(story.weights, term) for term in _SUMMED}
            found.append(
                replace(
                    story,
                    length=length,
                    longest=story.length,
                    weights=story.weights._replace(**weights),
                    **asked,
                )
            )
        return tuple(reversed(found))

    def vocabulary(self, world: ast.World) -> Vocabulary | None:
        name = _word(world.name)
        try:
            found = self.find_world(name, self.folder)
        except StoryError as problem:
            note = Note("the world is named here", world.name.span)
            self.problems += [replace(d, notes=(*d.notes, note)) for d in problem.diagnostics]
            return None
        except (OSError, ValueError):  # a name that no file can have
            found = None
        if found is None:
            hint = did_you_mean(name, known_worlds(self.folder))
            self.problem("no-world", f"there is no world `{shorten(name)}`", world.name.span, hint)
        return found

    def keeping_apart(self, world: ast.World, words: Vocabulary, settings: Settings) -> Settings:
        """Where there are more hypotheses than anybody can hold, viewers keep those latents apart
        that the story names, and those that its world is told to."""
        sources = {d.item.span.source for d in self.module.names.values()}
        texts = [self.program.source.text, *(source.text for source in sources)]
        told = {word for text in texts for word in re.findall(r"\w+", text)}
        told |= set(re.findall(r"\w+", str(dict(settings).get(ASKED, ""))))
        names = " ".join(latent for latent in words.latents if latent in told)
        settings = tuple(sorted({**dict(settings), ASKED: names}.items()))
        try:
            found = self.find_world(_word(world.name), self.folder, settings)
        except StoryError as problem:
            self.problems += [replace(d, span=world.span) for d in problem.diagnostics]
            found = None
        self.elaborator.world = found or words
        return settings

    def warn_of_particles(self, audiences: Iterable[Audience]) -> None:
        """Says that viewers hold particles, where they do without being told to."""
        words, held = self.world, [o.particles for a in audiences for o in a.observers]
        names = [a.name for a in self.program.of(ast.Audience)]
        asked = any(isinstance(name, ast.Name) and name.id == "particles" for name in names)
        if not words.counts or asked or not any(held):
            return
        whose = "viewers who know of several characters together" if words.factors else "viewers"
        message = (
            f"{whose} cannot hold all {math.fsum(words.counts):,.0f} hypotheses: "
            f"they hold {Particles().count} particles"
        )
        hint = "`audience particles(count = 1000)` are more; docs/particles.md says how exact"
        place = self.program.of(ast.World)[0].span
        self.elaborator.report(Diagnostic("particles", message, place, hint, severity="warning"))

    def lengths(self, world: ast.World) -> range:
        """The numbers of frames; any other where it is wrong, to check the rest."""
        usual = range(10, 11)
        statement: ast.LengthIs | None = self.first(ast.LengthIs)
        if statement is None:
            hint = "add a number of frames: `length 15`"
            message = "the story has no length"
            self.missing("no-length", message, world.span, hint, "length")
            return usual
        fewest = self.frames(statement.frames)
        most = fewest if statement.most is None else self.frames(statement.most)
        if fewest is None or most is None:
            return usual
        if not 0 <= most - fewest < MOST_LENGTHS:
            message = f"there is no length in {fewest}..{most}"
            if fewest < most:
                message = (
                    f"these are {most - fewest + 1:,} lengths, at most {MOST_LENGTHS} are tried"
                )
            self.problem("length", message, statement.value, "for instance `length 12..20`")
            return range(most, most + 1)
        return range(fewest, most + 1)

    def frames(self, node: ast.Expr) -> int | None:
        """The number of frames that is written."""
        hint = "write a number of frames: `length 15`"
        value = -1.0
        if isinstance(node, ast.Number):
            value = node.value
        elif not isinstance(node, ast.Negative):
            self.problem("length", "the length must be a number", node.span, hint)
            return None
        if value != int(value) or not 1 <= value <= LONGEST_STORY:
            message = f"the length must be a whole number from 1 to {LONGEST_STORY:,}"
            self.problem("length", message, node.span, hint)
            return None
        return int(value)

    def check_time(self, length: int) -> None:
        """A story is no longer than the time that there is in its world."""
        statement: ast.LengthIs | None = self.first(ast.LengthIs)
        most = self.world.longest
        if statement is not None and most is not None and length > most:
            message = f"after {most} frames the time in {self.world.world} is up"
            hint = f"`length {most}`; or `world {self.world.world}(horizon = {length})`"
            self.problem("length", message, statement.value, hint)

    def check_own_names(self) -> None:
        """The world's latents keep their names, and an audience has one of its own."""
        named = [s.called for s in self.program.of(ast.Audience) if s.called is not None]
        definitions = [s.name for s in self.program.of(ast.Let) + self.program.of(ast.Pattern)]
        own = {name.id: name.span for name in definitions}
        for name in (*definitions, *named):
            if name.id in self.world.latents:
                message = f"`{name.id}` is the name of a latent of the world"
                self.problem("shadow", message, name.span, "choose another name")
        for name in named:
            if name.id in RESERVED or name.id == "pi":
                message = f"`{name.id}` is a word of the language and cannot be a name"
                self.problem("reserved", message, name.span, "choose another name")
            elif name.id in own:
                note = Note("the first one", own[name.id])
                self.problem("duplicate", f"`{name.id}` is defined twice", name.span, None, note)

    def audiences(self) -> tuple[Audience, ...]:
        """The viewers of all beliefs that name no others, and those that have names."""
        usual = usual_audience(self.world)
        found = {VIEWERS: usual}
        for statement in self.program.of(ast.Audience):
            observers = self.settings.audience(statement.name, statement.settings, self.folder)
            held = able(observers, self.world)
            audience = Audience(_audience(statement), held, span=statement.span)
            if found.get(audience.name, usual) is usual:  # another one is a mistake
                found[audience.name] = audience
        self.warn_of_particles(found.values())
        return ordered(tuple(found.values()))

    def assumption(self) -> ty.Mask:
        statement: ast.Assume | None = self.first(ast.Assume)
        if statement is None:
            usual = default_assumption(self.world)
            for audience in self.elaborator.audiences:
                if not audience.can_hold(usual):
                    message = "some viewer takes it for impossible that everyone is rational"
                    hint = "`assume nothing` drops what is assumed by default"
                    place = audience.span or self.program.of(ast.World)[0].span
                    self.problem("impossible", message, place, hint)
            return usual
        return read_assumption(self.elaborator, statement.condition, self.env)

    def start(self) -> ty.Typed | None:
        given: ast.Start | None = self.first(ast.Start)
        if given is not None and not (self.world.enumerable or self.world.size):
            message = f"stories of world {self.world.world} all start in the same state"
            self.problem("start", message, given.span, "leave out the `start`")
            return None
        conditions: list[ty.Typed] = []
        places: list[Span] = []
        seen: set[str] = set()
        for statement in self.program.of(ast.Start):
            text = statement.condition.span.text
            if text in seen:
                continue
            seen.add(text)
            try:
                env = replace(self.env, inside="start")
                value = self.elaborator.truth(statement.condition, env)
            except Stop:
                continue
            conditions.append(value)
            places.append(statement.condition.span)
            if can_start(value, self.world) is False:
                message = "no state fulfils this condition"
                self.problem("impossible", message, statement.condition.span)
                return None
        if not conditions:
            return None
        start = ty.Apply("and", tuple(conditions)) if len(conditions) > 1 else conditions[0]
        if len(conditions) > 1 and can_start(start, self.world) is False:
            notes = [Note("and this one", place) for place in places[:-1]]
            message = "no state fulfils all conditions of the start: this one"
            self.problem("impossible", message, places[-1], None, *notes)
        return start

    def allow(self) -> tuple[tuple[str, str], ...]:
        found = []
        for statement in self.program.of(ast.Allow):
            for event in statement.events:
                try:
                    found.append(self.event(event))
                except Stop:
                    continue
        return tuple(dict.fromkeys(found))

    def event(self, node: ast.Expr) -> tuple[str, str]:
        shown = [f"{e}({thing})" for e, things in self.world.events.items() for thing in things]
        hint = "events: " + ", ".join(shown) if shown else "this world has no events"
        if not isinstance(node, ast.Call) or len(node.arguments) != 1:
            message = "expected an event of the world and what it brings"
            raise self.elaborator.fail("no-event", message, node.span, self.env, hint)
        thing = node.arguments[0].value
        name = thing.id if isinstance(thing, ast.Name) else thing.span.text
        if name not in self.world.events.get(node.callee.id, ()):
            message = f"there is no event `{node.callee.id}({name})`"
            raise self.elaborator.fail("no-event", message, node.span, self.env, hint)
        return node.callee.id, name

    def weights(self) -> Weights:
        usual = self.world.weights._asdict()
        found = {term: w for term, w in usual.items() if term in self.world.automatic}
        for statement in self.program.of(ast.Weight):
            if statement.term not in self.world.automatic:
                message = f"world {self.world.world} has no automatic term `{statement.term}`"
                warning = Diagnostic("world", message, statement.span, severity="warning")
                self.problems.append(warning)
            try:
                value = self.elaborator.constant(statement.value, self.env)
            except Stop:
                continue
            if statement.term in self.world.automatic:
                found[statement.term] = value
        return Weights(**{term: found.get(term, 0.0) for term in Weights._fields})

    def objective(self, statement: ast.Objective) -> tuple[int, ty.Typed] | None:
        text = statement.value.span.text
        value = self.values.get(text)
        if value is None:
            try:
                value = self.elaborator.number(statement.value, self.env)
            except Stop:
                return None
            self.values[text] = value
        return statement.sign, value

    def requirement(self, statement: ast.Require) -> Requirement | None:
        first, second = statement.condition, statement.second
        weight, self.elaborator.weight = self.elaborator.weight, None
        try:
            if second is None:
                item = self.elaborator.item(first, self.env)
                value = item.value
                if item.kind == "number" and not self.elaborator.is_predicate(value):
                    message = "expected a condition, found a number"
                    hint = "compare it: `... > 0.9`"
                    raise self.elaborator.blame("type", message, first, self.env, hint)
                if item.kind not in ("number", "truth"):
                    raise self.elaborator.wrong_kind("a condition", item, first, self.env)
            else:
                value = self.elaborator.order(first, second, self.env)
            if not any(isinstance(n, ty.Moment) for n in ty.walk(value)):
                message = "this says nothing about the script"
                hint = "for instance `require eventually [...]`, or `P(... | script[:T]) > 0.9`"
                raise self.elaborator.fail("require", message, first.span, self.env, hint)
        except Stop:
            return None
        finally:
            self.elaborator.weight = weight
        return Requirement(value, statement.span)


def _audience(statement: ast.Audience) -> str:
    """The name of an audience."""
    return VIEWERS if statement.called is None else statement.called.id


@cache
def _meant(word: str) -> str | None:
    """The statement that a word was meant to begin."""
    return closest(word, STATEMENT_WORDS)


def known_worlds(folder: Path | None) -> set[str]:
    """The names of the worlds that could have been meant."""
    places = [data_folder("stories") / "worlds", folder or Path()]
    return {p.stem for place in places if place.is_dir() for p in place.glob("*.world")}


def _word(node: ast.Name | ast.Text) -> str:
    return node.id if isinstance(node, ast.Name) else node.value
