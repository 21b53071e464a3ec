"""The syntax tree of a story: what was written, with its place. Nothing here knows a world."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, fields
from typing import Any

from i2pdsl.errors import Source, Span
from i2pdsl.language import forms


@dataclass(frozen=True, slots=True)
class Node:
    """Anything that was written. Two nodes are equal if they say the same, wherever they stand."""

    span: Span = field(compare=False)


# Expressions, in the order of language.md.


@dataclass(frozen=True, slots=True)
class Number(Node):
    value: float


@dataclass(frozen=True, slots=True)
class Text(Node):
    value: str


@dataclass(frozen=True, slots=True)
class Name(Node):
    id: str


@dataclass(frozen=True, slots=True)
class Time(Node):
    """`t`, the current frame."""


@dataclass(frozen=True, slots=True)
class Length(Node):
    """`T`, the number of frames."""


@dataclass(frozen=True, slots=True)
class Script(Node):
    """`script`, the story being made."""


@dataclass(frozen=True, slots=True)
class Pair(Node):
    first: Expr
    second: Expr


@dataclass(frozen=True, slots=True)
class SetOf(Node):
    items: tuple[Expr, ...]


@dataclass(frozen=True, slots=True)
class Shares(Node):
    """`(latent) = {value: weight, ...}`, behind `prior`: pairs of a value and its weight."""

    latent: Expr
    pairs: tuple[Pair, ...]


@dataclass(frozen=True, slots=True)
class Prefix(Node):
    """`script[:end]`, or `script[:end, until]`: of the last frame only up to someone's action."""

    script: Expr
    end: Expr
    until: Expr | None = None


@dataclass(frozen=True, slots=True)
class FrameOf(Node):
    """`script[number]`."""

    script: Expr
    number: Expr


@dataclass(frozen=True, slots=True)
class Move(Node):
    """`who: action`, or `who: action!` where the action shall fail."""

    who: Name
    action: Name
    fails: bool


@dataclass(frozen=True, slots=True)
class Fall(Node):
    """`deus: table at (1, 3)`: an event in an appended turn."""

    event: Name
    thing: Name
    place: Expr


@dataclass(frozen=True, slots=True)
class Append(Node):
    """`script ++ [turn]`."""

    script: Expr
    turn: tuple[Move | Fall, ...]


@dataclass(frozen=True, slots=True)
class Sum(Node):
    """`a + b - c`: terms with their signs (+1 or -1)."""

    signs: tuple[int, ...]
    terms: tuple[Expr, ...]


@dataclass(frozen=True, slots=True)
class Product(Node):
    """`a * b / c`: the operators stand before each factor but the first."""

    operators: tuple[str, ...]
    factors: tuple[Expr, ...]


@dataclass(frozen=True, slots=True)
class Negative(Node):
    operand: Expr


@dataclass(frozen=True, slots=True)
class Power(Node):
    base: Expr
    exponent: Expr


@dataclass(frozen=True, slots=True)
class Compare(Node):
    """A chain of comparisons, `a <= b < c`."""

    operators: tuple[str, ...]
    operands: tuple[Expr, ...]


@dataclass(frozen=True, slots=True)
class Member(Node):
    """`x in {a, b}`."""

    item: Expr
    items: SetOf


@dataclass(frozen=True, slots=True)
class Not(Node):
    operand: Expr


@dataclass(frozen=True, slots=True)
class And(Node):
    operands: tuple[Expr, ...]


@dataclass(frozen=True, slots=True)
class Or(Node):
    operands: tuple[Expr, ...]


@dataclass(frozen=True, slots=True)
class If(Node):
    condition: Expr
    then: Expr
    otherwise: Expr


@dataclass(frozen=True, slots=True)
class Reduction(Node):
    """`sum_t body`, or `sum_{t in first..last} body`; kind is sum, mean, min or max."""

    kind: str
    first: Expr | None
    last: Expr | None
    body: Expr


@dataclass(frozen=True, slots=True)
class Argument(Node):
    """An argument of a call; `name` where it was written `NAME = value`.

    `comparison` is the other reading of `rho = 0`, for a pattern that has no parameter `rho`.
    """

    name: Name | None
    value: Expr
    comparison: Expr | None = field(default=None, compare=False)


@dataclass(frozen=True, slots=True)
class Call(Node):
    callee: Name
    arguments: tuple[Argument, ...]


@dataclass(frozen=True, slots=True)
class LastOf(Node):
    script: Expr


@dataclass(frozen=True, slots=True)
class Form(Node):
    """A form about what viewers believe, `NAME(about | given, ...)` (forms.py has the names).

    `given` holds scripts and further conditions as written; of a divergence the two scripts stand
    first first. `audience` is whose belief it is, where that is said: `NAME[audience](...)`.
    `moment` is the frame of which it is asked in hindsight, `NAME(about @ moment | given, ...)`.
    """

    name: str
    about: tuple[Expr, ...]
    given: tuple[Expr, ...]
    audience: Name | None = None
    moment: Expr | None = None

    @property
    def kind(self) -> forms.Form:
        """Its entry in the table of forms."""
        return forms.BY_NAME[self.name]


@dataclass(frozen=True, slots=True)
class Holds(Node):
    """`[predicate @ frame]`."""

    predicate: Expr
    frame: Expr


@dataclass(frozen=True, slots=True)
class Ever(Node):
    """`never [predicate]`, `eventually [predicate]`, or the frame `when [predicate]` comes."""

    word: str
    predicate: Expr


Expr = (
    Number
    | Text
    | Name
    | Time
    | Length
    | Script
    | Pair
    | SetOf
    | Shares
    | Prefix
    | FrameOf
    | Append
    | Sum
    | Product
    | Negative
    | Power
    | Compare
    | Member
    | Not
    | And
    | Or
    | If
    | Reduction
    | Call
    | LastOf
    | Form
    | Holds
    | Ever
)

# Statements.


@dataclass(frozen=True, slots=True)
class World(Node):
    name: Name | Text
    settings: tuple[Argument, ...]


@dataclass(frozen=True, slots=True)
class LengthIs(Node):
    """`length frames`, or `length frames..most`, of which the search chooses."""

    frames: Expr
    most: Expr | None = None

    @property
    def value(self) -> Span:
        """Where the number stands, or both."""
        return self.frames.span if self.most is None else self.frames.span.to(self.most.span)


@dataclass(frozen=True, slots=True)
class Start(Node):
    condition: Expr


@dataclass(frozen=True, slots=True)
class Allow(Node):
    events: tuple[Expr, ...]


@dataclass(frozen=True, slots=True)
class Let(Node):
    name: Name
    value: Expr


@dataclass(frozen=True, slots=True)
class Parameter(Node):
    name: Name
    default: Expr | None


@dataclass(frozen=True, slots=True)
class Pattern(Node):
    """A reusable objective; `documentation` is the comment block above it."""

    name: Name
    parameters: tuple[Parameter, ...]
    body: Expr
    documentation: str = ""

    @property
    def signature(self) -> str:
        """`arc(who, shape = sin(t / T * 3 * pi), ...)` as it was written."""
        parts = [" ".join(p.span.text.split()) for p in self.parameters]
        return f"{self.name.id}({', '.join(parts)})"


@dataclass(frozen=True, slots=True)
class Import(Node):
    target: Name | Text


@dataclass(frozen=True, slots=True)
class Objective(Node):
    """`maximize value` (sign +1) or `minimize value` (sign -1)."""

    sign: int
    value: Expr


@dataclass(frozen=True, slots=True)
class Weight(Node):
    """The weight of an automatic term, such as `rationality W`; `term` says which."""

    term: str
    value: Expr


@dataclass(frozen=True, slots=True)
class Assume(Node):
    """`assume CONDITION`; the condition is None for `assume nothing`."""

    condition: Expr | None


@dataclass(frozen=True, slots=True)
class Audience(Node):
    """`audience name(settings)`, or `audience called = name(settings)`; a text in place of the
    name is a file."""

    name: Name | Text
    settings: tuple[Argument, ...]
    called: Name | None = None


@dataclass(frozen=True, slots=True)
class Search(Node):
    name: Name
    settings: tuple[Argument, ...]


@dataclass(frozen=True, slots=True)
class Require(Node):
    """`require condition`, or `require [first] before [second]`, where `second` is given."""

    condition: Expr
    second: Expr | None = None


@dataclass(frozen=True, slots=True)
class Pin(Node):
    """`pin script[first]: condition`, or `... = [turn]`, which need not say what everybody does, or
    `... = "script.json"`, as in another script; of several frames with a `last` one."""

    first: Expr
    last: Expr | None
    turn: tuple[Move | Fall, ...] = ()
    condition: Expr | None = None
    file: Text | None = None


Statement = (
    World
    | LengthIs
    | Start
    | Allow
    | Let
    | Pattern
    | Import
    | Objective
    | Weight
    | Assume
    | Audience
    | Search
    | Require
    | Pin
)


@dataclass(frozen=True)
class Program:
    """A file: its statements in the order in which they were written."""

    source: Source
    statements: tuple[Statement, ...]
    unread: tuple[Span, ...] = ()  # statements that could not be read

    def of(self, kind: type[Any]) -> list[Any]:
        """All statements of one class."""
        return [s for s in self.statements if isinstance(s, kind)]


_fields: dict[type, tuple[str, ...]] = {}


def _field_names(kind: type[Node]) -> tuple[str, ...]:
    if kind not in _fields:
        _fields[kind] = tuple(f.name for f in fields(kind) if f.name != "span")
    return _fields[kind]


def children(node: Node) -> Iterator[Node]:
    """The expressions directly below a node; the names of callees, parameters and audiences are
    none."""
    match node:
        case Call(arguments=arguments):
            yield from (a.value for a in arguments)
        case Form(about=about, given=given, moment=moment):
            yield from (*about, *(() if moment is None else (moment,)), *given)
        case Append(script=script, turn=turn):
            yield script
            yield from (part.place for part in turn if isinstance(part, Fall))
        case Pin(turn=turn):
            yield from (e for e in (node.first, node.last, node.condition) if e is not None)
            yield from (part.place for part in turn if isinstance(part, Fall))
        case _:
            for name in _field_names(node.__class__):
                value = getattr(node, name)
                for part in value if isinstance(value, tuple) else (value,):
                    if isinstance(part, Node):
                        yield part


def walk(node: Node) -> Iterator[Node]:
    """A node and everything below it, without recursion."""
    stack = [node]
    while stack:
        part = stack.pop()
        yield part
        stack.extend(children(part))


def is_belief(node: Node) -> bool:
    """Whether a node asks what viewers believe or see, and no event or quantity can hold it."""
    is_form = isinstance(node, Form) and node.kind.shape is not forms.HIDDEN
    return is_form or isinstance(node, Holds | Ever)
