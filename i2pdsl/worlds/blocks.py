"""The syntax of .world files: blocks of NAME = VALUE lines, with their places. Which blocks there
are, each kind of world says."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

from lark import Token, Tree

from i2pdsl.errors import (
    MOST_SHOWN,
    Diagnostic,
    Note,
    Source,
    Span,
    StoryError,
    closest,
    did_you_mean,
    shorten,
)
from i2pdsl.language.format import format_statements
from i2pdsl.language.mistakes import explain
from i2pdsl.language.naming import NAME, same_name, with_marks
from i2pdsl.language.priors import fitted
from i2pdsl.language.shares import CONTRADICTION, WHY_NONE, Told, shares_of
from i2pdsl.language.statements import Cut, Piece, check_text, split_statements
from i2pdsl.language.tables import Tables, UnexpectedError
from i2pdsl.language.vocabulary import Latent, show_value
from i2pdsl.resources import data_folder

_WORD = re.compile(NAME)
_SECOND_WORD = re.compile(rf"\S+\s+({NAME})")
Shares = tuple[tuple[str, tuple[tuple[Any, float], ...]], ...]
"""Latents, and pairs of a value and its weight."""
KIND = "kind"  # what a file's first statement may say: `kind = plane`
_KIND = re.compile(rf"^{KIND}\b[ \t]*(?:=[ \t]*({NAME})?)?", re.MULTILINE)


@dataclass(frozen=True)
class Syntax:
    """The blocks that the files of a kind of world have.

    Attributes:
        grammar: the file, in grammar/, of Lark's rules `statement` and `entries`.
        keys: those of each block.
        named: the blocks that have a name, and may occur several times.
        drawn: the statements whose lines are drawn, not written.
        elsewhere: what is to be said of a word that has no meaning (in a block, if one is named).
        what: the file says, for messages and their codes.
    """

    grammar: str
    keys: Mapping[str, tuple[str, ...]]
    named: tuple[str, ...]
    drawn: frozenset[str] = frozenset()
    elsewhere: Callable[[str, str], str | None] = lambda word, block: None
    what: str = "world"

    @property
    def keywords(self) -> tuple[str, ...]:
        return (*sorted(self.drawn), *self.keys)

    def cut(self, source: Source) -> Cut:
        """The statements of a file."""
        return split_statements(source, (*self.keywords, KIND), drawn=self.drawn)

    def tree(self, piece: Piece, mistakes: int = 0) -> Tree[Token]:
        """Lark's tree of a block; after many mistakes it explains none. Raises StoryError."""
        return self.tree_of(
            piece.span, "entries" if piece.keyword == KIND else "statement", mistakes
        )

    def tree_of(self, span: Span, start: str, mistakes: int) -> Tree[Token]:
        source = span.source
        try:
            return tables(self.grammar).parse(source.text, span.start, span.end, start)
        except UnexpectedError as problem:
            if mistakes > MOST_SHOWN:
                place = Span(source, problem.start, min(problem.start + 1, span.end))
                raise StoryError([Diagnostic("syntax", "this cannot be read", place)]) from None
            raise StoryError([explain(problem, source, span)]) from None

    def formatted(self, source: Source) -> str:
        """The text of a file in the usual layout; what is drawn stays as it is drawn.

        Raises StoryError if it has syntax errors.
        """
        check_text(source)
        return format_statements(source, self.cut(source), self.tree, drawn=self.drawn)


def kind_said(source: Source) -> tuple[str, Span] | None:
    """The kind of world that a file says it is, and where it says so."""
    match = _KIND.search(source.text)
    if match is None:
        return None
    return same_name(match[1] or ""), Span(source, *match.span(1 if match[1] else 0))


def header(source: Source) -> str:
    """The comment block at the top of a file, which documents its world."""
    lines = []
    for line in source.text.splitlines():
        if not line.startswith("#"):
            break
        lines.append(line.lstrip("#").strip())
    return "\n".join(lines)


@cache
def tables(file: str) -> Tables:
    """The tables of one of the grammars of worlds and studies."""
    text = (data_folder("grammar") / file).read_text(encoding="utf-8")
    return Tables.kept(with_marks(text), ("statement", "entries"))


@dataclass(frozen=True)
class Value:
    """A value as written: a number, a name or text (str), a pair, a tuple of values, or one of
    pairs of them."""

    span: Span
    value: Any
    kind: str  # number | name | text | pair | list | mapping


@dataclass(frozen=True)
class Weighed:
    """The weights that a latent's values are given."""

    told: tuple[Told, ...]
    name: Span
    span: Span


@dataclass
class Block:
    keyword: str
    name: str
    span: Span  # of the name, or of the keyword where there is none
    entries: dict[str, Value]
    keys: dict[str, Span]
    damaged: bool = False  # a line of it could not be read
    shares: dict[str, Weighed] = field(default_factory=dict)  # of latents: `prior(NAME) = {...}`

    def mentioned(self) -> set[Any]:
        """The words in its values."""
        lists = [v.value if v.kind == "list" else [v] for v in self.entries.values()]
        return {v.value for values in lists for v in values if v.kind in ("name", "text")}


class BlockReader:
    """Collects the blocks of a file, and gives typed access to their entries.

    A line that cannot be read spoils neither the rest of its block nor the other blocks.

    Attributes:
        incomplete: whether a block could not be read: what seems to be missing may stand there.
        lost: the texts of such blocks.
        unsure: the kinds of blocks (`tile`, ...) of which one has lost its name.
    """

    def __init__(self, source: Source, syntax: Syntax):
        self.source, self.syntax = source, syntax
        self.readable = source  # the same places, and what stands there can be parsed
        self.problems: list[Diagnostic] = []
        self.blocks: list[Block] = []
        self.incomplete = False
        self.lost: list[str] = []
        self.unsure: set[str] = set()

    def read(self) -> None:
        """Reads the whole text."""
        pieces, unread, problems = self.syntax.cut(self.readable)
        self.report(problems)
        for piece in pieces:
            if piece.keyword != KIND:  # it was read to come here
                self.statement(piece)
        for span in unread:  # the mistake is known: brackets, quotes, indentation
            word = _WORD.match(span.text)
            if word and word[0] in self.syntax.keys:
                self.salvage(span, None)
            else:
                self.lose(span.text, closest(word[0], self.syntax.keywords) if word else None)

    def report(self, problems: Iterable[Diagnostic]) -> None:
        """Reports mistakes in the readable text at their places in the text as it was written."""
        here = lambda span: Span(self.source, span.start, span.end)
        for d in problems:
            notes = tuple(replace(note, span=here(note.span)) for note in d.notes)
            self.problems.append(replace(d, span=here(d.span), notes=notes))

    def lose(self, text: str, kind: str | None) -> None:
        """Notes a block that could not be read; `kind` is what it would have been."""
        self.incomplete = True
        self.lost.append(text)
        if kind in self.syntax.named and not _SECOND_WORD.match(text):
            self.unsure.add(kind)

    def may_be_lost(self, name: str, kinds: str) -> bool:
        """Whether an unknown name may be that of a block that could not be read."""
        names = {same_name(found[1]) for found in map(_SECOND_WORD.match, self.lost) if found}
        return name in names or any(kind in kinds for kind in self.unsure)

    def problem(
        self, code: str, message: str, span: Span, hint: str | None = None, note: Note | None = None
    ) -> None:
        notes = (note,) if note else ()
        self.problems.append(Diagnostic(code, message, span, hint, notes))

    # Syntax.

    def statement(self, piece: Piece) -> None:
        if piece.keyword not in self.syntax.keywords:
            meant = closest(piece.keyword, self.syntax.keywords)
            self.lose(self.source.text[piece.span.start : piece.span.end], meant)
            if self.is_known(piece):
                return
            start = piece.span.start
            span = Span(self.source, start, start + max(1, len(piece.keyword)))
            shown = shorten(piece.keyword) or piece.span.text[:1]
            hint = f"did you mean `{meant}`?" if meant else self.syntax.elsewhere(piece.keyword, "")
            hint = hint or "blocks: " + ", ".join(self.syntax.keywords)
            self.problem(
                "world-block", f"`{shown}` begins no block of a {self.syntax.what}", span, hint
            )
            return
        try:
            tree = self.syntax.tree(piece, len(self.problems))
        except StoryError as problem:
            self.report(problem.diagnostics)
            if piece.keyword in self.syntax.drawn:
                self.incomplete = True
            else:
                place = problem.diagnostics[0].span.start
                self.salvage(piece.span, self.source.position(place)[0])
            return
        if piece.keyword in self.syntax.drawn:
            self.read_drawn(piece, tree)
        else:
            self.read_block(tree)

    def is_known(self, piece: Piece) -> bool:
        """Whether what is wrong about a piece that begins no block was reported already."""
        return False

    def read_drawn(self, piece: Piece, tree: Tree[Token]) -> None:
        """Reads a statement whose lines are drawn."""
        raise NotImplementedError(piece.keyword)

    def salvage(self, span: Span, reported: int | None) -> None:
        """Reads what can be read of a block, line by line.

        `reported` is the line of its first mistake; what is wrong on other lines is reported too.
        None where brackets or quotes are wrong: a line may then belong to the one before.
        """
        head = _WORD.match(span.text)
        known = self.syntax.keys.get(head[0], ()) if head else ()
        source, first = span.source, self.source.position(span.start)[0]
        last = self.source.position(max(span.start, span.end - 1))[0]
        block: Block | None = None
        entries = []
        damaged = False
        for number in range(first, last + 1):
            begin = max(span.start, source.line_starts[number - 1])
            line = Span(source, begin, min(span.end, begin + len(source.line(number))))
            if not line.text.split("#")[0].strip():
                continue
            try:
                if number == first:
                    block = self.head(self.syntax.tree_of(line, "statement", len(self.problems)))
                    if block is None:
                        return
                else:
                    more = self.syntax.tree_of(line, "entries", len(self.problems))
                    entries += more.children
            except StoryError as problem:
                damaged = True
                # A line may also be wrong for the one before it, which has no value.
                if reported is None:
                    word = _WORD.match(line.text.strip())
                    is_key = word is not None and word[0] in known
                    if is_key and not set(line.text) & set('(){}[]"'):
                        self.report(problem.diagnostics)
                elif number not in (reported, reported - 1):
                    self.report(problem.diagnostics)
                if number == first:
                    word = _WORD.match(line.text)
                    self.lose(self.source.text[span.start : span.end], word and word[0])
                    return
        if block is not None:
            block.damaged = damaged
            self.fill(block, entries)

    def read_block(self, tree: Tree[Token]) -> None:
        block = self.head(tree)
        if block is not None:
            self.fill(block, tree.children[2:])

    def head(self, tree: Tree[Token]) -> Block | None:
        """A block with its name, yet without its entries; None where the name is missing."""
        kind: Any = tree.children[0]
        token = kind.children[0]
        name: Any = tree.children[1]
        block = Block(
            str(token), same_name(str(name or "")), self.token_span(name or token), {}, {}
        )
        named = block.keyword in self.syntax.named
        if named and not name:
            hint = f"write `{token} NAME`"
            message = f"every {token} needs a name"
            self.problem("world-block", message, self.token_span(token), hint)
            self.lose(str(token), str(token))
            return None
        if name and not named:
            self.problem("world-block", f"`{token}` takes no name", block.span, "remove the name")
        return block

    def fill(self, block: Block, entries: Iterable[Any]) -> None:
        """Puts the entries into a block."""
        for entry in entries:
            parts: Any = entry.children
            key = str(parts[0])
            if entry.data == "entry_shares":
                self.fill_shares(block, entry)
                continue
            if key in block.entries:
                note = Note("the first one", block.keys[key])
                span = self.token_span(parts[0])
                self.problem("duplicate", f"`{key}` is given twice", span, note=note)
                continue
            block.entries[key] = self.value(parts[2])
            block.keys[key] = self.token_span(parts[0])
        self.blocks.append(block)

    def fill_shares(self, block: Block, entry: Any) -> None:
        """Puts `prior(latent) = {value: weight, ...}` into a block."""
        key, _, latent, *rest = entry.children
        name, place = same_name(str(latent)), self.token_span(latent)
        if block.keyword != "audience" or key != "prior":
            message = f"`{block.keyword}` has no `{key}({latent})`"
            hint = "the block `audience` has `prior(LATENT) = {VALUE: WEIGHT}`"
            self.problem("world-key", message, self.token_span(key), hint)
            return
        if name in block.shares:
            note = Note("the first one", block.shares[name].name)
            self.problem("duplicate", f"the prior of `{name}` is given twice", place, note=note)
            return
        told = []
        for share in (part for part in rest if isinstance(part, Tree)):
            value, _, weight = share.children
            first, second = self.value(value), self.value(weight)
            if second.kind != "number":
                message = f"a weight must be a number, not `{shorten(second.span.text)}`"
                self.problem("world-value", message, second.span)
                return
            plain = first.kind in ("name", "text")
            text = first.value if plain else first.span.text
            text = show_value(first.value) if first.kind == "number" else text
            told.append(Told(text, second.value, first.span, second.span))
        span = Span(self.source, entry.meta.start_pos, entry.meta.end_pos)
        block.shares[name] = Weighed(tuple(told), place, span)

    def shares(self, latents: Mapping[str, Latent]) -> Shares:
        """What viewers think at first, latent by latent."""
        found = []
        for name, weighed in self.weighed:
            latent = latents.get(name)
            if latent is None and not self.incomplete:
                hint = did_you_mean(name, latents) or "latents: " + ", ".join(latents)
                message = f"there is no latent `{shorten(name)}`"
                self.problem("world-name", message, weighed.name, hint)
            elif latent is not None:
                shares = shares_of(latent, weighed.told, weighed.span, self.problem)
                if shares is not None:
                    found.append((name, tuple(shares.items())))
        return tuple(found)

    def check_prior(self, shares: Shares, rows: Sequence[Mapping[str, Any]]) -> None:
        """Reports shares that no prior over the hypotheses has."""
        told = {name: dict(weights) for name, weights in shares}
        if fitted(rows, [1.0] * len(rows), told) is None:
            self.problem("prior", CONTRADICTION, self.weighed[-1][1].span, WHY_NONE)

    @property
    def weighed(self) -> list[tuple[str, Weighed]]:
        """The latents whose values have weights."""
        return [each for block in self.blocks for each in block.shares.items()]

    def token_span(self, token: Token) -> Span:
        assert token.start_pos is not None
        assert token.end_pos is not None
        return Span(self.source, token.start_pos, token.end_pos)

    def value(self, tree: Any) -> Value:
        span = Span(self.source, tree.meta.start_pos, tree.meta.end_pos)
        parts = tree.children
        match str(tree.data):
            case "number":
                return Value(span, float(parts[0]), "number")
            case "negative":
                return Value(span, -float(parts[1]), "number")
            case "name":
                return Value(span, same_name(str(parts[0])), "name")
            case "string":
                return Value(span, same_name(str(parts[0])[1:-1]), "text")
            case "pair":
                return Value(span, (self.value(parts[1]), self.value(parts[3])), "pair")
            case "mapping":
                shares = [part.children for part in parts if isinstance(part, Tree)]
                pairs = [(self.value(key), self.value(item)) for key, _, item in shares]
                return Value(span, pairs, "mapping")
            case _:
                items = [self.value(p) for p in parts if isinstance(p, Tree)]
                return Value(span, items, "list")

    # Typed access to the entries of a block; a wrong one is reported and gives the default.

    def known_keys(self, block: Block) -> None:
        """Reports the keys that a block does not have, and where they belong."""
        known = self.syntax.keys[block.keyword]
        for key, span in block.keys.items():
            if key not in known:
                close = closest(key, known)
                hint = (
                    f"did you mean `{close}`?"
                    if close
                    else self.syntax.elsewhere(key, block.keyword)
                )
                hint = (hint or "known: " + ", ".join(known)).replace("WHO", block.name or "WHO")
                self.problem("world-key", f"`{block.keyword}` has no `{key}`", span, hint)

    def number(
        self, block: Block, key: str, default: float, valid: Callable[[float], bool], range_: str
    ) -> float:
        value = block.entries.get(key)
        if value is None:
            return default
        if value.kind != "number":
            message = f"`{key}` must be a number, not `{shorten(value.span.text)}`"
            self.problem("world-value", message, value.span)
            return default
        if not valid(value.value):
            message = f"`{key}` must be {range_}, not {value.span.text}"
            self.problem("world-range", message, value.span)
            return default
        return float(value.value)

    def word(self, block: Block, key: str, default: str, allowed: tuple[str, ...] = ()) -> str:
        value = block.entries.get(key)
        if value is None:
            return default
        if value.kind not in ("name", "text"):
            message = f"`{key}` must be a word, not `{shorten(value.span.text)}`"
            hint = "one of " + ", ".join(allowed) if allowed else None
            self.problem("world-value", message, value.span, hint)
            return default
        if allowed and value.value not in allowed:
            close = closest(value.value, allowed)
            hint = f"did you mean `{close}`?" if close else "one of " + ", ".join(allowed)
            message = f"`{key}` cannot be `{shorten(value.value)}`"
            self.problem("world-value", message, value.span, hint)
            return default
        return str(value.value)

    def words(self, block: Block, key: str, allowed: tuple[str, ...], what: str) -> tuple[str, ...]:
        value = block.entries.get(key)
        if value is None:
            return ()
        items = value.value if value.kind == "list" else [value]
        found: dict[str, None] = {}
        possible = set(allowed)
        for item in items:
            if item.kind not in ("name", "text"):
                named = f"a {what}".replace("a o", "an o").replace("an other", "another")
                self.problem("world-value", f"`{key}` must name {named}", item.span)
            elif item.value not in possible:
                if not self.may_be_lost(item.value, what):
                    few = len(self.problems) <= MOST_SHOWN
                    hint = did_you_mean(item.value, possible) if few else None
                    message = f"there is no {what} `{shorten(item.value)}`"
                    self.problem("world-name", message, item.span, hint)
            elif item.value not in found:
                found[item.value] = None
        return tuple(found)

    def color(self, block: Block, key: str, default: str) -> str:
        value = block.entries.get(key)
        if value is None:
            return default
        if value.kind != "text" or not re.fullmatch(r"#[0-9a-fA-F]{6}", value.value):
            hint = 'write it as "#rrggbb"'
            self.problem("world-value", f"`{key}` must be a colour", value.span, hint)
            return default
        return str(value.value).lower()
