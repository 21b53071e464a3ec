"""What viewers believe: probabilities, expectations, and the other forms with a bar."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import product
from typing import Any

from i2pdsl.errors import closest, shorten
from i2pdsl.language import ast
from i2pdsl.language import typed as ty
from i2pdsl.language.addends import addends, whose
from i2pdsl.language.elaboration import INSIDE, ITEMS_IN_WORDS, Item, Stop
from i2pdsl.language.evaluate import NotFiniteError, finite_values, fold_hypotheses, is_pure
from i2pdsl.language.forms import APART, HIDDEN, UNSURE, Form
from i2pdsl.language.frames import Frames
from i2pdsl.language.scope import Env
from i2pdsl.language.story import Audience, Observer
from i2pdsl.language.vocabulary import UNKNOWN, Latent, show_value

_SCRIPTS = ast.Prefix | ast.FrameOf | ast.Script | ast.Append
MOST_CELLS = 10_000  # of a table of several latents
MOST_POINTS = 1 << 16  # at which an expectation by factors looks in each frame
UNTHINKABLE = "some viewer gives all those that fulfil it a prior of 0"
KNOWS_BETTER = "it contradicts what this audience knows (its `given`)"
OTHERS = "others"
_DROP = "by default everyone is taken to be rational; `assume nothing` drops that"


class Beliefs(Frames):
    """Posterior beliefs, each conditioned on a script, on conditions, and on the assumption."""

    def mask(self, node: ast.Expr, env: Env, inside: str) -> ty.Mask:
        """An event or condition as one truth value for each hypothesis."""
        value = self.truth(node, replace(env, inside=inside, times=None, reached=None))
        if not is_pure(value):
            message = "an event speaks of latents only"
            hint = "beliefs and frames cannot stand inside an event"
            raise self.blame("event", message, node, env, hint)
        try:
            return tuple(map(bool, finite_values(value, self.world.hypotheses)))
        except NotFiniteError as problem:
            raise self.not_finite(problem, node, env) from None

    def is_script(self, node: ast.Expr, env: Env) -> bool:
        """Whether an expression is a script, its first frames or one of them."""
        return isinstance(self.strip(node, env)[0], _SCRIPTS)

    def given(
        self,
        parts: tuple[ast.Expr, ...],
        node: ast.Node,
        env: Env,
        form: str,
        audience: Audience,
        kind: str = "prefix",
    ) -> ty.Given:
        """The script and the conditions behind the bar, with the assumption."""
        if env.inside:
            message = f"a belief cannot stand inside {INSIDE.get(env.inside, 'this')}"
            raise self.fail("event", message, node.span, env)
        moments: list[ty.Moment] = []
        masks: list[tuple[ty.Mask, ast.Expr]] = []

        def read(part: ast.Expr) -> None:
            if self.is_script(part, env):
                moments.append(self.conditioning(part, env, form, kind))
            else:
                masks.append((self.mask(part, env, "condition"), part))

        self.each([lambda p=p: read(p) for p in parts])  # type: ignore[misc]
        if len(moments) != 1:
            what = "without a script" if not moments else "with two scripts"
            raise self.fail("no-script", f"a belief {what}", node.span, env, f"write `{form}`")
        mask = self.assumption
        for condition, place in masks:
            mask = _both(mask, condition)
            if not audience.can_hold(mask):
                raise self.impossible(condition, mask, place, env, audience)
        return ty.Given(moments[0], mask)

    def conditioning(self, node: ast.Expr, env: Env, form: str, kind: str) -> ty.Moment:
        item = self.item(node, env)
        if item.kind == kind:
            return item.value
        message = f"expected {ITEMS_IN_WORDS[kind]}, found {ITEMS_IN_WORDS[item.kind]}"
        raise self.blame("type", message, node, env, f"write `{form}`")

    def impossible(
        self, mask: ty.Mask, given: ty.Mask, node: ast.Expr, env: Env, audience: Audience
    ) -> Stop:
        """`mask` is the condition alone, `given` together with all that stands before it."""
        hint = None
        if any(given):
            hint = KNOWS_BETTER if not any(audience.open_to(given)) else UNTHINKABLE
        elif any(mask):
            hint = "it is impossible together with the conditions before it and the assumption"
            if not any(_both(mask, self.assumption)):
                hint = _DROP if self.assumes_rationality else "the assumption excludes it"
        return self.blame("impossible", "no hypothesis fulfils this condition", node, env, hint)

    @property
    def assumes_rationality(self) -> bool:
        """Whether the assumption is the default one, that every character is rational."""
        return self.assumption == self.rational_rows(*self.world.rational.values())

    def rational_rows(self, *latents: str) -> ty.Mask:
        return tuple(all(row.get(x) for x in latents) for row in self.world.hypotheses)

    def on_form(self, node: ast.Form, env: Env) -> Item:
        """A form about beliefs, by what the table says of it."""
        form = node.kind
        if form.shape is HIDDEN:
            return self.hidden_value(node, env)
        self.refuse_without_script(form, node, env)
        audience = self.audience(node.audience, env)
        if self.world.counts:
            self.refuse_where_sampled(form, node, env, audience)
        if form.looks_ahead and not self.world.enumerable:
            message = f"{form.looks_ahead}, which needs actions that can be listed"
            raise self.fail("world", message, node.span, env)
        if self.is_tabulated(form, node, env):
            return self.table(form, node, env, audience)
        about, (givens, moment) = self.both(
            lambda: self.about(form, node, env), lambda: self.conditions(form, node, env, audience)
        )
        if form.about == "event":
            self.check_certain(about, audience.open_to(givens[0].mask), node, env)
        elif form.about == "quantity":
            about, mask = self.expected(about, givens[0].mask, node.about[0], env, audience)
            givens = (ty.Given(givens[0].moment, mask),)
        # To who forgets nothing what is so was so, but for what may be hoped for in a state. Others
        # are not asked there.
        if self.world.counts and not (form.about == "quantity" and whose(about)):
            moment = None
        value = ty.Belief(form.name, about, givens, (), self.viewers(audience), moment)
        self.check_whole_frame(form, value, node, env)
        return Item("number", value)

    def refuse_where_sampled(
        self, form: Form, node: ast.Form, env: Env, audience: Audience
    ) -> None:
        """What needs every hypothesis cannot be asked where there are too many of them; but who
        holds factors can be asked about everything."""
        message, forget = "", not all(map(_forgets_nothing, audience.observers))
        hint = "ask about latents after the given frames: `entropy(LATENT | script[:t])`"
        if node.moment is not None and forget:
            message = "hindsight looks back at every hypothesis"
            hint = "to viewers who forget nothing what is so was so: `bayesian(forgetting = 0)`"
        elif not node.about and form.about == "latent" and any(map(_samples, audience.observers)):
            message = f"`{form.name}` of everything is about every hypothesis"
        if message:
            message = f"{message}: there are too many hypotheses {self.world.where} to be listed"
            raise self.fail("particles", message, node.span, env, hint)

    def viewers(self, audience: Audience) -> ty.Viewers | None:
        """The observers of an audience; None where there is no other."""
        return audience.viewers if len(self.audiences) > 1 else None

    def check_whole_frame(self, form: Form, value: ty.Belief, node: ast.Form, env: Env) -> None:
        """What asks for the state after the given frames cannot be asked in the midst of one."""
        whole = all(given.moment.seen is None for given in value.given)
        if whole or (value.moment is not None and not self.world.counts):
            return
        values = bool(whose(value))
        every = bool(self.world.counts) and form.about == "latent" and value.about is None
        if form.looks_ahead or values or every:
            what = "`V`" if values else f"`{form.name}`"
            what += " of everything" if every else ""
            message = f"{what} needs the end of a frame, here someone has yet to act"
            hint = "leave out who acted last: `script[:t]`"
            raise self.fail("index", message, node.span, env, hint)

    def refuse_without_script(self, form: Form, node: ast.Form, env: Env) -> None:
        """`P(rho > 0)` has no script, `P(script[:t])` says nothing about anything."""
        missing = f"{form.called} without a script"
        if form.shape is APART:
            if len(node.given) > 1:
                return
            message = f"{form.called} is between two beliefs, here is one script"
            raise self.fail("divergence", message, node.span, env, _write(form))
        if form.shape is UNSURE:
            if node.about or any(self.is_script(g, env) for g in node.given):
                return
        elif node.given:
            return
        elif self.is_script(node.about[0], env):
            missing = f"{form.called} of what? only the script is given"
        raise self.fail("no-script", missing, node.span, env, _write(form))

    def is_tabulated(self, form: Form, node: ast.Form, env: Env) -> bool:
        """Whether a form makes a table: of a latent or several, or of a character's actions."""
        if len(node.about) > 1 and not (form.tabulates and form.about == "event"):
            message = f"`{form.name}` is about one {form.about}"
            hint = _write(form)
            raise self.fail("arguments", message, node.about[1].span, env, hint)
        if not form.tabulates or form.is_table or len(node.about) > 1:
            return form.tabulates
        latent = self.latent_named(node.about[0], env)
        return latent is not None and latent.kind != "truth"

    def table(self, form: Form, node: ast.Form, env: Env, audience: Audience) -> Item:
        """A form that is a table of probabilities, for queries only."""
        about, labels, latents = self.axes(form, node, env)
        if not self.query:
            over = "actions" if form.is_table else "values"
            told = " and ".join(f"`{axis.name}`" for axis in labels)
            message = f"this is a distribution over the {over} of {told}, not a number"
            hint = "only a query can ask for it"
            if latents:
                events = (f"{x.name} = {show_value(x.values[0])}" for x in latents)
                hint = f"ask for an event: `{' and '.join(events)}`"
            raise self.blame("distribution", message, node.about[0], env, hint)
        givens, moment = self.conditions(form, node, env, audience)
        moment = None if self.world.counts else moment  # as in `on_form`
        value = ty.Belief(form.name, about, givens, labels, self.viewers(audience), moment)
        self.check_whole_frame(form, value, node, env)
        if len(latents) == 1:
            return Item("symbol", value, latents[0])
        return Item("table", value)

    def axes(
        self, form: Form, node: ast.Form, env: Env
    ) -> tuple[Any, tuple[ty.Labels, ...], list[Latent]]:
        """What a table is about, its axes, and their latents if it is about any."""
        if form.is_table:
            who = self.character(node.about[0], env)
            return who, (ty.Labels(self.world.characters[who], self.world.actions),), []
        latents = self.each([lambda n=n: self.joint(n, env) for n in node.about])  # type: ignore[misc]
        for number, latent in enumerate(latents):
            if latent in latents[:number]:
                place = node.about[number]
                raise self.blame("duplicate", f"`{latent.name}` stands here twice", place, env)
        parts = [self.partition(latent) for latent in latents]
        cells = math.prod(len(part.labels) for part in parts)
        if cells > MOST_CELLS:
            message = f"a table of {cells:,} probabilities; the most is {MOST_CELLS:,}"
            raise self.fail("distribution", message, node.span, env, "ask about fewer latents")
        labels = tuple(ty.Labels(x.name, p.labels) for x, p in zip(latents, parts, strict=True))
        return _product(parts), labels, latents

    def joint(self, node: ast.Expr, env: Env) -> Latent:
        """One of the latents of a table."""
        if isinstance(self.strip(node, env)[0], ast.Name):
            return self.latent(node, env)
        hint = "events are joined by `and`: `P(A and B | script[:t])`"
        raise self.blame("latent", "expected the name of a latent", node, env, hint)

    def about(self, form: Form, node: ast.Form, env: Env) -> Any:
        """What a form is about: a mask, a partition, a quantity, or None for everything."""
        if not node.about:
            return None
        operand = node.about[0]
        if form.about == "event":
            return self.mask(operand, env, "event")
        if form.about == "latent":
            if isinstance(operand, ast.Call) and operand.callee.id == OTHERS:
                return self.others(operand, env)
            return self.partition(self.latent(operand, env))
        if env.inside:
            return ty.Constant(0.0)  # `given` refuses a belief here
        return self.number(operand, replace(env, inside="quantity"))

    def givens(
        self, form: Form, node: ast.Form, env: Env, audience: Audience
    ) -> tuple[ty.Given, ...]:
        """What a form is conditioned on: one script, or two."""
        kind = "frame" if form.asks_frame else "prefix"
        if form.shape is not APART:
            return (self.given(node.given, node, env, form.written, audience, kind),)
        first, second, *conditions = node.given
        return self.both(
            lambda: self.given((first, *conditions), node, env, form.written, audience),
            lambda: self.given((second, *conditions), node, env, form.written, audience),
        )

    def conditions(
        self, form: Form, node: ast.Form, env: Env, audience: Audience
    ) -> tuple[tuple[ty.Given, ...], ty.Moment | None]:
        """What a form is conditioned on, and the frame that it is asked of in hindsight."""
        givens, moment = self.both(
            lambda: self.givens(form, node, env, audience),
            lambda: self.hindsight(form, node, env),
        )
        if moment is not None and node.moment is not None:
            for turns in (given.moment.turns for given in givens):
                if any(a != b for a, b in zip(turns, moment.turns, strict=False)):
                    message = "this frame is of another script than the one that is given"
                    raise self.blame("index", message, node.moment, env)
        return givens, moment

    def hindsight(self, form: Form, node: ast.Form, env: Env) -> ty.Moment | None:
        """The frame behind the `@` of a form: 0 is the first picture."""
        if node.moment is None:
            return None
        if form.looks_ahead:
            message = f"{form.looks_ahead} from the last one that is given"
            hint = "leave out what begins with `@`"
            raise self.fail("index", message, node.moment.span, env, hint)
        stripped, inner = self.strip(node.moment, env)
        if isinstance(stripped, ast.FrameOf):
            return self.at(stripped.script, stripped.number, 0, inner)
        item = self.item(node.moment, env)
        message = f"expected a frame of a script, found {ITEMS_IN_WORDS[item.kind]}"
        number = node.moment.span.text if item.kind == "number" else "t"
        raise self.blame("type", message, node.moment, env, f"write `@ script[{number}]`")

    def check_certain(self, event: ty.Mask, mask: ty.Mask, node: ast.Form, env: Env) -> None:
        """Warns where a probability is 0 or 1 whatever happens."""
        under = {e for e, m in zip(event, mask, strict=True) if m}
        if len(under) != 1:  # of none there is an error, said where the viewers are known
            return
        by_assumption = {e for e, m in zip(event, self.assumption, strict=True) if m}
        hint = None
        if len(by_assumption) == 1 and len(set(event)) > 1 and self.assumes_rationality:
            hint = _DROP
        message = f"this probability is always {int(under.pop())}, whatever happens"
        operand = node.about[0]
        is_argument = isinstance(operand, ast.Name) and operand.id in env.names
        self.warn("certain", message, operand if is_argument else node, env, hint)

    def expected(
        self, value: ty.Typed, mask: ty.Mask, node: ast.Expr, env: Env, audience: Audience
    ) -> tuple[ty.Typed, ty.Mask]:
        """A quantity by hypotheses, and the mask of those of them under which it means anything."""
        for part in ty.walk(value):
            if isinstance(part, ty.ValueAt):
                rational = self.world.rational.get(self.world.characters[part.who])
                if rational is not None:
                    mask = _both(mask, self.rational_rows(rational))
            elif isinstance(part, ty.LatentValue):
                mask = _both(mask, tuple(part.latent in r for r in self.world.hypotheses))
        if not audience.can_hold(mask):
            message = "under these conditions no hypothesis gives this quantity a value"
            hint = UNTHINKABLE if any(mask) else None
            raise self.blame("impossible", message, node, env, hint)
        if not all(map(_samples, audience.observers)):
            self.check_points(value, node, env)
        try:
            return fold_hypotheses(value, self.world.hypotheses, mask), mask
        except NotFiniteError as problem:
            raise self.not_finite(problem, node, env) from None

    def check_points(self, value: ty.Typed, node: ast.Expr, env: Env) -> None:
        """Who holds factors tells all apart that those may have in mind whose values he is asked
        about together."""
        sizes = self.world.factor_sizes
        if sizes is None:
            return
        of = {who: self.factor_of(who) for who in whose(value)}
        points = max(sizes.points({of[who] for who in each}) for each in addends(value))
        if points > MOST_POINTS:
            message = f"this asks about {points:,} ways how those whose values it is about may be"
            message += f"; the most is {MOST_POINTS:,}"
            hint = "multiply the values of fewer of them, or let the story ask about fewer latents"
            raise self.blame("too-large", message, node, env, hint)

    def factor_of(self, who: int) -> int | None:
        """The factor of a character's own; None where it is that of all whom others model."""
        latent = self.world.rational[self.world.characters[who]]
        number = next(i for i, part in enumerate(self.world.factors) if latent in part)
        return number - 1 if number else None

    def hidden_value(self, node: ast.Form, env: Env) -> Item:
        if env.inside != "quantity":
            message = f"`{shorten(node.span.text)}` depends on what is hidden from the viewers"
            hint = "take the viewers' expectation: `E[V(who) | script[:t]]`"
            raise self.fail("value", message, node.span, env, hint)
        return Item("number", ty.ValueAt(self.character(node.about[0], env)))

    def partition(self, latent: Latent) -> ty.Partition:
        """Which value of the latent each hypothesis has; the last label is `unknown`."""
        order = {value: i for i, value in enumerate(latent.values)}
        nothing = len(order)
        index = tuple(
            order[row[latent.name]] if latent.name in row else nothing
            for row in self.world.hypotheses
        )
        return ty.Partition((*(show_value(v) for v in latent.values), UNKNOWN), index)

    def others(self, node: ast.Call, env: Env) -> ty.Partition:
        """`others(event, ...)`: all latents together but those that the events are about."""
        self.check_arity(node, env)
        told = [argument.comparison or argument.value for argument in node.arguments]
        events = self.each([lambda n=n: self.mask(n, env, "event") for n in told])  # type: ignore[misc]
        about = {latent for event in events for latent in self.latents_of(event)}
        parts = [self.partition(x) for x in self.world.latents.values() if x.name not in about]
        values = [
            ", ".join(part.labels[i] for part, i in zip(parts, row, strict=True))
            for row in zip(*(part.index for part in parts), strict=True)
        ] or [""] * len(self.world.hypotheses)  # nothing else is hidden here
        labels = tuple(dict.fromkeys(values))
        return ty.Partition(labels, tuple(map(labels.index, values)))

    def latents_of(self, event: ty.Mask) -> list[str]:
        """The latents that an event is about: the fewest by whose values it can be told."""
        needed = list(self.world.latents)
        for latent in self.world.latents:
            fewer = [name for name in needed if name != latent]
            told: dict[tuple[Any, ...], set[bool]] = {}
            for row, holds in zip(self.world.hypotheses, event, strict=True):
                told.setdefault(tuple(map(row.get, fewer)), set()).add(holds)
            if all(len(found) == 1 for found in told.values()):
                needed = fewer
        return needed

    def latent(self, node: ast.Expr, env: Env) -> Latent:
        latent = self.latent_named(node, env)
        if latent is None:
            stripped, _ = self.strip(node, env)
            hint = "latents: " + ", ".join(self.world.latents)
            if isinstance(stripped, ast.Name) and stripped.id not in self.entities:
                close = closest(stripped.id, self.world.latents)
                hint = f"did you mean `{close}`?" if close else hint
            raise self.blame("latent", "expected the name of a latent", node, env, hint)
        return latent


def _forgets_nothing(observer: Observer) -> bool:
    """Whether an observer is told to forget nothing."""
    return dict(observer.settings).get("forgetting") == 0


def _samples(observer: Observer) -> bool:
    """Whether an observer holds particles."""
    return observer.particles is not None


def _write(form: Form) -> str:
    return f"write `{form.written}`"


def _product(parts: list[ty.Partition]) -> ty.Partition:
    """The partition by several latents together, the last of which changes fastest."""
    labels = tuple(map(", ".join, product(*(part.labels for part in parts))))
    index = [0] * len(parts[0].index)
    for part in parts:
        index = [i * len(part.labels) + j for i, j in zip(index, part.index, strict=True)]
    return ty.Partition(labels, tuple(index))


def _both(a: ty.Mask, b: ty.Mask) -> ty.Mask:
    """The hypotheses that fulfil two conditions."""
    return tuple(x and y for x, y in zip(a, b, strict=True))
