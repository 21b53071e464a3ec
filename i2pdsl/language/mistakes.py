"""Syntax errors in words: what was found, what was expected, and the usual reason."""

from __future__ import annotations

import re
import unicodedata

from lark import Token

from i2pdsl.errors import Diagnostic, Source, Span, shorten
from i2pdsl.language.builtins import RESERVED, STATEMENT_WORDS
from i2pdsl.language.forms import APART, BY_NAME, BY_TERMINAL, EXPECTED
from i2pdsl.language.tables import END, UnexpectedError
from i2pdsl.language.vocabulary import Weights

_OPERAND = "an expression"
_WORDS = {
    "NAME": "a name",
    "NAMED": "a name",
    "NUMBER": "a number",
    "STRING": "a text in quotes",
    "NAME_T": "`t`",
    "T_VAR": "`t`",
    "T_END": "`T`",
    "BIG_T": "`sum_t`",
    "BIG_OPEN": "`sum_{`",
    "ROW": "a row of the map",
    "PLUSPLUS": "`++`",
    "DBAR": "`||`",
    "RANGE": "`..`",
    "LPAR": "`(`",
    "RPAR": "`)`",
    "LSQB": "`[`",
    "RSQB": "`]`",
    "LBRACE": "`{`",
    "RBRACE": "`}`",
    "COMMA": "`,`",
    "COLON": "`:`",
    "SEMI": "`;`",
    "BAR": "`|`",
    "AT": "`@`",
    "BANG": "`!`",
    "EQ": "`=`",
    "MINUS": "`-`",
}
_OPERATORS = frozenset(
    ("PLUS", "MINUS", "STAR", "SLASH", "CARET", "LT", "LE", "NE", "GE", "GT", "AND_KW", "OR_KW")
)
_OPERANDS = frozenset(
    ("NAME", "NUMBER", "STRING", "T_VAR", "T_END", "SCRIPT_KW", "LAST_KW", "BIG_T", "BIG_OPEN")
) | {"LPAR", "LBRACE", *BY_TERMINAL}
_EXAMPLES = {
    "world": "world kitchen",
    "length": "length 15",
    "start": "start absent(table)",
    "allow": "allow deus(table)",
    "let": "let turn = T/2",
    "pattern": "pattern show(event) = sum_t P(event | script[:t])",
    "import": "import mylibrary",
    "maximize": "maximize sum_t P(rho > 0 | script[:t])",
    "minimize": "minimize sum_t P(rho > 0 | script[:t])",
    **{term: f"{term} {weight:g}" for term, weight in Weights()._asdict().items()},
    "assume": "assume nothing",
    "audience": "audience bayesian(beta = 1)",
    "search": "search beam(starts = 500)",
    "require": "require eventually [moved(robot)]",
    "pin": "pin script[4]: at(robot, pink)",
    "map": "map, and the rows of the map in indented lines",
}
_TAKEN = RESERVED - {*STATEMENT_WORDS, *["if", "then", "else", "and", "or", "not", "in"]}
_MARK = re.compile(r'["#()\[\]{}]')
_EVERY = re.compile(r"\b(never|eventually|when|before)\s*\[[^\[\]]*$")
_HINTS_FOR_CHARACTERS = {
    "&&": "write `and`",
    "&": "write `and`",
    "'": 'texts stand in double quotes: `"..."`',
    "$": "formulas are written without `$`",
    "≥": "write `>=`",
    "≤": "write `<=`",
    "≠": "write `!=`",
    "×": "write `*`",
    "·": "write `*`",
    "−": "write `-`",
    "“": 'write `"`',
    "”": 'write `"`',
}


def explain(problem: UnexpectedError, source: Source, span: Span) -> Diagnostic:
    """The diagnostic for what the parser did not expect in the statement at `span`."""
    if problem.token is not None:
        return _unexpected_token(problem, problem.token, source, span)
    start = problem.start
    character, pair = source.text[start], source.text[start : start + 2]
    shown = character if character.isprintable() else f"U+{ord(character):04X}"
    hint = _HINTS_FOR_CHARACTERS.get(pair) or _HINTS_FOR_CHARACTERS.get(character)
    if unicodedata.category(character).startswith("M"):  # behind a word such as `E`
        hint = "write the letter and its mark as one character, as most keyboards do"
    if character == ".":
        hint = "numbers need digits on both sides of the point: `0.5`"
        if source.text[max(0, start - 2) : start] == "..":
            hint = "a range has two dots: `1..5`"
    place = Span(source, start, start + 1)
    return Diagnostic("syntax", f"the character `{shown}` has no meaning here", place, hint)


def _unexpected_token(
    problem: UnexpectedError, token: Token, source: Source, span: Span
) -> Diagnostic:
    expected, before = set(problem.expected), problem.before
    if before is not None and before.type == "NAME" and str(before) in RESERVED:
        token = before  # `2 * if c ...`: the lexer takes the word for a name
        expected = {"NUMBER", "SCRIPT_KW", "NAME"}
    if token.type == END:
        return _ends_too_early(source, span, expected, before)
    assert token.start_pos is not None
    place = Span(source, token.start_pos, token.start_pos + len(token))
    if token.type in ("BIG_T", "BIG_OPEN") or str(token) in ("if", "not"):
        hint: str | None = f"put `{shorten(str(token))} ...` in parentheses"
    elif _may_be_name(expected) and str(token) in _TAKEN:
        message = f"`{token}` is a word of the language and cannot be a name"
        return Diagnostic("reserved", message, place, "choose another name")
    else:
        hint = _hint(token, expected, before, source, span)
    wanted = _expectation(expected, _opener(source, span, place.start))
    message = f"unexpected `{shorten(str(token))}`"
    return Diagnostic("syntax", f"{message}{f', expected {wanted}' if wanted else ''}", place, hint)


def bar_missing(form: str, comma: Span) -> Diagnostic:
    """The diagnostic for `P(rho > 0, script[:t])`: a comma where the bar belongs."""
    message = "unexpected `,`, expected `)` or `|`"
    return Diagnostic("syntax", message, comma, _behind_a_bar(form))


def _behind_a_bar(form: str) -> str:
    shown = BY_NAME[form].shape.written(form, "...")
    return f"the script stands behind a bar: `{shown}`"


def _may_be_name(expected: set[str]) -> bool:
    return bool(expected & {"NAME", "NAMED"})


def _ends_too_early(
    source: Source, span: Span, expected: set[str], before: Token | None
) -> Diagnostic:
    last = before if before is not None else None
    end = span.start + len(span.text.rstrip())
    start = end - 1 if last is None or last.start_pos is None else last.start_pos
    place = Span(source, max(span.start, min(start, end - 1)), end)
    word = span.text.split(None, 1)[0] if span.text.strip() else ""
    hint = None
    if "THEN_KW" in expected and "NUMBER" not in expected:
        hint = "write `if CONDITION then A else B`"
    elif "ELSE_KW" in expected and "NUMBER" not in expected:
        hint = "every `if` needs its `else`"
    elif span.text.strip() == word and word in _EXAMPLES:
        hint = f"for instance `{_EXAMPLES[word]}`"
    if word == "require" and "BEFORE_KW" in expected:
        hint = "say when: `[... @ script[T]]`, `eventually [...]`, `never [...]`"
    wanted = _expectation(expected, "")
    message = "the statement ends too early"
    return Diagnostic("syntax", f"{message}{f', expected {wanted}' if wanted else ''}", place, hint)


def _hint(
    token: Token, expected: set[str], before: Token | None, source: Source, span: Span
) -> str | None:
    assert token.start_pos is not None
    text = source.text[span.start : token.start_pos]
    opener = _opener(source, span, token.start_pos)
    last = str(before) if before is not None else ""
    operator_missing = bool(_OPERATORS & expected)
    if str(token) in STATEMENT_WORDS:
        return "every statement begins on a new line, in the first column"
    if token.type == "EQ" and text[: text.rfind("\n")].rstrip().endswith("="):
        return "the line before has no value"
    if token.type == "EQ" and last == "=":
        return "equality has one sign: `=`"
    if token.type == "DBAR":
        return "write `or`; `||` stands only in KL(script[:a] || script[:b])"
    if token.type == "LPAR" and last == "E":
        return "expectations have square brackets: `E[quantity | script[:t]]`"
    form = BY_NAME.get(opener)
    if form is not None and form.shape is not EXPECTED and expected <= {"NAME", "RSQB"}:
        of = "probabilities have" if opener == "P" else f"`{opener}` has"
        return f"{of} round brackets: `{form.written}`"
    if token.type == "COMMA" and form is not None and form.shape is APART:
        if "SEMI" in expected and "script" not in text[text.rfind(f"{opener}(") :]:
            return f"write `{opener}(latent; script[:a] || script[:b])`"
        return f"two beliefs are compared with `||`: `{opener}(script[:a] || script[:b])`"
    if token.type == "COMMA" and form is not None and form.shape is EXPECTED:
        return _behind_a_bar(opener)
    if token.type == "BAR" and opener in ("p", "pr", "Pr", "prob", "probability"):
        return "probabilities are written with a capital letter: `P(event | script[:t])`"
    if token.type == "BAR" and opener == "e":
        return "expectations are written with a capital letter: `E[quantity | script[:t]]`"
    if token.type == "COLON" and "RSQB" in expected:
        return "the first t frames are `script[:t]`, from the beginning on"
    if token.type == "LSQB" and last == "]" and "++" in text:
        return "put the longer script in parentheses: `(script ++ [...])[:t]`"
    every = _EVERY.search(text)
    if token.type == "AT" and every:
        return f"`{every[1]}` looks at all frames; leave out the `@ ...`"
    if text.startswith("pin") and last == "=":
        return "a condition follows a colon: `pin script[4]: at(...)`"
    if text.startswith("pin") and token.type == "RSQB" and "AT" in expected:
        return "the condition of a pin stands without brackets: `pin script[4]: at(...)`"
    if token.type == "RSQB" and "AT" in expected:
        return "a predicate is asked of a frame: `[... @ script[t]]`"
    if token.type == "COLON" and "AT" in expected:
        return "a turn is appended with `++`: `script ++ [WHO: ACTION, ...]`"
    if last == "++":
        return "write `script ++ [WHO: ACTION, ...]`"
    if "NAME_T" in expected:
        return "sums run over t: `sum_{t in 1..5}`"
    if token.type == "RBRACE" and "RANGE" in expected:
        return "a range has two dots: `1..5`"
    if operator_missing and last in ("sum", "mean", "min", "max"):
        return f"write `{last}_t`"
    if operator_missing and str(token) == "given":
        return "write `|`"
    if operator_missing and token.type in _OPERANDS:
        return "an operator is missing, for instance `*`"
    if "ELSE_KW" in expected and token.type in ("RPAR", "COMMA"):
        return "every `if` needs its `else`"
    return None


def _opener(source: Source, span: Span, end: int) -> str:
    """The bracket that is open at `end`, or the word right before it, as `P` of `P(`."""
    open_at: list[int] = []
    closed = span.start  # what is before is not looked at: a comment, a text in quotes
    for mark in _MARK.finditer(source.text, span.start, end):
        i, c = mark.start(), mark.group()
        if i < closed:
            continue
        if c in '#"':
            close = source.text.find("\n" if c == "#" else c, i + 1, end)
            closed = end if close < 0 else close + 1
        elif c in "([{":
            open_at.append(i)
        elif open_at:
            open_at.pop()
    if not open_at:
        return ""
    begin = open_at[-1]
    while begin > span.start and (
        source.text[begin - 1].isalnum() or source.text[begin - 1] == "_"
    ):
        begin -= 1
    return source.text[begin : open_at[-1]] or source.text[open_at[-1]]


def _expectation(expected: set[str], opener: str) -> str:
    """What could have stood there, in a few words."""
    if "NUMBER" in expected and "SCRIPT_KW" in expected:
        return _OPERAND
    if _OPERATORS & expected:
        ends = ("THEN_KW", "ELSE_KW", "BAR", "AT", "RPAR", "RSQB", "RBRACE", "COMMA")
        known = [e for e in ends if e in expected] if opener else []
        if opener not in BY_NAME and opener != "[":  # in an index a bar makes no sense
            known = [e for e in known if e != "BAR"]
        return " or ".join(["an operator", *(_word(e) for e in known[:3])])
    if "NAME" in expected:
        expected = expected - {"NAMED"}
    names = sorted({_word(e) for e in expected if e not in ("$END", "COMMENT", "SPACE")})
    return " or ".join(names) if len(names) <= 5 else ""


def _word(terminal: str) -> str:
    if terminal in _WORDS:
        return _WORDS[terminal]
    return f"`{terminal.removesuffix('_KW').lower()}`"
