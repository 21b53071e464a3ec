"""Syntax errors in words: what was found, what was expected, and the usual reason."""

from __future__ import annotations

from lark import Token
from lark.exceptions import UnexpectedCharacters, UnexpectedInput, UnexpectedToken

from i2pdsl.errors import Diagnostic, Source, Span

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
}
_OPERATORS = frozenset(
    ("PLUS", "MINUS", "STAR", "SLASH", "CARET", "LT", "LE", "NE", "GE", "GT", "AND_KW", "OR_KW")
)


def explain(problem: UnexpectedInput, source: Source, span: Span) -> Diagnostic:
    """The diagnostic for Lark's error in the statement at `span`."""
    expected: set[str] = set()
    if isinstance(problem, UnexpectedToken):
        token = problem.token
        expected = set(problem.accepts or problem.expected)
        if token.type == "$END":
            return _ends_too_early(source, span, expected)
        assert token.start_pos is not None
        place = Span(source, token.start_pos, token.start_pos + len(token))
        hint = _hint(token, expected, source, place)
        message = f"unexpected `{_shown(str(token))}`"
    else:
        assert isinstance(problem, UnexpectedCharacters)
        start = problem.pos_in_stream
        assert start is not None
        place = Span(source, start, start + 1)
        expected = set(problem.allowed or ())
        character = source.text[start]
        shown = character if character.isprintable() else f"U+{ord(character):04X}"
        message = f"unexpected character `{shown}`"
        hint = _HINTS_FOR_CHARACTERS.get(source.text[start : start + 2]) or (
            _HINTS_FOR_CHARACTERS.get(character)
        )
        if character == "." and source.text[start + 1 : start + 2].isdigit():
            hint = "write a digit before the point: `0.5`"
    wanted = _expectation(expected)
    return Diagnostic("syntax", f"{message}{f', expected {wanted}' if wanted else ''}", place, hint)


_HINTS_FOR_CHARACTERS = {
    "&&": "write `and`",
    "==": "write `=` for equality",
    "&": "write `and`",
    "'": 'texts stand in double quotes: `"..."`',
    "$": "formulas are written without `$`",
    "≥": "write `>=`",
    "≤": "write `<=`",
    "≠": "write `!=`",
    "ρ": "write `rho`",
}


def _ends_too_early(source: Source, span: Span, expected: set[str]) -> Diagnostic:
    end = span.start + len(span.text.rstrip())
    last = span.text.rstrip().rsplit(None, 1)[-1] if span.text.strip() else ""
    place = Span(source, max(span.start, end - len(last)), end)
    wanted = _expectation(expected)
    hint = None
    if "THEN_KW" in expected:
        hint = "write `if CONDITION then A else B`"
    elif "ELSE_KW" in expected:
        hint = "every `if` needs its `else`"
    message = "the statement ends too early"
    return Diagnostic("syntax", f"{message}{f', expected {wanted}' if wanted else ''}", place, hint)


def _hint(token: Token, expected: set[str], source: Source, place: Span) -> str | None:
    before = source.text[: place.start].rstrip()
    if token.type == "EQ" and before.endswith("="):
        return "write `=` for equality"
    if token.type == "DBAR":
        return "write `or`; `||` stands only in KL(script[:a] || script[:b])"
    if token.type == "LSQB" and before.endswith("P"):
        return "probabilities have round brackets: `P(event | script[:t])`"
    if token.type == "LPAR" and before.endswith("E"):
        return "expectations have square brackets: `E[quantity | script[:t]]`"
    if token.type == "NE" and "BANG" in expected:
        return "`!` marks a move that fails: `cheese: west!`"
    if token.type in ("BIG_T", "BIG_OPEN", "IF_KW") and "NUMBER" in expected:
        return "put it in parentheses"
    if (token.type.endswith("_KW") or token.type in ("T_VAR", "T_END")) and "NAME" in expected:
        return f"`{token}` is a word of the language and cannot be a name"
    if token.type in ("NAME", "NUMBER", "T_VAR", "T_END") and _OPERATORS & expected:
        return "an operator is missing, for instance `*`"
    if "ELSE_KW" in expected and token.type in ("RPAR", "COMMA"):
        return "every `if` needs its `else`"
    return None


def _expectation(expected: set[str]) -> str:
    """What could have stood there, in a few words."""
    parts = []
    if "NUMBER" in expected and "SCRIPT_KW" in expected:
        parts.append(_OPERAND)
        expected = {e for e in expected if e in ("RPAR", "RSQB", "COLON")}
    elif _OPERATORS & expected:
        closing = [
            e for e in ("THEN_KW", "ELSE_KW", "BAR", "AT", "RPAR", "RSQB", "RBRACE", "COMMA")
        ]
        known = [e for e in closing if e in expected]
        return " or ".join(["an operator", *(_word(e) for e in known[:3])])
    expected = expected - {"$END", "COMMENT", "SPACE", "NAMED"} if "NAME" in expected else expected
    names = sorted(_word(e) for e in expected if e not in ("$END", "COMMENT", "SPACE"))
    parts.extend(names)
    if len(parts) > 5:
        return ""
    return " or ".join(parts)


def _word(terminal: str) -> str:
    if terminal in _WORDS:
        return _WORDS[terminal]
    return f"`{terminal.removesuffix('_KW').lower()}`"


def _shown(text: str) -> str:
    return text if len(text) <= 40 else text[:39] + "…"
