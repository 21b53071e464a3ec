"""Pygments lexers for stories and worlds: for documents, terminals and notebooks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, ClassVar

from pygments.lexer import Lexer
from pygments.token import (
    Comment,
    Error,
    Keyword,
    Literal,
    Name,
    Number,
    Operator,
    Punctuation,
    String,
    Whitespace,
    _TokenType,
)

from i2pdsl.editor.colours import colour, colour_world

TOKENS: dict[str, _TokenType] = {
    "keyword": Keyword,
    "form": Name.Builtin,
    "story": Name.Builtin.Pseudo,
    "reduction": Operator.Word,
    "function": Name.Function.Magic,
    "call": Name.Function,
    "latent": Name.Variable,
    "definition": Name.Class,
    "constant": Name.Constant,
    "name": Name,
    "number": Number,
    "string": String,
    "comment": Comment.Single,
    "operator": Operator,
    "sign": Punctuation,
    "bracket": Punctuation,
    "map": Literal,
    "space": Whitespace,
    "error": Error,
}
"""The Pygments token of each kind of colours.py."""

_Tokens = Iterator[tuple[int, _TokenType, str]]


class StoryLexer(Lexer):
    """Stories, libraries of patterns and single expressions.

    The option `names` gives the kinds of names that are known ({'weight': 'latent'}), see
    `colours.colour`.
    """

    name = "i2p story"
    aliases: ClassVar[list[str]] = ["story", "i2p"]
    filenames: ClassVar[list[str]] = ["*.story"]
    url = ""

    def __init__(self, **options: Any):
        super().__init__(**options)
        self.names: Mapping[str, str] = options.get("names") or {}

    def get_tokens_unprocessed(self, text: str) -> _Tokens:
        for piece in colour(text, self.names):
            yield piece.start, TOKENS[piece.kind], text[piece.start : piece.end]


class WorldLexer(Lexer):
    """Worlds: a map, where `#` is a wall, and blocks of NAME = VALUE."""

    name = "i2p world"
    aliases: ClassVar[list[str]] = ["i2p-world"]
    filenames: ClassVar[list[str]] = ["*.world"]
    url = ""

    def get_tokens_unprocessed(self, text: str) -> _Tokens:
        for piece in colour_world(text):
            yield piece.start, TOKENS[piece.kind], text[piece.start : piece.end]
