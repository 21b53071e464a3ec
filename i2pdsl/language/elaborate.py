"""From the syntax tree of an expression to its checked form (typed.py).

Patterns, lets and arguments are put in as expressions; names are resolved against the world's
vocabulary; events become masks over hypotheses. Every mistake is reported once and stops the
expression that holds it, while its neighbours are still checked.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any, NoReturn, TypeVar

from i2pdsl.errors import Diagnostic, Note, Span, did_you_mean
from i2pdsl.language import ast
from i2pdsl.language import typed as ty
from i2pdsl.language.builtins import FUNCTIONS
from i2pdsl.language.evaluate import (
    COMPARISONS,
    OPERATIONS,
    evaluate,
    fold_hypotheses,
    fold_time,
    is_pure,
)
from i2pdsl.language.scope import Bound, Env
from i2pdsl.language.statements import DEEPEST
from i2pdsl.language.vocabulary import Latent, Vocabulary, show_value

MOST_NODES = 50_000  # of an expression once all patterns are put in

A = TypeVar("A")


class Stop(Exception):
    """A mistake was reported; what depends on the expression cannot be checked."""


class LeavesAtZero(Exception):
    """An index leaves the script at t = 0: the query covers t = 1..T instead."""


@dataclass(frozen=True)
class Item:
    """What an expression turned out to be.

    `kind` is number, truth, symbol (of `latent`), script, prefix, frame, pair or text; `value`
    is a typed node, the appended turns, a Moment or a pair of numbers.
    """

    kind: str
    value: Any
    latent: Latent | None = None


_KINDS = {
    "number": "a number",
    "truth": "a condition",
    "symbol": "a latent",
    "script": "a script",
    "prefix": "the first frames of a script",
    "frame": "a frame of a script",
    "pair": "a pair",
    "text": "a text",
}


class Elaborator:
    """Checks expressions for one world, one length and one assumption."""

    def __init__(
        self,
        vocabulary: Vocabulary,
        length: int,
        report: Callable[[Diagnostic], None],
        query: bool = False,
    ):
        self.world = vocabulary
        self.length = length
        self.report = report
        self.query = query
        self.assumption: ty.Mask = (True,) * len(vocabulary.hypotheses)
        self.entities = (*vocabulary.characters, *vocabulary.things)
        self.depth = 0
        self.nodes = 0
        self.moment: ty.Moment | None = None  # the frame of the enclosing [... @ script[k]]
        self.certain: set[tuple[int, int]] = set()

    # Reporting.

    def fail(
        self, code: str, message: str, span: Span, env: Env, hint: str | None = None
    ) -> NoReturn:
        self.report(Diagnostic(code, message, span, hint, env.notes()))
        raise Stop

    def warn(self, code: str, message: str, span: Span, env: Env, hint: str | None = None) -> None:
        self.report(Diagnostic(code, message, span, hint, env.notes(), "warning"))

    def each(self, tasks: Sequence[Callable[[], A]]) -> list[A]:
        """Runs all tasks, so that all their mistakes are reported, then stops if one failed."""
        results: list[A] = []
        for task in tasks:
            try:
                results.append(task())
            except Stop:
                continue
        if len(results) < len(tasks):
            raise Stop
        return results

    @contextmanager
    def entering(self, node: ast.Node, env: Env) -> Iterator[None]:
        self.depth += 1
        self.nodes += 1
        try:
            if self.depth > DEEPEST + 20:
                self.fail("nesting", f"nested deeper than {DEEPEST}", node.span, env)
            if self.nodes > MOST_NODES:
                message = f"the patterns expand to more than {MOST_NODES:,} parts"
                self.fail("nesting", message, node.span, env)
            yield
        finally:
            self.depth -= 1

    # Wanted kinds.

    def number(self, node: ast.Expr, env: Env) -> ty.Typed:
        item = self.item(node, env)
        if item.kind == "number":
            return item.value  # type: ignore[no-any-return]
        self.wrong_kind("a number", item, node, env)

    def truth(self, node: ast.Expr, env: Env) -> ty.Typed:
        item = self.item(node, env)
        if item.kind == "truth" or isinstance(item.value, ty.Feature):
            return item.value  # type: ignore[no-any-return]
        self.wrong_kind("a condition", item, node, env)

    def wrong_kind(self, wanted: str, item: Item, node: ast.Expr, env: Env) -> NoReturn:
        found = _KINDS[item.kind]
        hint = None
        if item.latent is not None and item.kind == "symbol":
            found = f"the latent `{item.latent.name}`"
            hint = f"compare it: `{item.latent.name} = {show_value(item.latent.values[0])}`"
        elif item.kind == "truth" and wanted == "a number":
            hint = "write `if CONDITION then 1 else 0`, or `P(EVENT | script[:t])`"
        elif item.kind == "prefix":
            hint = "ask for a belief: `P(EVENT | script[:t])`"
        self.fail("type", f"{wanted} is expected here, this is {found}", node.span, env, hint)

    def constant(self, node: ast.Expr, env: Env) -> float:
        value = self.number(node, replace(env, times=None))
        if not isinstance(value, ty.Constant):
            self.fail("constant", "this must be a constant", node.span, env)
        return float(value.value)

    # Expressions.

    def item(self, node: ast.Expr, env: Env) -> Item:
        with self.entering(node, env):
            method = getattr(self, f"on_{type(node).__name__.lower()}")
            return method(node, env)  # type: ignore[no-any-return]

    def on_number(self, node: ast.Number, env: Env) -> Item:
        return Item("number", ty.Constant(node.value))

    def on_text(self, node: ast.Text, env: Env) -> Item:
        return Item("text", node.value)

    def on_time(self, node: ast.Time, env: Env) -> Item:
        if env.times is None:
            if env.inside in ("event", "condition"):
                message = "an event cannot depend on t"
                hint = "choose between beliefs: `if t < 5 then P(...) else P(...)`"
                self.fail("time-in-event", message, node.span, env, hint)
            hint = "put `sum_t` before the expression"
            self.fail("free-time", "`t` means nothing outside a sum", node.span, env, hint)
        return Item("number", ty.TimeIndex())

    def on_length(self, node: ast.Length, env: Env) -> Item:
        return Item("number", ty.Constant(float(self.length)))

    def on_script(self, node: ast.Script, env: Env) -> Item:
        return Item("script", ())

    def on_pair(self, node: ast.Pair, env: Env) -> Item:
        first, second = self.each(
            [lambda: self.constant(node.first, env), lambda: self.constant(node.second, env)]
        )
        return Item("pair", (first, second))

    def on_name(self, node: ast.Name, env: Env) -> Item:
        name = node.id
        if name in env.names:
            bound = env.names[name]
            return self.item(bound.expression, self.outside(bound.env, env))
        found = env.module.find(name)
        if found is not None:
            if isinstance(found.item, ast.Let):
                if name in self.world.latents:
                    message = f"`{name}` is a latent of the world, a `let` cannot have its name"
                    self.fail("shadow", message, found.item.name.span, env)
                inner = Env(found.module, uses=(*env.uses, (name, node.span)))
                self.check_recursion(name, node.span, env)
                return self.item(found.item.value, self.outside(inner, env))
            call = ast.Call(node.span, node, ())
            return self.call_pattern(found.item, found.module, call, env)
        if name in self.world.latents:
            latent = self.world.latents[name]
            kind = {"number": "number", "symbol": "symbol", "truth": "truth"}[latent.kind]
            if env.inside not in ("event", "condition", "quantity"):
                kind = "symbol"
            return Item(kind, ty.LatentValue(name), latent)
        if name == "pi":
            return Item("number", ty.Constant(math.pi))
        self.unknown_name(node, env)

    def outside(self, definition: Env, use: Env) -> Env:
        """The names of where an expression was written, the time of where it is put in."""
        return replace(
            definition,
            times=use.times,
            in_sum=use.in_sum,
            inside=use.inside,
            guarded=use.guarded,
        )

    def unknown_name(self, node: ast.Name, env: Env) -> NoReturn:
        name = node.id
        owners = [x for x in self.world.latents.values() if name in x.values]
        if owners:
            message = f"`{name}` is a value, it stands beside its latent"
            hint = " or ".join(f"`{x.name} = {name}`" for x in owners)
        elif name in self.entities:
            message = f"`{name}` is no quantity"
            hint = f"who wants what is a latent: {', '.join(self.world.latents)}"
        elif name in self.world.predicates:
            message = f"`{name}` is asked of a frame"
            hint = f"write `[{name}(...) @ script[t]]`"
        elif name in FUNCTIONS:
            message = f"`{name}` needs its arguments"
            hint = f"write `{FUNCTIONS[name].signature}`"
        else:
            message = f"unknown name `{name}`"
            hint = did_you_mean(name, self.known(env)) or ""
        self.fail("unknown-name", message, node.span, env, hint or None)

    def known(self, env: Env) -> set[str]:
        names = {*env.names, *env.module.known(), *self.world.latents, *FUNCTIONS, "pi"}
        return names | {"script"}

    def on_sum(self, node: ast.Sum, env: Env) -> Item:
        terms = self.each([lambda n=n: self.number(n, env) for n in node.terms])  # type: ignore[misc]
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
        return Item("number", result)

    def on_negative(self, node: ast.Negative, env: Env) -> Item:
        operand = self.number(node.operand, env)
        return Item("number", self.apply("negate", (operand,), node, env))

    def on_power(self, node: ast.Power, env: Env) -> Item:
        base, exponent = self.each(
            [lambda: self.number(node.base, env), lambda: self.number(node.exponent, env)]
        )
        return Item("number", self.apply("power", (base, exponent), node, env))

    def apply(
        self, operation: str, arguments: tuple[ty.Typed, ...], node: ast.Node, env: Env
    ) -> ty.Typed:
        """An operation on numbers; constants are computed at once."""
        if all(isinstance(a, ty.Constant) for a in arguments):
            values = [a.value for a in arguments]  # type: ignore[union-attr]
            try:
                value = float(OPERATIONS[operation](*values))
            except (ArithmeticError, ValueError):
                value = math.nan
            if not math.isfinite(value):
                self.fail("arithmetic", "this has no finite value", node.span, env)
            return ty.Constant(value)
        return ty.Apply(operation, arguments)

    def on_compare(self, node: ast.Compare, env: Env) -> Item:
        pairs = list(zip(node.operators, node.operands, node.operands[1:], strict=False))
        parts = self.each([lambda p=p: self.compare(*p, env) for p in pairs])  # type: ignore[misc]
        value = parts[0] if len(parts) == 1 else ty.Apply("and", tuple(parts))
        return Item("truth", value)

    def compare(self, operator: str, left: ast.Expr, right: ast.Expr, env: Env) -> ty.Typed:
        first, second = self.symbol_latent(left, env), self.symbol_latent(right, env)
        name = COMPARISONS[operator][0]
        if first is None and second is None:
            values = self.each(
                [lambda: self.comparable(left, env), lambda: self.comparable(right, env)]
            )
            for value, other, place in ((*values, right), (values[1], values[0], left)):
                self.check_number_value(operator, value, other, place, env)
            return ty.Apply(name, tuple(values))
        for latent, place in ((first, left), (second, right)):
            if latent is not None and latent.kind == "truth":
                message = f"`{latent.name}` is true or false by itself"
                hint = f"write `{latent.name}` or `not {latent.name}`"
                self.fail("compare", message, place.span, env, hint)
        if operator not in ("=", "!="):
            latent = first or second
            assert latent is not None
            message = f"`{latent.name}` has no order, `{operator}` means nothing for it"
            self.fail("compare", message, left.span.to(right.span), env, "use `=` or `!=`")
        if first is not None and second is not None:
            return ty.Apply(name, (ty.LatentValue(first.name), ty.LatentValue(second.name)))
        latent, other = (first, right) if first is not None else (second, left)
        assert latent is not None
        symbol = self.symbol(latent, other, env)
        return ty.Apply(name, (ty.LatentValue(latent.name), ty.Symbol(symbol)))

    def comparable(self, node: ast.Expr, env: Env) -> ty.Typed:
        """A number in a comparison; a numeric latent only where an event is expected."""
        name, inner = self.strip(node, env)
        if isinstance(name, ast.Name) and env.inside not in ("event", "condition", "quantity"):
            latent = self.latent_named(name, inner)
            if latent is not None:
                self.outside_belief(latent, name.span, inner)
        return self.number(node, env)

    def outside_belief(self, latent: Latent, span: Span, env: Env) -> NoReturn:
        message = f"`{latent.name}` is hidden from viewers"
        hint = f"ask what they believe: `P({latent.name} ... | script[:t])`"
        self.fail("hidden", message, span, env, hint)

    def check_number_value(
        self, operator: str, value: ty.Typed, other: ty.Typed, place: ast.Expr, env: Env
    ) -> None:
        if operator not in ("=", "!=") or not isinstance(value, ty.LatentValue):
            return
        latent = self.world.latents[value.latent]
        if isinstance(other, ty.Constant) and other.value not in latent.values:
            message = f"`{latent.name}` is never {show_value(other.value)}"
            self.fail("no-value", message, place.span, env, f"its values: {latent.domain}")

    def strip(self, node: ast.Expr, env: Env) -> tuple[ast.Expr, Env]:
        """Follows names to the expression that they stand for."""
        for _ in range(DEEPEST):
            if not isinstance(node, ast.Name):
                break
            if node.id in env.names:
                bound = env.names[node.id]
                node, env = bound.expression, self.outside(bound.env, env)
                continue
            found = env.module.find(node.id)
            if found is None or not isinstance(found.item, ast.Let):
                break
            node, env = found.item.value, self.outside(Env(found.module, uses=env.uses), env)
        return node, env

    def latent_named(self, node: ast.Expr, env: Env) -> Latent | None:
        """The latent that an expression names, if it is nothing but a latent's name."""
        node, env = self.strip(node, env)
        if isinstance(node, ast.Name) and env.module.find(node.id) is None:
            return self.world.latents.get(node.id)
        return None

    def symbol_latent(self, node: ast.Expr, env: Env) -> Latent | None:
        latent = self.latent_named(node, env)
        if latent is None or latent.kind == "number":
            return None
        if env.inside not in ("event", "condition", "quantity"):
            self.outside_belief(latent, node.span, env)
        return latent

    def symbol(self, latent: Latent, node: ast.Expr, env: Env) -> str:
        """The value of a latent that an expression names."""
        node, inner = self.strip(node, env)
        if isinstance(node, ast.Name) and node.id in latent.values:
            return node.id
        if isinstance(node, ast.Name):
            close = did_you_mean(node.id, latent.values)
            hint = f"its values: {latent.domain}"
            if close and "mean" in close:
                hint = f"{close} ({hint})"
            message = f"`{latent.name}` is never `{node.id}`"
            self.fail("no-value", message, node.span, inner, hint)
        message = f"`{latent.name}` is compared with one of its values"
        self.fail("compare", message, node.span, inner, f"its values: {latent.domain}")

    def on_member(self, node: ast.Member, env: Env) -> Item:
        parts = self.each(
            [lambda i=i: self.compare("=", node.item, i, env) for i in node.items.items]  # type: ignore[misc]
        )
        return Item("truth", ty.Apply("or", tuple(parts)))

    def on_not(self, node: ast.Not, env: Env) -> Item:
        return Item("truth", ty.Apply("not", (self.truth(node.operand, env),)))

    def on_and(self, node: ast.And, env: Env) -> Item:
        parts = self.each([lambda n=n: self.truth(n, env) for n in node.operands])  # type: ignore[misc]
        return Item("truth", ty.Apply("and", tuple(parts)))

    def on_or(self, node: ast.Or, env: Env) -> Item:
        parts = self.each([lambda n=n: self.truth(n, env) for n in node.operands])  # type: ignore[misc]
        return Item("truth", ty.Apply("or", tuple(parts)))

    def on_if(self, node: ast.If, env: Env) -> Item:
        condition = self.truth(node.condition, env)
        branch = replace(env, guarded=env.guarded or condition.axes.time)
        then, otherwise = self.each(
            [lambda: self.item(node.then, branch), lambda: self.item(node.otherwise, branch)]
        )
        for item, place in ((then, node.then), (otherwise, node.otherwise)):
            if item.kind not in ("number", "truth"):
                self.wrong_kind("a number or a condition", item, place, env)
        if then.kind != otherwise.kind:
            message = f"one branch is {_KINDS[then.kind]}, the other {_KINDS[otherwise.kind]}"
            self.fail("type", message, node.otherwise.span, env)
        return Item(then.kind, ty.Apply("choose", (condition, then.value, otherwise.value)))

    # Sums over t.

    def on_reduction(self, node: ast.Reduction, env: Env) -> Item:
        if env.in_sum:
            self.fail("nested-sum", "sums over t do not nest", node.span, env)
        if env.inside:
            message = "a sum over t cannot stand inside an event or a quantity"
            self.fail("nested-sum", message, node.span, env)
        first, last = 1, self.length
        if node.first is not None and node.last is not None:
            bounds = self.each(
                [lambda: self.constant(node.first, env), lambda: self.constant(node.last, env)]  # type: ignore[arg-type]
            )
            first, last = math.ceil(bounds[0]), math.floor(bounds[1])
            span = node.first.span.to(node.last.span)
            if first < 0:
                self.fail("range", "frames count from 1, the prior is 0", span, env)
            if first > last:
                self.fail("range", f"no frame lies in {first}..{last}", span, env)
            if last > self.length + 1000:
                message = f"the story has {self.length} frames, this goes to {last}"
                self.fail("range", message, span, env)
        times = range(first, last + 1)
        body = self.number(node.body, replace(env, times=times, in_sum=True, guarded=False))
        longest = self.length + max(
            (len(n.turns) for n in ty.walk(body) if isinstance(n, ty.Moment)), default=0
        )
        if last > longest:
            span = node.last.span if node.last is not None else node.span
            message = f"the script has {longest} frames, this goes to {last}"
            self.fail("range", message, span, env)
        return Item(
            "number", ty.Reduction(node.kind, first, last, self.folded(body, times, node, env))
        )

    def folded(self, body: ty.Typed, times: range, node: ast.Node, env: Env) -> ty.Typed:
        try:
            return fold_time(body, times)  # type: ignore[no-any-return]
        except (ArithmeticError, ValueError, OverflowError):
            self.fail("arithmetic", "this has no finite value at some t", node.span, env)

    # Scripts and their frames.

    def on_append(self, node: ast.Append, env: Env) -> Item:
        turns = self.script(node.script, env)
        return Item("script", (*turns, self.turn(node, env)))

    def script(self, node: ast.Expr, env: Env) -> tuple[ty.Turn, ...]:
        item = self.item(node, env)
        if item.kind != "script":
            hint = "put `script ++ [...]` in parentheses" if item.kind == "prefix" else None
            message = f"a script is expected here, this is {_KINDS[item.kind]}"
            self.fail("type", message, node.span, env, hint)
        return item.value  # type: ignore[no-any-return]

    def turn(self, node: ast.Append, env: Env) -> ty.Turn:
        falls = [m for m in node.turn if isinstance(m, ast.Fall)]
        if falls:
            if len(node.turn) > 1:
                self.fail("turn", "an event fills a whole frame", node.turn[1].span, env)
            return self.fall(falls[0], env)
        acts: dict[str, ty.Act] = {}
        for move in node.turn:
            assert isinstance(move, ast.Move)
            who = self.character(move.who, env)
            name = self.world.characters[who]
            if name in acts:
                self.fail("turn", f"`{name}` acts twice in this turn", move.span, env)
            acts[name] = self.act(move, name, env)
        missing = [c for c in self.world.characters if c not in acts]
        if missing:
            span = node.turn[0].span.to(node.turn[-1].span)
            message = f"the turn does not say what {' and '.join(missing)} does"
            self.fail("turn", message, span, env, f"add `{missing[0]}: stay`")
        return tuple(acts[c] for c in self.world.characters)

    def act(self, move: ast.Move, name: str, env: Env) -> ty.Act:
        action = move.action.id
        if action not in self.world.actions:
            hint = did_you_mean(action, self.world.actions)
            message = f"there is no action `{action}`"
            self.fail("no-action", message, move.action.span, env, hint)
        if move.fails and (name not in self.world.can_fail or action == "stay"):
            reason = "staying" if action == "stay" else f"a move of {name}"
            self.fail("turn", f"{reason} cannot fail", move.span, env, "leave out the `!`")
        return ty.Act(self.world.actions.index(action), move.fails)

    def fall(self, fall: ast.Fall, env: Env) -> ty.Drop:
        event, thing = fall.event.id, fall.thing.id
        if event not in self.world.events:
            hint = did_you_mean(event, self.world.events)
            self.fail("no-event", f"there is no event `{event}`", fall.event.span, env, hint)
        if thing not in self.world.events[event]:
            hint = did_you_mean(thing, self.world.events[event])
            message = f"`{event}` brings no `{thing}`"
            self.fail("no-event", message, fall.thing.span, env, hint)
        cells = self.place(fall.place, env)
        if len(cells) != 1:
            self.fail("no-place", "the place must be a single cell", fall.place.span, env)
        return ty.Drop(event, thing, cells[0])

    def on_prefix(self, node: ast.Prefix, env: Env) -> Item:
        return Item("prefix", self.at(node.script, node.end, 0, env))

    def on_frameof(self, node: ast.FrameOf, env: Env) -> Item:
        return Item("frame", self.at(node.script, node.number, 1, env))

    def at(self, script: ast.Expr, index: ast.Expr, lowest: int, env: Env) -> ty.Moment:
        """The moment that an index points to, for every t."""
        plain = replace(env, inside="")
        turns, value = self.each(
            [lambda: self.script(script, plain), lambda: self.number(index, plain)]
        )
        if not is_pure(value) or value.axes.hypothesis:
            message = "an index depends on t and constants only"
            self.fail("index", message, index.span, env)
        longest = self.length + len(turns)
        times = env.times if value.axes.time else None
        frames = []
        for t in times if times is not None else (None,):
            frames.append(self.frame_number(value, t, lowest, longest, index, env))
        return ty.Moment(turns, tuple(frames), times.start if times is not None else None)

    def frame_number(
        self, value: Any, t: int | None, lowest: int, longest: int, index: ast.Expr, env: Env
    ) -> int:
        try:
            exact = float(evaluate(value, t))
        except (ArithmeticError, ValueError):
            exact = math.nan
        where = "" if t is None else f" at t = {t}"
        if not math.isfinite(exact) or abs(exact - round(exact)) > 1e-9:
            message = f"an index is a whole number, this is {exact:g}{where}"
            self.fail("index", message, index.span, env)
        frame = round(exact)
        if frame < lowest and self.query and t == 0 and not env.in_sum:
            raise LeavesAtZero
        if (frame < lowest or frame > longest) and not env.guarded:
            kind = "frames count from 1" if lowest else "a prefix has at least 0 frames"
            message = f"this is {frame}{where}; {kind}"
            if frame > longest:
                message = f"the script has {longest} frames, this is {frame}{where}"
            hint = "sum over a range: `sum_{t in 1..T-1} ...`" if t is not None else None
            self.fail("index", message, index.span, env, hint)
        return frame

    def on_lastof(self, node: ast.LastOf, env: Env) -> Item:
        turns = self.script(node.script, env)
        return Item("number", ty.Constant(float(self.length + len(turns))))

    # Beliefs.

    def mask(self, node: ast.Expr, env: Env, inside: str) -> ty.Mask:
        """An event or condition as one truth value for each hypothesis."""
        value = self.truth(node, replace(env, inside=inside, times=None))
        if not is_pure(value):
            message = "an event speaks of latents only"
            hint = "beliefs and frames cannot stand inside an event"
            self.fail("event", message, node.span, env, hint)
        return tuple(bool(evaluate(value, None, row)) for row in self.world.hypotheses)

    def given(
        self, parts: tuple[ast.Expr, ...], node: ast.Node, env: Env, form: str, kind: str = "prefix"
    ) -> ty.Given:
        """The script and the conditions behind the bar, with the assumption."""
        if env.inside:
            message = f"a belief cannot stand inside {_INSIDE.get(env.inside, 'this')}"
            self.fail("event", message, node.span, env)
        moments: list[ty.Moment] = []
        masks: list[tuple[ty.Mask, ast.Expr]] = []

        def read(part: ast.Expr) -> None:
            stripped, inner = self.strip(part, env)
            if isinstance(stripped, ast.Prefix | ast.FrameOf | ast.Script | ast.Append):
                moments.append(self.conditioning(stripped, inner, form, kind))
            else:
                masks.append((self.mask(part, env, "condition"), part))

        self.each([lambda p=p: read(p) for p in parts])  # type: ignore[misc]
        if len(moments) != 1:
            what = "without a script" if not moments else "with two scripts"
            self.fail("no-script", f"a belief {what}", node.span, env, f"write `{form}`")
        mask = self.assumption
        for condition, place in masks:
            mask = _both(mask, condition)
            if not any(mask):
                self.impossible(condition, place, env)
        return ty.Given(moments[0], mask)

    def conditioning(self, node: ast.Expr, env: Env, form: str, kind: str) -> ty.Moment:
        item = self.item(node, replace(env, inside=""))
        if item.kind == kind:
            return item.value  # type: ignore[no-any-return]
        hint = f"write `{form}`"
        wanted = _KINDS[kind]
        self.fail(
            "type", f"{wanted} is expected here, this is {_KINDS[item.kind]}", node.span, env, hint
        )

    def impossible(self, mask: ty.Mask, node: ast.Expr, env: Env) -> NoReturn:
        hint = None
        if any(mask):
            hint = "the default assumption is that everyone is rational: `assume nothing` drops it"
        self.fail("impossible", "no hypothesis fulfils this condition", node.span, env, hint)

    def on_probability(self, node: ast.Probability, env: Env) -> Item:
        form = "P(EVENT | script[:t])"
        if not node.given:
            message = "a probability without a script"
            self.fail("no-script", message, node.span, env, f"write `{form}`")
        latent = self.latent_named(node.event, env)
        if latent is not None and latent.kind != "truth":
            if not self.query:
                message = f"this is a distribution over the values of `{latent.name}`"
                hint = f"ask for an event: `{latent.name} = {show_value(latent.values[0])}`"
                self.fail("distribution", message, node.event.span, env, hint)
            given = self.given(node.given, node, env, form)
            return Item("symbol", ty.Distribution(self.partition(latent), given), latent)
        event, given = self.each(
            [
                lambda: self.mask(node.event, env, "event"),
                lambda: self.given(node.given, node, env, form),
            ]
        )
        assert not isinstance(event, ty.Given)
        assert isinstance(given, ty.Given)
        self.check_certain(event, given.mask, node, env)
        return Item("number", ty.Probability(event, given))

    def check_certain(self, event: ty.Mask, mask: ty.Mask, node: ast.Probability, env: Env) -> None:
        inside = [e for e, m in zip(event, mask, strict=True) if m]
        key = (node.span.start, id(node.span.source))
        if (all(inside) or not any(inside)) and key not in self.certain:
            self.certain.add(key)
            value = "1" if all(inside) else "0"
            hint = None
            whole = [e for e, m in zip(event, (True,) * len(event), strict=True) if m]
            if any(whole) and not all(whole):
                hint = (
                    "under the default assumption everyone is rational: `assume nothing` drops it"
                )
            message = f"this probability is always {value}"
            self.warn("certain", message, node.span, env, hint)

    def on_expectation(self, node: ast.Expectation, env: Env) -> Item:
        form = "E[QUANTITY | script[:t]]"
        if not node.given:
            message = "an expectation without a script"
            self.fail("no-script", message, node.span, env, f"write `{form}`")

        def quantity() -> ty.Typed:
            return self.number(node.quantity, replace(env, inside="quantity"))

        value, given = self.each([quantity, lambda: self.given(node.given, node, env, form)])
        assert isinstance(given, ty.Given)
        assert not isinstance(value, ty.Given)
        mask = given.mask
        for part in ty.walk(value):
            if isinstance(part, ty.ValueAt):
                rational = self.world.rational[self.world.characters[part.who]]
                mask = _both(mask, tuple(bool(r.get(rational)) for r in self.world.hypotheses))
            elif isinstance(part, ty.LatentValue):
                mask = _both(mask, tuple(part.latent in r for r in self.world.hypotheses))
        if not any(mask):
            self.impossible(mask, node.quantity, env)
        value = fold_hypotheses(value, self.world.hypotheses)
        return Item("number", ty.Expectation(value, ty.Given(given.moment, mask)))

    def on_valueof(self, node: ast.ValueOf, env: Env) -> Item:
        if env.inside != "quantity":
            hint = "write `E[V(who) | script[:t]]`"
            self.fail("value", "a value depends on the hypothesis", node.span, env, hint)
        return Item("number", ty.ValueAt(self.character(node.who, env)))

    def partition(self, latent: Latent) -> ty.Partition:
        """Which value of the latent each hypothesis has; the last label is `unknown`."""
        order = {value: i for i, value in enumerate(latent.values)}
        unknown = len(order)
        index = tuple(
            order[row[latent.name]] if latent.name in row else unknown
            for row in self.world.hypotheses
        )
        return ty.Partition((*(show_value(v) for v in latent.values), "unknown"), index)

    def latent(self, node: ast.Expr, env: Env) -> Latent:
        latent = self.latent_named(node, env)
        if latent is None:
            stripped, inner = self.strip(node, env)
            hint = "latents: " + ", ".join(self.world.latents)
            if isinstance(stripped, ast.Name):
                close = did_you_mean(stripped.id, self.world.latents)
                hint = close if close and "mean" in close else hint
            self.fail("latent", "a latent is expected here", stripped.span, inner, hint)
        return latent

    def on_divergence(self, node: ast.Divergence, env: Env) -> Item:
        form = "KL(script[:t-1] || script[:t])"
        if not node.given:
            message = "a divergence is between two beliefs"
            self.fail("divergence", message, node.span, env, f"write `{form}`")
        latent = self.latent(node.latent, env) if node.latent is not None else None
        conditions = node.given[1:]
        first, second = self.each(
            [
                lambda: self.given((node.first, *conditions), node, env, form),
                lambda: self.given(node.given, node, env, form),
            ]
        )
        partition = self.partition(latent) if latent is not None else None
        return Item("number", ty.Divergence(partition, first, second))

    def on_entropy(self, node: ast.Entropy, env: Env) -> Item:
        form = "entropy(LATENT | script[:t])"
        latent = self.latent(node.latent, env) if node.latent is not None else None
        if latent is None and self.latent_named(node.given[0], env) is not None:
            message = "an entropy without a script"
            self.fail("no-script", message, node.span, env, f"write `{form}`")
        given = self.given(node.given, node, env, form)
        return Item("number", ty.Entropy(self.partition(latent) if latent else None, given))

    def on_surprise(self, node: ast.Surprise, env: Env) -> Item:
        given = self.given((node.frame,), node, env, "surprise(script[t])", "frame")
        return Item("number", ty.Surprise(given))

    def on_suspense(self, node: ast.Suspense, env: Env) -> Item:
        form = "suspense(LATENT | script[:t])"
        if not node.given:
            message = "suspense without a script"
            self.fail("no-script", message, node.span, env, f"write `{form}`")
        if not self.world.enumerable:
            message = "suspense looks one frame ahead, which needs actions that can be listed"
            self.fail("world", message, node.span, env)
        latent = self.latent(node.latent, env)
        given = self.given(node.given, node, env, form)
        return Item("number", ty.Suspense(self.partition(latent), given))

    # Predicates of frames.

    def on_holds(self, node: ast.Holds, env: Env) -> Item:
        item = self.item(node.frame, replace(env, inside=""))
        if item.kind != "frame":
            hint = "write `[... @ script[t]]`"
            message = f"a frame is expected here, this is {_KINDS[item.kind]}"
            self.fail("type", message, node.frame.span, env, hint)
        if env.inside:
            message = f"a frame cannot stand inside {_INSIDE.get(env.inside, 'this')}"
            self.fail("event", message, node.span, env)
        before, self.moment = self.moment, item.value
        try:
            inner = replace(env, inside="frame")
            value = self.item(node.predicate, inner)
        finally:
            self.moment = before
        features = [n for n in ty.walk(value.value) if isinstance(n, ty.Feature)]
        if value.kind not in ("number", "truth") or not features:
            hint = "predicates: " + ", ".join(p.name for p in self.world.predicates.values())
            self.fail("predicate", "a predicate is expected here", node.predicate.span, env, hint)
        if value.kind == "truth":
            one, zero = ty.Constant(1.0), ty.Constant(0.0)
            if isinstance(value.value, ty.Feature):
                return Item("number", value.value)
            return Item("number", ty.Apply("choose", (value.value, one, zero)))
        return value

    def predicate(self, node: ast.Call, env: Env) -> Item:
        predicate = self.world.predicates[node.callee.id]
        shown = f"{predicate.name}({', '.join(predicate.parameters)})"
        if env.inside not in ("frame", "start"):
            hint = f"write `[{predicate.name}(...) @ script[t]]`"
            message = f"`{predicate.name}` is asked of a frame"
            self.fail("predicate", message, node.span, env, hint)
        if env.inside == "start" and (predicate.needs_action or predicate.is_number):
            message = f"`{predicate.name}` needs a frame, nothing has happened at the start"
            self.fail("predicate", message, node.span, env)
        if len(node.arguments) != len(predicate.parameters):
            message = f"`{predicate.name}` takes {len(predicate.parameters)} arguments"
            self.fail("arguments", message, node.span, env, f"write `{shown}`")
        arguments = self.each(
            [
                lambda k=kind, a=argument: self.feature_argument(k, a.value, env)  # type: ignore[misc]
                for kind, argument in zip(predicate.parameters, node.arguments, strict=True)
            ]
        )
        moment = self.moment if env.inside == "frame" else None
        kind = "number" if predicate.is_number else "truth"
        return Item(kind, ty.Feature(predicate.name, tuple(arguments), moment))

    def feature_argument(self, kind: str, node: ast.Expr, env: Env) -> Any:
        if kind == "place":
            return self.place(node, env)
        if kind == "character":
            return self.character(node, env)
        known = self.world.things if kind == "object" else self.entities
        return self.entities.index(self.named(node, env, known, kind))

    def character(self, node: ast.Expr, env: Env) -> int:
        name = self.named(node, env, self.world.characters, "character")
        return self.world.characters.index(name)

    def named(self, node: ast.Expr, env: Env, known: tuple[str, ...], what: str) -> str:
        node, inner = self.strip(node, env)
        if isinstance(node, ast.Name) and node.id in known:
            return node.id
        code = {"character": "no-character", "object": "no-object"}.get(what, "no-thing")
        if isinstance(node, ast.Name):
            hint = did_you_mean(node.id, known)
            self.fail(code, f"there is no {what} `{node.id}`", node.span, inner, hint)
        hint = "known here: " + ", ".join(known)
        self.fail(code, f"a {what} is expected here", node.span, inner, hint)

    def place(self, node: ast.Expr, env: Env) -> tuple[tuple[int, int], ...]:
        """The cells that a tile's name or a pair (column, row) stands for."""
        stripped, inner = self.strip(node, env)
        if isinstance(stripped, ast.Name):
            if stripped.id not in self.world.places:
                hint = did_you_mean(stripped.id, self.world.places)
                message = f"there is no tile `{stripped.id}`"
                self.fail("no-place", message, stripped.span, inner, hint)
            return self.world.places[stripped.id]
        item = self.item(stripped, replace(inner, inside="", times=None))
        if item.kind != "pair":
            hint = "a tile's name or (column, row)"
            self.fail("no-place", "a place is expected here", node.span, env, hint)
        column, row = item.value
        if (column, row) not in self.world.free:
            size = f"{self.world.columns} x {self.world.rows}"
            inside = 0 <= column < self.world.columns and 0 <= row < self.world.rows
            what = "is a wall" if inside else f"is outside the map of {size}"
            if inside and (column != int(column) or row != int(row)):
                what = "is no cell"
            self.fail("no-place", f"({column:g}, {row:g}) {what}", node.span, env)
        return ((int(column), int(row)),)

    # Calls.

    def on_call(self, node: ast.Call, env: Env) -> Item:
        name = node.callee.id
        found = env.module.find(name) if name not in env.names else None
        if found is not None and isinstance(found.item, ast.Pattern):
            return self.call_pattern(found.item, found.module, node, env)
        if name in self.world.predicates:
            return self.predicate(node, env)
        if name == "points":
            return self.points(node, env)
        if name in FUNCTIONS:
            return self.function(node, env)
        if found is not None or name in env.names:
            self.fail("call", f"`{name}` is no pattern and takes no arguments", node.span, env)
        known = {*env.module.known(), *FUNCTIONS, *self.world.predicates}
        hint = did_you_mean(name, known)
        if name in ("sum", "mean"):
            hint = f"write `{name}_t EXPRESSION`"
        message = f"there is no pattern or function `{name}`"
        self.fail("unknown-pattern", message, node.callee.span, env, hint)

    def function(self, node: ast.Call, env: Env) -> Item:
        function = FUNCTIONS[node.callee.id]
        low, high = function.arity
        if not low <= len(node.arguments) <= high:
            hint = f"write `{function.signature}`"
            count = f"{low}" if low == high else f"at least {low}"
            message = f"`{function.name}` takes {count} argument{'s' if low != 1 else ''}"
            self.fail("arguments", message, node.span, env, hint)
        for argument in node.arguments:
            if argument.name is not None:
                message = f"`{function.name}` has no parameter `{argument.name.id}`"
                self.fail("arguments", message, argument.span, env)
        values = self.each([lambda a=a: self.number(a.value, env) for a in node.arguments])  # type: ignore[misc]
        return Item("number", self.apply(function.name, tuple(values), node, env))

    def points(self, node: ast.Call, env: Env) -> Item:
        if env.times is None:
            message = "`points` is a curve over t, it means nothing outside a sum"
            self.fail("free-time", message, node.span, env)
        items = self.each([lambda a=a: self.item(a.value, env) for a in node.arguments])  # type: ignore[misc]
        for item, argument in zip(items, node.arguments, strict=True):
            if item.kind != "pair":
                message = "the points of a curve are pairs (t/T, height)"
                self.fail("arguments", message, argument.span, env, "points((0, 0), (1, 1))")
        xs, ys = tuple(i.value[0] for i in items), tuple(i.value[1] for i in items)
        if len(xs) < 2 or any(b <= a for a, b in zip(xs, xs[1:], strict=False)):
            message = "a curve needs two points or more, from left to right"
            self.fail("arguments", message, node.span, env, "points((0, 0), (0.3, 1), (1, -1))")
        share = ty.Apply("divide", (ty.TimeIndex(), ty.Constant(float(self.length))))
        return Item("number", ty.Points(xs, ys, share))

    def call_pattern(self, pattern: ast.Pattern, module: Any, node: ast.Call, env: Env) -> Item:
        name = pattern.name.id
        for parameter in pattern.parameters:
            if parameter.name.id in self.world.latents:
                message = f"the parameter `{parameter.name.id}` of `{name}` has a latent's name"
                note = Note("it is defined here", parameter.span)
                hint = "rename the parameter"
                self.report(Diagnostic("shadow", message, node.span, hint, (note, *env.notes())))
                raise Stop
        names = self.bind(pattern, node, env)
        inner = Env(module, names, uses=(*env.uses, (name, node.span)))
        for parameter in pattern.parameters:
            if parameter.name.id not in names:
                assert parameter.default is not None
                names[parameter.name.id] = Bound(parameter.default, inner)
        self.check_recursion(name, node.span, env)
        return self.item(pattern.body, self.outside(inner, env))

    def check_recursion(self, name: str, span: Span, env: Env) -> None:
        """A pattern that is being expanded around this place cannot be used here again."""
        chain = [used for used, _ in env.uses]
        if name in chain:
            shown = " -> ".join((*chain[chain.index(name) :], name))
            self.fail("recursion", f"`{name}` is defined by itself: {shown}", span, env)

    def bind(self, pattern: ast.Pattern, node: ast.Call, env: Env) -> dict[str, Bound]:
        """The arguments of a call by the names of the parameters."""
        parameters = [p.name.id for p in pattern.parameters]
        bound: dict[str, Bound] = {}
        free = list(parameters)
        hint = f"its signature: {pattern.signature}"
        for argument in node.arguments:
            value = argument.value
            if argument.name is not None and argument.name.id in parameters:
                name = argument.name.id
                if name in bound:
                    message = f"`{name}` is given twice"
                    self.fail("arguments", message, argument.span, env, hint)
            else:
                if argument.name is not None:
                    value = self.positional(argument, pattern, env, hint)
                if not free:
                    message = f"too many arguments for `{pattern.name.id}`"
                    self.fail("arguments", message, argument.span, env, hint)
                name = free[0]
            free.remove(name)
            bound[name] = Bound(value, env)
        missing = [
            p.name.id for p in pattern.parameters if p.default is None and p.name.id not in bound
        ]
        if missing:
            listed = ", ".join(f"`{m}`" for m in missing)
            message = f"`{pattern.name.id}` needs {listed}"
            self.fail("arguments", message, node.span, env, hint)
        return bound

    def positional(
        self, argument: ast.Argument, pattern: ast.Pattern, env: Env, hint: str
    ) -> ast.Expr:
        """`rho = 0` for a pattern without a parameter `rho`: a condition."""
        assert argument.name is not None
        name = argument.name.id
        is_known = name in self.world.latents or name in env.names or env.module.find(name)
        if argument.comparison is None or not is_known:
            message = f"`{pattern.name.id}` has no parameter `{name}`"
            parameters = [p.name.id for p in pattern.parameters]
            close = did_you_mean(name, (*parameters, *self.world.latents))
            better = close if close and "mean" in close else hint
            self.fail("arguments", message, argument.name.span, env, better)
        return argument.comparison


_INSIDE = {
    "event": "an event",
    "condition": "a condition",
    "quantity": "a quantity",
    "frame": "a predicate of a frame",
    "start": "the condition of the start",
}


def _both(a: ty.Mask, b: ty.Mask) -> ty.Mask:
    return tuple(x and y for x, y in zip(a, b, strict=True))
