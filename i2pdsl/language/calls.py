"""Calls: functions, predicates, and patterns, whose arguments are put in as expressions."""

from __future__ import annotations

from i2pdsl.errors import Diagnostic, Note, shorten
from i2pdsl.language import ast
from i2pdsl.language.arguments import MismatchError, bind, unknown_call_hint
from i2pdsl.language.beliefs import Beliefs
from i2pdsl.language.builtins import FUNCTIONS
from i2pdsl.language.elaboration import Item, Stop
from i2pdsl.language.names import check_names
from i2pdsl.language.scope import Bound, Definition, Env


class Calls(Beliefs):
    """`NAME(ARGUMENT, ...)`."""

    def on_call(self, node: ast.Call, env: Env) -> Item:
        name = node.callee.id
        found = env.module.find(name) if name not in env.names else None
        if found is not None and isinstance(found.item, ast.Pattern):
            return self.call_pattern(found, found.item, node, env)
        if name in self.world.predicates:
            return self.predicate(node, env)
        if name == "points":
            return self.points(node, env)
        if name == "beats":
            return self.beats(node, env)
        if name == "believes":
            return self.believes(node, env)
        if name in FUNCTIONS:
            return self.function(node, env)
        if found is not None or name in env.names:
            raise self.fail(
                "call", f"`{name}` is not a pattern and takes no arguments", node.span, env
            )
        known = lambda: {*env.module.known_patterns(), *FUNCTIONS, *self.world.predicates}
        if env.module.is_lost(name, known):
            raise Stop
        message = f"there is no pattern or function `{shorten(name)}`"
        hint = unknown_call_hint(name, lambda: env.module.meant(name, known))
        if hint is None and env.inside in ("frame", "start"):
            hint = "predicates: " + ", ".join(self.world.predicates)
        span = node.callee.span
        self.report(Diagnostic("unknown-pattern", message, span, hint, env.notes()))
        self.check_arguments(node, env)
        raise Stop

    def call_pattern(
        self, found: Definition, pattern: ast.Pattern, node: ast.Call, env: Env
    ) -> Item:
        name = pattern.name.id
        self.used.add(id(pattern))
        for parameter in pattern.parameters:
            if parameter.name.id in self.world.latents:
                message = f"the parameter `{parameter.name.id}` of `{name}` has a latent's name"
                note = Note("it is defined here", parameter.span)
                hint = "rename the parameter"
                self.report(Diagnostic("shadow", message, node.span, hint, (note, *env.notes())))
                raise Stop
        try:
            arguments = bind(pattern, node, lambda n: self.is_known(n, env), self.world.latents)
        except MismatchError as wrong:
            self.report(Diagnostic("arguments", wrong.message, wrong.span, wrong.hint, env.notes()))
            self.check_arguments(node, env)
            raise Stop from None
        self.check_recursion(name, node.span, env)
        names = {name: Bound(value, env) for name, value in arguments.items()}
        inner = Env(found.module, names, uses=(*env.uses, (name, node.span)))
        for parameter in pattern.parameters:
            if parameter.name.id not in names:
                assert parameter.default is not None
                names[parameter.name.id] = Bound(parameter.default, inner)
        return self.item(pattern.body, self.outside(inner, env))

    def is_known(self, name: str, env: Env) -> bool:
        """Whether `name = 0` can be a comparison: the name stands for something."""
        return name in self.world.latents or name in env.names or env.module.find(name) is not None

    def check_arguments(self, node: ast.Call, env: Env) -> None:
        """Finds the unknown names in the arguments of a call that is wrong itself."""
        for argument in node.arguments:
            named = tuple(audience.name for audience in self.audiences)
            check_names(
                argument.value, env.module, tuple(env.names), self.world, self.report, named
            )
