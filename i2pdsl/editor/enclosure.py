"""What encloses a place in a statement: brackets with what they belong to, innermost last."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from lark import Token

from i2pdsl.language.forms import BY_TERMINAL, EXPECTED

OPERAND_ENDS = frozenset(
    ("NAME", "NUMBER", "STRING", "SCRIPT_KW", "T_VAR", "T_END", "RPAR", "RSQB", "RBRACE")
)
COMPARISONS = frozenset(("LT", "LE", "EQ", "NE", "GE", "GT"))
_REDUCTIONS = ("BIG_T", "BIG_RANGE")
_ENDS_SUM = COMPARISONS | {"IN_KW", "AND_KW", "OR_KW", "THEN_KW", "ELSE_KW", "PLUSPLUS"}
_FORMS = (*BY_TERMINAL, "LAST_KW")
_SEPARATORS = ("COMMA", "SEMI", "BAR", "DBAR", "AT", "COLON", "RANGE")
_SETTINGS = {"WORLD_KW": "world", "AUDIENCE_KW": "audience", "SEARCH_KW": "search"}


@dataclass
class Enclosure:
    """A bracket that is open, or the statement itself.

    Attributes:
        kind: statement, expression, group, call, parameters, settings, index, holds (a predicate
            of a frame), turn, set, range, whose (the audience of a form), prior (of a latent), or
            the word of a form: P, E, V, KL...
        name: what is called; the keyword of a statement, or of the statement that has settings.
        separator: the terminal that began the part at hand, '' in the first.
        part: the tokens of the part at hand; closed brackets stand in it as their last token.
        given: all tokens since the bar, with those inside round brackets.
        parts: the parts before, each as its tokens.
        barred: whether a bar stands before.
    """

    kind: str
    name: str = ""
    separator: str = ""
    part: list[Token] = field(default_factory=list)
    given: list[Token] = field(default_factory=list)
    parts: list[list[Token]] = field(default_factory=list)
    barred: bool = False

    @property
    def argument(self) -> str:
        """The name of the named argument that the part at hand is the value of, or ''."""
        return argument_name(self.part)

    @property
    def in_sum(self) -> bool:
        """Whether what comes next is inside the term of a `sum_t`."""
        for i, token in enumerate(self.part):
            if token.type in _REDUCTIONS and not _ends(self.part[i + 1 :]):
                return True
        return False

    @property
    def in_condition(self) -> bool:
        """Whether what comes next is between an `if` and its `then`."""
        open_ifs = 0
        for token in self.part:
            open_ifs += (token.type == "IF_KW") - (token.type == "THEN_KW")
        return open_ifs > 0


def argument_name(part: list[Token]) -> str:
    """The name in `NAME = ...`."""
    if len(part) >= 2 and part[0].type == "NAMED" and part[1].type == "EQ":
        return str(part[0])
    return ""


def _ends(after: list[Token]) -> bool:
    """Whether the term of a sum ends in these tokens, which follow the `sum_t`."""
    before = ""
    for token in after:
        if token.type in _ENDS_SUM:
            return True
        if token.type in ("PLUS", "MINUS") and before in OPERAND_ENDS:
            return True
        before = token.type
    return False


def enclosures(tokens: Iterable[Token], expression: bool) -> list[Enclosure]:
    """The open brackets of a statement (or expression) after these tokens."""
    stack = [Enclosure("expression" if expression else "statement")]
    for token in tokens:
        top = stack[-1]
        if token.type in ("LPAR", "LSQB", "LBRACE", "BIG_OPEN"):
            stack.append(_opened(token, stack))
        elif token.type in ("RPAR", "RSQB", "RBRACE") and len(stack) > 1:
            closed = stack.pop()
            kind = "BIG_RANGE" if closed.kind == "range" else token.type
            end = Token(kind, str(token), token.start_pos)
            if closed.kind == "prior":  # its latent is wanted behind it
                stack[-1].part.extend(closed.part[-1:])
            stack[-1].part.append(end)
            stack[-1].given.append(end)
            if closed.kind == "group":
                stack[-1].given.extend(closed.given)
        elif token.type in _SEPARATORS and not _inside_move(top, token):
            top.parts.append(top.part)
            top.part, top.separator = [], token.type
            top.barred = top.barred or token.type in ("BAR", "DBAR")
            if token.type in ("BAR", "SEMI", "DBAR", "AT"):
                top.given = []
        elif not top.name and top.kind == "statement":
            top.name = str(token)
        else:
            top.part.append(token)
            top.given.append(token)
    return stack


def _inside_move(top: Enclosure, token: Token) -> bool:
    return top.kind == "turn" and token.type == "COLON"


def _opened(token: Token, stack: list[Enclosure]) -> Enclosure:
    """The enclosure that a bracket opens."""
    top = stack[-1]
    before = top.part[-1] if top.part else None
    last = before.type if before is not None else ""
    if token.type == "BIG_OPEN":
        return Enclosure("range")
    if token.type == "LBRACE":
        return Enclosure("set", _compared(top.part))
    if last in _FORMS:
        whose = token.type == "LSQB" and last != EXPECTED.terminal
        return Enclosure("whose" if whose else str(before))
    if last == "RSQB" and len(top.part) > 1 and top.part[-2].type in BY_TERMINAL:
        return Enclosure(str(top.part[-2]))  # `P[audience](`, `E[audience][`
    if token.type == "LSQB":
        if last == "PLUSPLUS" or (top.name == "pin" and last == "EQ"):
            return Enclosure("turn")
        return Enclosure("index" if last in OPERAND_ENDS else "holds")
    keyword = top.name.upper() + "_KW" if top.kind == "statement" else ""
    named = keyword == "AUDIENCE_KW" and [t.type for t in top.part[:2]] == ["NAMED", "EQ"]
    first = len(top.part) == (3 if named else 1)
    if first and before is not None and keyword in (*_SETTINGS, "PATTERN_KW"):
        name = str(before).strip('"')
        if keyword == "PATTERN_KW":
            return Enclosure("parameters", name)
        return Enclosure("settings", f"{_SETTINGS[keyword]} {name}")
    if last == "NAME":
        if top.kind == "settings" and top.name.startswith("audience"):
            if before == "prior":
                return Enclosure("prior")
            return Enclosure("settings", f"audience {before}")
        return Enclosure("call", str(before))
    return Enclosure("group")


def _compared(part: list[Token]) -> str:
    """The name before `in`, or before the `=` of a setting; the latent of `prior(latent) =`."""
    if [t.type for t in part[-3:]] == ["NAME", "RPAR", "EQ"] and part[0] == "prior":
        return str(part[-3])
    if len(part) >= 2 and part[-1].type in ("IN_KW", "EQ") and part[-2].type in ("NAME", "NAMED"):
        return str(part[-2])
    return ""
