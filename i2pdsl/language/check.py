"""From a parsed program to a typed story: the statements, one by one. No JAX, no planning."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from i2pdsl.errors import Diagnostic, Note, Source, Span, StoryError, did_you_mean
from i2pdsl.language import ast
from i2pdsl.language import typed as ty
from i2pdsl.language.elaborate import Elaborator, LeavesAtZero, Stop
from i2pdsl.language.evaluate import evaluate, fold_time, is_pure
from i2pdsl.language.parse import parse_expression, parse_tolerantly
from i2pdsl.language.scope import Env, Module, build_module
from i2pdsl.language.vocabulary import Setting, Vocabulary

LONGEST_STORY = 100_000

FindWorld = Callable[[str, Path | None], Vocabulary | None]
"""Finds a world's vocabulary by name or path, beside a folder or among the built-in ones."""


@dataclass(frozen=True)
class Observer:
    """One simulated viewer: the world's settings replaced, and a prior weight per hypothesis."""

    settings: tuple[tuple[str, float | str], ...] = ()
    prior: tuple[float, ...] | None = None


@dataclass(frozen=True)
class SearchPlan:
    """How to look for the script."""

    method: str = "beam"
    starts: int = 500
    width: int = 1


@dataclass(frozen=True)
class TypedStory:
    """A story that has no mistakes.

    Attributes:
        world: the world's name as written, and `settings` that the story replaces.
        objective: (sign, expression) pairs that add up; empty for `search naive`.
        assumption: the mask that every belief is conditioned on.
        observers: one, or several whose beliefs are averaged.
    """

    name: str
    source: Source
    world: str
    settings: tuple[tuple[str, float | str], ...]
    vocabulary: Vocabulary
    length: int
    start: ty.Typed | None
    allow: tuple[tuple[str, str], ...]
    objective: tuple[tuple[int, ty.Typed], ...]
    rationality: float
    plausibility: float
    assumption: ty.Mask
    observers: tuple[Observer, ...]
    search: SearchPlan
    module: Module = field(compare=False)
    warnings: tuple[Diagnostic, ...] = ()

    @property
    def everyone_rational(self) -> ty.Mask:
        """The event of the automatic rationality term."""
        return default_assumption(self.vocabulary)


@dataclass(frozen=True)
class Library:
    """A file of patterns and lets only."""

    source: Source
    program: ast.Program
    module: Module
    warnings: tuple[Diagnostic, ...] = ()


def default_assumption(vocabulary: Vocabulary) -> ty.Mask:
    """Every character is rational."""
    return tuple(
        all(row.get(latent) for latent in vocabulary.rational.values())
        for row in vocabulary.hypotheses
    )


def check_source(
    source: Source, find_world: FindWorld, folder: Path | None = None
) -> TypedStory | Library:
    """Checks a file. Raises StoryError with every independent mistake."""
    program, problems = parse_tolerantly(source)
    checker = _Checker(program, find_world, folder)
    checker.problems.extend(problems)
    result = checker.run()
    errors = [d for d in checker.problems if d.severity == "error"]
    if errors or result is None:
        raise StoryError(_in_order(errors, source))
    warnings = tuple(_in_order([d for d in checker.problems if d.severity != "error"], source))
    return replace(result, warnings=warnings)


def _in_order(problems: list[Diagnostic], source: Source) -> list[Diagnostic]:
    """By place, those of the file itself first; without repetitions."""
    unique = list(dict.fromkeys(problems))
    return sorted(unique, key=lambda d: (d.span.source is not source, d.span.start))


_SINGLE = (ast.World, ast.LengthIs, ast.Assume, ast.Audience, ast.Search)


class _Checker:
    """Collects the statements of one file."""

    def __init__(self, program: ast.Program, find_world: FindWorld, folder: Path | None):
        self.program = program
        self.find_world = find_world
        self.folder = folder
        self.problems: list[Diagnostic] = []

    def problem(
        self, code: str, message: str, span: Span, hint: str | None = None, *notes: Note
    ) -> None:
        self.problems.append(Diagnostic(code, message, span, hint, notes))

    def run(self) -> TypedStory | Library | None:
        program = self.program
        whole = Span(program.source, 0, 0)
        if not program.statements:
            if not self.problems:
                hint = "a story needs `world`, `length` and `maximize`"
                self.problem("empty", "the file is empty", whole, hint)
            return None
        self.module = build_module(program, self.problems.append, self.folder)
        self.check_single()
        kinds = {type(s) for s in program.statements}
        if kinds <= {ast.Let, ast.Pattern, ast.Import} and not self.problems:
            return Library(program.source, program, self.module)
        return self.story()

    def check_single(self) -> None:
        for kind in _SINGLE:
            self.only_one(self.program.of(kind))
        for term in ("rationality", "plausibility"):
            self.only_one([w for w in self.program.of(ast.Weight) if w.term == term])

    def only_one(self, statements: list[Any]) -> None:
        for extra in statements[1:]:
            word = extra.span.text.split(None, 1)[0]
            note = Note("the first one", statements[0].span)
            self.problem("duplicate", f"`{word}` stands here twice", extra.span, None, note)

    def first(self, kind: type[Any]) -> Any:
        return next(iter(self.program.of(kind)), None)

    def story(self) -> TypedStory | None:
        world: ast.World | None = self.first(ast.World)
        objectives: list[ast.Objective] = self.program.of(ast.Objective)
        search: ast.Search | None = self.first(ast.Search)
        naive = search is not None and search.name.id == "naive"
        # A statement that could not be read may have been the one that seems to be missing.
        readable = not any(d.code in ("syntax", "bracket", "string") for d in self.problems)
        whole = Span(self.program.source, 0, 0)
        if world is None:
            if readable:
                hint = "add `world kitchen`, or leave only `let`, `pattern` and `import`"
                self.problem("no-world", "the story names no world", whole, hint)
            return None
        vocabulary = self.vocabulary(world)
        if vocabulary is None:
            return None
        self.elaborator = Elaborator(vocabulary, self.length(readable), self.problems.append)
        self.world = vocabulary
        settings = self.settings(world.settings, vocabulary.settings, f"world {vocabulary.world}")
        if "hypotheses" in dict(settings):
            # Another reading of the hypotheses changes the masks.
            self.world = self.with_hypotheses(world, settings) or vocabulary
            self.elaborator.world = self.world
        if not objectives and not naive and readable:
            hint = "add `maximize EXPRESSION`, or `search naive`"
            self.problem("no-objective", "the story has no objective", world.span, hint)
        self.elaborator.assumption = self.assumption()
        start = self.start()
        allow = self.allow()
        weights = self.weights()
        typed = tuple(o for o in map(self.objective, objectives) if o is not None)
        self.unused_definitions()
        return TypedStory(
            name=Path(self.program.source.name).stem,
            source=self.program.source,
            world=world.name.id if isinstance(world.name, ast.Name) else world.name.value,
            settings=settings,
            vocabulary=self.world,
            length=self.elaborator.length,
            start=start,
            allow=allow,
            objective=typed,
            rationality=weights["rationality"],
            plausibility=weights["plausibility"],
            assumption=self.elaborator.assumption,
            observers=self.audience(),
            search=self.search(search),
            module=self.module,
        )

    def env(self) -> Env:
        return Env(self.module)

    def vocabulary(self, world: ast.World) -> Vocabulary | None:
        name = world.name.id if isinstance(world.name, ast.Name) else world.name.value
        try:
            found = self.find_world(name, self.folder)
        except StoryError as problem:
            self.problems.extend(problem.diagnostics)
            return None
        if found is None:
            hint = did_you_mean(name, known_worlds(self.folder))
            self.problem("no-world", f"there is no world `{name}`", world.name.span, hint)
        return found

    def with_hypotheses(
        self, world: ast.World, settings: tuple[tuple[str, float | str], ...]
    ) -> Vocabulary | None:
        name = world.name.id if isinstance(world.name, ast.Name) else world.name.value
        reading = dict(settings)["hypotheses"]
        return self.find_world(f"{name}?hypotheses={reading}", self.folder)

    def length(self, readable: bool) -> int:
        statement: ast.LengthIs | None = self.first(ast.LengthIs)
        if statement is None:
            if readable:
                whole = Span(self.program.source, 0, 0)
                self.problem("no-length", "the story has no length", whole, "add `length 15`")
            return 10
        node = statement.frames
        if not isinstance(node, ast.Number | ast.Negative):
            hint = "write a number of frames: `length 15`"
            self.problem("length", "the length must be a number", node.span, hint)
            return 10
        value = node.value if isinstance(node, ast.Number) else -1.0
        if value != int(value) or not 1 <= value <= LONGEST_STORY:
            message = f"the length must be a whole number from 1 to {LONGEST_STORY:,}"
            self.problem("length", message, node.span)
            return 10
        return int(value)

    def settings(
        self, arguments: tuple[ast.Argument, ...], known: dict[str, Setting], owner: str
    ) -> tuple[tuple[str, float | str], ...]:
        found: dict[str, float | str] = {}
        for argument in arguments:
            if argument.name is None:
                hint = "settings: " + ", ".join(known)
                self.problem("setting", "a setting is written NAME = VALUE", argument.span, hint)
                continue
            name = argument.name.id
            if name not in known:
                hint = did_you_mean(name, known) or "settings: " + ", ".join(known)
                self.problem("setting", f"{owner} has no setting `{name}`", argument.name.span, hint)
            elif name in found:
                self.problem("duplicate", f"`{name}` is given twice", argument.span)
            else:
                value = self.setting(known[name], argument.value)
                if value is not None:
                    found[name] = value
        return tuple(sorted(found.items()))

    def setting(self, setting: Setting, node: ast.Expr) -> float | str | None:
        if setting.choices:
            if isinstance(node, ast.Name | ast.Text):
                word = node.id if isinstance(node, ast.Name) else node.value
                if word in setting.choices:
                    return word
            hint = "one of " + ", ".join(setting.choices)
            message = f"`{setting.name}` cannot be `{node.span.text}`"
            self.problem("setting", message, node.span, hint)
            return None
        try:
            value = self.elaborator.constant(node, self.env())
        except Stop:
            return None
        if not in_range(setting, value):
            message = f"`{setting.name}` must be {setting.valid_range}"
            self.problem("setting", message, node.span)
            return None
        return value

    def assumption(self) -> ty.Mask:
        statement: ast.Assume | None = self.first(ast.Assume)
        if statement is None:
            return default_assumption(self.world)
        return read_assumption(self.elaborator, statement.condition, self.env())

    def start(self) -> ty.Typed | None:
        conditions = []
        for statement in self.program.of(ast.Start):
            try:
                env = replace(self.env(), inside="start")
                value = self.elaborator.truth(statement.condition, env)
            except Stop:
                continue
            if not all(isinstance(n, ty.Feature | ty.Apply | ty.Constant) for n in ty.walk(value)):
                message = "the start is chosen by `at`, `absent` and `adjacent`"
                self.problem("predicate", message, statement.condition.span)
            conditions.append(value)
        if len(conditions) > 1:
            return ty.Apply("and", tuple(conditions))
        return conditions[0] if conditions else None

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
        env = self.env()
        shown = [f"{e}({thing})" for e, things in self.world.events.items() for thing in things]
        hint = "events: " + ", ".join(shown) if shown else "this world has no events"
        if not isinstance(node, ast.Call) or len(node.arguments) != 1:
            self.elaborator.fail("no-event", "an event is expected here", node.span, env, hint)
        thing = node.arguments[0].value
        name = thing.id if isinstance(thing, ast.Name) else thing.span.text
        if name not in self.world.events.get(node.callee.id, ()):
            message = f"there is no event `{node.callee.id}({name})`"
            self.elaborator.fail("no-event", message, node.span, env, hint)
        return node.callee.id, name

    def weights(self) -> dict[str, float]:
        found = {"rationality": 1.0, "plausibility": 1.0}
        for statement in self.program.of(ast.Weight):
            try:
                found[statement.term] = self.elaborator.constant(statement.value, self.env())
            except Stop:
                continue
        return found

    def objective(self, statement: ast.Objective) -> tuple[int, ty.Typed] | None:
        try:
            return statement.sign, self.elaborator.number(statement.value, self.env())
        except Stop:
            return None

    def unused_definitions(self) -> None:
        """Checks the lets that nothing used, as far as they can be checked by themselves."""
        for definition in self.program.of(ast.Let):
            env = replace(
                self.env(),
                inside="event",
                times=range(1, self.elaborator.length + 1),
            )
            probe = Elaborator(self.world, self.elaborator.length, self.problems.append, query=True)
            probe.assumption = self.elaborator.assumption
            node, inner = probe.strip(definition.value, env)
            if isinstance(node, ast.Append | ast.Script | ast.Prefix | ast.FrameOf):
                try:
                    probe.item(node, replace(inner, inside=""))
                except (Stop, LeavesAtZero):
                    continue

    def audience(self) -> tuple[Observer, ...]:
        statement: ast.Audience | None = self.first(ast.Audience)
        if statement is None:
            return (Observer(),)
        return self.observers(statement.name, statement.settings)

    def observers(
        self, name: ast.Name, arguments: tuple[ast.Argument, ...]
    ) -> tuple[Observer, ...]:
        if name.id == "bayesian":
            return (self.observer(arguments),)
        if name.id == "average":
            found: list[Observer] = []
            for argument in arguments:
                inner = argument.value
                if isinstance(inner, ast.Call) and argument.name is None:
                    found.extend(self.observers(inner.callee, inner.arguments))
                elif isinstance(inner, ast.Name) and argument.name is None:
                    found.extend(self.observers(inner, ()))
                else:
                    hint = "average(bayesian(beta = 1), bayesian(beta = 2))"
                    message = "an average is taken over audiences"
                    self.problem("audience", message, argument.span, hint)
            if not arguments:
                self.problem("audience", "an average of nobody", name.span)
            return tuple(found)
        hint = did_you_mean(name.id, AUDIENCES) or "audiences: " + ", ".join(AUDIENCES)
        self.problem("audience", f"there is no audience `{name.id}`", name.span, hint)
        return (Observer(),)

    def observer(self, arguments: tuple[ast.Argument, ...]) -> Observer:
        allowed = {k: s for k, s in self.world.settings.items() if k in OBSERVER_SETTINGS}
        prior = [a for a in arguments if a.name is not None and a.name.id == "prior"]
        others = tuple(a for a in arguments if a not in prior)
        settings = self.settings(others, allowed, "audience bayesian")
        return Observer(settings, self.prior(prior[0].value) if prior else None)

    def prior(self, node: ast.Expr) -> tuple[float, ...] | None:
        env = replace(self.env(), inside="quantity")
        try:
            value = self.elaborator.number(node, env)
        except Stop:
            return None
        message = "a prior is a number for each hypothesis, at least 0 and not 0 everywhere"
        hint = "for instance `prior = if rho > 0 then 2 else 1`"
        weights: list[float | None] = []
        if is_pure(value) and not value.axes.time:
            weights = [evaluate(value, None, row) for row in self.world.hypotheses]
        if not weights or any(w is None or not w >= 0 for w in weights) or not any(weights):
            self.problem("audience", message, node.span, hint)
            return None
        numbers = [float(w) for w in weights if w is not None]
        return tuple(w / sum(numbers) for w in numbers)

    def search(self, statement: ast.Search | None) -> SearchPlan:
        if statement is None:
            return SearchPlan() if self.world.enumerable else SearchPlan("descend")
        name = statement.name.id
        known = BEAM_SETTINGS if name == "beam" else {}
        if name not in ("beam", "naive", "descend"):
            hint = did_you_mean(name, ("beam", "naive", "descend")) or "beam, naive or descend"
            self.problem("search", f"there is no search `{name}`", statement.name.span, hint)
        elif name == "descend" and self.world.enumerable:
            message = "`descend` needs continuous actions; this world's can be listed"
            self.problem("search", message, statement.name.span, "use `beam`")
        else:
            values = dict(self.settings(statement.settings, known, f"search {name}"))
            return SearchPlan(name, **{k: int(v) for k, v in values.items()})
        return SearchPlan()


AUDIENCES = ("bayesian", "average")
OBSERVER_SETTINGS = ("beta", "forgetting", "level0")
BEAM_SETTINGS = {
    "starts": Setting("starts", 500.0, "initial states that are tried", (), "from 1 to 1000000"),
    "width": Setting("width", 1.0, "scripts kept for each start", (), "from 1 to 10000"),
}


def in_range(setting: Setting, value: float) -> bool:
    """Whether a number is one that the setting can have."""
    match setting.name:
        case "starts":
            return value == int(value) and 1 <= value <= 1_000_000
        case "width":
            return value == int(value) and 1 <= value <= 10_000
        case "gamma":
            return 0 <= value < 1
        case "beta":
            return 0 <= value <= 1e3
        case "forgetting":
            return 0 <= value <= 0.5
    return abs(value) <= 1e6


def known_worlds(folder: Path | None) -> set[str]:
    """The names of the worlds that could have been meant."""
    from i2pdsl.resources import data_folder

    places = [data_folder("stories") / "worlds", folder or Path()]
    return {p.stem for place in places if place.is_dir() for p in place.glob("*.world")}


def read_assumption(elaborator: Elaborator, condition: ast.Expr | None, env: Env) -> ty.Mask:
    """The mask of an `assume`; `assume nothing` keeps every hypothesis."""
    every = (True,) * len(elaborator.world.hypotheses)
    if condition is None:
        return every
    try:
        mask = elaborator.mask(condition, env, "condition")
    except Stop:
        return every
    if not any(mask):
        message = "no hypothesis fulfils this assumption"
        elaborator.report(Diagnostic("impossible", message, condition.span))
        return every
    return mask


@dataclass(frozen=True)
class TypedQuery:
    """A checked query: the frames t that it covers (None without a free t), and its value."""

    value: ty.Typed
    times: range | None
    warnings: tuple[Diagnostic, ...]


def check_query(
    source: Source,
    vocabulary: Vocabulary,
    module: Module,
    length: int,
    assumption: ty.Mask | None = None,
    assume: Source | None = None,
) -> TypedQuery:
    """Checks an expression over a finished script of `length` frames.

    `assumption` is the story's; `assume` is the text of another one ('nothing' drops it).
    Raises StoryError.
    """
    problems: list[Diagnostic] = []
    elaborator = Elaborator(vocabulary, length, problems.append, query=True)
    env = Env(module)
    if assume is not None:
        nothing = assume.text.strip() == "nothing"
        condition = None if nothing else parse_expression(assume)
        elaborator.assumption = read_assumption(elaborator, condition, env)
    else:
        elaborator.assumption = assumption or default_assumption(vocabulary)
    node = parse_expression(source)
    times = range(length + 1)
    try:
        try:
            value = _query_value(elaborator, node, env, times)
        except LeavesAtZero:
            times = range(1, length + 1)
            value = _query_value(elaborator, node, env, times)
    except Stop:
        value = ty.Constant(0.0)
    errors = [d for d in problems if d.severity == "error"]
    if errors:
        raise StoryError(list(dict.fromkeys(errors)))
    return TypedQuery(value, times if value.axes.time else None, tuple(dict.fromkeys(problems)))


def _query_value(elaborator: Elaborator, node: ast.Expr, env: Env, times: range) -> ty.Typed:
    env = replace(env, times=times)
    item = elaborator.item(node, env)
    if isinstance(item.value, ty.Distribution):
        return item.value
    if item.kind not in ("number", "truth"):
        elaborator.wrong_kind("a number", item, node, env)
    value: ty.Typed = item.value
    try:
        return fold_time(value, times)  # type: ignore[no-any-return]
    except (ArithmeticError, ValueError, OverflowError):
        elaborator.fail("arithmetic", "this has no finite value at some t", node.span, env)
