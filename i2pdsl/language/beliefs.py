"""What viewers believe: probabilities, expectations, and the other forms with a bar."""

from __future__ import annotations

from dataclasses import replace

from i2pdsl.errors import closest, shorten
from i2pdsl.language import ast
from i2pdsl.language import typed as ty
from i2pdsl.language.elaboration import INSIDE, KINDS, Item, Stop
from i2pdsl.language.evaluate import NotFiniteError, finite_values, fold_hypotheses, is_pure
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

    def refuse_without_script(
        self,
        what: str,
        node: ast.Node,
        operand: ast.Expr,
        given: tuple[ast.Expr, ...],
        env: Env,
        form: str,
    ) -> None:
        """`P(rho > 0)` has no script, `P(script[:t])` says nothing about anything."""
        if given:
            return
        missing = f"{what} without a script"
        if self.is_script(operand, env):
            missing = f"{what} of what? only the script is given"
        raise self.fail("no-script", missing, node.span, env, f"write `{form}`")

    def on_probability(self, node: ast.Probability, env: Env) -> Item:
        form = "P(EVENT | script[:t])"
        self.refuse_without_script("a probability", node, node.event, node.given, env, form)
        latent = self.latent_named(node.event, env)
        if latent is not None and latent.kind != "truth":
            if not self.query:
                message = f"this is a distribution over the values of `{latent.name}`, not a number"
                hint = f"ask for an event: `{latent.name} = {show_value(latent.values[0])}`"
                raise self.blame("distribution", message, node.event, env, hint)
            given = self.given(node.given, node, env, form)
            return Item("symbol", ty.Distribution(self.partition(latent), given), latent)
        event, given = self.both(
            lambda: self.mask(node.event, env, "event"),
            lambda: self.given(node.given, node, env, form),
        )
        self.check_certain(event, given.mask, node, env)
        return Item("number", ty.Probability(event, given))

    def check_certain(self, event: ty.Mask, mask: ty.Mask, node: ast.Probability, env: Env) -> None:
        """Warns where a probability is 0 or 1 whatever happens."""
        under = {e for e, m in zip(event, mask, strict=True) if m}
        if len(under) > 1:
            return
        by_assumption = {e for e, m in zip(event, self.assumption, strict=True) if m}
        hint = None
        if len(by_assumption) == 1 and len(set(event)) > 1 and self.assumes_rationality:
            hint = _DROP
        message = f"this probability is always {int(under.pop())}, whatever happens"
        is_argument = isinstance(node.event, ast.Name) and node.event.id in env.names
        self.warn("certain", message, node.event if is_argument else node, env, hint)

    def on_expectation(self, node: ast.Expectation, env: Env) -> Item:
        form = "E[QUANTITY | script[:t]]"
        self.refuse_without_script("an expectation", node, node.quantity, node.given, env, form)

        def quantity() -> ty.Typed:
            if env.inside:
                return ty.Constant(0.0)  # `given` refuses a belief here
            return self.number(node.quantity, replace(env, inside="quantity"))

        value, given = self.both(quantity, lambda: self.given(node.given, node, env, form))
        mask = given.mask
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
            raise self.blame("impossible", message, node.quantity, env, hint)
        try:
            value = fold_hypotheses(value, self.world.hypotheses, mask)
        except NotFiniteError as problem:
            raise self.not_finite(problem, node.quantity, env) from None
        return Item("number", ty.Expectation(value, ty.Given(given.moment, mask)))

    def on_valueof(self, node: ast.ValueOf, env: Env) -> Item:
        if env.inside != "quantity":
            message = f"`{shorten(node.span.text)}` depends on what is hidden from the viewers"
            hint = "take the viewers' expectation: `E[V(who) | script[:t]]`"
            raise self.fail("value", message, node.span, env, hint)
        return Item("number", ty.ValueAt(self.character(node.who, env)))

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

    def on_divergence(self, node: ast.Divergence, env: Env) -> Item:
        form = "KL(script[:t-1] || script[:t])"
        if not node.given:
            message = "a divergence is between two beliefs, here is one script"
            raise self.fail("divergence", message, node.span, env, f"write `{form}`")
        conditions = node.given[1:]
        partition, (first, second) = self.both(
            lambda: self.optional_partition(node.latent, env),
            lambda: self.both(
                lambda: self.given((node.first, *conditions), node, env, form),
                lambda: self.given(node.given, node, env, form),
            ),
        )
        return Item("number", ty.Divergence(partition, first, second))

    def on_entropy(self, node: ast.Entropy, env: Env) -> Item:
        form = "entropy(LATENT | script[:t])"
        if node.latent is None and not any(self.is_script(g, env) for g in node.given):
            message = "an entropy without a script"
            raise self.fail("no-script", message, node.span, env, f"write `{form}`")
        partition, given = self.both(
            lambda: self.optional_partition(node.latent, env),
            lambda: self.given(node.given, node, env, form),
        )
        return Item("number", ty.Entropy(partition, given))

    def optional_partition(self, node: ast.Expr | None, env: Env) -> ty.Partition | None:
        """The partition by a latent; None for the whole hypothesis."""
        return None if node is None else self.partition(self.latent(node, env))

    def on_surprise(self, node: ast.Surprise, env: Env) -> Item:
        given = self.given((node.frame,), node, env, "surprise(script[t])", "frame")
        return Item("number", ty.Surprise(given))

    def on_suspense(self, node: ast.Suspense, env: Env) -> Item:
        form = "suspense(LATENT | script[:t])"
        self.refuse_without_script("suspense", node, node.latent, node.given, env, form)
        if not self.world.enumerable:
            message = "suspense looks one frame ahead, which needs actions that can be listed"
            raise self.fail("world", message, node.span, env)
        partition, given = self.both(
            lambda: self.partition(self.latent(node.latent, env)),
            lambda: self.given(node.given, node, env, form),
        )
        return Item("number", ty.Suspense(partition, given))


def _both(a: ty.Mask, b: ty.Mask) -> ty.Mask:
    """The hypotheses that fulfil two conditions."""
    return tuple(x and y for x, y in zip(a, b, strict=True))
