"""The kinds of words in a text, for colours: keyword, form, latent, number, comment...

The words are those of the real grammars: each terminal of grammar/*.lark has a kind here. A text
need not be right or finished: what no terminal matches is of kind `error`, and the pieces joined
are always the text. Some things hang on what stands around a word, and are the same in the real
(contextual) lexer: a statement's word is one in the first column only, and `at` is a keyword in
`deus: table at (1, 3)`, else a name; `before` is one behind `]`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from functools import cache
from typing import NamedTuple

from i2pdsl.errors import Source
from i2pdsl.language.builtins import FUNCTIONS, STATEMENT_WORDS
from i2pdsl.language.forms import BY_TERMINAL
from i2pdsl.language.tables import Tables

EVER = ("NEVER_KW", "EVENTUALLY_KW", "WHEN_KW")  # what is asked of all frames
TERMINALS = {
    **{f"{word.upper()}_KW": "keyword" for word in STATEMENT_WORDS},
    **dict.fromkeys(("IF_KW", "THEN_KW", "ELSE_KW"), "keyword"),
    **dict.fromkeys(("AND_KW", "OR_KW", "NOT_KW", "IN_KW", "AT_KW", "BEFORE_KW"), "keyword"),
    **dict.fromkeys((*BY_TERMINAL, "LAST_KW", *EVER), "form"),
    **dict.fromkeys(("SCRIPT_KW", "T_VAR", "T_END", "NAME_T"), "story"),
    **dict.fromkeys(("BIG_T", "BIG_OPEN"), "reduction"),
    **dict.fromkeys(("LPAR", "RPAR", "LSQB", "RSQB", "LBRACE", "RBRACE"), "bracket"),
    **dict.fromkeys(("COMMA", "COLON", "SEMI", "BAR", "DBAR", "AT", "RANGE", "BANG"), "sign"),
    **dict.fromkeys(("PLUS", "PLUSPLUS", "MINUS", "STAR", "SLASH", "CARET"), "operator"),
    **dict.fromkeys(("LT", "LE", "EQ", "NE", "GE", "GT"), "operator"),
    "NAMED": "name",
    "NAME": "name",
    "NUMBER": "number",
    "STRING": "string",
    "COMMENT": "comment",
    "SPACE": "space",
}
"""What each terminal of grammar/story.lark is. `name` is looked at more closely, see `kind_of`."""

WORLD_TERMINALS = {
    **dict.fromkeys(("LPAR", "RPAR", "LSQB", "RSQB", "LBRACE", "RBRACE"), "bracket"),
    "COMMA": "sign",
    "COLON": "sign",
    "EQ": "operator",
    "MINUS": "operator",
    "NAME": "name",
    "NUMBER": "number",
    "STRING": "string",
    "ROW": "map",
    "COMMENT": "comment",
    "SPACE": "space",
}
"""What each terminal of a world's grammar is, besides its keywords."""

LATENT = re.compile(r"rho(?:_\w+)?|[BGR]_\w+")
"""The latents of every grid world; those of other worlds are known with their vocabulary."""


class Piece(NamedTuple):
    """A piece of a text, [start, end), and the terminal that it is ('' where none matches)."""

    kind: str
    start: int
    end: int
    terminal: str


def colour(text: str, names: Mapping[str, str] | None = None) -> Iterator[Piece]:
    """The pieces of a story or an expression, without gaps.

    `names` gives the kind of names that are known: {'weight': 'latent', 'plot': 'keyword'}.
    """
    known = names or {}
    before: list[Piece] = []  # up to three pieces that are neither space nor comment
    for terminal, start, end in _scan(text, *_story()):
        kind = TERMINALS.get(terminal, "error")
        if terminal == "AT_KW" and [p.terminal for p in before] != ["NAME", "COLON", "NAME"]:
            terminal, kind = "NAME", "name"
        if terminal == "BEFORE_KW" and (not before or before[-1].terminal != "RSQB"):
            terminal, kind = "NAME", "name"
        if kind == "keyword" and terminal in _STATEMENT_TERMINALS and not _first(text, start):
            terminal, kind = "NAME", "name"
        if kind == "name":
            terminal = "NAME"
            last = before[-1].terminal if before else ""
            kind = known.get(text[start:end]) or kind_of(text, start, end, last)
        piece = Piece(kind, start, end, terminal)
        if kind not in ("space", "comment"):
            before = [*before[-2:], piece]
        yield piece


_STATEMENT_TERMINALS = frozenset(f"{word.upper()}_KW" for word in STATEMENT_WORDS)
_CALLED = re.compile(r"[ \t]*\(")
_GIVEN = re.compile(r"[ \t]*=")


def kind_of(text: str, start: int, end: int, last: str) -> str:
    """The kind of a name, from the text alone; `last` is the terminal before it."""
    name = text[start:end]
    if last in ("LET_KW", "PATTERN_KW") or (last == "AUDIENCE_KW" and _GIVEN.match(text, end)):
        return "definition"
    if name in FUNCTIONS:
        return "function"
    if name == "pi":
        return "constant"
    if LATENT.fullmatch(name):
        return "latent"
    return "call" if _CALLED.match(text, end) else "name"


def colour_world(text: str) -> Iterator[Piece]:
    """The pieces of a .world file, without gaps. In the map `#` is a wall, no comment."""
    from i2pdsl.worlds.kinds import syntax_of

    syntax = syntax_of(Source("world", text))
    drawing = {f"{word.upper()}_KW" for word in syntax.drawn}
    drawn = False
    for line in re.finditer(r"[^\n]*\n|[^\n]+", text):
        start, end = line.span()
        if drawn and text[start].isspace():
            yield from _row(text, start, end)
            continue
        beginning = not text[start].isspace() and text[start] != "#"
        drawn = drawn and not beginning
        for terminal, begin, stop in _scan(text, *_world(syntax.grammar), start, end):
            is_keyword = terminal.endswith("_KW")
            kind = "keyword" if is_keyword else WORLD_TERMINALS.get(terminal, "error")
            if kind == "keyword" and begin != start:
                terminal, kind = "NAME", "name"
            if kind == "name" and re.compile(r"\s*=").match(text, stop):
                kind = "definition"
            yield Piece(kind, begin, stop, terminal)
            if terminal in drawing:
                drawn = True
                yield from _row(text, stop, end)
                break


def _row(text: str, start: int, end: int) -> Iterator[Piece]:
    for found in re.compile(r"\s+|\S+").finditer(text, start, end):
        space = found.group().isspace()
        kind, terminal = ("space", "SPACE") if space else ("map", "ROW")
        yield Piece(kind, found.start(), found.end(), terminal)


def _first(text: str, start: int) -> bool:
    return start == 0 or text[start - 1] == "\n"


def _scan(
    text: str,
    pattern: re.Pattern[str],
    terminals: tuple[str, ...],
    start: int = 0,
    end: int | None = None,
) -> Iterator[tuple[str, int, int]]:
    """The terminals of a text; a character that begins none has the terminal ''."""
    end = len(text) if end is None else end
    while start < end:
        found = pattern.match(text, start, end)
        if found is None:
            stop = start + 1
            if text[start] == '"':  # a text that is never closed
                line_end = text.find("\n", start, end)
                stop = end if line_end < 0 else line_end
                yield "STRING", start, stop
            else:
                yield "", start, stop
        else:
            assert found.lastindex is not None
            stop = found.end()
            yield terminals[found.lastindex - 1], start, stop
        start = stop


@cache
def _story() -> tuple[re.Pattern[str], tuple[str, ...]]:
    from i2pdsl.language.parse import tables

    # NAMED is a NAME with `=` behind it; NAME_T is `t` too.
    return _alternatives(tables(), ("NAMED", "NAME_T"))


@cache
def _world(file: str) -> tuple[re.Pattern[str], tuple[str, ...]]:
    from i2pdsl.worlds.blocks import tables

    return _alternatives(tables(file), ("ROW",))


def _alternatives(tables: Tables, but: tuple[str, ...]) -> tuple[re.Pattern[str], tuple[str, ...]]:
    """One pattern with a group for each terminal, in the order in which Lark tries them."""
    terminals = [t for t in tables.terminals if t.name not in but]
    groups = "|".join(f"({_without_groups(t.pattern)})" for t in terminals)
    return re.compile(groups), tuple(t.name for t in terminals)


def _without_groups(pattern: str) -> str:
    """The same pattern whose own groups do not count."""
    return re.sub(r"(?<!\\)\((?!\?)", "(?:", pattern)
