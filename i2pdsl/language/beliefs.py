"""What viewers believe: probabilities, expectations, and the other forms with a bar."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from i2pdsl.errors import closest, shorten
from i2pdsl.language import ast
from i2pdsl.language import typed as ty
from i2pdsl.language.elaboration import INSIDE, KINDS, Item, Stop
from i2pdsl.language.evaluate import NotFiniteError, finite_values, fold_hypotheses, is_pure
from i2pdsl.language.forms import APART, HIDDEN, UNSURE, Form
from i2pdsl.language.frames import Frames
from i2pdsl.language.scope import Env
from i2pdsl.language.vocabulary import UNKNOWN, Latent, show_value

_SCRIPTS = ast.Prefix | ast.FrameOf | ast.Script | ast.Append
UNTHINKABLE = "some viewer gives all those that fulfil it a prior of 0"
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
        self, parts: tuple[ast.Expr, ...], node: ast.Node, env: Env, form: str, kind: str = "prefix"
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
            if not self.can_hold(mask):
                raise self.impossible(condition, mask, place, env)
        return ty.Given(moments[0], mask)

    def conditioning(self, node: ast.Expr, env: Env, form: str, kind: str) -> ty.Moment:
        item = self.item(node, env)
        if item.kind == kind:
            return item.value
        message = f"expected {KINDS[kind]}, found {KINDS[item.kind]}"
        raise self.blame("type", message, node, env, f"write `{form}`")

    def impossible(self, mask: ty.Mask, given: ty.Mask, node: ast.Expr, env: Env) -> Stop:
        """`mask` is the condition alone, `given` together with all that stands before it."""
        hint = None
        if any(given):
            hint = UNTHINKABLE
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
        if form.looks_ahead and not self.world.enumerable:
            message = f"{form.looks_ahead}, which needs actions that can be listed"
            raise self.fail("world", message, node.span, env)
        latent = self.tabulated(form, node, env)
        if latent is not None:
            partition = self.partition(latent)
            labels = ty.Labels(latent.name, partition.labels)
            (given,) = self.givens(form, node, env)
            return Item("symbol", ty.Belief(form.name, partition, (given,), labels), latent)
        about, givens = self.both(
            lambda: self.about(form, node, env), lambda: self.givens(form, node, env)
        )
        if form.about == "event":
            self.check_certain(about, givens[0].mask, node, env)
        elif form.about == "quantity":
            about, mask = self.expected(about, givens[0].mask, node.about[0], env)
            givens = (ty.Given(givens[0].moment, mask),)
        return Item("number", ty.Belief(form.name, about, givens))

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

    def tabulated(self, form: Form, node: ast.Form, env: Env) -> Latent | None:
        """The latent of whose values a form makes a table, where it stands in place of an event."""
        if not form.tabulates:
            return None
        latent = self.latent_named(node.about[0], env)
        if latent is None or latent.kind == "truth":
            return None
        if not self.query:
            message = f"this is a distribution over the values of `{latent.name}`, not a number"
            hint = f"ask for an event: `{latent.name} = {show_value(latent.values[0])}`"
            raise self.blame("distribution", message, node.about[0], env, hint)
        return latent

    def about(self, form: Form, node: ast.Form, env: Env) -> Any:
        """What a form is about: a mask, a partition, a quantity, or None for everything."""
        if not node.about:
            return None
        operand = node.about[0]
        if form.about == "event":
            return self.mask(operand, env, "event")
        if form.about == "latent":
            return self.partition(self.latent(operand, env))
        if env.inside:
            return ty.Constant(0.0)  # `given` refuses a belief here
        return self.number(operand, replace(env, inside="quantity"))

    def givens(self, form: Form, node: ast.Form, env: Env) -> tuple[ty.Given, ...]:
        """What a form is conditioned on: one script, or two."""
        kind = "frame" if form.asks_frame else "prefix"
        if form.shape is not APART:
            return (self.given(node.given, node, env, form.written, kind),)
        first, second, *conditions = node.given
        return self.both(
            lambda: self.given((first, *conditions), node, env, form.written),
            lambda: self.given((second, *conditions), node, env, form.written),
        )

    def check_certain(self, event: ty.Mask, mask: ty.Mask, node: ast.Form, env: Env) -> None:
        """Warns where a probability is 0 or 1 whatever happens."""
        under = {e for e, m in zip(event, mask, strict=True) if m}
        if len(under) > 1:
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
        self, value: ty.Typed, mask: ty.Mask, node: ast.Expr, env: Env
    ) -> tuple[ty.Typed, ty.Mask]:
        """A quantity by hypotheses, and the mask of those of them under which it means anything."""
        for part in ty.walk(value):
            if isinstance(part, ty.ValueAt):
                rational = self.world.rational.get(self.world.characters[part.who])
                if rational is not None:
                    mask = _both(mask, self.rational_rows(rational))
            elif isinstance(part, ty.LatentValue):
                mask = _both(mask, tuple(part.latent in r for r in self.world.hypotheses))
        if not self.can_hold(mask):
            message = "under these conditions no hypothesis gives this quantity a value"
            hint = UNTHINKABLE if any(mask) else None
            raise self.blame("impossible", message, node, env, hint)
        try:
            return fold_hypotheses(value, self.world.hypotheses, mask), mask
        except NotFiniteError as problem:
            raise self.not_finite(problem, node, env) from None

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


def _write(form: Form) -> str:
    return f"write `{form.written}`"


def _both(a: ty.Mask, b: ty.Mask) -> ty.Mask:
    """The hypotheses that fulfil two conditions."""
    return tuple(x and y for x, y in zip(a, b, strict=True))
