"""The arguments of a call, by the parameters of the pattern."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from i2pdsl.errors import Span, closest
from i2pdsl.language import ast


class MismatchError(Exception):
    """The arguments of a call do not fit the parameters of the pattern."""

    def __init__(self, message: str, span: Span, hint: str):
        super().__init__(message)
        self.message = message
        self.span = span
        self.hint = hint


def bind(
    pattern: ast.Pattern,
    node: ast.Call,
    is_known: Callable[[str], bool],
    latents: Iterable[str] = (),
) -> dict[str, ast.Expr]:
    """The arguments of a call by the names of the parameters. Raises MismatchError.

    `NAME = EXPR` is a named argument if NAME is a parameter, else a comparison, for which
    `is_known` must hold; `latents` are what a misspelt one may have meant.
    """
    parameters = [p.name.id for p in pattern.parameters]
    known = set(parameters)
    hint = f"its signature: {pattern.signature}"
    bound: dict[str, ast.Expr] = {}
    free = (name for name in parameters if name not in bound)
    for argument in node.arguments:
        value = argument.value
        if argument.name is not None and argument.name.id in known:
            name = argument.name.id
            if name in bound:
                raise MismatchError(f"`{name}` is given twice", argument.span, hint)
        else:
            if argument.name is not None:
                value = _comparison(argument, argument.name, pattern, is_known, latents)
            name = next(free, "")
            if not name:
                message = f"too many arguments for `{pattern.name.id}`"
                raise MismatchError(message, argument.span, hint)
        bound[name] = value
    missing = [
        f"`{p.name.id}`" for p in pattern.parameters if p.default is None and p.name.id not in bound
    ]
    if missing:
        message = f"`{pattern.name.id}` needs an argument for {' and '.join(missing)}"
        raise MismatchError(message, node.span, hint)
    return bound


def _comparison(
    argument: ast.Argument,
    name: ast.Name,
    pattern: ast.Pattern,
    is_known: Callable[[str], bool],
    latents: Iterable[str],
) -> ast.Expr:
    """`rho = 0` for a pattern without a parameter `rho`: a condition."""
    if argument.comparison is not None and is_known(name.id):
        return argument.comparison
    hint = f"its signature: {pattern.signature}"
    if argument.comparison is None and is_known(name.id):
        hint = f"put what `{name.id}` is compared with in parentheses"
    else:
        close = closest(name.id, [*(p.name.id for p in pattern.parameters), *latents])
        hint = f"did you mean `{close}`? ({hint})" if close else hint
    message = f"`{pattern.name.id}` has no parameter `{name.id}`"
    raise MismatchError(message, name.span, hint)


def unknown_call_hint(name: str, meant: Callable[[], str | None]) -> str | None:
    """What a call of an unknown function or pattern was meant to be."""
    if name in ("sum", "mean"):
        return f"write `{name}_t EXPRESSION`"
    if name.lower() in ("p", "pr", "prob", "probability"):
        return "write `P(EVENT | script[:t])`"
    return meant()
