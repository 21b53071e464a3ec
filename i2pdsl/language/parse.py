"""From text to syntax tree, by grammar/story.lark."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedInput
from lark.utils import TextSlice

from i2pdsl.errors import Diagnostic, Source, Span, StoryError, did_you_mean
from i2pdsl.language import ast
from i2pdsl.language.mistakes import explain
from i2pdsl.language.statements import (
    DEEPEST,
    Piece,
    check_text,
    read_source,
    split_statements,
    too_deep,
)
from i2pdsl.resources import data_folder

STATEMENT_WORDS = (
    "world",
    "length",
    "start",
    "allow",
    "let",
    "pattern",
    "import",
    "maximize",
    "minimize",
    "rationality",
    "plausibility",
    "assume",
    "audience",
    "search",
)
RESERVED = frozenset(
    (*STATEMENT_WORDS, *["script", "t", "T", "P", "E", "V", "KL", "entropy", "surprise", "suspense", "last"])
) | frozenset(["if", "then", "else", "and", "or", "not", "in"])


@cache
def grammar() -> Lark:
    """The LALR(1) parser of stories."""
    text = (data_folder("grammar") / "story.lark").read_text(encoding="utf-8")
    return Lark(
        text,
        parser="lalr",
        lexer="contextual",
        start=["statement", "expression"],
        propagate_positions=True,
        maybe_placeholders=True,
    )


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
    pieces, problems = split_statements(source, STATEMENT_WORDS)
    statements = []
    for piece in pieces:
        try:
            statements.append(_statement(piece))
        except StoryError as problem:
            problems.extend(problem.diagnostics)
    problems.sort(key=lambda d: d.span.start)
    return ast.Program(source, tuple(statements)), problems


def parse_expression(source: Source) -> ast.Expr:
    """Parses a single expression, as asked in a query."""
    check_text(source)
    if not source.text.strip():
        span = Span(source, 0, len(source.text))
        raise StoryError([Diagnostic("syntax", "an expression is expected here", span)])
    pieces, problems = split_statements(Source(source.name, "=" + source.text), ())
    if len(pieces) == 1 and not problems:
        return _Builder(source).expression(
            _parse(source, Span(source, 0, len(source.text)), "expression")
        )
    problems = [_shifted(d, source) for d in problems]
    if not problems:
        rest = pieces[1].span if len(pieces) > 1 else Span(source, 1, len(source.text))
        message = "one expression is expected, this begins another"
        problems = [Diagnostic("syntax", message, Span(source, rest.start - 1, rest.end - 1))]
    raise StoryError(problems)


def _shifted(problem: Diagnostic, source: Source) -> Diagnostic:
    span = Span(source, problem.span.start - 1, problem.span.end - 1)
    return Diagnostic(problem.code, problem.message, span, problem.hint)


def _statement(piece: Piece) -> ast.Statement:
    span = piece.span
    if piece.keyword not in STATEMENT_WORDS:
        word_end = span.start + max(1, len(piece.keyword))
        shown = piece.keyword or span.text[:1]
        hint = did_you_mean(piece.keyword, STATEMENT_WORDS) if piece.keyword else None
        if "P(" in span.text or "sum_t" in span.text:
            hint = hint if hint and "mean" in hint else "an objective begins with `maximize`"
        raise StoryError(
            [
                Diagnostic(
                    "statement",
                    f"`{shown}` begins no statement",
                    Span(span.source, span.start, word_end),
                    hint or "a statement begins with one of " + ", ".join(STATEMENT_WORDS),
                )
            ]
        )
    tree = _parse(span.source, span, "statement")
    return _Builder(span.source, piece.documentation).statement(tree)


def _parse(source: Source, span: Span, start: str) -> Tree[Token]:
    try:
        tree = grammar().parse(TextSlice(source.text, span.start, span.end), start=start)
    except UnexpectedInput as problem:
        raise StoryError([explain(problem, source, span)]) from None
    _check_depth(tree, source)
    return tree


def _check_depth(tree: Tree[Token], source: Source) -> None:
    """Nesting without brackets (`not not ...`, `- - ...`) counts too. Without recursion."""
    stack: list[tuple[Tree[Token], int]] = [(tree, 0)]
    while stack:
        node, depth = stack.pop()
        if node.data not in _FLAT:
            depth += 1
            if depth > DEEPEST + 10:
                raise too_deep(Span(source, node.meta.start_pos, node.meta.end_pos))
        stack.extend((child, depth) for child in node.children if isinstance(child, Tree))


_FLAT = frozenset(("group", "argument", "argument_named", "given", "settings", "set", "turn"))


class _Builder:
    """Builds the syntax tree from Lark's; one method for each rule's name."""

    def __init__(self, source: Source, documentation: str = ""):
        self.source = source
        self.documentation = documentation

    def span(self, item: Tree[Token] | Token) -> Span:
        if isinstance(item, Token):
            assert item.start_pos is not None
            assert item.end_pos is not None
            return Span(self.source, item.start_pos, item.end_pos)
        return Span(self.source, item.meta.start_pos, item.meta.end_pos)

    def name(self, token: Token) -> ast.Name:
        return ast.Name(self.span(token), str(token))

    def target(self, item: Any) -> ast.Name | ast.Text:
        return self.text(item) if item.type == "STRING" else self.name(item)

    def text(self, token: Token) -> ast.Text:
        return ast.Text(self.span(token), str(token)[1:-1])

    def statement(self, tree: Tree[Token]) -> ast.Statement:
        span = self.span(tree)
        parts = tree.children
        rest: Any = parts[1]
        match str(tree.data):
            case "world":
                return ast.World(span, self.target(rest), self.settings(parts[2]))
            case "length":
                return ast.LengthIs(span, self.expression(rest))
            case "start":
                return ast.Start(span, self.expression(rest))
            case "allow":
                return ast.Allow(span, self.expressions(parts[1:]))
            case "let":
                return ast.Let(span, self.name(rest), self.expression(parts[3]))
            case "pattern":
                return self.pattern(tree)
            case "import_":
                return ast.Import(span, self.target(rest))
            case "maximize":
                return ast.Objective(span, 1, self.expression(rest))
            case "minimize":
                return ast.Objective(span, -1, self.expression(rest))
            case "rationality" | "plausibility":
                return ast.Weight(span, str(tree.data), self.expression(rest))
            case "assume":
                condition = self.expression(rest)
                nothing = isinstance(condition, ast.Name) and condition.id == "nothing"
                return ast.Assume(span, None if nothing else condition)
            case "audience":
                return ast.Audience(span, self.name(rest), self.settings(parts[2]))
            case _:
                return ast.Search(span, self.name(rest), self.settings(parts[2]))

    def pattern(self, tree: Tree[Token]) -> ast.Pattern:
        name: Any = tree.children[1]
        parameters = []
        for part in tree.children:
            if isinstance(part, Tree) and part.data in ("parameter", "parameter_default"):
                default = self.expression(part.children[2]) if len(part.children) > 1 else None
                token: Any = part.children[0]
                parameters.append(ast.Parameter(self.span(part), self.name(token), default))
        body = self.expression(tree.children[-1])
        return ast.Pattern(
            self.span(tree), self.name(name), tuple(parameters), body, self.documentation
        )

    def settings(self, tree: Any) -> tuple[ast.Argument, ...]:
        return self.arguments(tree.children) if tree is not None else ()

    def expressions(self, parts: Any) -> tuple[ast.Expr, ...]:
        return tuple(
            self.expression(p) for p in parts if isinstance(p, Tree | Token) and not _mark(p)
        )

    def expression(self, item: Any) -> ast.Expr:
        build: Callable[[Span, list[Any]], ast.Expr] = getattr(self, f"_{item.data}")
        return build(self.span(item), item.children)

    def arguments(self, parts: Any) -> tuple[ast.Argument, ...]:
        found = []
        for part in parts:
            if not isinstance(part, Tree):
                continue
            span = self.span(part)
            if part.data == "argument":
                found.append(ast.Argument(span, None, self.expression(part.children[0])))
            else:
                token: Any = part.children[0]
                name, tree = self.name(token), part.children[2]
                value = self.expression(tree)
                comparison = _as_comparison(name, tree, value, span)
                found.append(ast.Argument(span, name, value, comparison))
        return tuple(found)

    def given(self, tree: Any) -> tuple[ast.Expr, ...]:
        return self.expressions(tree.children) if tree is not None else ()

    # One method for each rule of an expression.

    def _conditional(self, span: Span, p: list[Any]) -> ast.Expr:
        return ast.If(span, self.expression(p[1]), self.expression(p[3]), self.expression(p[5]))

    def _disjunction(self, span: Span, p: list[Any]) -> ast.Expr:
        return ast.Or(span, self.expressions(p))

    def _conjunction(self, span: Span, p: list[Any]) -> ast.Expr:
        return ast.And(span, self.expressions(p))

    def _negation(self, span: Span, p: list[Any]) -> ast.Expr:
        return ast.Not(span, self.expression(p[1]))

    def _comparison(self, span: Span, p: list[Any]) -> ast.Expr:
        operators = tuple(str(token) for token in p[1::2])
        return ast.Compare(span, operators, tuple(self.expression(x) for x in p[0::2]))

    def _member(self, span: Span, p: list[Any]) -> ast.Expr:
        items = ast.SetOf(self.span(p[2]), self.expressions(p[2].children))
        return ast.Member(span, self.expression(p[0]), items)

    def _plus(self, span: Span, p: list[Any]) -> ast.Expr:
        return self.expression(p[1])

    def _sum(self, span: Span, p: list[Any]) -> ast.Expr:
        p = [x for x in p if x is not None]
        if isinstance(p[0], Token):
            p = p[1:]
        signs, terms = [1], [self.expression(p[0])]
        for sign, term in zip(p[1::2], p[2::2], strict=True):
            if sign.type == "PLUSPLUS":
                # `a + script ++ [...]` binds the turn to what stands right before it.
                turn = tuple(self._turn_item(m) for m in term.children if isinstance(m, Tree))
                joined = terms[-1].span.to(self.span(term))
                terms[-1] = ast.Append(joined, terms[-1], turn)
            else:
                signs.append(-1 if sign.type == "MINUS" else 1)
                terms.append(self.expression(term))
        return terms[0] if len(terms) == 1 else ast.Sum(span, tuple(signs), tuple(terms))

    def _turn_item(self, tree: Tree[Token]) -> ast.Move | ast.Fall:
        parts: list[Any] = tree.children
        if tree.data == "move":
            who, action = self.name(parts[0]), self.name(parts[2])
            return ast.Move(self.span(tree), who, action, parts[3] is not None)
        place = self.expression(parts[4])
        return ast.Fall(self.span(tree), self.name(parts[0]), self.name(parts[2]), place)

    def _product(self, span: Span, p: list[Any]) -> ast.Expr:
        operators = tuple(str(token) for token in p[1::2])
        return ast.Product(span, operators, tuple(self.expression(x) for x in p[0::2]))

    def _minus(self, span: Span, p: list[Any]) -> ast.Expr:
        return ast.Negative(span, self.expression(p[1]))

    def _power(self, span: Span, p: list[Any]) -> ast.Expr:
        return ast.Power(span, self.expression(p[0]), self.expression(p[2]))

    def _reduction(self, span: Span, p: list[Any]) -> ast.Expr:
        kind = str(p[0]).partition("_")[0]
        return ast.Reduction(span, kind, None, None, self.expression(p[1]))

    def _reduction_range(self, span: Span, p: list[Any]) -> ast.Expr:
        kind = str(p[0]).partition("_")[0]
        first, last = self.expression(p[3]), self.expression(p[5])
        return ast.Reduction(span, kind, first, last, self.expression(p[7]))

    def _prefix(self, span: Span, p: list[Any]) -> ast.Expr:
        return ast.Prefix(span, self.expression(p[0]), self.expression(p[3]))

    def _frame(self, span: Span, p: list[Any]) -> ast.Expr:
        return ast.FrameOf(span, self.expression(p[0]), self.expression(p[2]))

    def _number(self, span: Span, p: list[Any]) -> ast.Expr:
        return ast.Number(span, float(p[0]))

    def _name(self, span: Span, p: list[Any]) -> ast.Expr:
        return self.name(p[0])

    def _string(self, span: Span, p: list[Any]) -> ast.Expr:
        return self.text(p[0])

    def _time(self, span: Span, p: list[Any]) -> ast.Expr:
        return ast.Time(span)

    def _length_of_story(self, span: Span, p: list[Any]) -> ast.Expr:
        return ast.Length(span)

    def _script(self, span: Span, p: list[Any]) -> ast.Expr:
        return ast.Script(span)

    def _group(self, span: Span, p: list[Any]) -> ast.Expr:
        return self.expression(p[1])

    def _pair(self, span: Span, p: list[Any]) -> ast.Expr:
        return ast.Pair(span, self.expression(p[1]), self.expression(p[3]))

    def _call(self, span: Span, p: list[Any]) -> ast.Expr:
        return ast.Call(span, self.name(p[0]), self.arguments(p[1:]))

    def _last(self, span: Span, p: list[Any]) -> ast.Expr:
        return ast.LastOf(span, self.expression(p[2]))

    def _probability(self, span: Span, p: list[Any]) -> ast.Expr:
        return ast.Probability(span, self.expression(p[2]), self.given(p[4]))

    def _expectation(self, span: Span, p: list[Any]) -> ast.Expr:
        return ast.Expectation(span, self.expression(p[2]), self.given(p[4]))

    def _value(self, span: Span, p: list[Any]) -> ast.Expr:
        return ast.ValueOf(span, self.expression(p[2]))

    def _divergence(self, span: Span, p: list[Any]) -> ast.Expr:
        latent = self.expression(p[2]) if p[2] is not None else None
        return ast.Divergence(span, latent, self.expression(p[4]), self.given(p[6]))

    def _entropy(self, span: Span, p: list[Any]) -> ast.Expr:
        first = self.expression(p[2])
        if p[4] is None:
            return ast.Entropy(span, None, (first,))
        return ast.Entropy(span, first, self.given(p[4]))

    def _surprise(self, span: Span, p: list[Any]) -> ast.Expr:
        return ast.Surprise(span, self.expression(p[2]))

    def _suspense(self, span: Span, p: list[Any]) -> ast.Expr:
        return ast.Suspense(span, self.expression(p[2]), self.given(p[4]))

    def _holds(self, span: Span, p: list[Any]) -> ast.Expr:
        return ast.Holds(span, self.expression(p[1]), self.expression(p[3]))


def _mark(item: Any) -> bool:
    """Whether this is punctuation or a keyword rather than an operand."""
    return isinstance(item, Token)


def _as_comparison(name: ast.Name, tree: Any, value: ast.Expr, span: Span) -> ast.Expr | None:
    """`rho = 0 and x` read as a condition rather than as a named argument.

    The name belongs to the leftmost comparison of the value; a value that begins with `not` or
    `if` cannot be read in this way.
    """
    match str(tree.data):
        case "disjunction" | "conjunction":
            assert isinstance(value, ast.Or | ast.And)
            first = _as_comparison(name, tree.children[0], value.operands[0], span)
            if first is None:
                return None
            return type(value)(span, (first, *value.operands[1:]))
        case "comparison":
            assert isinstance(value, ast.Compare)
            inner = name.span.to(value.span)
            return ast.Compare(inner, ("=", *value.operators), (name, *value.operands))
        case "negation" | "conditional" | "member":
            return None
        case _:
            return ast.Compare(name.span.to(value.span), ("=",), (name, value))
