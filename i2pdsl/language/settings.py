"""Settings of worlds, audiences and searches: `NAME(setting = value, ...)`."""

from __future__ import annotations

from dataclasses import replace

from i2pdsl.errors import Diagnostic, Note, Span, did_you_mean, shorten
from i2pdsl.language import ast
from i2pdsl.language.elaborate import Elaborator, Stop
from i2pdsl.language.evaluate import evaluate, is_pure
from i2pdsl.language.scope import Env
from i2pdsl.language.story import Observer, SearchPlan
from i2pdsl.language.vocabulary import Setting

AUDIENCES = ("bayesian", "average")
SEARCHES = ("beam", "descend", "naive")
OBSERVER_SETTINGS = ("beta", "forgetting", "level0")
BEAM_SETTINGS = {
    "starts": Setting(
        "starts",
        500.0,
        "initial states that are tried",
        (),
        "a whole number from 1 to 1,000,000",
        lambda x: x == int(x) and 1 <= x <= 1_000_000,
    ),
    "width": Setting(
        "width",
        1.0,
        "scripts kept for each start",
        (),
        "a whole number from 1 to 10,000",
        lambda x: x == int(x) and 1 <= x <= 10_000,
    ),
}


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
    ) -> tuple[tuple[str, float | str], ...]:
        """The values of the settings that are given, sorted by name."""
        found: dict[str, float | str] = {}
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

    def value(self, setting: Setting, node: ast.Expr) -> float | str | None:
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
        try:
            value = self.elaborator.constant(node, self.env)
        except Stop:
            return None
        if not setting.accepts(value):
            message = f"`{setting.name}` must be {setting.valid_range}, not {value:g}"
            self.problem("setting", message, node.span)
            return None
        return value

    # Audiences.

    def audience(self, name: ast.Name, arguments: tuple[ast.Argument, ...]) -> tuple[Observer, ...]:
        """The simulated viewers of `audience NAME(...)`."""
        if name.id == "bayesian":
            return (self.observer(arguments),)
        if name.id == "average":
            example = "write `average(bayesian(beta = 1), bayesian(beta = 2))`"
            found: list[Observer] = []
            for argument in arguments:
                inner = argument.value
                if isinstance(inner, ast.Call) and argument.name is None:
                    found.extend(self.audience(inner.callee, inner.arguments))
                elif isinstance(inner, ast.Name) and argument.name is None:
                    found.extend(self.audience(inner, ()))
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

    def observer(self, arguments: tuple[ast.Argument, ...]) -> Observer:
        world = self.elaborator.world.settings
        known = {k: s for k, s in world.items() if k in OBSERVER_SETTINGS}
        known["prior"] = Setting("prior", 1.0, "the weight of each hypothesis")
        priors = [a for a in arguments if a.name is not None and a.name.id == "prior"]
        for extra in priors[1:]:
            note = Note("the first one", priors[0].span)
            self.problem("duplicate", "`prior` is given twice", extra.span, None, note)
        others = tuple(a for a in arguments if a not in priors)
        settings = self.read(others, known, "audience bayesian")
        return Observer(settings, self.prior(priors[0].value) if priors else None)

    def prior(self, node: ast.Expr) -> tuple[float, ...] | None:
        """The weights of the hypotheses, summing to one."""
        try:
            value = self.elaborator.number(node, replace(self.env, inside="quantity"))
        except Stop:
            return None
        weights: list[float | None] = []
        if is_pure(value) and not value.axes.time:
            rows = self.elaborator.world.hypotheses
            weights = [evaluate(value, None, row) for row in rows]
        if not weights or any(w is None or not w >= 0 for w in weights) or not any(weights):
            message = "a prior is a number for each hypothesis, at least 0 and not 0 everywhere"
            hint = "for instance `prior = if rho > 0 then 2 else 1`"
            self.problem("audience", message, node.span, hint)
            return None
        numbers = [float(w) for w in weights if w is not None]
        return tuple(w / sum(numbers) for w in numbers)

    # Searches.

    def search(self, statement: ast.Search | None) -> SearchPlan:
        """The plan of `search NAME(...)`, or the world's usual one."""
        enumerable = self.elaborator.world.enumerable
        if statement is None:
            return SearchPlan() if enumerable else SearchPlan("descend")
        name = statement.name.id
        if name not in SEARCHES:
            hint = did_you_mean(name, SEARCHES)
            self.problem("search", f"there is no search `{name}`", statement.name.span, hint)
        elif name == "descend" and enumerable:
            message = "`descend` needs continuous actions; this world's can be listed"
            self.problem("search", message, statement.name.span, "use `beam`")
        else:
            known = BEAM_SETTINGS if name == "beam" else {}
            values = dict(self.read(statement.settings, known, f"search {name}"))
            return SearchPlan(name, **{k: int(v) for k, v in values.items()})
        return SearchPlan()
