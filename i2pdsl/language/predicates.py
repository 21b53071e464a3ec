"""What can be seen: predicates of frames and of the start, and the places and names in them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from i2pdsl.errors import did_you_mean, shorten
from i2pdsl.language import ast
from i2pdsl.language import typed as ty
from i2pdsl.language.arithmetic import Arithmetic
from i2pdsl.language.elaboration import BELIEVED, INSIDE, ITEMS_IN_WORDS, Item
from i2pdsl.language.scope import Env
from i2pdsl.language.vocabulary import Predicate


class Predicates(Arithmetic):
    """`[predicate @ script[k]]` and the conditions of `start`."""

    def on_holds(self, node: ast.Holds, env: Env) -> Item:
        if env.inside == "start":
            message = "the start has no frames yet, its condition stands without brackets"
            hint = f"write `start {node.predicate.span.text}`"
            raise self.fail("predicate", message, node.span, env, hint)
        if env.inside:
            message = f"a frame cannot stand inside {INSIDE[env.inside]}"
            hint = "viewers know what they see; put the frame outside the belief"
            raise self.fail("event", message, node.span, env, hint)
        item = self.item(node.frame, env)
        if item.kind != "frame":
            message = f"expected a frame of a script, found {ITEMS_IN_WORDS[item.kind]}"
            raise self.blame("type", message, node.frame, env, "write `[... @ script[t]]`")
        return Item("number", _number(self.seen(node.predicate, item.value, env)))

    def seen(self, node: ast.Expr, moment: ty.Moment, env: Env) -> Item:
        """A predicate or quantity of a frame."""
        before, self.moment = self.moment, moment
        try:
            value = self.item(node, replace(env, inside="frame"))
        finally:
            self.moment = before
        features = [n for n in ty.walk(value.value) if isinstance(n, ty.Feature)]
        if value.kind not in ("number", "truth") or not features:
            hint = "predicates: " + ", ".join(p.name for p in self.world.predicates.values())
            raise self.blame("predicate", "expected a predicate of the world", node, env, hint)
        return value

    def on_ever(self, node: ast.Ever, env: Env) -> Item:
        if env.inside:
            message = f"`{node.word} [...]` cannot stand inside {INSIDE[env.inside]}"
            hint = "it is about all frames of the script"
            raise self.fail("predicate", message, node.span, env, hint)
        every = ty.Moment((), range(1, self.length + 1), 1)
        item = self.seen(node.predicate, every, replace(env, times=None, reached=None))
        if item.kind != "truth":
            message = f"`{node.word}` needs what holds or does not, this is a number"
            hint = "compare it: `[... > 1]`"
            raise self.blame("type", message, node.predicate, env, hint)
        body = _number(item)
        if node.word == "when":
            return Item("number", ty.When(body, self.length))
        ever = ty.Reduction("max", 1, self.length, body) if self.length else ty.Constant(0.0)
        return Item("truth", ever if node.word == "eventually" else ty.Apply("not", (ever,)))

    def order(self, first: ast.Expr, second: ast.Expr, env: Env) -> ty.Typed:
        """Whether two predicates come to hold, the first one in an earlier frame."""
        ever = lambda word, n: self.item(ast.Ever(n.span, word, n), env).value
        when, then = self.both(lambda: ever("when", first), lambda: ever("when", second))
        in_time = ty.Apply("less", (when, ty.Constant(float(self.length))))
        earlier = ty.Apply("less", (when, then))
        return ty.Apply("and", (earlier, in_time, ever("eventually", second)))

    def predicate(self, node: ast.Call, env: Env) -> Item:
        predicate = self.world.predicates[node.callee.id]
        shown = f"{predicate.name}({', '.join(predicate.parameters)})"
        if self.believer is not None and env.inside in BELIEVED and predicate.name == "at":
            return self.supposed(node, env)
        if env.inside not in ("frame", "start"):
            hint = f"write `[{predicate.name}(...) @ script[t]]`"
            message = f"`{predicate.name}` is asked of a frame"
            raise self.fail("predicate", message, node.span, env, hint)
        if env.inside == "start" and predicate.needs_action:
            message = f"`{predicate.name}` needs a frame, but nothing has happened at the start"
            hint = "the start is described by " + self.first_pictures
            raise self.fail("predicate", message, node.span, env, hint)
        count = len(predicate.parameters)
        if len(node.arguments) != count:
            message = f"`{predicate.name}` takes {count} argument{'' if count == 1 else 's'}"
            raise self.fail("arguments", message, node.span, env, f"write `{shown}`")
        for argument in node.arguments:
            if argument.name is not None:
                message = f"`{predicate.name}` has no parameter `{argument.name.id}`"
                raise self.fail("arguments", message, argument.span, env, f"write `{shown}`")
        arguments = self.each(
            [
                lambda k=kind, a=argument: self.feature_argument(predicate, k, a.value, env)  # type: ignore[misc]
                for kind, argument in zip(predicate.parameters, node.arguments, strict=True)
            ]
        )
        moment = self.moment if env.inside == "frame" else None
        kind = "number" if predicate.is_number else "truth"
        return Item(kind, ty.Feature(predicate.name, tuple(arguments), moment))

    def believes(self, node: ast.Call, env: Env) -> Item:
        """`believes(who, event)`: an event about what somebody takes for true."""
        self.check_arity(node, env)
        who, event = (argument.comparison or argument.value for argument in node.arguments)
        name = self.world.characters[self.character(who, env)]
        readings = self.world.readings.get(name, {})
        message = hint = None
        if env.inside not in BELIEVED:
            message = "what somebody believes is hidden from viewers"
            hint = f"ask what they think of it: `P({shorten(node.span.text)} | script[:t])`"
        elif self.believer is not None:
            message = "nobody believes something about what another believes"
        elif not readings:
            message = f"`{name}` is never wrong, so viewers do not wonder what it believes"
            hint = (
                "whoever may be wrong has `misreads = WHO` or `supposes = {OBJECT: {TILE, TILE}}`"
            )
            hint += " in the world"
        if message is not None:
            raise self.fail("event", message, node.span, env, hint)
        self.believer = name
        try:
            value = self.truth(event, env)
        finally:
            self.believer = None
        asked = {part.latent for part in ty.walk(value) if isinstance(part, ty.LatentValue)}
        if not asked & {*readings.values()}:
            known = ", ".join(f"`{what}`" for what in readings)
            message = f"`{name}` cannot be wrong about this"
            raise self.blame("event", message, event, env, f"it may be wrong about {known}")
        return Item("truth", value)

    def supposed(self, node: ast.Call, env: Env) -> Item:
        """`at(object, tile)` inside `believes`: where the believer takes something to be."""
        assert self.believer is not None
        readings = self.world.readings[self.believer]
        things = [name for name in readings if name in self.world.things]
        if len(node.arguments) != 2:
            hint = "write `at(object, tile)`"
            raise self.fail("arguments", "`at` takes 2 arguments", node.span, env, hint)
        first, place = (argument.value for argument in node.arguments)
        latent = self.world.latents[readings[self.named(first, env, things, "object")]]
        symbol = ty.Symbol(self.symbol(latent, place, env))
        return Item("truth", ty.Apply("equal", (ty.LatentValue(latent.name), symbol)))

    def feature_argument(self, predicate: Predicate, kind: str, node: ast.Expr, env: Env) -> Any:
        if kind == "place":
            return self.place(node, env, predicate.takes_points)
        if kind == "character":
            return self.character(node, env)
        if kind == "spot":
            return self.spot(node, env, predicate.takes_points)
        known = self.world.things if kind == "object" else self.entities
        return self.entities.index(self.named(node, env, known, kind))

    def character(self, node: ast.Expr, env: Env) -> int:
        name = self.named(node, env, self.world.characters, "character")
        return self.world.characters.index(name)

    def named(self, node: ast.Expr, env: Env, known: Sequence[str], what: str) -> str:
        """The character, object or either that an expression names."""
        label = {"thing": "character or object"}.get(what, what)
        stripped, inner = self.strip(node, env, known, f"the name of a {label}")
        code = {"character": "no-character", "object": "no-object"}.get(what, "no-thing")
        if not isinstance(stripped, ast.Name):
            hint = "known here: " + ", ".join(known)
            article = "an" if label[0] in "aeio" else "a"
            raise self.blame(code, f"expected the name of {article} {label}", node, env, hint)
        if stripped.id in known:
            return stripped.id
        message = f"there is no {label} `{stripped.id}`"
        hint = did_you_mean(stripped.id, known) or ""
        if stripped.id in self.entities:
            other = "a character" if stripped.id in self.world.characters else "an object"
            article = "an" if label[0] in "aeio" else "a"
            message = f"`{stripped.id}` is {other}, expected the name of {article} {label}"
            hint = "known here: " + ", ".join(known)
        raise self.fail(code, message, stripped.span, inner, hint or None)

    def spot(
        self, node: ast.Expr, env: Env, points: bool
    ) -> int | tuple[tuple[int, int], ...] | ty.Point:
        """A character, an object or a place."""
        names = (*self.entities, *self.world.places)
        stripped, inner = self.strip(node, env, names, "the name of a character, object or place")
        if isinstance(stripped, ast.Name) and stripped.id in self.entities:
            return self.entities.index(stripped.id)
        if not isinstance(stripped, ast.Name) or stripped.id in self.world.places:
            return self.place(node, env, points)
        hint = did_you_mean(stripped.id, names) or "known here: " + ", ".join(names)
        message = f"there is no character, object or place `{stripped.id}`"
        raise self.fail("no-place", message, stripped.span, inner, hint)

    def place(
        self, node: ast.Expr, env: Env, points: bool = False
    ) -> tuple[tuple[int, int], ...] | ty.Point:
        """The cells that a tile's name or a pair (column, row) stands for; in a world without a map
        a place with a name or, where `points` are taken, a pair (x, y)."""
        has_map, area = self.world.columns > 0, self.world.size if points else None
        what = "tile" if has_map else "place"
        listed = "or write (column, row)" if has_map else "places: " + ", ".join(self.world.places)
        listed += ", or write (x, y)" if area else ""
        stripped, inner = self.strip(node, env, tuple(self.world.places), f"the name of a {what}")
        if isinstance(stripped, ast.Name):
            if stripped.id not in self.world.places:
                hint = did_you_mean(stripped.id, self.world.places) or listed
                message = f"there is no {what} `{stripped.id}`"
                raise self.fail("no-place", message, stripped.span, inner, hint)
            return self.world.places[stripped.id]
        item = self.item(stripped, replace(inner, inside="", times=None))
        if item.kind == "pair" and area is not None:
            x, y = item.value
            if not (0 <= x <= area[0] and 0 <= y <= area[1]):
                message = f"({x:g}, {y:g}) is outside {area[0]:g} x {area[1]:g} units"
                hint = "x grows to the right and y upwards, from the lower left corner"
                raise self.blame("no-place", message, node, env, hint)
            return ty.Point(float(x), float(y))
        if item.kind != "pair" or not has_map:
            hint = "write a tile's name or (column, row)" if has_map else listed
            raise self.blame(
                "no-place", f"expected a place, found {ITEMS_IN_WORDS[item.kind]}", node, env, hint
            )
        column, row = item.value
        hint = "columns and rows count from 0 at the top left"
        if (column, row) not in self.world.free:
            size = f"{self.world.columns} columns and {self.world.rows} rows"
            inside = 0 <= column < self.world.columns and 0 <= row < self.world.rows
            what = "is a wall" if inside else f"is outside the map of {size}"
            if inside and (column != int(column) or row != int(row)):
                what = "is not a cell"
            raise self.blame("no-place", f"({column:g}, {row:g}) {what}", node, env, hint)
        return ((int(column), int(row)),)


def _number(item: Item) -> ty.Typed:
    """1 or 0 for what holds or does not."""
    if item.kind != "truth" or isinstance(item.value, ty.Feature):
        return item.value
    return ty.Apply("choose", (item.value, ty.Constant(1.0), ty.Constant(0.0)))
