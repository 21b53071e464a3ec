"""The shape of what is parsed: precedence, every form of language.md, and its words."""

from __future__ import annotations

import random
import re
from dataclasses import fields
from pathlib import Path
from typing import Any

import pytest
from lark import Lark, Tree
from lark.exceptions import UnexpectedInput, UnexpectedToken

from fuzz_for_tests import examples
from i2pdsl.errors import Source, StoryError
from i2pdsl.language import ast
from i2pdsl.language.builtins import (
    FORMS,
    FUNCTIONS,
    RESERVED,
    STATEMENT_WORDS,
    STATEMENTS,
    word_named,
)
from i2pdsl.language.forms import BY_NAME
from i2pdsl.language.naming import with_marks
from i2pdsl.language.parse import (
    FLAT,
    STARTS,
    grammar,
    grammar_text,
    parse,
    parse_expression,
    tables,
)
from i2pdsl.language.statements import split_statements
from i2pdsl.language.tables import Tables, UnexpectedError, lark_of

ROOT = Path(__file__).parents[2]
SIGNATURE = "maximize sum_t P(rho>0 | script[:t])"


def shape(node: object) -> str:
    """An expression with every bracket written out."""
    match node:
        case ast.Number(value=value):
            return f"{value:g}"
        case ast.Name(id=name):
            return name
        case ast.Text(value=value):
            return f'"{value}"'
        case ast.Time() | ast.Length() | ast.Script():
            return {"Time": "t", "Length": "T", "Script": "script"}[type(node).__name__]
        case ast.Sum(signs=signs, terms=terms):
            parts = [("+" if s > 0 else "-") + shape(x) for s, x in zip(signs, terms, strict=True)]
            return f"({' '.join(parts)})"
        case ast.Product(operators=operators, factors=factors):
            rest = zip(operators, factors[1:], strict=True)
            return f"({shape(factors[0])}{''.join(f' {o} {shape(f)}' for o, f in rest)})"
        case ast.Negative(operand=operand):
            return f"(neg {shape(operand)})"
        case ast.Power(base=base, exponent=exponent):
            return f"({shape(base)} ^ {shape(exponent)})"
        case ast.Compare(operators=operators, operands=operands):
            rest = zip(operators, operands[1:], strict=True)
            return f"({shape(operands[0])}{''.join(f' {o} {shape(x)}' for o, x in rest)})"
        case ast.Member(item=item, items=items):
            return f"({shape(item)} in {{{', '.join(map(shape, items.items))}}})"
        case ast.Not(operand=operand):
            return f"(not {shape(operand)})"
        case ast.And(operands=operands):
            return f"({' and '.join(map(shape, operands))})"
        case ast.Or(operands=operands):
            return f"({' or '.join(map(shape, operands))})"
        case ast.If(condition=c, then=a, otherwise=b):
            return f"(if {shape(c)} then {shape(a)} else {shape(b)})"
        case ast.Reduction(kind=kind, first=None, body=body):
            return f"({kind} {shape(body)})"
        case ast.Reduction(kind=kind, first=first, last=last, body=body):
            return f"({kind} {shape(first)}..{shape(last)} {shape(body)})"
        case ast.Prefix(script=script, end=end):
            return f"{shape(script)}[:{shape(end)}]"
        case ast.FrameOf(script=script, number=number):
            return f"{shape(script)}[{shape(number)}]"
        case ast.Append(script=script, turn=turn):
            return f"({shape(script)} ++ [{', '.join(map(shape, turn))}])"
        case ast.Move(who=who, action=action, fails=fails):
            return f"{who.id}: {action.id}{'!' if fails else ''}"
        case ast.Fall(event=event, thing=thing, place=place):
            return f"{event.id}: {thing.id} at {shape(place)}"
        case ast.Pair(first=first, second=second):
            return f"<{shape(first)}, {shape(second)}>"
        case ast.Argument(name=None, value=value):
            return shape(value)
        case ast.Argument(name=name, value=value, comparison=comparison):
            other = f" | {shape(comparison)}" if comparison else ""
            return f"{name.id}: {shape(value)}{other}"
        case ast.Form(name=name, about=about, given=given, moment=moment):
            at = f" @ {shape(moment)}" if moment else ""
            return f"{name}({', '.join(map(shape, about))}{at}; {', '.join(map(shape, given))})"
    assert isinstance(node, ast.Node)
    parts = []
    for f in fields(node):
        value = getattr(node, f.name)
        if f.name == "span" or value is None:
            continue
        group = value if isinstance(value, tuple) else (value,)
        parts.append(", ".join(map(shape, group)))
    return f"{type(node).__name__}({'; '.join(parts)})"


def parsed(text: str) -> str:
    return shape(parse_expression(Source("expression", text)))


PRECEDENCE = [
    # The order of language.md, tightest first, each against its neighbours.
    ("a ^ script[:t]", "(a ^ script[:t])"),
    ("-a ^ b", "(neg (a ^ b))"),
    ("a ^ -b", "(a ^ (neg b))"),
    ("a ^ b ^ c", "(a ^ (b ^ c))"),
    ("-a * b", "((neg a) * b)"),
    ("a * -b", "(a * (neg b))"),
    ("a / b * c", "(a / b * c)"),
    ("a * b ^ c", "(a * (b ^ c))"),
    ("sum_t a * b", "(sum (a * b))"),
    ("sum_t a * b + c", "(+(sum (a * b)) +c)"),
    ("c + sum_t a * b", "(+c +(sum (a * b)))"),
    ("2 * sum_t a * b", "(2 * (sum (a * b)))"),
    ("a / sum_t b", "(a / (sum b))"),
    ("-sum_t a", "(neg (sum a))"),
    ("sum_t -a", "(sum (neg a))"),
    ("sum_t - a - b", "(+(sum (neg a)) -b)"),
    ("mean_t a + min_t b - max_t c", "(+(mean a) +(min b) -(max c))"),
    ("sum_{t in 1..T-1} a * b + c", "(+(sum 1..(+T -1) (a * b)) +c)"),
    ("1..5", None),
    ("a + b < c", "((+a +b) < c)"),
    ("a < b <= c", "(a < b <= c)"),
    ("a = b != c >= d > e", "(a = b != c >= d > e)"),
    ("a + b in {c, d}", "((+a +b) in {c, d})"),
    ("not a < b", "(not (a < b))"),
    ("not not a", "(not (not a))"),
    ("not a and b", "((not a) and b)"),
    ("a and b or c and d", "((a and b) or (c and d))"),
    ("a or b and not c or d", "(a or (b and (not c)) or d)"),
    ("if a then b else c or d", "(if a then b else (c or d))"),
    ("if a then b else c + d", "(if a then b else (+c +d))"),
    ("if a then b else if c then d else e", "(if a then b else (if c then d else e))"),
    ("if if a then b else c then d else e", "(if (if a then b else c) then d else e)"),
    ("sum_t (if a then b else c)", "(sum (if a then b else c))"),
    ("sum_t if a then b else c", None),
    ("a * if b then c else d", None),
    ("a + b - c", "(+a +b -c)"),
    ("a - -b", "(+a -(neg b))"),
    ("+a + b", "(+a +b)"),
    ("+a", "a"),
    ("script ++ [cheese: stay, robot: west!]", "(script ++ [cheese: stay, robot: west!])"),
    ("script ++ [a: b] ++ [c: d]", "((script ++ [a: b]) ++ [c: d])"),
    ("(script ++ [a: b])[:t]", "(script ++ [a: b])[:t]"),
    ("script ++ [a: b][:t]", None),
    ("script ++ [deus: table at (1, 3)]", "(script ++ [deus: table at <1, 3>])"),
    ("a < script ++ [b: c]", "(a < (script ++ [b: c]))"),
    ("script[:t][t]", "script[:t][t]"),
    ("(a)", "a"),
    ("(a, b)", "<a, b>"),
    ("1.", None),
    (".5", None),
    ("1.5e-3", "0.0015"),
    ("2 3", None),
    ("", None),
]


@pytest.mark.parametrize(("text", "tree"), PRECEDENCE, ids=[p[0] for p in PRECEDENCE])
def test_precedence(text: str, tree: str | None) -> None:
    if tree is None:
        with pytest.raises(StoryError):
            parsed(text)
    else:
        assert parsed(text) == tree


FORMS_PARSED = [
    ("P(rho > 0 | script[:k], a, b = c)", "P((rho > 0); script[:k], a, (b = c))"),
    ("P(a = b @ script[8] | script[:k])", "P((a = b) @ script[8]; script[:k])"),
    ("P(a, b @ script[t] | script[:k])", "P(a, b @ script[t]; script[:k])"),
    ("E[V(a) @ script[0] | script[:k]]", "E(V(a; ) @ script[0]; script[:k])"),
    ("entropy(a @ script[t] | script[:k])", "entropy(a @ script[t]; script[:k])"),
    (
        "KL(a @ script[t]; script[:a] || script[:b])",
        "KL(a @ script[t]; script[:a], script[:b])",
    ),
    ("P(a)", "P(a; )"),
    ("E[V(robot) | script[:t]]", "E(V(robot; ); script[:t])"),
    ("KL(script[:a] || script[:b])", "KL(; script[:a], script[:b])"),
    ("KL(rho; script[:a] || script[:b], c)", "KL(rho; script[:a], script[:b], c)"),
    ("KL(script[:a])", "KL(; script[:a])"),
    ("entropy(rho | script[:k])", "entropy(rho; script[:k])"),
    ("entropy(script[:k])", "entropy(; script[:k])"),
    ("entropy(script[:k], a)", "entropy(; script[:k], a)"),
    ("surprise(script[k])", "surprise(; script[k])"),
    ("suspense(rho | script[:k])", "suspense(rho; script[:k])"),
    ("[at(a, b) @ script[k]]", "Holds(Call(at; a, b); script[k])"),
    ("last(script)", "LastOf(script)"),
    ("points((0, 0), (0.3, 1))", "Call(points; <0, 0>, <0.3, 1>)"),
    ("f()", "Call(f; )"),
    # `NAME = VALUE` has two readings, kept until the pattern's parameters are known.
    ("f(rho = 0)", "Call(f; rho: 0 | (rho = 0))"),
    ("f(rho = 0 = x)", "Call(f; rho: (0 = x) | (rho = 0 = x))"),
    ("f(rho = 0 and x)", "Call(f; rho: (0 and x) | ((rho = 0) and x))"),
    ("f(rho = 0 or x and y)", "Call(f; rho: (0 or (x and y)) | ((rho = 0) or (x and y)))"),
    ("f(x = not y)", "Call(f; x: (not y))"),
    ("f(x = if a then b else c)", "Call(f; x: (if a then b else c))"),
    ("f(x = a and not b)", "Call(f; x: (a and (not b)) | ((x = a) and (not b)))"),
    ("f(x = -1)", "Call(f; x: (neg 1) | (x = (neg 1)))"),
    ("f(x = script ++ [a: b])", "Call(f; x: (script ++ [a: b]) | (x = (script ++ [a: b])))"),
    ("f(a, x = b, rho > 0)", "Call(f; a, x: b | (x = b), (rho > 0))"),
]


@pytest.mark.parametrize(("text", "tree"), FORMS_PARSED, ids=[f[0] for f in FORMS_PARSED])
def test_forms(text: str, tree: str) -> None:
    assert parsed(text) == tree


def test_the_signature_parses_letter_for_letter() -> None:
    (objective,) = parse(Source("s", SIGNATURE)).statements
    assert isinstance(objective, ast.Objective)
    assert shape(objective.value) == "(sum P((rho > 0); script[:t]))"
    in_story = parse(Source("s", f"world kitchen\nlength 15\n\n{SIGNATURE}\n"))
    assert in_story.statements[2] == objective


def test_white_space_and_comments_mean_nothing_inside_a_statement() -> None:
    spread = "maximize\n  sum_t  # every frame\n\n    P(rho>0 |\nscript[ : t ]\n) # end"
    assert parse(Source("s", spread)).statements == parse(Source("s", SIGNATURE)).statements


def test_every_statement() -> None:
    text = (ROOT / "tests" / "language" / "every_statement.story").read_text()
    program = parse(Source("every", text))
    assert [type(s).__name__ for s in program.statements] == [
        *("Import", "Import", "World", "LengthIs", "Start", "Allow", "Let", "Pattern", "Pattern"),
        *("Objective", "Objective", *["Weight"] * 5, "Assume", "Audience", "Search"),
        *("Require", "Require", "Require", "Pin", "Pin", "Objective"),
    ]
    patterns = program.of(ast.Pattern)
    assert patterns[0].documentation == "Two lines\nof documentation."
    assert patterns[0].signature == "rise(event, over = script, slope = 1 / T)"
    assert patterns[1].documentation == ""
    assert [o.sign for o in program.of(ast.Objective)] == [1, -1, 1]
    assert program.of(ast.World)[0].settings[0].name.id == "beta"


def grammar_of(which: str) -> tuple[str, tuple[str, ...], frozenset[str]]:
    """The text of a grammar, where it can begin, and what does not count as nesting."""
    if which == "story":
        return grammar_text(), STARTS, FLAT
    text = (ROOT / "grammar" / f"{which}.lark").read_text(encoding="utf-8")
    return with_marks(text), ("statement", "entries"), frozenset()


def said(tables: Tables) -> tuple[object, ...]:
    """All that tables say."""
    return tables.starts, tables.ends, tables.rules, tables.actions, tables.terminals


@pytest.mark.parametrize("which", [p.stem for p in sorted((ROOT / "grammar").glob("*.lark"))])
def test_tables_from_the_cache_are_those_that_are_made(
    which: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("I2PDSL_CACHE", str(tmp_path))
    made: list[str] = []

    def noted(text: str, starts: tuple[str, ...]) -> Lark:
        made.append(text)
        return lark_of(text, starts)

    monkeypatch.setattr("i2pdsl.language.tables.lark_of", noted)
    first = Tables.kept(*grammar_of(which))
    (path,) = (tmp_path / "grammars").iterdir()
    whole = path.read_bytes()
    again = Tables.kept(*grammar_of(which))
    assert len(made) == 1
    assert said(again) == said(first)
    assert again.any_word == first.any_word
    for damaged in (whole[:40] + b"?" + whole[41:], whole[:1000], b""):
        path.write_bytes(damaged)
        anew = Tables.kept(*grammar_of(which))  # its states may have other numbers
        assert anew.terminals == first.terminals
        assert said(Tables.kept(*grammar_of(which))) == said(anew)
    assert len(made) == 4


def test_one_grammar_is_not_taken_for_another(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of what is signed, too: whoever shares the cache may have put one in the other's place."""
    monkeypatch.setenv("I2PDSL_CACHE", str(tmp_path))
    ours = [Tables.kept(*grammar_of(which)) for which in ("story", "world")]
    one, other = (tmp_path / "grammars").iterdir()
    content = one.read_bytes(), other.read_bytes()
    one.write_bytes(content[1])
    other.write_bytes(content[0])
    for which, first in zip(("story", "world"), ours, strict=True):
        assert Tables.kept(*grammar_of(which)).terminals == first.terminals


def test_without_a_cache_grammars_are_read_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("no folder", encoding="utf-8")
    monkeypatch.setenv("I2PDSL_CACHE", str(tmp_path / "file"))
    ours = Tables.kept(*grammar_of("story"))
    assert ours.terminals == tables().terminals
    tree = ours.parse(SIGNATURE, 0, len(SIGNATURE), "statement")
    assert tree == tables().parse(SIGNATURE, 0, len(SIGNATURE), "statement")


def test_reserved_words_are_those_of_the_grammar() -> None:
    """`at` is a predicate's name as well, `before` a parameter's: they stay free."""
    text = (ROOT / "grammar" / "story.lark").read_text(encoding="utf-8")
    words = set(re.findall(r"^[A-Z_]+(?:_KW|_VAR|_END|NAME_T)\.5: /(\w+)\\b/", text, re.MULTILINE))
    words |= BY_NAME.keys()  # put into the grammar from the table
    assert words - {"at", "before"} == RESERVED - {
        f"{kind}_t" for kind in ("sum", "mean", "min", "max")
    }
    assert set(STATEMENT_WORDS) < RESERVED


@pytest.mark.parametrize("word", sorted(RESERVED))
def test_reserved_words_name_nothing(word: str) -> None:
    with pytest.raises(StoryError):
        parse(Source("s", f"let {word} = 1"))


@pytest.mark.parametrize("word", sorted(RESERVED))
def test_every_word_of_the_language_is_explained(word: str) -> None:
    found = word_named(word)
    assert found is not None
    assert word in found.signature


def test_examples_of_the_reference_parse() -> None:
    for word in STATEMENTS:
        (statement,) = parse(Source(word.name, word.example)).statements
        assert word.example.startswith(word.name)
        assert statement.span.text == word.example
    for word in (*FORMS, *FUNCTIONS.values()):
        parse_expression(Source(word.name, word.example))


def test_the_faster_driver_reads_as_lark_does() -> None:
    """The same trees; where something is wrong, the same token and the same expectations."""
    dice = random.Random(6)
    words = "maximize let a = ( ) [ ] { } , : | 1 t T P( rho > 0 script[:t] + ++ - not if then else"
    texts = [p.read_text(encoding="utf-8") for p in sorted((ROOT / "stories").rglob("*.story"))]
    pieces = [
        piece.span.text
        for text in texts
        for piece in split_statements(Source("", text), STATEMENT_WORDS).pieces
    ]
    for _ in range(examples(600)):
        begin, piece = dice.choice(words.split()), dice.choice(pieces)
        at = dice.randrange(len(piece))
        pieces.append(f"{piece[:at]} {begin} {piece[at + dice.randint(0, 3) :]}")
    outcomes = {bool(_same_as_lark(piece)) for piece in pieces}
    assert outcomes == {True, False}


def _same_as_lark(text: str) -> bool:
    expected: UnexpectedInput | None = None
    try:
        tree = grammar().parse(text, start="statement")
    except UnexpectedInput as problem:
        expected = problem
    if expected is None:
        assert _places(tree) == _places(tables().parse(text, 0, len(text), "statement"))
        return True
    with pytest.raises(UnexpectedError) as caught:
        tables().parse(text, 0, len(text), "statement")
    token = caught.value.token
    if isinstance(expected, UnexpectedToken):
        assert token is not None
        assert token.type == expected.token.type
        assert token.type == "$END" or token.start_pos == expected.token.start_pos
        assert caught.value.expected == set(expected.accepts or expected.expected)
    else:
        assert token is None
    return False


def _places(tree: Any) -> Any:
    if not isinstance(tree, Tree):
        return tree and (tree.type, str(tree), tree.start_pos, tree.end_pos)
    place = tree.meta.start_pos, tree.meta.end_pos
    return str(tree.data), place, [_places(child) for child in tree.children]
