"""From Lark's tree to the syntax tree: one method for each rule of grammar/story.lark."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from lark import Token, Tree

from i2pdsl.errors import Diagnostic, Source, Span, StoryError
from i2pdsl.language import ast
from i2pdsl.language.builtins import RESERVED
from i2pdsl.language.forms import EXPECTED
from i2pdsl.language.mistakes import bar_missing
from i2pdsl.language.naming import same_name


class Builder:
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
        name = same_name(str(token))
        if name in RESERVED and token.type == "NAME":
            message = f"`{token}` is a word of the language and cannot be a name"
            hint = "choose another name"
            raise StoryError([Diagnostic("reserved", message, self.span(token), hint)])
        return ast.Name(self.span(token), name)

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
                most = self.expression(parts[3]) if parts[3] is not None else None
                return ast.LengthIs(span, self.expression(rest), most)
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
            case "rationality" | "plausibility" | "naturalness" | "luck" | "liveliness":
                return ast.Weight(span, str(tree.data), self.expression(rest))
            case "assume":
                condition = self.expression(rest)
                nothing = isinstance(condition, ast.Name) and condition.id == "nothing"
                return ast.Assume(span, None if nothing else condition)
            case "audience":
                name: Any = parts[3]
                called = None if rest is None else self.name(rest)
                return ast.Audience(span, self.target(name), self.settings(parts[4]), called)
            case "require":
                return ast.Require(span, self.expression(rest))
            case "require_order":
                second: Any = parts[6]
                return ast.Require(span, self.expression(parts[2]), self.expression(second))
            case "pin":
                return self.pin(span, parts)
            case _:
                return ast.Search(span, self.name(rest), self.settings(parts[2]))

    def pin(self, span: Span, p: list[Any]) -> ast.Pin:
        first = self.expression(p[3])
        last = self.expression(p[5]) if p[5] is not None else None
        if p[7].type == "COLON":
            return ast.Pin(span, first, last, condition=self.expression(p[8]))
        if isinstance(p[8], Token):
            return ast.Pin(span, first, last, file=self.text(p[8]))
        turn = tuple(self._turn_item(m) for m in p[8].children if isinstance(m, Tree))
        return ast.Pin(span, first, last, turn)

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
            elif part.data == "argument_shares":
                found.append(self.shares(span, part.children))
            else:
                token: Any = part.children[0]
                name, tree = self.name(token), part.children[2]
                value = self.expression(tree)
                comparison = _as_comparison(name, tree, value, span)
                found.append(ast.Argument(span, name, value, comparison))
        return tuple(found)

    def shares(self, span: Span, p: list[Any]) -> ast.Argument:
        """`prior(latent) = {value: weight, ...}`."""
        call = self.expression(p[0])
        latents = call.arguments if isinstance(call, ast.Call) else ()
        if not isinstance(call, ast.Call) or len(latents) != 1 or latents[0].name is not None:
            message = "weights are given to the values of a latent"
            hint = "write `prior(LATENT) = {VALUE: WEIGHT, others: WEIGHT}`"
            raise StoryError([Diagnostic("syntax", message, self.span(p[0]), hint)])
        trees = [x.children for x in p[2:] if isinstance(x, Tree)]
        pairs = [(self.expression(value), self.expression(weight)) for value, _, weight in trees]
        told = tuple(ast.Pair(a.span.to(b.span), a, b) for a, b in pairs)
        return ast.Argument(span, call.callee, ast.Shares(span, latents[0].value, told))

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
        items = self._set(self.span(p[2]), p[2].children)
        return ast.Member(span, self.expression(p[0]), items)

    def _set(self, span: Span, p: list[Any]) -> ast.SetOf:
        return ast.SetOf(span, self.expressions(p))

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
        until = self.expression(p[5]) if p[5] is not None else None
        return ast.Prefix(span, self.expression(p[0]), self.expression(p[3]), until)

    def _frame(self, span: Span, p: list[Any]) -> ast.Expr:
        script, number = self.expression(p[0]), self.expression(p[2])
        whose = _audience_of(script)
        if isinstance(script, ast.Form) and whose is not None:  # E[audience][quantity]: no script
            return ast.Form(span, script.name, (number,), (), whose)
        return ast.FrameOf(span, script, number)

    def _number(self, span: Span, p: list[Any]) -> ast.Expr:
        value = float(p[0])
        if not math.isfinite(value):
            raise StoryError([Diagnostic("number", "this number is too large", span)])
        return ast.Number(span, value)

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

    def whose(self, p: list[Any]) -> tuple[ast.Name | None, list[Any]]:
        """The audience that a form names, and its parts without it."""
        word, found, *rest = p
        if isinstance(found, Token):  # of the forms that stand without
            return None, p
        return None if found is None else self.name(found.children[1]), [word, *rest]

    def _form(self, span: Span, p: list[Any]) -> ast.Expr:
        whose, p = self.whose(p)
        moment, given = (self.moment(p[3]), self.given(p[5])) if len(p) > 4 else (None, ())
        if p[2].data != "about":
            return ast.Form(span, str(p[0]), (self.expression(p[2]),), given, whose, moment)
        if len(p[2].children) > 1 and not given:  # P(rho > 0, script[:t])
            raise StoryError([bar_missing(str(p[0]), self.span(p[2].children[1]))])
        return ast.Form(span, str(p[0]), self.expressions(p[2].children), given, whose, moment)

    def moment(self, tree: Tree[Token] | None) -> ast.Expr | None:
        """The frame in `@ frame`, where a form says one."""
        return None if tree is None else self.expression(tree.children[1])

    def _form_of_all(self, span: Span, p: list[Any]) -> ast.Expr:
        whose, p = self.whose(p)
        return ast.Form(span, str(p[0]), (), self.given(p[2]), whose)

    def _form_of_frame(self, span: Span, p: list[Any]) -> ast.Expr:
        whose, p = self.whose(p)
        return ast.Form(span, str(p[0]), (), (self.expression(p[2]),), whose)

    def _form_apart(self, span: Span, p: list[Any]) -> ast.Expr:
        whose, p = self.whose(p)
        about, at = ((), None) if p[2] is None else (p[2].children[:1], p[2].children[1])
        moment = self.moment(at)
        given = (self.expression(p[3]), *self.given(p[5]))
        return ast.Form(span, str(p[0]), self.expressions(about), given, whose, moment)

    def _form_of_audience(self, span: Span, p: list[Any]) -> ast.Expr:
        """`E[audience][quantity | ...]`, whose first half reads as an expectation."""
        form = self.expression(p[0])
        whose = _audience_of(form)
        if not isinstance(form, ast.Form) or whose is None:
            message = "a bar stands in no index"
            hint = "whose expectation it is stands before it: `E[AUDIENCE][QUANTITY | script[:t]]`"
            raise StoryError([Diagnostic("syntax", message, self.span(p[4]), hint)])
        about, given = (self.expression(p[2]),), self.given(p[5])
        return ast.Form(span, form.name, about, given, whose, self.moment(p[3]))

    def _holds(self, span: Span, p: list[Any]) -> ast.Expr:
        return ast.Holds(span, self.expression(p[1]), self.expression(p[3]))

    def _ever(self, span: Span, p: list[Any]) -> ast.Expr:
        return ast.Ever(span, str(p[0]), self.expression(p[2]))


def _audience_of(node: ast.Expr) -> ast.Name | None:
    """The name in `E[NAME]`, which may be an audience's."""
    if isinstance(node, ast.Form) and node.kind.shape is EXPECTED and not node.given:
        (about,) = node.about
        return about if isinstance(about, ast.Name) and node.audience is None else None
    return None


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
