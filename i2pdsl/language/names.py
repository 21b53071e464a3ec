"""Unknown names and wrong calls in what cannot be elaborated: patterns that nothing uses."""

from __future__ import annotations

from collections.abc import Callable, Collection

from i2pdsl.errors import Diagnostic, did_you_mean, shorten
from i2pdsl.language import ast
from i2pdsl.language.arguments import MismatchError, bind, unknown_call_hint
from i2pdsl.language.builtins import FUNCTIONS
from i2pdsl.language.scope import Module
from i2pdsl.language.vocabulary import Vocabulary

Report = Callable[[Diagnostic], None]


def check_names(
    node: ast.Expr,
    module: Module,
    parameters: Collection[str],
    world: Vocabulary | None,
    report: Report,
    audiences: Collection[str] = (),
) -> None:
    """Reports the names in an expression that can mean nothing, and calls that fit no pattern.

    Without a world (in a library) a name may be one of a world that is not known yet.
    """
    _Names(module, frozenset(parameters), world, report, frozenset(audiences)).visit(node, False)


class _Names:
    def __init__(
        self,
        module: Module,
        parameters: frozenset[str],
        world: Vocabulary | None,
        report: Report,
        audiences: frozenset[str],
    ):
        self.module = module
        self.audiences = audiences
        self.parameters = parameters
        self.world = world
        self.report = report

    def is_known(self, name: str) -> bool:
        if name in self.parameters or name in FUNCTIONS or name == "pi":
            return True
        if name in self.audiences:
            return True
        if self.module.find(name) is not None:
            return True
        return self.world is not None and name in self.world.words

    def known(self) -> set[str]:
        words = self.world.words if self.world is not None else ()
        return {*self.parameters, *self.module.known(), *FUNCTIONS, "pi", *words}

    def visit(self, node: ast.Node, seen: bool) -> None:
        """`seen` is whether a predicate of an unknown world may stand here."""
        match node:
            case ast.Name():
                if self.world is not None and not self.is_known(node.id):
                    self.unknown(node)
            case ast.Call():
                self.call(node, seen)
            case ast.Holds():
                self.visit(node.predicate, True)
                self.visit(node.frame, False)
            case ast.Ever():
                self.visit(node.predicate, True)
            case ast.Form():
                self.audience(node.audience)
                for child in ast.children(node):
                    self.visit(child, seen)
            case _:
                for child in ast.children(node):
                    self.visit(child, seen)

    def audience(self, node: ast.Name | None) -> None:
        if self.world is None or node is None or node.id in self.parameters | self.audiences:
            return
        message = f"there is no audience `{shorten(node.id)}`"
        hint = did_you_mean(node.id, self.audiences)
        self.report(Diagnostic("audience", message, node.span, hint))

    def unknown(self, node: ast.Name) -> None:
        if self.module.is_lost(node.id, self.known):
            return
        message = f"unknown name `{shorten(node.id)}`"
        hint = self.module.meant(node.id, self.known)
        self.report(Diagnostic("unknown-name", message, node.span, hint))

    def call(self, node: ast.Call, seen: bool) -> None:
        name = node.callee.id
        found = self.module.find(name) if name not in self.parameters else None
        if found is not None and isinstance(found.item, ast.Pattern):
            latents = self.world.latents if self.world is not None else ()
            try:
                bound = bind(found.item, node, self.may_be_compared, latents)
            except MismatchError as wrong:
                self.report(Diagnostic("arguments", wrong.message, wrong.span, wrong.hint))
                return
            for value in bound.values():
                self.visit(value, True)
            return
        predicates = self.world.predicates if self.world is not None else {}
        if name in FUNCTIONS:
            low, high = FUNCTIONS[name].arity
            if not low <= len(node.arguments) <= high:
                count = f"{low}" if low == high else f"at least {low}"
                message = f"`{name}` takes {count} argument{'s' if low != 1 else ''}"
                hint = f"write `{FUNCTIONS[name].signature}`"
                self.report(Diagnostic("arguments", message, node.span, hint))
        elif name in self.parameters or found is not None:
            message = f"`{name}` is not a pattern and takes no arguments"
            self.report(Diagnostic("call", message, node.span))
        elif name not in predicates and not (seen and self.world is None):
            known = lambda: {*self.module.known_patterns(), *FUNCTIONS, *predicates}
            if self.module.is_lost(name, known):
                return
            message = f"there is no pattern or function `{shorten(name)}`"
            meant = unknown_call_hint(name, lambda: self.module.meant(name, known))
            self.report(Diagnostic("unknown-pattern", message, node.callee.span, meant))
        for argument in node.arguments:
            self.visit(argument.value, seen)

    def may_be_compared(self, name: str) -> bool:
        return self.world is None or self.is_known(name)
