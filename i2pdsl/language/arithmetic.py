"""Numbers: operators, functions, `if`, and comparisons of numbers and latents."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

from i2pdsl.errors import Span, closest
from i2pdsl.language import ast
from i2pdsl.language import typed as ty
from i2pdsl.language.builtins import FUNCTIONS
from i2pdsl.language.elaboration import BELIEVED, ITEMS_IN_WORDS, Elaboration, Item, Stop
from i2pdsl.language.evaluate import (
    COMPARISONS,
    OPERATIONS,
    NotFiniteError,
    evaluate,
    finite_values,
    fold_time,
    is_pure,
    may_be,
)
from i2pdsl.language.scope import Env
from i2pdsl.language.vocabulary import Latent, show_value

MOST_FACTORS = 400  # that are no constants, in one product


class Arithmetic(Elaboration):
    """Numbers and truth values."""

    def on_number(self, node: ast.Number, env: Env) -> Item:
        return Item("number", ty.Constant(node.value))

    def on_text(self, node: ast.Text, env: Env) -> Item:
        return Item("text", node.value)

    def on_time(self, node: ast.Time, env: Env) -> Item:
        if env.times is not None:
            return Item("number", ty.TimeIndex())
        if env.inside in ("event", "condition"):
            message = "an event cannot depend on `t`"
            hint = "choose between beliefs: `if t < 5 then P(...) else P(...)`"
            raise self.fail("time-in-event", message, node.span, env, hint)
        raise self.free_time("`t` means nothing outside a sum", node.span, env)

    def free_time(self, message: str, span: Span, env: Env) -> Stop:
        """Reports the first use of t outside a sum; the others have the same cause."""
        if self.time_missed:
            return Stop()
        self.time_missed = True
        hint = "put `sum_t` before the expression"
        if env.after_sum:
            message += ", and the sum ends before this term"
            hint = "put all that is summed in parentheses: `sum_t (A + B)`"
        return self.fail("free-time", message, span, env, hint)

    def on_length(self, node: ast.Length, env: Env) -> Item:
        return Item("number", ty.Constant(float(self.length)))

    def on_setof(self, node: ast.SetOf, env: Env) -> Item:
        message = "a set of values stands only after `in`, or as a setting"
        raise self.blame("type", message, node, env, "write `x in {a, b}`")

    def on_shares(self, node: ast.Shares, env: Env) -> Item:
        message = "weights of a latent's values are a `prior` of viewers"
        hint = "write `audience bayesian(prior(LATENT) = {VALUE: WEIGHT, others: WEIGHT})`"
        raise self.blame("type", message, node, env, hint)

    def on_pair(self, node: ast.Pair, env: Env) -> Item:
        first, second = self.both(
            lambda: self.constant(node.first, env), lambda: self.constant(node.second, env)
        )
        return Item("pair", (first, second))

    def on_sum(self, node: ast.Sum, env: Env) -> Item:
        places, place = [], env
        for term in node.terms:
            places.append(place)
            if not place.after_sum and any(isinstance(x, ast.Reduction) for x in ast.walk(term)):
                place = replace(env, after_sum=True)
        terms = self.each(
            [lambda n=n, e=e: self.number(n, e) for n, e in zip(node.terms, places, strict=True)]  # type: ignore[misc]
        )
        signed = [
            t if sign > 0 else self.apply("negate", (t,), node, env)
            for sign, t in zip(node.signs, terms, strict=True)
        ]
        return Item("number", self.apply("add", tuple(signed), node, env))

    def on_product(self, node: ast.Product, env: Env) -> Item:
        factors = self.each([lambda n=n: self.number(n, env) for n in node.factors])  # type: ignore[misc]
        result = factors[0]
        for operator, factor in zip(node.operators, factors[1:], strict=True):
            name = "multiply" if operator == "*" else "divide"
            result = self.apply(name, (result, factor), node, env)
            if getattr(result, "height", 0) > MOST_FACTORS:
                message = f"a product of more than {MOST_FACTORS} factors"
                raise self.fail("nesting", message, node.span, env, "name parts of it with `let`")
        return Item("number", result)

    def on_negative(self, node: ast.Negative, env: Env) -> Item:
        operand = self.number(node.operand, env)
        return Item("number", self.apply("negate", (operand,), node, env))

    def on_power(self, node: ast.Power, env: Env) -> Item:
        base, exponent = self.both(
            lambda: self.number(node.base, env), lambda: self.number(node.exponent, env)
        )
        return Item("number", self.apply("power", (base, exponent), node, env))

    def apply(
        self, operation: str, arguments: tuple[ty.Typed, ...], node: ast.Node, env: Env
    ) -> ty.Typed:
        """An operation on numbers; constants are computed at once."""
        constants = [a.value for a in arguments if isinstance(a, ty.Constant)]
        if len(constants) < len(arguments):
            result = ty.Apply(operation, arguments)
            self.places[id(result)] = (result, node.span, env)
            return result
        try:
            value = float(OPERATIONS[operation](*constants))
        except (ArithmeticError, ValueError):
            value = math.nan
        if not math.isfinite(value):
            if env.is_dead:
                return ty.Constant(0.0)
            raise self.fail("arithmetic", _not_finite(operation, constants), node.span, env)
        return ty.Constant(value)

    def folded(self, value: ty.Typed, times: range, node: ast.Node, env: Env) -> ty.Typed:
        """An expression with its functions of t as tables."""
        try:
            return fold_time(value, times, env.reached)
        except NotFiniteError as problem:
            raise self.not_finite(problem, node, env) from None

    def not_finite(self, problem: NotFiniteError, node: ast.Node, env: Env) -> Stop:
        """Reports an operation that has no value at some t, or under some hypothesis, at the place
        of the operation."""
        part, point = problem.node, problem.point
        _, span, env = self.places.get(id(part), (None, node.span, env))
        values: list[float] = []
        if isinstance(part, ty.Apply):
            values = [float(evaluate(a, point)) for a in part.arguments]
        operation = part.operation if isinstance(part, ty.Apply) else ""
        if isinstance(point, int):
            message = f"{_not_finite(operation, values)} at t = {point}"
            hint = f"leave that frame out: `if t != {point} then ... else 0`"
        else:
            latents = {n.latent for n in ty.walk(part) if isinstance(n, ty.LatentValue)}
            told = [f"{x} = {show_value(point[x])}" for x in sorted(latents)]
            message = f"{_not_finite(operation, values)} where {' and '.join(told)}"
            hint = f"leave that out: `if {' and '.join(told)} then 0 else ...`"
        return self.fail("arithmetic", message, span, env, hint)

    # Functions.

    def function(self, node: ast.Call, env: Env) -> Item:
        function = FUNCTIONS[node.callee.id]
        self.check_arity(node, env)
        if function.gives != "number":
            message = f"`{function.name}` stands for latents, it is no number"
            raise self.blame("type", message, node, env, f"write `{function.example}`")
        values = self.each([lambda a=a: self.number(a.value, env) for a in node.arguments])  # type: ignore[misc]
        return Item("number", self.apply(function.name, tuple(values), node, env))

    def check_arity(self, node: ast.Call, env: Env) -> None:
        """Refuses too few, too many and named arguments of a function."""
        function = FUNCTIONS[node.callee.id]
        low, high = function.arity
        if not low <= len(node.arguments) <= high:
            count = f"{low}" if low == high else f"at least {low}"
            message = f"`{function.name}` takes {count} argument{'s' if low != 1 else ''}"
            raise self.fail("arguments", message, node.span, env, f"write `{function.signature}`")
        for number, argument in enumerate(node.arguments):
            is_event = function.argument(number) == "event" and argument.comparison is not None
            if argument.name is not None and not is_event:
                message = f"`{function.name}` has no parameter `{argument.name.id}`"
                hint = f"write `{function.signature}`"
                raise self.fail("arguments", message, argument.span, env, hint)

    def points(self, node: ast.Call, env: Env) -> Item:
        if env.times is None:
            raise self.free_time("`points` draws a curve over t, outside a sum", node.span, env)
        shape = "write `points((0, 0), (0.3, 1), (1, -1))`, pairs of t/T and height"
        items = self.each([lambda a=a: self.item(a.value, env) for a in node.arguments])  # type: ignore[misc]
        for item, argument in zip(items, node.arguments, strict=True):
            if item.kind != "pair":
                message = f"expected a point of the curve, found {ITEMS_IN_WORDS[item.kind]}"
                raise self.blame("arguments", message, argument.value, env, shape)
        xs, ys = tuple(i.value[0] for i in items), tuple(i.value[1] for i in items)
        if len(xs) < 2:
            raise self.fail("arguments", "a curve needs two points or more", node.span, env, shape)
        if any(b <= a for a, b in pairwise(xs)):
            message = "the points of a curve go from left to right"
            raise self.fail("arguments", message, node.span, env, shape)
        share = ty.Apply("divide", (ty.TimeIndex(), ty.Constant(float(self.length))))
        return Item("number", ty.Points(xs, ys, share))

    # Conditions.

    def on_not(self, node: ast.Not, env: Env) -> Item:
        return Item("truth", ty.Apply("not", (self.truth(node.operand, env),)))

    def on_and(self, node: ast.And, env: Env) -> Item:
        parts = self.each([lambda n=n: self.truth(n, env) for n in node.operands])  # type: ignore[misc]
        return Item("truth", ty.Apply("and", tuple(parts)))

    def on_or(self, node: ast.Or, env: Env) -> Item:
        parts = self.each([lambda n=n: self.truth(n, env) for n in node.operands])  # type: ignore[misc]
        return Item("truth", ty.Apply("or", tuple(parts)))

    def on_if(self, node: ast.If, env: Env) -> Item:
        """`if`: indices and divisions must be sound only at the t that reach their branch."""
        condition = self.truth(node.condition, env)
        then, otherwise = self.both(
            lambda: self.item(node.then, self.reaching(condition, True, node, env)),
            lambda: self.item(node.otherwise, self.reaching(condition, False, node, env)),
        )
        for item, place in ((then, node.then), (otherwise, node.otherwise)):
            if item.kind not in ("number", "truth"):
                raise self.wrong_kind("a number or a condition", item, place, env)
        if then.kind != otherwise.kind:
            one, other = ITEMS_IN_WORDS[then.kind], ITEMS_IN_WORDS[otherwise.kind]
            message = f"one branch is {one}, the other {other}"
            raise self.fail("type", message, node.otherwise.span, env)
        if is_pure(condition) and condition.axes == ty.NO_AXES:
            return then if evaluate(condition) else otherwise
        return Item(then.kind, ty.Apply("choose", (condition, then.value, otherwise.value)))

    def reaching(self, condition: ty.Typed, wanted: bool, node: ast.If, env: Env) -> Env:
        """The surroundings of a branch: the t at which the condition may be `wanted`."""
        if env.times is None and not (is_pure(condition) and condition.axes == ty.NO_AXES):
            return env
        ts = env.ts if env.times is not None else (0,)
        try:
            return replace(env, reached=may_be(condition, ts, wanted))
        except (ArithmeticError, ValueError):
            raise self.condition_fails(condition, ts, node.condition, env) from None

    def condition_fails(
        self, condition: ty.Typed, ts: Sequence[int], node: ast.Expr, env: Env
    ) -> Stop:
        """Reports where a condition has no value."""
        for part in ty.walk(condition):
            if is_pure(part) and isinstance(part, ty.Apply):
                try:
                    finite_values(part, ts)
                except NotFiniteError as problem:
                    return self.not_finite(problem, node, env)
        return self.fail("arithmetic", "this condition has no value", node.span, env)

    # Comparisons.

    def on_compare(self, node: ast.Compare, env: Env) -> Item:
        chain = list(zip(node.operators, pairwise(node.operands), strict=True))
        parts = self.each([lambda o=o, p=p: self.compare(o, p[0], p[1], env) for o, p in chain])  # type: ignore[misc]
        value = parts[0] if len(parts) == 1 else ty.Apply("and", tuple(parts))
        return Item("truth", value)

    def on_member(self, node: ast.Member, env: Env) -> Item:
        parts = self.each(
            [lambda i=i: self.compare("=", node.item, i, env) for i in node.items.items]  # type: ignore[misc]
        )
        parts = list(dict.fromkeys(parts))
        return Item("truth", parts[0] if len(parts) == 1 else ty.Apply("or", tuple(parts)))

    def compare(self, operator: str, left: ast.Expr, right: ast.Expr, env: Env) -> ty.Typed:
        first, second = self.symbol_latent(left, env), self.symbol_latent(right, env)
        name = COMPARISONS[operator][0]
        # A `let` that stands for a latent may have the name of a value of the one beside it.
        if first is not None and second is not None:
            if self.is_value_of(first, right, env):
                second = None
            elif self.is_value_of(second, left, env):
                first = None
        if first is None and second is None:
            return self.compare_numbers(operator, left, right, env)
        for latent, place in ((first, left), (second, right)):
            if latent is not None and latent.kind == "truth":
                message = f"`{latent.name}` is true or false by itself"
                hint = f"write `{latent.name}` or `not {latent.name}`"
                raise self.blame("compare", message, place, env, hint)
        if operator not in ("=", "!="):
            latent = first or second
            assert latent is not None
            message = f"the values of `{latent.name}` have no order, so `{operator}` says nothing"
            raise self.fail("compare", message, left.span.to(right.span), env, "use `=` or `!=`")
        if first is not None and second is not None:
            return ty.Apply(name, (ty.LatentValue(first.name), ty.LatentValue(second.name)))
        latent, other = (first, right) if first is not None else (second, left)
        assert latent is not None
        symbol = self.symbol(latent, other, env)
        return ty.Apply(name, (ty.LatentValue(latent.name), ty.Symbol(symbol)))

    def compare_numbers(self, operator: str, left: ast.Expr, right: ast.Expr, env: Env) -> ty.Typed:
        latents = self.latent_named(left, env), self.latent_named(right, env)
        if env.inside not in BELIEVED:
            for latent, place in zip(latents, (left, right), strict=True):
                if latent is not None:
                    raise self.outside_belief(latent, place, env)
        for latent, place, other in ((latents[0], right, left), (latents[1], left, right)):
            if self.is_value(place, env):
                if latent is not None:
                    self.symbol(latent, place, env)
                if self.is_unknown(other, env) and not self.is_value(other, env):
                    self.number(other, env)  # a misspelt latent, the value beside it is right
        values = self.both(lambda: self.number(left, env), lambda: self.number(right, env))
        self.check_number_value(operator, values[0], values[1], right, env)
        self.check_number_value(operator, values[1], values[0], left, env)
        return ty.Apply(COMPARISONS[operator][0], values)

    def is_value(self, node: ast.Expr, env: Env) -> bool:
        """Whether an expression is the name of some latent's value."""
        if not self.is_unknown(node, env):
            return False
        node, _ = self.strip(node, env)
        assert isinstance(node, ast.Name)
        return any(node.id in x.values for x in self.world.latents.values())

    def is_value_of(self, latent: Latent, node: ast.Expr, env: Env) -> bool:
        """Whether an expression is the name of one of a latent's values."""
        stripped, _ = self.strip(node, env, latent.values)
        return isinstance(stripped, ast.Name) and stripped.id in latent.values

    def check_number_value(
        self, operator: str, value: ty.Typed, other: ty.Typed, place: ast.Expr, env: Env
    ) -> None:
        if operator not in ("=", "!=") or not isinstance(value, ty.LatentValue):
            return
        latent = self.world.latents[value.latent]
        if isinstance(other, ty.Constant) and other.value not in latent.values:
            message = f"`{latent.name}` is never {show_value(other.value)}"
            raise self.blame("no-value", message, place, env, f"its values: {latent.domain}")

    def symbol_latent(self, node: ast.Expr, env: Env) -> Latent | None:
        latent = self.latent_named(node, env)
        if latent is None or latent.kind == "number":
            return None
        if env.inside not in BELIEVED:
            raise self.outside_belief(latent, node, env)
        return latent

    def symbol(self, latent: Latent, node: ast.Expr, env: Env) -> str:
        """The value of a latent that an expression names."""
        what = f"a value of `{latent.name}`"
        stripped, inner = self.strip(node, env, latent.values, what)
        if isinstance(stripped, ast.Name) and stripped.id in latent.values:
            return stripped.id
        hint = f"its values: {latent.domain}"
        if isinstance(stripped, ast.Name):
            close = closest(stripped.id, map(str, latent.values))
            hint = f"did you mean `{close}`? ({hint})" if close else hint
            message = f"`{latent.name}` is never `{stripped.id}`"
            raise self.fail("no-value", message, stripped.span, inner, hint)
        message = f"`{latent.name}` is compared with one of its values"
        raise self.blame("compare", message, node, env, hint)


def _not_finite(operation: str, values: list[Any]) -> str:
    """Why an operation has no finite value."""
    if operation == "divide" and values[1:] == [0.0]:
        return "a division by zero"
    if operation == "log" and values and values[0] <= 0:
        return f"the logarithm of {values[0]:g} does not exist"
    if operation == "sqrt" or (operation == "power" and values and values[0] < 0):
        return "the root of a negative number does not exist"
    return "this number is too large to be computed"
