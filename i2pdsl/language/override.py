"""`--set NAME=VALUE`: a story with one of its values replaced, as text, so that what is stored
with a script is what was really solved."""

from __future__ import annotations

from i2pdsl.errors import Diagnostic, Source, Span, StoryError, did_you_mean, whole_file
from i2pdsl.language import ast
from i2pdsl.language.methods import METHODS
from i2pdsl.language.naming import same_name
from i2pdsl.language.parse import parse_expression, parse_tolerantly
from i2pdsl.language.vocabulary import Weights

_STATEMENTS = ("length", *Weights._fields)


def override(
    source: Source,
    name: str,
    value: str,
    world_settings: tuple[str, ...] = (),
    method: str = "beam",
) -> Source:
    """The story with `name` set to `value` (an expression, as it would be written).

    A name is a `let` of the file, `length`, the weight of an automatic term, a setting of the
    search (`starts`, `steps`, ...) or of the world (`beta`, ...). `method` is the world's usual
    search.
    Raises StoryError for any other, and for a value that is not one expression.
    """
    where, is_set = f"--set {name}", value.lstrip().startswith("{")
    parse_expression(Source(where, f"0 in {value}" if is_set else value))
    program, _ = parse_tolerantly(source)
    name = same_name(name)
    for let in program.of(ast.Let):
        if let.name.id == name:
            return _replaced(source, let.value.span, value)
    if name in _STATEMENTS:
        for statement in program.statements:
            if isinstance(statement, ast.LengthIs) and name == "length":
                return _replaced(source, statement.value, value)
            if isinstance(statement, ast.Weight) and statement.term == name:
                return _replaced(source, statement.value.span, value)
        return Source(source.name, f"{source.text.rstrip()}\n{name} {value}\n")
    of_search = tuple(s.name for s in METHODS[method].settings(None) or ())
    if name in of_search:
        searches = program.of(ast.Search)
        if not searches:
            line = f"search {method}({name} = {value})"
            return Source(source.name, f"{source.text.rstrip()}\n{line}\n")
        return _with_setting(source, searches[0], name, value)
    worlds = program.of(ast.World)
    if name in world_settings and worlds:
        return _with_setting(source, worlds[0], name, value)
    lets = [let.name.id for let in program.of(ast.Let)]
    known = (*lets, *_STATEMENTS, *of_search, *world_settings)
    message = f"the story has no `{name}` to set"
    hint = did_you_mean(name, known) or "known: " + ", ".join(known)
    raise StoryError([Diagnostic("set", message, whole_file(source.name), hint)])


def _replaced(source: Source, span: Span, value: str) -> Source:
    text = source.text
    return Source(source.name, f"{text[: span.start]}{value}{text[span.end :]}")


def _with_setting(
    source: Source, statement: ast.World | ast.Search, name: str, value: str
) -> Source:
    for argument in statement.settings:
        if argument.name is not None and argument.name.id == name:
            return _replaced(source, argument.value.span, value)
    if statement.settings:
        last = statement.settings[-1].span
        return _replaced(source, Span(source, last.end, last.end), f", {name} = {value}")
    end = statement.name.span.end
    # An empty pair of brackets may stand there already.
    rest = statement.span.text[end - statement.span.start :]
    span = Span(source, end, statement.span.end if rest.strip() == "()" else end)
    return _replaced(source, span, f"({name} = {value})")
