"""A driver for Lark's LALR tables: the trees and errors of Lark's own, at a fraction of the time.

Most of what a parser of expressions does is to rename: `1` is an atom, a postfix, a power, a unary,
a product... Lark does these steps one by one; here such a chain is one look-up, remembered by the
two states on top of the stack and the next terminal. The trees are Lark's `Tree` and `Token`.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import Any, NamedTuple

import lark
from lark import Lark, Token, Tree
from lark.parsers.lalr_analysis import Shift

from i2pdsl.signed import read_signed, signed_path, write_signed

END = "$END"
_MOST_BYTES = 2**22  # of a file of the cache: the largest grammar has 110 kB
_IGNORED = r"(?:\s+|#[^\n]*)*"
_IGNORED_BEFORE_ROWS = r"\s*"  # on a map `#` is a wall


class Place:
    """Where a tree stands in the text, and how deep it is: `Tree.meta`."""

    __slots__ = ("depth", "end_pos", "start_pos")
    empty = False

    def __init__(self, start_pos: int, end_pos: int, depth: int):
        self.start_pos = start_pos
        self.end_pos = end_pos
        self.depth = depth


class UnexpectedError(Exception):
    """What stands in a text is not what can stand there.

    Attributes:
        token: what was found; None where a character begins no token at all.
        start: its place; the end of the text for the token `$END`.
        states, values: the stacks of the parser.
    """

    def __init__(
        self, tables: Tables, token: Token | None, start: int, states: list[int], values: list[Any]
    ):
        super().__init__(start)
        self.tables = tables
        self.token = token
        self.start = start
        self.states = states
        self.values = values

    @property
    def expected(self) -> frozenset[str]:
        """The terminals that could have stood there."""
        return self.tables.accepted(self.states)

    @property
    def before(self) -> Token | None:
        """The token before it."""
        return _last_token(self.values)


@dataclass(frozen=True, slots=True)
class _Rule:
    """A rule of the grammar.

    Attributes:
        origin: what it makes; `name` is that of the tree.
        size: how many values it takes.
        parts: of its children: which value, whether its parts are taken, `None`s before it.
        nones: `None`s behind the last child.
        renames: whether it only gives its single value another name.
        single: whether a single child stands for the tree.
        deep: 1, or 0 where its trees do not count as nesting.
        inlined: whether the children become children of what it is put into.
    """

    origin: str
    name: str
    size: int
    parts: tuple[tuple[int, bool, int], ...]
    nones: int
    renames: bool
    single: bool
    deep: int
    inlined: bool


class Terminal(NamedTuple):
    """A terminal of the grammar: its regular expression, and the text it is of, if it has one."""

    name: str
    pattern: str
    value: str
    is_text: bool


class Tables:
    """The tables of a grammar; terminals in the order in which Lark tries them."""

    def __init__(
        self,
        starts: dict[str, int],
        ends: Iterable[int],
        rules: Iterable[Iterable[Any]],
        actions: list[dict[str, int]],
        terminals: Iterable[Iterable[Any]],
        ignored: Iterable[str],
    ):
        self.starts = starts
        self.ends = frozenset(ends)
        self.rules = [_Rule(*rule) for rule in rules]
        self.actions = actions  # the next state, or ~ the number of a rule
        self.terminals = tuple(Terminal(*terminal) for terminal in terminals)
        self._patterns = {t.name: t.pattern for t in self.terminals}
        ignored = frozenset(ignored)
        self.any_word = _scanner([n for n in self._patterns if n not in ignored], self._patterns)
        self.scanners: list[re.Pattern[str] | None] = [None] * len(actions)
        self._made: dict[frozenset[str], re.Pattern[str]] = {}
        self.renamed: dict[tuple[int, int, str], int] = {}

    @classmethod
    def kept(cls, text: str, starts: tuple[str, ...], flat: frozenset[str] = frozenset()) -> Tables:
        """Those of a grammar's text, from the cache if they were made before: that takes Lark
        a fifth of a second. `flat` names the trees that do not count as nesting."""
        ours = Path(__file__).read_text(encoding="utf-8")
        described = (text, starts, sorted(flat), lark.__version__, ours)
        path = None
        with suppress(OSError, ValueError):
            path = signed_path("grammar", repr(described))
            return cls(*json.loads(read_signed(path, _MOST_BYTES)))
        said = json.dumps(description(lark_of(text, starts), flat))
        with suppress(OSError):
            if path is not None:
                write_signed(path, said.encode())
        return cls(*json.loads(said))

    def _scanner_of(self, state: int) -> re.Pattern[str]:
        """What can stand where the parser is in a state; made when it comes there."""
        fitting = frozenset(name for name in self.actions[state] if name in self._patterns)
        if fitting not in self._made:
            names = [name for name in self._patterns if name in fitting]
            self._made[fitting] = _scanner(names, self._patterns)
        found = self.scanners[state] = self._made[fitting]
        return found

    def parse(self, text: str, start: int, end: int, rule: str) -> Tree[Token]:
        """The tree of a part of a text. Raises UnexpectedError."""
        states, values = [self.starts[rule]], list[Any]()
        scanners, feed = self.scanners, self._feed
        while True:
            scanner = scanners[states[-1]] or self._scanner_of(states[-1])
            found = scanner.match(text, start, end)
            assert found is not None
            terminal = found.lastgroup
            if terminal is not None:  # as in `_next`, which is called for all tokens but these
                begin, start = found.start(terminal), found.end()
                token = _token(terminal, text[begin:start], begin, start)
            else:
                token = self._next(text, start, end, states, values)
            if feed(token, states, values):
                result: Tree[Token] = values[-1]
                return result

    def read(
        self, text: str, start: int, end: int, rule: str
    ) -> tuple[tuple[Token, ...], frozenset[str]]:
        """The tokens of the beginning of something, and the terminals that can follow.

        Raises UnexpectedError.
        """
        states, values = [self.starts[rule]], list[Any]()
        tokens: list[Token] = []
        position = start
        while True:
            token = self._next(text, position, end, states, values)
            if token.type == END:
                return tuple(tokens), self.accepted(states)
            self._feed(token, states, values)
            tokens.append(token)
            position = token.end_pos  # type: ignore[assignment]

    def _next(
        self, text: str, position: int, end: int, states: list[int], values: list[Any]
    ) -> Token:
        """The next token, or `$END`."""
        scanner = self.scanners[states[-1]] or self._scanner_of(states[-1])
        found = scanner.match(text, position, end)
        assert found is not None
        terminal = found.lastgroup
        if terminal is not None:
            begin, stop = found.span(terminal)
            return _token(terminal, text[begin:stop], begin, stop)
        begin = found.end()
        if begin == end:
            return _token(END, "", end, end)
        other = self.any_word.match(text, begin, end)
        assert other is not None
        if other.lastgroup is None:
            raise UnexpectedError(self, None, begin, states, values)
        found_token = _token(other.lastgroup, other.group(other.lastgroup), begin, other.end())
        raise UnexpectedError(self, found_token, begin, states, values)

    def _feed(self, token: Token, states: list[int], values: list[Any]) -> bool:
        """Takes a token; whether it was the end of the text."""
        actions, rules, renamed = self.actions, self.rules, self.renamed
        terminal = token.type
        while True:
            state = states[-1]
            if len(states) > 1:
                key = (states[-2], state, terminal)
                following = renamed.get(key)
                if following is None:
                    following = renamed[key] = self._rename(*key)
                if following != state:
                    states[-1] = state = following
            if terminal == END and state in self.ends:
                return True
            action = actions[state].get(terminal)
            if action is None:
                start = token.start_pos or 0
                raise UnexpectedError(self, token, start, states, values)
            if action >= 0:
                states.append(action)
                values.append(token)
                return False
            rule = rules[~action]
            size = rule.size
            if size == 1:
                values[-1] = self._value(rule, [values[-1]])
                states[-1] = actions[states[-2]][rule.origin]
                continue
            children = values[-size:]
            del values[-size:]
            del states[-size:]
            values.append(self._value(rule, children))
            states.append(actions[states[-1]][rule.origin])

    def _rename(self, below: int, state: int, terminal: str) -> int:
        """The state on top of the stack after all rules that only rename what is there."""
        while True:
            action = self.actions[state].get(terminal)
            ended = terminal == END and state in self.ends
            if ended or action is None or action >= 0 or not self.rules[~action].renames:
                return state
            state = self.actions[below][self.rules[~action].origin]

    def _value(self, rule: _Rule, children: list[Any]) -> Any:
        """What a rule makes: a tree, the only child, or a list for the rule around it."""
        if rule.parts:
            parts: list[Any] = []
            for number, taken, nones in rule.parts:
                if nones:
                    parts += [None] * nones
                if not taken:
                    parts.append(children[number])
                elif parts:
                    parts += children[number]
                else:
                    parts = children[number]  # a list that grows at its end
            children = parts
        if rule.nones:
            children += [None] * rule.nones
        if rule.inlined:
            return children
        if len(children) == 1:
            if rule.single:
                return children[0]
            if type(children[0]) is Token:
                leaf = Place(children[0].start_pos, children[0].end_pos, rule.deep)  # type: ignore[arg-type]
                return Tree(rule.name, children, leaf)  # type: ignore[arg-type]
        start = end = -1
        depth = 0
        for child in children:
            if child is None:
                continue
            if type(child) is Token:
                place: Any = child
            else:
                place = child._meta
                if place.depth > depth:
                    depth = place.depth
            if start < 0:
                start = place.start_pos
            end = place.end_pos
        return Tree(rule.name, children, Place(start, end, depth + rule.deep))  # type: ignore[arg-type]

    def accepted(self, states: list[int]) -> frozenset[str]:
        """The terminals that can come next."""
        return frozenset(t for t in self.actions[states[-1]] if self._accepts(states, t))

    def _accepts(self, states: list[int], terminal: str) -> bool:
        if terminal.islower() or terminal.startswith("_"):
            return False
        kept, top = len(states), list[int]()  # the stack is states[:kept] + top
        while True:
            state = top[-1] if top else states[kept - 1]
            if terminal == END and state in self.ends:
                return True
            action = self.actions[state].get(terminal)
            if action is None or action >= 0:
                return action is not None
            size = self.rules[~action].size
            kept -= max(0, size - len(top))
            del top[max(0, len(top) - size) :]
            top.append(
                self.actions[top[-1] if top else states[kept - 1]][self.rules[~action].origin]
            )


def lark_of(text: str, starts: Iterable[str]) -> Lark:
    """Lark's parser of a grammar."""
    return Lark(
        text,
        parser="lalr",
        lexer="contextual",
        start=list(starts),
        propagate_positions=True,
        maybe_placeholders=True,
    )


def description(grammar: Lark, flat: frozenset[str]) -> tuple[Any, ...]:
    """What Tables are made of, of Lark's parser: as JSON can hold it."""
    table = grammar.parser.parser._parse_table
    rules: list[tuple[Any, ...]] = []
    numbers: dict[int, int] = {}
    actions: list[dict[str, int]] = []
    for state in range(len(table.states)):
        row: dict[str, int] = {}
        for symbol, (action, argument) in table.states[state].items():
            if action is not Shift and id(argument) not in numbers:
                numbers[id(argument)] = len(rules)
                rules.append(astuple(_rule(argument, flat)))
            row[str(symbol)] = argument if action is Shift else ~numbers[id(argument)]
        actions.append(row)
    terminals = sorted(
        grammar.terminals,
        key=lambda t: (-t.priority, -t.pattern.max_width, -len(t.pattern.value), t.name),
    )
    told = [
        (t.name, t.pattern.to_regexp(), t.pattern.value, t.pattern.type == "str") for t in terminals
    ]
    starts = {str(start): state for start, state in table.start_states.items()}
    return starts, sorted(table.end_states.values()), rules, actions, told, grammar.ignore_tokens


def _rule(rule: Any, flat: frozenset[str]) -> _Rule:
    """What Lark knows of a rule, as its tree builder reads it."""
    options = rule.options
    name = str(rule.origin.name)
    empty = "".join(str(int(b)) for b in options.empty_indices)
    nones = [len(ones) for ones in empty.split("0")] if empty else [0] * (len(rule.expansion) + 1)
    inlines = [not s.is_term and s.name.startswith("_") for s in rule.expansion]
    parts = tuple((i, taken, nones[i]) for i, taken in enumerate(inlines))
    plain = not any(inlines) and not any(nones[:-1])
    single = bool(options.expand1) and not rule.alias
    return _Rule(
        origin=name,
        name=str(rule.alias or name),
        size=len(rule.expansion),
        parts=() if plain else parts,
        nones=nones[-1],
        renames=single and len(rule.expansion) == 1 and plain and not nones[-1],
        single=single,
        deep=int(str(rule.alias or name) not in flat),
        inlined=name.startswith("_"),
    )


def _scanner(names: list[str], patterns: dict[str, str]) -> re.Pattern[str]:
    """White space and comments, and then one of the terminals, if there is one."""
    ignored = _IGNORED_BEFORE_ROWS if "ROW" in names else _IGNORED
    words = "|".join(f"(?P<{name}>{patterns[name]})" for name in names)
    return re.compile(f"{ignored}(?:{words})?" if words else ignored)


def _token(terminal: str, text: str, start: int, end: int) -> Token:
    token = str.__new__(Token, text)
    token.type, token.value, token.start_pos, token.end_pos = terminal, text, start, end
    return token


def _last_token(values: list[Any]) -> Token | None:
    """The last token that was read, wherever in the trees it is by now."""
    last = values[-1] if values else None
    while last is not None and not isinstance(last, Token):
        parts = last if isinstance(last, list) else last.children
        last = next((p for p in reversed(parts) if p is not None), None)
    return last
