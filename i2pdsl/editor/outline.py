"""The statements of a file as an outline, and the call that the cursor stands in."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from i2pdsl.editor.enclosure import argument_name, enclosures
from i2pdsl.editor.reading import read_before
from i2pdsl.editor.surroundings import Surroundings
from i2pdsl.errors import Source, Span, shorten
from i2pdsl.language import ast
from i2pdsl.language.builtins import STATEMENT_WORDS, word_named
from i2pdsl.language.statements import Piece, split_statements
from i2pdsl.worlds.kinds import syntax_of


@dataclass(frozen=True)
class Heading:
    """A statement, or a block of a world: `kind` is its keyword."""

    name: str
    kind: str
    span: Span
    name_span: Span


@dataclass(frozen=True)
class Signature:
    """A call around the cursor: its signature, its parameters as written there, the one at hand."""

    signature: str
    documentation: str
    parameters: tuple[str, ...]
    active: int | None


def headings(source: Source) -> Iterator[Heading]:
    """The statements of a story."""
    for piece in _pieces(split_statements(source, STATEMENT_WORDS).pieces):
        span, keyword = piece.span, piece.keyword
        if keyword in ("let", "pattern", "audience"):
            pattern = _AUDIENCE if keyword == "audience" else _NAMED
            named = pattern.match(source.text, span.start, span.end)
            if named is not None:
                name_span = Span(source, named.start(1), named.end(1))
                yield Heading(named.group(1), keyword, span, name_span)
        elif keyword in ("world", "maximize", "minimize"):
            yield Heading(shorten(source.text[span.start : span.end]), keyword, span, span)
        elif not keyword:
            yield Heading(piece.documentation, keyword, span, span)


_NAMED = re.compile(r"\w+\s+([^\W\d]\w*)")
_AUDIENCE = re.compile(rf"{_NAMED.pattern}\s*=")
_MOST = 500  # headings


def _pieces(pieces: list[Piece]) -> list[Piece]:
    """The first of many, and how many more there are."""
    more = len(pieces) - _MOST
    if more <= 0:
        return [piece for piece in pieces if piece.keyword]
    return [
        *(p for p in pieces[:_MOST] if p.keyword),
        Piece(pieces[_MOST].span, "", f"... {more:,} more"),
    ]


def blocks(source: Source) -> Iterator[Heading]:
    """The blocks of a world."""
    syntax = syntax_of(source)
    for piece in _pieces(syntax.cut(source).pieces):
        head = Span(source, piece.span.start, piece.span.start + len(piece.keyword))
        if piece.keyword in syntax.keywords:
            name = shorten(piece.span.text.split("\n", 1)[0])
            yield Heading(name, piece.keyword, piece.span, head)
        elif not piece.keyword:
            yield Heading(piece.documentation, "", piece.span, head)


def signature_at(
    text: str, offset: int, around: Surroundings, start: str = "file"
) -> Signature | None:
    """The innermost call or form whose brackets are open at a place."""
    reading = read_before(text, offset, start, ended=True) or read_before(text, offset, start)
    if reading is None:
        return None
    expression = start == "expression" or str(next(iter(reading.tokens), "")) not in STATEMENT_WORDS
    for inner in reversed(enclosures(reading.tokens, expression)):
        if inner.kind in ("group", "index", "set", "range"):
            continue
        position = len(inner.parts)
        found = around.module.find(inner.name) if inner.kind == "call" else None
        world = around.vocabulary
        if found is not None and isinstance(found.item, ast.Pattern):
            pattern = found.item
            names = [p.name.id for p in pattern.parameters]
            shown = tuple(" ".join(p.span.text.split()) for p in pattern.parameters)
            free = list(range(len(names)))
            for part in [*inner.parts, inner.part]:
                given = argument_name(part)
                place = names.index(given) if given in names else next(iter(free), None)
                if part is not inner.part and place in free:
                    free.remove(place)
            return Signature(pattern.signature, pattern.documentation, shown, place)
        if inner.kind == "call" and world is not None and inner.name in world.predicates:
            predicate = world.predicates[inner.name]
            signature = f"{predicate.name}({', '.join(predicate.parameters)})"
            active = position if position < len(predicate.parameters) else None
            return Signature(signature, predicate.documentation, predicate.parameters, active)
        word = word_named(
            inner.name if inner.kind == "call" else _FORMS.get(inner.kind, inner.kind)
        )
        return Signature(word.signature, word.documentation, (), None) if word is not None else None
    return None


_FORMS = {"holds": "[ @ ]", "turn": "++", "settings": "", "statement": "", "expression": ""}
