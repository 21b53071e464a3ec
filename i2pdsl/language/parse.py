"""From text to syntax tree, by grammar/story.lark."""

from __future__ import annotations

from dataclasses import replace
from functools import cache, lru_cache
from pathlib import Path

from lark import Lark, Token, Tree

from i2pdsl.errors import MOST_SHOWN, Diagnostic, Source, Span, StoryError, closest, shorten
from i2pdsl.language import ast
from i2pdsl.language.build import Builder
from i2pdsl.language.builtins import STATEMENT_WORDS
from i2pdsl.language.forms import with_words
from i2pdsl.language.mistakes import explain
from i2pdsl.language.naming import with_marks
from i2pdsl.language.statements import (
    DEEPEST,
    Piece,
    check_brackets,
    check_text,
    read_source,
    room_for_nesting,
    split_statements,
    too_deep,
)
from i2pdsl.language.tables import Tables, UnexpectedError, lark_of
from i2pdsl.resources import data_folder

MOST_UNKNOWN = 10  # lines that begin no statement, of a text that is no story, that are reported


STARTS = ("statement", "expression")


@cache
def grammar_text() -> str:
    """The grammar of stories, as Lark reads it."""
    text = (data_folder("grammar") / "story.lark").read_text(encoding="utf-8")
    return with_marks(with_words(text))


@cache
def grammar() -> Lark:
    """Lark's own LALR(1) parser of stories."""
    return lark_of(grammar_text(), STARTS)


@cache
def tables() -> Tables:
    """The same grammar, for a faster driver."""
    return Tables.kept(grammar_text(), STARTS, FLAT)


def parse_file(path: Path | str) -> ast.Program:
    """Reads and parses a .story file. Raises StoryError with every mistake of the syntax."""
    return parse(read_source(path))


def parse(source: Source) -> ast.Program:
    """Parses a story or a library. Raises StoryError with every mistake of the syntax."""
    program, problems = parse_tolerantly(source)
    if problems:
        raise StoryError(problems)
    return program


def parse_tolerantly(source: Source) -> tuple[ast.Program, list[Diagnostic]]:
    """The statements that could be read, and the mistakes of the others."""
    check_text(source)
    pieces, unread, problems = split_statements(source, STATEMENT_WORDS)
    statements = []
    with room_for_nesting():
        for piece in pieces:
            try:
                builder = Builder(source, piece.documentation)
                statements.append(builder.statement(statement_tree(piece, len(problems))))
            except StoryError as problem:
                problems.extend(problem.diagnostics)
                unread.append(piece.span)
    problems.sort(key=lambda d: d.span.start)
    return ast.Program(source, tuple(statements), tuple(unread)), few_unknown(problems)


def few_unknown(problems: list[Diagnostic]) -> list[Diagnostic]:
    """Without the many lines that begin no statement, of a text that is no story."""
    unknown = [d for d in problems if d.code == "statement"]
    more = len(unknown) - MOST_UNKNOWN
    if more <= 0:
        return problems
    last = unknown[MOST_UNKNOWN - 1]
    counted = f"and {more:,} more line{' begins' if more == 1 else 's begin'} no statement"
    told = replace(last, hint=f"{last.hint} ({counted})" if last.hint else counted)
    left_out = set(map(id, unknown[MOST_UNKNOWN:]))
    kept = (d for d in problems if id(d) not in left_out)
    return [told if d is last else d for d in kept]


@lru_cache(64)
def parse_expression(source: Source) -> ast.Expr:
    """Parses a single expression, as asked in a query: often the same one, of many scripts."""
    check_text(source)
    span = Span(source, 0, len(source.text))
    if not source.text.strip():
        raise StoryError([Diagnostic("syntax", "expected an expression, found nothing", span)])
    problems = check_brackets(source)
    if problems:
        raise StoryError(problems)
    with room_for_nesting():
        return Builder(source).expression(parse_tree(source, span, "expression"))


def statement_tree(piece: Piece, mistakes: int = 0) -> Tree[Token]:
    """Lark's tree of a statement. Raises StoryError.

    `mistakes` is how many there are before it: those that are not shown are not explained either.
    """
    if piece.keyword not in STATEMENT_WORDS:
        raise StoryError([_no_statement(piece, mistakes)])
    return parse_tree(piece.span.source, piece.span, "statement", mistakes)


def _no_statement(piece: Piece, mistakes: int) -> Diagnostic:
    if mistakes > MOST_SHOWN:
        start = Span(piece.span.source, piece.span.start, piece.span.start + 1)
        return Diagnostic("statement", "this begins no statement", start)
    text, word = piece.span.text, piece.keyword
    close = closest(word, STATEMENT_WORDS) if word else None
    if close:
        hint = f"did you mean `{close}`?"
    elif word and text[len(word) :].lstrip().startswith("="):
        hint = f"a name is given with `let`: `let {word} = ...`"
    elif "P(" in text or "sum_t" in text:
        hint = "an objective begins with `maximize`"
    else:
        hint = "a statement begins with one of " + ", ".join(STATEMENT_WORDS)
    shown = shorten(word) or (text[:1] if text[:1].isprintable() else f"U+{ord(text[0]):04X}")
    span = Span(piece.span.source, piece.span.start, piece.span.start + max(1, len(word)))
    return Diagnostic("statement", f"`{shown}` begins no statement", span, hint)


def parse_tree(source: Source, span: Span, start: str, mistakes: int = 0) -> Tree[Token]:
    """Lark's tree of a part of a text. Raises StoryError."""
    try:
        tree = tables().parse(source.text, span.start, span.end, start)
    except UnexpectedError as problem:
        if mistakes > MOST_SHOWN:
            place = Span(source, problem.start, min(problem.start + 1, span.end))
            raise StoryError([Diagnostic("syntax", "this cannot be read", place)]) from None
        raise StoryError([explain(problem, source, span)]) from None
    if tree.meta.depth > DEEPEST + 10:  # type: ignore[attr-defined]
        raise too_deep(_too_deep(tree, source))
    return tree


def _too_deep(tree: Tree[Token], source: Source) -> Span:
    """A part that is nested too deeply. Nesting without brackets (`not not ...`, `- - ...`) counts
    too. Without recursion."""
    stack: list[tuple[Tree[Token], int]] = [(tree, 0)]
    while stack:
        node, depth = stack.pop()
        if node.data not in FLAT:
            depth += 1
            if depth > DEEPEST + 10:
                break
        stack.extend((child, depth) for child in node.children if isinstance(child, Tree))
    return Span(source, node.meta.start_pos, node.meta.end_pos)


FLAT = frozenset(
    ("group", "argument", "argument_named", "about", "given", "settings", "set", "turn")
)
