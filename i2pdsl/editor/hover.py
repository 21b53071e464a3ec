"""What is said of a word where the cursor rests: what it is, its type, its documentation."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from i2pdsl.editor.colours import EVER, Piece, colour
from i2pdsl.editor.complete import offers_at
from i2pdsl.editor.names import definition_offer, latent_offer
from i2pdsl.editor.offers import Offer, audience_offer
from i2pdsl.editor.reading import line_around, read_before, statement_around
from i2pdsl.editor.surroundings import Surroundings
from i2pdsl.editor.types import type_of
from i2pdsl.editor.words import explanation
from i2pdsl.errors import Source, StoryError
from i2pdsl.language import ast
from i2pdsl.language.forms import BY_TERMINAL
from i2pdsl.language.kinds import PARAMETER_KINDS, parameter_kinds, result_kind
from i2pdsl.language.parse import parse_expression

_SILENT = ("space", "comment", "number", "string", "operator", "sign", "bracket", "error")
_TELLING = ("++", "@", "in")  # operators that are forms of the language
_FORMS: dict[str, tuple[type[ast.Node], ...]] = {
    **dict.fromkeys(BY_TERMINAL, (ast.Form,)),
    "LAST_KW": (ast.LastOf,),
    "BIG_T": (ast.Reduction,),
    "BIG_OPEN": (ast.Reduction,),
    **dict.fromkeys(EVER, (ast.Ever,)),
    "SCRIPT_KW": (ast.Prefix, ast.FrameOf, ast.Append, ast.Script),
    "IF_KW": (ast.If,),
    "NAME": (ast.Call, ast.Name),
}


@dataclass(frozen=True)
class Hover:
    """What is known of the word in [start, end).

    `what` is its kind (as in `offers.Offer`), `signature` one line, `type` a value and its axes
    or ''.
    """

    start: int
    end: int
    what: str
    signature: str
    type: str
    documentation: str
    example: str = ""

    def markdown(self) -> str:
        """For an editor."""
        lines = [f"```story\n{self.signature}\n```"]
        if self.type:
            lines.append(f"*{self.type}*")
        elif self.what not in ("form", "keyword", "reduction", "story", "operator", "sign"):
            lines.append(f"*{self.what}*")
        if self.documentation:
            lines.append(self.documentation)
        if self.example and self.example != self.signature:
            lines.append(f"For instance `{self.example}`")
        return "\n\n".join(lines)


def hover(text: str, offset: int, around: Surroundings, start: str = "file") -> Hover | None:
    """What is known of the word at a place; None where there is nothing to say."""
    piece = word_at(text, offset)
    if piece is None:
        return None
    word = text[piece.start : piece.end]
    offer = _offered(text, piece, word, around, start) or _known(word, around)
    about = explanation(word)
    if offer is None and about is None:
        return None
    node = _node(text, piece, start)
    shown = _type(word, node, offer, around)
    if offer is None or offer.kind not in _NAMES:
        if about is None:
            assert offer is not None
            detail = offer.detail or word
            return Hover(piece.start, piece.end, offer.kind, detail, shown, offer.documentation)
        return Hover(
            piece.start,
            piece.end,
            piece.kind,
            about.signature,
            shown,
            about.documentation,
            about.example,
        )
    return Hover(
        piece.start,
        piece.end,
        offer.kind,
        offer.detail or word,
        shown,
        offer.documentation,
    )


_OF_LATENT = {
    "number": "number over hypotheses",
    "symbol": "name over hypotheses",
    "truth": "event",
}
_NAMES = (
    "latent",
    "value",
    "character",
    "object",
    "place",
    "predicate",
    "event",
    "action",
    "pattern",
    "let",
    "parameter",
    "argument",
    "setting",
    "world",
    "library",
    "audience",
    "search",
)


def word_at(text: str, offset: int) -> Piece | None:
    """The word that the cursor touches; the one behind it, where it stands between two."""
    found = None
    line, end = line_around(text, offset)
    for piece in colour(text[line:end]):
        start, stop = piece.start + line, piece.end + line
        told = piece.kind not in _SILENT or text[start:stop] in _TELLING
        if told and start <= offset <= stop:
            found = piece._replace(start=start, end=stop)
    return found


def _offered(text: str, piece: Piece, word: str, around: Surroundings, start: str) -> Offer | None:
    """The word as it would be offered at its place: there it has its meaning."""
    reading = read_before(text, piece.start, start)
    if reading is None or (reading.accepts is None and not reading.begins):
        return None
    named = is_named(text, piece.end)
    found = [o for o in offers_at(reading, text, around, start, word) if o.text == word]
    found.sort(key=lambda o: (o.kind == "argument") != named)
    offer = found[0] if found else None
    if offer is not None and offer.kind == "parameter":
        return _own_parameter(text, piece, word, around) or offer
    if offer is None and piece.kind != "definition":
        return _own_parameter(text, piece, word, around)
    return offer


_EQUALS = re.compile(r"[ \t]*=")


def is_named(text: str, end: int) -> bool:
    """Whether `=` follows a name that ends there."""
    return _EQUALS.match(text, end) is not None


def _own_parameter(text: str, piece: Piece, word: str, around: Surroundings) -> Offer | None:
    """A parameter of the pattern that is defined around the place."""
    pattern = pattern_around(text, piece.start)
    for parameter in pattern.parameters if pattern is not None else ():
        if parameter.name.id == word and pattern is not None:
            kind = parameter_kinds(pattern, around.module).get(word, "any")
            detail = " ".join(parameter.span.text.split())
            about = f"a parameter of `{pattern.name.id}`: {PARAMETER_KINDS.get(kind, kind)}"
            return Offer(word, "parameter", detail, about)
    return None


def pattern_around(text: str, offset: int) -> ast.Pattern | None:
    """The pattern whose definition stands around a place."""
    statement = statement_around(text, offset)
    return statement if isinstance(statement, ast.Pattern) else None


def _known(word: str, around: Surroundings) -> Offer | None:
    """A name that means something somewhere in this file."""
    found = around.module.find(word)
    if found is not None:
        return definition_offer(found)
    world = around.vocabulary
    if world is not None and word in world.latents:
        return latent_offer(world.latents[word])
    return next((audience_offer(a) for a in around.audiences if a.name == word), None)


# Types.


def _node(text: str, piece: Piece, start: str) -> ast.Expr | None:
    """The expression that begins with the word."""
    kinds = _FORMS.get(piece.terminal, ())
    found: list[ast.Node] = []
    for top in _tops(text, piece.start, start):
        found += [n for n in ast.walk(top) if n.span.start == piece.start and isinstance(n, kinds)]
    found.sort(key=lambda n: kinds.index(type(n)))
    return found[0] if found else None  # type: ignore[return-value]


def _tops(text: str, offset: int, start: str) -> Iterator[ast.Node]:
    if start == "expression":
        try:
            yield parse_expression(Source("", text))
        except StoryError:
            return
    else:
        statement = statement_around(text, offset)
        yield from () if statement is None else (statement,)


def _type(word: str, node: ast.Expr | None, offer: Offer | None, around: Surroundings) -> str:
    if offer is not None and offer.kind in ("let", "pattern"):
        found = around.module.find(word)
        if found is None:
            return ""
        if isinstance(found.item, ast.Let):
            told = type_of(found.item.value, around, found.module)
            return told or result_kind(found.item, found.module)
        if isinstance(node, ast.Call):
            told = type_of(node, around)
            if told:
                return told
        return result_kind(found.item, found.module)
    if offer is not None and offer.kind in ("value", "parameter", "argument", "action", "setting"):
        return ""
    world = around.vocabulary
    if offer is not None and offer.kind == "latent" and world is not None:
        return _OF_LATENT[world.latents[word].kind]
    if offer is not None and offer.kind == "predicate" and world is not None:
        number = world.predicates[word].is_number
        return "number of a frame" if number else "condition of a frame"
    return type_of(node, around) if node is not None else ""
