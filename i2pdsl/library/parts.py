"""The parts of a story that become parameters: how they are named, and where they can stand."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from i2pdsl.errors import Source, Span, StoryError, error
from i2pdsl.language import ast
from i2pdsl.language.build import Builder
from i2pdsl.language.parse import parse_tree
from i2pdsl.language.scope import Module
from i2pdsl.language.statements import check_brackets, check_text, room_for_nesting


@dataclass(frozen=True)
class Part:
    """`NAME=EXPRESSION`: what becomes a parameter, as it was typed (`source`)."""

    name: str
    source: Source
    value: ast.Expr

    @property
    def place(self) -> Span:
        """Of the name."""
        return Span(self.source, 0, len(self.name))

    @property
    def text(self) -> str:
        return " ".join(self.value.span.text.split())


def read_part(text: str) -> Part:
    """Reads `NAME=EXPRESSION`. Raises StoryError with places in that text."""
    source = Source("--param", text)
    match = re.match(r"\s*([^\W\d]\w*)\s*=(?!=)", text)
    if match is None:
        whole = Span(source, 0, len(text))
        hint = 'for instance --param before="rho > 0"'
        raise error("extract", "expected NAME=EXPRESSION", whole, hint)
    shifted = Source("--param", text[match.start(1) :])
    place = Span(shifted, match.end() - match.start(1), len(shifted.text))
    check_text(shifted)
    if not place.text.strip():
        raise error("extract", "expected a part of the objective after `=`", place)
    problems = check_brackets(shifted)
    if problems:
        raise StoryError(problems)
    with room_for_nesting():
        return Part(
            match[1], shifted, Builder(shifted).expression(parse_tree(shifted, place, "expression"))
        )


def written_in(value: ast.Expr, module: Module) -> Iterator[ast.Node]:
    """An expression and all that is written in it, each place once.

    `rho = 0` in `depict(rho = 0)` is a comparison, since `depict` has no parameter `rho`; the names
    in an appended turn, and that of the audience of a form, are places too.
    """
    waiting: list[ast.Node] = [value]
    while waiting:
        node = waiting.pop()
        yield node
        if isinstance(node, ast.Call):
            found = module.find(node.callee.id)
            known: set[str] = set()
            if found is not None and isinstance(found.item, ast.Pattern):
                known = {p.name.id for p in found.item.parameters}
            for argument in node.arguments:
                named = argument.name is None or argument.name.id in known
                other = argument.comparison
                waiting.append(argument.value if named or other is None else other)
            continue
        if isinstance(node, ast.Form) and node.audience is not None:
            waiting.append(node.audience)
        if isinstance(node, ast.Append):
            for move in node.turn:
                waiting += [move.who, move.action] if isinstance(move, ast.Move) else [move.thing]
        waiting.extend(ast.children(node))
