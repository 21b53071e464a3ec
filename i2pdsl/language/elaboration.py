"""What all parts of the elaborator share: reporting, wanted kinds, and what names stand for."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

from i2pdsl.errors import Diagnostic, Note, Span, did_you_mean, shorten
from i2pdsl.language import ast
from i2pdsl.language import typed as ty
from i2pdsl.language.builtins import FUNCTIONS
from i2pdsl.language.scope import Env, Module, standard_library
from i2pdsl.language.statements import DEEPEST
from i2pdsl.language.story import USUAL, Audience
from i2pdsl.language.vocabulary import ASKED, Latent, Vocabulary, show_value

MOST_NODES = 50_000  # of an expression once all patterns are put in
MOST_IN_ALL = 150_000  # of all expressions of a story

A = TypeVar("A")
B = TypeVar("B")


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


@dataclass(frozen=True)
class _Known:
    """What a `let` was found to be, or None if it has a mistake; its size, put in."""

    item: Item | None
    nodes: int
    height: int


_methods: dict[type, str] = {}


def _method(kind: type) -> str:
    """The name of the method for a class of nodes."""
    if kind not in _methods:
        _methods[kind] = f"on_{kind.__name__.lower()}"
    return _methods[kind]


ITEMS_IN_WORDS = {
    "number": "a number",
    "truth": "a condition",
    "symbol": "a latent",
    "table": "a table of probabilities",
    "script": "a whole script",
    "prefix": "the first frames of a script",
    "frame": "a frame of a script",
    "pair": "a pair",
    "text": "a text in quotes",
}
INSIDE = {
    "event": "an event",
    "condition": "a condition",
    "quantity": "a quantity",
    "frame": "a predicate of a frame",
    "start": "the condition of the start",
}
BELIEVED = ("event", "condition", "quantity")  # where a latent has its hypothesis's value


class Elaboration:
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
        self.weight: float | None = None  # of a frame in sums over t, if a search chooses T
        self.report = report
        self.query = query
        self.assumption: ty.Mask = (True,) * len(vocabulary.hypotheses)
        self.audiences: tuple[Audience, ...] = (USUAL,)
        self.entities = (*vocabulary.characters, *vocabulary.things)
        self.used: set[int] = set()  # ids of the lets and patterns that were put in somewhere
        self.depth = 0
        self.nodes = 0  # of the expression at hand
        self.all_nodes = 0
        self.most_nodes = MOST_NODES
        self.highest = 0  # how deep it was nested so far
        self.is_full = False  # whether it was reported that there are too many parts
        self.lets: dict[Any, _Known] = {}
        self.time_missed = False  # whether a `t` outside a sum was reported in this expression
        self.moment: ty.Moment | None = None  # the frame of the enclosing [... @ script[k]]
        self.believer: str | None = None  # within whose `believes(who, ...)` one is
        self.places: dict[int, tuple[ty.Typed, Span, Env]] = {}  # where operations were written

    # Reporting.

    def fail(self, code: str, message: str, span: Span, env: Env, hint: str | None = None) -> Stop:
        self.report(Diagnostic(code, message, span, hint, env.notes()))
        return Stop()

    def origin(self, node: ast.Node, env: Env) -> tuple[Span, tuple[Note, ...]]:
        """Where an expression was written, and notes on how it came here.

        For the parameter of a pattern this is the argument; a note then shows the pattern's line.
        """
        notes = env.notes()
        while isinstance(node, ast.Name) and node.id in env.names:
            bound = env.names[node.id]
            notes = (Note(f"it is put in here for `{node.id}`", node.span), *bound.env.notes())
            node, env = bound.expression, bound.env
        return node.span, notes

    def blame(
        self, code: str, message: str, node: ast.Node, env: Env, hint: str | None = None
    ) -> Stop:
        """Reports a wrong expression where it was written."""
        span, notes = self.origin(node, env)
        self.report(Diagnostic(code, message, span, hint, notes))
        return Stop()

    def warn(
        self, code: str, message: str, node: ast.Node, env: Env, hint: str | None = None
    ) -> None:
        span, notes = self.origin(node, env)
        self.report(Diagnostic(code, message, span, hint, notes, "warning"))

    def both(self, first: Callable[[], A], second: Callable[[], B]) -> tuple[A, B]:
        """Two parts of an expression: the mistakes of the second are found if the first fails."""
        one, other = self.each([first, second])
        return one, other  # type: ignore[return-value]

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

    def enter(self, node: ast.Node, env: Env, nodes: int = 1, height: int = 1) -> None:
        """Counts an expression: its `nodes`, and how deep it is nested in itself."""
        if self.depth == 0:
            self.nodes = self.highest = 0
            self.time_missed = False
        before, self.nodes = self.nodes, self.nodes + nodes
        self.all_nodes += nodes
        self.highest = max(self.highest, self.depth + height)
        if self.depth + height > DEEPEST + 20:
            hint = "name the parts with `let`" if not env.uses else None
            raise self.fail("nesting", f"nested deeper than {DEEPEST}", node.span, env, hint)
        if self.nodes >= self.most_nodes or self.all_nodes >= MOST_IN_ALL:
            raise self.too_large(before, node, env)

    def too_large(self, before: int, node: ast.Node, env: Env) -> Stop:
        """Reports once that an expression, or the whole story, has too many parts."""
        if self.all_nodes >= MOST_IN_ALL:
            if self.is_full:
                return Stop()
            self.is_full = True
            message = f"the story grows to more than {MOST_IN_ALL:,} parts when patterns are put in"
        elif before >= self.most_nodes:
            return Stop()
        else:
            message = f"the patterns grow to more than {self.most_nodes:,} parts when put in"
        return self.fail("nesting", message, node.span, env, "use fewer patterns in patterns")

    # Wanted kinds.

    def number(self, node: ast.Expr, env: Env) -> ty.Typed:
        item = self.item(node, env)
        if item.kind == "number":
            return item.value
        raise self.wrong_kind("a number", item, node, env)

    def truth(self, node: ast.Expr, env: Env) -> ty.Typed:
        item = self.item(node, env)
        if item.kind == "truth" or self.is_predicate(item.value):
            return item.value
        raise self.wrong_kind("a condition", item, node, env)

    def is_predicate(self, value: object) -> bool:
        """Whether a form of a frame is a predicate, 1 or 0, and no quantity."""
        if not isinstance(value, ty.Feature):
            one_or_zero = (ty.Constant(1.0), ty.Constant(0.0))
            return isinstance(value, ty.Apply) and value.arguments[1:] == one_or_zero
        return not self.world.predicates[value.predicate].is_number

    def wrong_kind(self, wanted: str, item: Item, node: ast.Expr, env: Env) -> Stop:
        found = ITEMS_IN_WORDS[item.kind]
        hint = None
        if item.latent is not None and item.kind == "symbol":
            found = f"the latent `{item.latent.name}`"
            event = f"{item.latent.name} = {show_value(item.latent.values[0])}"
            hint = f"ask what viewers believe: `P({event} | script[:t])`"
            if env.inside in BELIEVED:
                hint = f"compare it: `{event}`"
        elif item.kind == "table":
            hint = "a query asks for a table by itself"
        elif item.kind == "truth" and wanted == "a number":
            hint = "write `if CONDITION then 1 else 0`, or `P(EVENT | script[:t])`"
        elif item.kind in ("script", "prefix", "frame"):
            hint = "ask for a belief: `P(EVENT | script[:t])`"
        elif wanted == "a condition":
            hint = _CONDITIONS.get(env.inside)
        return self.blame("type", f"expected {wanted}, found {found}", node, env, hint)

    def constant(self, node: ast.Expr, env: Env) -> float:
        value = self.number(node, replace(env, times=None))
        if not isinstance(value, ty.Constant):
            message = "this must be a constant number, it cannot depend on beliefs or frames"
            raise self.fail("constant", message, node.span, env)
        return float(value.value)

    def audience(self, node: ast.Name | None, env: Env) -> Audience:
        """The audience that a form names, or a parameter in its place; the usual one without."""
        if node is None:
            return self.audiences[0]
        found, inner = node, env
        while isinstance(found, ast.Name) and found.id in inner.names:
            bound = inner.names[found.id]
            found, inner = bound.expression, bound.env  # type: ignore[assignment]
        named = {audience.name: audience for audience in self.audiences}
        if isinstance(found, ast.Name) and found.id in named:
            return named[found.id]
        text = shorten(found.span.text)
        hint = did_you_mean(text, named)
        if len(named) == 1:
            hint = f"name one: `audience {text if isinstance(found, ast.Name) else 'NAME'} = ...`"
        raise self.blame("audience", f"there is no audience `{text}`", node, env, hint)

    # Expressions.

    def item(self, node: ast.Expr, env: Env) -> Item:
        self.enter(node, env)
        self.depth += 1
        try:
            item: Item = getattr(self, _method(node.__class__))(node, env)
        finally:
            self.depth -= 1
        return item

    # Names.

    def on_name(self, node: ast.Name, env: Env) -> Item:
        name = node.id
        if name in env.names:
            bound = env.names[name]
            return self.item(bound.expression, self.outside(bound.env, env))
        found = env.module.find(name)
        if found is not None:
            if isinstance(found.item, ast.Pattern):
                return self.item(ast.Call(node.span, node, ()), env)
            return self.let(node, found.item, found.module, env)
        if name in self.world.latents:
            name = self.as_seen(name)
            latent = self.kept(self.world.latents[name], node, env)
            kind = latent.kind if env.inside in BELIEVED else "symbol"
            return Item(kind, ty.LatentValue(name), latent)
        if name == "pi":
            return Item("number", ty.Constant(math.pi))
        raise self.unknown_name(node, env)

    def as_seen(self, name: str) -> str:
        """The latent that a name means, or what the believer at hand takes that for."""
        readings = self.world.readings.get(self.believer, {}) if self.believer else {}
        return readings.get(name, name)

    def let(self, node: ast.Name, let: ast.Let, module: Module, env: Env) -> Item:
        """What a `let` stands for: looked at once for all the places where it means the same."""
        is_summed = env.sum_span is not None
        place = (env.times, is_summed, env.after_sum, env.inside, self.assumption, self.believer)
        is_plain = env.reached is None and self.moment is None
        key = (id(let), id(self.world), self.length, self.weight, *place) if is_plain else None
        known = self.lets.get(key) if key is not None else None
        if known is not None:
            if known.item is not None:
                self.enter(node, env, known.nodes, known.height)
        else:
            inner = self.outside(self.inside_let(node, let, module, env), env)
            self.check_recursion(node.id, node.span, env)
            nodes, highest = self.nodes, self.highest
            self.highest = self.depth
            try:
                item: Item | None = self.item(let.value, inner)
            except Stop:
                item = None
            known = _Known(item, self.nodes - nodes, self.highest - self.depth)
            self.highest = max(highest, self.highest)
            # A `t` outside a sum is reported once, maybe not in this `let`.
            if key is not None and not (item is None and self.time_missed):
                self.lets[key] = known
        if known.item is None:
            raise Stop
        return known.item

    def inside_let(self, node: ast.Name, let: ast.Let, module: Module, env: Env) -> Env:
        """The names that the value of a `let` was written among."""
        self.used.add(id(let))
        return Env(module, uses=(*env.uses, (node.id, node.span)))

    def outside(self, definition: Env, use: Env) -> Env:
        """The names of where an expression was written, the time of where it is put in."""
        return Env(
            definition.module,
            definition.names,
            use.times,
            use.reached,
            use.sum_span,
            definition.after_sum,
            use.inside,
            definition.uses,
        )

    def check_recursion(self, name: str, span: Span, env: Env) -> None:
        """A definition that is being put in around this place cannot be used here again."""
        chain = [used for used, _ in env.uses]
        if name in chain:
            shown = " -> ".join((*chain[chain.index(name) :], name))
            raise self.fail("recursion", f"`{name}` is defined by itself: {shown}", span, env)

    def strip(
        self, node: ast.Expr, env: Env, understood: Sequence[object] = (), what: str = ""
    ) -> tuple[ast.Expr, Env]:
        """Follows names to the expression that they stand for.

        Words that are `understood` at this place (the values of a latent, say) stand for
        themselves, whatever `let` or parameter has the same name. `what` they are, in words: with
        it, that is said.
        """
        for _ in range(DEEPEST):
            if not isinstance(node, ast.Name):
                break
            # The standard patterns know no world: `who` is their parameter, whoever is called so.
            own = node.id in env.names and env.module is standard_library()
            if node.id in understood and not own:
                if what:
                    self.check_shadow(node, env, what)
                break
            if node.id in env.names:
                bound = env.names[node.id]
                node, env = bound.expression, self.outside(bound.env, env)
                continue
            found = env.module.find(node.id)
            if found is None or not isinstance(found.item, ast.Let):
                break
            inner = self.inside_let(node, found.item, found.module, env)
            node, env = found.item.value, self.outside(inner, env)
        return node, env

    def check_shadow(self, node: ast.Name, env: Env, what: str) -> None:
        """Says so where a `let` has the name of a word of the world that is understood here, and
        refuses a parameter that has: its argument would be lost."""
        name = node.id
        bound = env.names.get(name)
        if bound is not None:
            if not isinstance(bound.expression, ast.Name) or bound.expression.id != name:
                message = f"`{name}` is {what} here, so the parameter `{name}` is never looked at"
                raise self.fail("shadow", message, node.span, env, "rename the parameter")
            return
        found = env.module.find(name)
        if found is not None and isinstance(found.item, ast.Let):
            message = f"`{name}` is {what} here, not the `let` of that name"
            notes = (Note("the `let`", found.item.name.span), *env.notes())
            hint = "rename the `let`"
            self.report(Diagnostic("shadow", message, node.span, hint, notes, "warning"))

    def latent_named(self, node: ast.Expr, env: Env) -> Latent | None:
        """The latent that an expression names, if it is nothing but a latent's name."""
        node, env = self.strip(node, env)
        if isinstance(node, ast.Name) and env.module.find(node.id) is None:
            latent = self.world.latents.get(self.as_seen(node.id))
            return None if latent is None else self.kept(latent, node, env)
        return None

    def kept(self, latent: Latent, node: ast.Expr, env: Env) -> Latent:
        """A latent that viewers keep apart; where not all can be, asking of another is an error."""
        if not self.world.counts or latent.name in self.world.kept:
            return latent
        message = f"viewers of this story do not keep `{latent.name}` apart"
        usual = set(self.world.rational.values())
        told = " ".join(sorted({latent.name, *self.world.kept} - usual))
        hint = f'write `world {self.world.world}({ASKED} = "{told}")`'
        raise self.fail("particles", message, node.span, env, hint)

    def is_unknown(self, node: ast.Expr, env: Env) -> bool:
        """Whether an expression is a name that means nothing."""
        node, env = self.strip(node, env)
        if not isinstance(node, ast.Name) or node.id in self.world.latents or node.id == "pi":
            return False
        return env.module.find(node.id) is None

    def unknown_name(self, node: ast.Name, env: Env) -> Stop:
        name = node.id
        owners = [x for x in self.world.latents.values() if name in x.values]
        hint: str | None
        if env.inside in ("start", "frame") and name in self.entities:
            message = f"`{name}` is not a condition"
            hint = f"say where it is: `at({name}, TILE)`"
            if name in self.world.may_be_absent:
                hint += f" or `absent({name})`"
        elif owners:
            message = f"`{name}` is a value and stands beside its latent"
            hint = "write " + " or ".join(f"`{x.name} = {name}`" for x in owners)
        elif name in self.entities:
            message = f"`{name}` is neither a number nor a condition"
            hint = f"what is hidden about the characters: {', '.join(self.world.latents)}"
        elif name in self.world.predicates:
            message = f"`{name}` is asked of a frame"
            hint = f"write `[{name}(...) @ script[t]]`"
        elif name in self.world.settings:
            message = f"`{name}` is a setting of {self.world.world}"
            hint = self.world.settings[name].documentation
        elif name in FUNCTIONS:
            message = f"`{name}` needs its arguments"
            hint = f"write `{FUNCTIONS[name].signature}`"
        elif env.module.is_lost(name, lambda: self.known(env)):
            return Stop()
        else:
            message = f"unknown name `{shorten(name)}`"
            hint = "write `rho`" if name == "ρ" else env.module.meant(name, lambda: self.known(env))
        return self.fail("unknown-name", message, node.span, env, hint)

    def known(self, env: Env) -> set[str]:
        names = {*env.names, *env.module.known(), *self.world.latents, *FUNCTIONS, "pi"}
        return names | {"script"}

    @property
    def first_pictures(self) -> str:
        """What can be said of a first picture, in words."""
        names = [f"`{p.name}`" for p in self.world.predicates.values() if not p.needs_action]
        return f"{', '.join(names[:-1])} and {names[-1]}" if len(names) > 1 else "".join(names)

    def outside_belief(self, latent: Latent, node: ast.Expr, env: Env) -> Stop:
        """A latent's value was asked for where only frames and beliefs are known."""
        message = f"`{latent.name}` is hidden from the viewers"
        hint = f"ask what they believe: `P({latent.name} ... | script[:t])`"
        if env.inside == "start":
            message = f"`{latent.name}` is no part of the first picture"
            hint = "the start is described by " + self.first_pictures
        return self.blame("hidden", message, node, env, hint)


_CONDITIONS = {
    "event": "an event is a comparison with a latent, such as `rho > 0`",
    "condition": "a condition is a comparison with a latent, such as `rho > 0`",
    "start": "for instance `start absent(table)`",
}
