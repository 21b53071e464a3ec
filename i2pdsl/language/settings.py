"""Settings of worlds, audiences and searches: `NAME(setting = value, ...)`."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from math import isfinite
from pathlib import Path

from i2pdsl.errors import Diagnostic, Note, Span, StoryError, did_you_mean, shorten
from i2pdsl.language import ast
from i2pdsl.language.elaborate import Elaborator, Stop
from i2pdsl.language.evaluate import is_pure, values
from i2pdsl.language.methods import METHODS, usual_method
from i2pdsl.language.people import read_people
from i2pdsl.language.priors import fitted
from i2pdsl.language.scope import Env
from i2pdsl.language.shares import CONTRADICTION, OTHERS, WHY_NONE, Told, shares_of
from i2pdsl.language.story import Observer, Particles, SearchPlan
from i2pdsl.language.vocabulary import (
    Latent,
    Setting,
    SettingValue,
    Value,
    between,
    show_value,
    whole,
)
from i2pdsl.language.vocabulary import Settings as Values

AUDIENCES = ("bayesian", "particles", "average")
OF_VIEWERS = {
    "sharpness": Setting(
        "sharpness",
        1.0,
        "how much more strongly than they do characters seem to prefer what is best for them",
        (),
        "above 0",
        lambda x: 0 < x <= 1000,
    ),
    "prior": Setting(
        "prior",
        1.0,
        "the weight of each hypothesis; of a latent's values `prior(LATENT) = {VALUE: WEIGHT}`",
    ),
    "given": Setting("given", "EVENT", "what they know to be so from the beginning"),
}
"""What a viewer may have besides the settings of the world."""
_OF_PARTICLES = Particles()
PARTICLES = {
    s.name: s
    for s in (
        whole("count", _OF_PARTICLES.count, "hypotheses that a viewer holds", 1, 100_000),
        whole("seed", _OF_PARTICLES.seed, "of all that chance decides", 0, 2**32 - 1),
        whole("moves", _OF_PARTICLES.moves, "sweeps after they were drawn anew", 0, 100),
        between("least", _OF_PARTICLES.least, "share that must count, else new ones", 0.0, 1.0),
    )
}
"""What a viewer has who holds some hypotheses instead of all."""


def _is_weight(value: float | None) -> bool:
    return value is not None and value >= 0 and isfinite(value)


def _plan(method: str, values: dict[str, SettingValue]) -> SearchPlan:
    usual = SearchPlan()
    kinds = {k: type(getattr(usual, k)) for k in values}
    return replace(usual, method=method, **{k: kinds[k](v) for k, v in values.items()})


class Settings:
    """Reads settings, and reports those that are wrong."""

    def __init__(self, elaborator: Elaborator, env: Env):
        self.elaborator = elaborator
        self.env = env

    def problem(
        self, code: str, message: str, span: Span, hint: str | None = None, *notes: Note
    ) -> None:
        self.elaborator.report(Diagnostic(code, message, span, hint, notes))

    def read(
        self, arguments: tuple[ast.Argument, ...], known: dict[str, Setting], owner: str
    ) -> Values:
        """The values of the settings that are given, sorted by name."""
        found: dict[str, SettingValue] = {}
        given: dict[str, Span] = {}
        listed = f"settings: {', '.join(known)}" if known else f"`{owner}` has no settings"
        for argument in arguments:
            if argument.name is None:
                self.problem("setting", "a setting is written NAME = VALUE", argument.span, listed)
                continue
            name = argument.name.id
            if name not in known:
                hint = (did_you_mean(name, known) if known else None) or listed
                message = f"`{owner}` has no setting `{name}`"
                self.problem("setting", message, argument.name.span, hint)
            elif name in given:
                note = Note("the first one", given[name])
                self.problem("duplicate", f"`{name}` is given twice", argument.span, None, note)
            else:
                given[name] = argument.span
                value = self.value(known[name], argument.value)
                if value is not None:
                    found[name] = value
        return tuple(sorted(found.items()))

    def value(self, setting: Setting, node: ast.Expr) -> SettingValue | None:
        if setting.choices:
            word = ""
            if isinstance(node, ast.Name | ast.Text):
                word = node.id if isinstance(node, ast.Name) else node.value
            if word in setting.choices:
                return word
            hint = "one of " + ", ".join(setting.choices)
            message = f"`{setting.name}` cannot be `{shorten(node.span.text)}`"
            self.problem("setting", message, node.span, hint)
            return None
        if setting.names:
            told = node.value if isinstance(node, ast.Text) else None
            if told is not None and setting.holds(told):
                return told
            message = f"`{setting.name}` cannot be `{shorten(node.span.text)}`"
            self.problem("setting", message, node.span, setting.possible)
            return None
        if setting.accepts_all is not None or isinstance(node, ast.SetOf):
            return self.numbers(setting, node)
        try:
            value = self.elaborator.constant(node, self.env)
        except Stop:
            return None
        if not setting.accepts(value):
            message = f"`{setting.name}` must be {setting.valid_range}, not {value:g}"
            self.problem("setting", message, node.span)
            return None
        return value

    def numbers(self, setting: Setting, node: ast.Expr) -> tuple[float, ...] | None:
        """A set of numbers, sorted."""
        accepts = setting.accepts_all
        if accepts is None or not isinstance(node, ast.SetOf):
            found, wanted = ("a number", "a set") if accepts else ("a set", "a number")
            hint = f"write `{setting.name} = {{a, b}}`" if accepts else None
            message = f"`{setting.name}` must be {wanted}, not {found}"
            self.problem("setting", message, node.span, hint)
            return None
        try:
            values = tuple(self.elaborator.constant(item, self.env) for item in node.items)
        except Stop:
            return None
        if not accepts(values):
            message = f"`{setting.name}` must be {setting.valid_range}"
            self.problem("setting", message, node.span)
            return None
        return tuple(sorted(values))

    # Audiences.

    def audience(
        self, name: ast.Name | ast.Text, arguments: tuple[ast.Argument, ...], folder: Path | None
    ) -> tuple[Observer, ...]:
        """The simulated viewers of `audience NAME(...)`, or of a file."""
        if isinstance(name, ast.Text):
            return self.people(name, arguments, folder)
        if name.id == "bayesian":
            return (self.observer(arguments),)
        if name.id == "particles":
            return (self.with_particles(name, arguments),)
        if name.id == "average":
            example = "write `average(bayesian(beta = 1), bayesian(beta = 2))`"
            found: list[Observer] = []
            for argument in arguments:
                inner = argument.value
                if isinstance(inner, ast.Call) and argument.name is None:
                    found.extend(self.audience(inner.callee, inner.arguments, folder))
                elif isinstance(inner, ast.Name | ast.Text) and argument.name is None:
                    found.extend(self.audience(inner, (), folder))
                else:
                    message = "an average is taken over audiences"
                    self.problem("audience", message, argument.span, example)
            if not arguments:
                message = "an average needs audiences to be taken over"
                self.problem("audience", message, name.span, example)
            return tuple(found)
        hint = did_you_mean(name.id, AUDIENCES) or "audiences: " + ", ".join(AUDIENCES)
        self.problem("audience", f"there is no audience `{name.id}`", name.span, hint)
        return (Observer(),)

    def people(
        self, name: ast.Text, arguments: tuple[ast.Argument, ...], folder: Path | None
    ) -> tuple[Observer, ...]:
        """The viewers of a file that `i2p fit` wrote."""
        if arguments:
            message = "an audience in a file has no settings"
            self.problem("setting", message, arguments[0].span, "change them in the file")
        try:
            people = read_people((folder or Path()) / name.value, name.span)
        except StoryError as problem:
            for diagnostic in problem.diagnostics:
                self.elaborator.report(diagnostic)
            return (Observer(),)
        words = self.elaborator.world
        foreign = {latent for person in people for latent in person.prior} - set(words.latents)
        if foreign:
            listed = ", ".join(f"`{latent[:40]}`" for latent in sorted(foreign)[:4])
            more = f" and {len(foreign) - 4} more" if len(foreign) > 4 else ""
            message = (
                f"world {words.world} has no {listed}{more}: what viewers think of that is left out"
            )
            self.elaborator.report(Diagnostic("audience", message, name.span, severity="warning"))
        return tuple(person.observer(words) for person in people)

    def with_particles(self, name: ast.Name, arguments: tuple[ast.Argument, ...]) -> Observer:
        """A viewer who holds some hypotheses instead of all."""
        words = self.elaborator.world
        own = [a for a in arguments if a.name is not None and a.name.id in PARTICLES]
        values = dict(self.read(tuple(own), PARTICLES, "audience particles"))
        rest = tuple(a for a in arguments if a not in own)
        observer = self.observer(rest, "audience particles", PARTICLES)
        if not words.holds_particles:
            message = f"{words.where} all hypotheses are held: there are few of them"
            self.problem("audience", message, name.span, "write `bayesian`")
        told = {k: v if k == "least" else int(v) for k, v in values.items()}  # type: ignore[arg-type]
        return replace(observer, particles=Particles(**told))  # type: ignore[arg-type]

    def observer(
        self,
        arguments: tuple[ast.Argument, ...],
        owner: str = "audience bayesian",
        more: dict[str, Setting] | None = None,
    ) -> Observer:
        world = self.elaborator.world.settings
        known = {k: world[k] for k in self.elaborator.world.observer_settings}
        known |= OF_VIEWERS
        own: dict[str, ast.Argument] = {}
        others, shares = [], []
        for argument in arguments:
            name = argument.name.id if argument.name is not None else ""
            if name == "prior" and isinstance(argument.value, ast.Shares):
                shares.append(argument.value)
            elif name not in OF_VIEWERS:
                others.append(argument)
            elif own.setdefault(name, argument) is not argument:
                note = Note("the first one", own[name].span)
                self.problem("duplicate", f"`{name}` is given twice", argument.span, None, note)
        settings = self.read(tuple(others), known | (more or {}), owner)
        prior = self.prior(own["prior"].value) if "prior" in own else None
        if shares:
            prior = self.with_shares(prior, shares)
        prior = prior or self.elaborator.world.prior
        sharpness: SettingValue | None = None
        if "sharpness" in own:
            sharpness = self.value(OF_VIEWERS["sharpness"], own["sharpness"].value)
        sharp = sharpness if isinstance(sharpness, float) else 1.0
        return self.informed(Observer(settings, prior, sharpness=sharp), own.get("given"))

    def informed(self, observer: Observer, given: ast.Argument | None) -> Observer:
        """A viewer who knows an event to be so: the prior is conditioned on it."""
        if given is None:
            return observer
        try:
            known = self.elaborator.mask(given.value, self.env, "condition")
        except Stop:
            return observer
        prior = observer.prior or self.elaborator.world.even
        weights = [p if k else 0.0 for p, k in zip(prior, known, strict=True)]
        if not any(weights):
            message = "nobody can know what no hypothesis fulfils"
            hint = "the `prior` excludes all that fulfil it" if any(known) else None
            self.problem("impossible", message, given.value.span, hint)
            return observer
        return replace(observer, prior=tuple(w / sum(weights) for w in weights), known=known)

    def with_shares(
        self, prior: tuple[float, ...] | None, told: list[ast.Shares]
    ) -> tuple[float, ...] | None:
        """A prior in which the values of some latents have given shares. Those that the world's
        file tells of other latents stay, unless a prior of hypotheses takes their place."""
        words = self.elaborator.world
        shares: dict[str, dict[Value, float]] = {}
        try:
            for node in told:
                latent = self.elaborator.latent(node.latent, self.env)
                if latent.name in shares:
                    message = f"the prior of `{latent.name}` is given twice"
                    self.problem("duplicate", message, node.span)
                weights = [self.told(latent, pair) for pair in node.pairs]
                found = shares_of(latent, weights, node.span, self.problem)
                if found is None:
                    return prior
                shares[latent.name] = found
        except Stop:
            return prior
        base = prior or words.even
        result = fitted(words.hypotheses, base, {**({} if prior else words.shares), **shares})
        if result is None:
            self.problem("prior", CONTRADICTION, told[0].span.to(told[-1].span), WHY_NONE)
        return result

    def told(self, latent: Latent, pair: ast.Pair) -> Told:
        """A value of a latent with its weight. Raises Stop."""
        value, weight = pair.first, self.elaborator.constant(pair.second, self.env)
        if latent.kind == "number" and not (isinstance(value, ast.Name) and value.id == OTHERS):
            text = show_value(self.elaborator.constant(value, self.env))
        else:
            text = value.id if isinstance(value, ast.Name) else value.span.text
        return Told(text, weight, value.span, pair.second.span)

    def prior(self, node: ast.Expr) -> tuple[float, ...] | None:
        """The weights of the hypotheses, summing to one."""
        try:
            value = self.elaborator.number(node, replace(self.env, inside="quantity"))
        except Stop:
            return None
        weights: list[float | None] = []
        if is_pure(value) and not value.axes.time:
            rows = self.elaborator.world.hypotheses
            with suppress(ArithmeticError, ValueError):  # 1 / rho
                weights = values(value, rows)
        if not weights or not all(_is_weight(w) for w in weights) or not any(weights):
            message = "a prior is a number for each hypothesis, at least 0 and not 0 everywhere"
            hint = "for instance `prior = if rho > 0 then 2 else 1`"
            self.problem("audience", message, node.span, hint)
            return None
        even = self.elaborator.world.even
        numbers = [float(w) * n for w, n in zip(weights, even, strict=True) if w is not None]
        if not isfinite(sum(numbers)):
            numbers = [w / max(numbers) for w in numbers]
        return tuple(w / sum(numbers) for w in numbers)

    # Searches.

    def search(self, statement: ast.Search | None) -> SearchPlan:
        """The plan of `search NAME(...)`, or the world's usual one."""
        words = self.elaborator.world
        usual = dict(words.search_settings)
        if statement is None:
            return _plan(usual_method(words), usual)
        name = statement.name.id
        if name not in METHODS:
            hint = did_you_mean(name, METHODS) or "searches: " + ", ".join(METHODS)
            self.problem("search", f"there is no search `{name}`", statement.name.span, hint)
            return _plan(usual_method(words), usual)
        offered = METHODS[name].settings(words.enumerable)
        if offered is None:
            needs, here = "actions that can be listed", "are continuous"
            if words.enumerable:
                needs, here = "continuous actions", "can be listed"
            message = f"`{name}` needs {needs}; this world's {here}"
            hint = f"use `{usual_method(words)}`"
            self.problem("search", message, statement.name.span, hint)
            return _plan(usual_method(words), usual)
        known = {s.name: s for s in offered}
        values = dict(self.read(statement.settings, known, f"search {name}"))
        if "bound" in values:
            how = "what lies in a box is minimised by projected gradients"
            self.useless(statement, ("optimiser", "rate"), "bound", how)
        elif values.get("optimiser", "adam") != "adam":
            self.useless(statement, ("rate",), "optimiser", "it finds its own step size")
        own = {s.name: usual[s.name] for s in offered if s.name in usual}
        return _plan(name, {**own, **values})

    def useless(
        self, statement: ast.Search, names: tuple[str, ...], beside: str, hint: str
    ) -> None:
        """Warns of settings that have no meaning beside another."""
        for argument in statement.settings:
            if argument.name is not None and argument.name.id in names:
                message = f"`{argument.name.id}` has no meaning beside `{beside}`"
                warning = Diagnostic("setting", message, argument.span, hint, severity="warning")
                self.elaborator.report(warning)
