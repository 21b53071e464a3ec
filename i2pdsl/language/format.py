"""The usual layout of a story: spaces, blank lines and indentation. Meaning and comments stay.

Works on the tokens of Lark's trees, so that it knows every form of the grammar. What lies between
two tokens is white space and comments only.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise

from lark import Token, Tree

from i2pdsl.errors import Diagnostic, Source, StoryError, first_of
from i2pdsl.language.build import Builder
from i2pdsl.language.builtins import STATEMENT_WORDS
from i2pdsl.language.parse import few_unknown, statement_tree
from i2pdsl.language.statements import Cut, Piece, check_text, room_for_nesting, split_statements

INDENT = 4
_TAB = 4

_ENTRIES = frozenset(("entry", "entry_shares"))  # each a line of a block of .world files
_FORMS = frozenset(("form", "form_of_all", "form_of_frame", "form_of_audience", "form_apart"))
_CALLS = _FORMS | {"call", "last", "pattern", "settings", "entry_shares"}
_INDEXED = frozenset(("prefix", "frame"))
_BEHIND = _FORMS | _INDEXED | {"whose", "pin"}
_TIGHT_AFTER = frozenset(("LPAR", "LSQB", "LBRACE", "BIG_OPEN", "RANGE"))
_TIGHT_BEFORE = frozenset(("RPAR", "RSQB", "RBRACE", "COMMA", "SEMI", "COLON", "BANG", "RANGE"))
_KEPT = frozenset(("STAR", "SLASH", "CARET"))  # tight where the author wrote them so: t/T
_KEPT_IN_INDEX = frozenset(("PLUS", "MINUS"))  # script[:t-1]


def format_source(source: Source) -> str:
    """The text of a story in the usual layout. Raises StoryError if it cannot be parsed."""
    check_text(source)
    with room_for_nesting():
        return format_statements(source, split_statements(source, STATEMENT_WORDS), _tree)


def _tree(piece: Piece, mistakes: int) -> Tree[Token]:
    """The tree of a statement that has a meaning."""
    tree = statement_tree(piece, mistakes)
    Builder(piece.span.source).statement(tree)
    return tree


def format_statements(
    source: Source,
    cut: Cut,
    parse: Callable[[Piece, int], Tree[Token]],
    drawn: frozenset[str] = frozenset(),
) -> str:
    """The text of statements in the usual layout; those in `drawn` stay as they are.

    `parse` is told how many mistakes there are before a statement.
    """
    words: list[_Word] = []
    problems: list[Diagnostic] = list(cut.problems)
    for piece in cut.pieces:
        try:
            tree = parse(piece, len(problems))
        except StoryError as problem:
            problems.extend(problem.diagnostics)
            continue
        if piece.keyword in drawn:
            lines = [line.rstrip() for line in piece.span.text.split("\n")]
            text = "\n".join(lines)
            words.append(_Word(text, piece.span.start, piece.span.end, True, False, 0))
        else:
            words.extend(_statement(tree, source.text))
    if problems:
        problems.sort(key=lambda d: d.span.start)
        raise StoryError(first_of(few_unknown(problems)))
    return _layout(source.text, words)


@dataclass(frozen=True)
class _Word:
    """A token, whether it begins a statement, and whether a space stands before it on its line.

    `margin` is the least indentation of its statement's later lines, as written; in a block that of
    its entry, which it may begin (`is_entry`).
    """

    text: str
    start: int
    end: int
    first: bool
    space: bool
    margin: int
    is_entry: bool = False


def _statement(tree: Tree[Token], text: str) -> Iterator[_Word]:
    tokens = list(_tokens(tree, False))
    gaps = [text[a.end_pos : b.start_pos] for (a, _, _), (b, _, _) in pairwise(tokens)]
    widths = [_width(gap[gap.rindex("\n") + 1 :]) if "\n" in gap else None for gap in gaps]
    margin = min((width for width in widths if width is not None), default=0)
    entries = {
        next(_tokens(part, False))[0].start_pos
        for part in tree.children
        if isinstance(part, Tree) and part.data in _ENTRIES
    }
    before: tuple[Token, str, bool] | None = None
    for token, width in zip(tokens, [None, *widths], strict=True):
        start, end = token[0].start_pos, token[0].end_pos
        assert start is not None
        assert end is not None
        space, is_entry = before is not None and _spaced(before, token, text), start in entries
        margin = width if is_entry and width is not None else margin
        yield _Word(str(token[0]), start, end, before is None, space, margin, is_entry)
        before = token


def _tokens(tree: Tree[Token], indexed: bool) -> Iterator[tuple[Token, str, bool]]:
    """The tokens of a tree in order, each with its role and whether it stands in an index.

    The role is the rule that the token belongs to; `sign` for a sign before its operand.
    """
    rule = str(tree.data)
    for position, part in enumerate(tree.children):
        if isinstance(part, Tree):
            inside = indexed or (rule in _INDEXED and position > 0)
            inside = inside or (rule == "reduction_range" and position < 6)
            yield from _tokens(part, inside)
        elif part is not None:
            signs = rule in ("minus", "plus", "negative", "sum") and position == 0
            yield part, "sign" if signs else rule, indexed


def _width(indentation: str) -> int:
    return len(indentation.expandtabs(_TAB))


def _spaced(before: tuple[Token, str, bool], after: tuple[Token, str, bool], text: str) -> bool:
    """Whether a space stands between two tokens of a line."""
    left, left_role, _ = before
    right, right_role, _ = after
    if left.type in _TIGHT_AFTER or left_role == "sign" or right.type in _TIGHT_BEFORE:
        return False
    if left.type == "COLON" and left_role == "prefix":
        return False
    if right.type == "LPAR" and right_role in _CALLS:
        return False
    if right.type == "LSQB" and right_role in _BEHIND:
        return False
    for token, role, indexed in (before, after):
        if role != "sign" and (token.type in _KEPT or (indexed and token.type in _KEPT_IN_INDEX)):
            return not _is_tight(token, text)
    return True


def _is_tight(operator: Token, text: str) -> bool:
    """Whether an operator was written without spaces on both sides."""
    assert operator.start_pos is not None
    assert operator.end_pos is not None
    start, end = operator.start_pos, operator.end_pos
    around = text[start - 1 : start], text[end : end + 1]
    return not any(c.isspace() or c == "#" for c in around)


def _layout(text: str, words: list[_Word]) -> str:
    """Joins the words: the author's lines, the usual spaces, comments where they stood."""
    lines: list[str] = []
    line = ""
    end = 0
    for word in words:
        gap = text[end : word.start].split("\n")
        if len(gap) == 1 and line:
            line += " " * word.space
        else:
            lines += _ended(line, gap[0])
            shift = 0 if word.first else INDENT - word.margin
            if word.is_entry and not word.first:
                lines += [_comment(g.strip(), 0, False) for g in gap[1:-1]]
            else:
                lines += [_comment(g, shift, word.first) for g in gap[1:-1]]
            line = "" if word.first else " " * max(INDENT, _width(gap[-1]) + shift)
        line += word.text
        end = word.end
    first, *rest = text[end:].split("\n")
    lines += _ended(line, first)
    lines += [_comment(g, 0, True) for g in rest]
    joined = re.sub(r"\n{3,}", "\n\n", "\n".join(lines)).strip("\n")
    return joined + "\n" if joined else ""


def _ended(line: str, rest: str) -> list[str]:
    """A finished line with its trailing comment; none for what lies before the first line."""
    comment = rest.strip()
    return ["  ".join(part for part in (line, comment) if part)] if line or comment else []


def _comment(line: str, shift: int, outside: bool) -> str:
    """A line that holds a comment or nothing."""
    comment = line.strip()
    if outside or not comment:
        return comment
    indentation = _width(line[: len(line) - len(line.lstrip())])
    return " " * max(INDENT, indentation + shift) + comment
