"""Questions about a finished script: one expression, with t free or not."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from i2pdsl.errors import Diagnostic, Source, Span, StoryError, error
from i2pdsl.language import ast
from i2pdsl.language import typed as ty
from i2pdsl.language.beliefs import UNTHINKABLE
from i2pdsl.language.elaborate import Elaborator, LeavesAtZero, Stop
from i2pdsl.language.parse import parse_expression
from i2pdsl.language.scope import Env, Module
from i2pdsl.language.settings import Settings
from i2pdsl.language.statements import room_for_nesting
from i2pdsl.language.story import USUAL, VIEWERS, Audience, able, default_assumption, ordered
from i2pdsl.language.vocabulary import Vocabulary


@dataclass(frozen=True)
class TypedQuery:
    """A checked query: the frames t that it covers (None without a free t), and its value."""

    value: ty.Typed
    times: range | None
    warnings: tuple[Diagnostic, ...]

    @property
    def asks_beliefs(self) -> bool:
        """Whether it is about what viewers believe."""
        return any(isinstance(node, ty.Belief) for node in ty.walk(self.value))

    @property
    def appends(self) -> bool:
        """Whether it asks what would be if the script went on."""
        return any(isinstance(n, ty.Moment) and n.turns for n in ty.walk(self.value))


def check_query(
    source: Source,
    vocabulary: Vocabulary,
    module: Module,
    length: int,
    assumption: ty.Mask | None = None,
    assume: Source | None = None,
    audiences: tuple[Audience, ...] = (USUAL,),
) -> TypedQuery:
    """Checks an expression over a finished script of `length` frames.

    `assumption` is the story's; `assume` is the text of another one ('nothing' drops it).
    `audiences` are those of the story. Raises StoryError.
    """
    problems: list[Diagnostic] = []
    elaborator = Elaborator(vocabulary, length, problems.append, query=True)
    elaborator.audiences = audiences
    env = Env(module)
    value: ty.Typed = ty.Constant(0.0)
    times = range(length + 1)
    with room_for_nesting():
        if assume is not None:
            nothing = assume.text.strip() == "nothing"
            condition = None if nothing else parse_expression(assume)
            elaborator.assumption = read_assumption(elaborator, condition, env)
        else:
            elaborator.assumption = assumption or default_assumption(vocabulary)
            if not all(audience.can_hold(elaborator.assumption) for audience in audiences):
                message = "some viewer takes what is assumed for impossible"
                hint = "`assume nothing` drops what is assumed by default"
                raise error("impossible", message, Span(source, 0, len(source.text)), hint)
        node = parse_expression(source)
        try:
            try:
                value = _value(elaborator, node, env, times)
            except LeavesAtZero:
                times = range(1, length + 1)
                value = _value(elaborator, node, env, times)
        except Stop:
            pass
    errors = [d for d in problems if d.severity == "error"]
    if errors:
        raise StoryError(list(dict.fromkeys(errors)))
    return TypedQuery(value, times if value.axes.time else None, tuple(dict.fromkeys(problems)))


def check_assumption(
    source: Source, vocabulary: Vocabulary, module: Module, audiences: tuple[Audience, ...]
) -> ty.Mask:
    """The mask of what stands behind `assume`, or of a condition. Raises StoryError."""
    problems: list[Diagnostic] = []
    elaborator = Elaborator(vocabulary, 1, problems.append, query=True)
    elaborator.audiences = audiences
    condition = None if source.text.strip() == "nothing" else parse_expression(source)
    mask = read_assumption(elaborator, condition, Env(module))
    if problems:
        raise StoryError(problems)
    return mask


def check_audience(
    source: Source,
    vocabulary: Vocabulary,
    module: Module,
    audiences: tuple[Audience, ...] = (USUAL,),
    folder: Path | None = None,
) -> tuple[Audience, ...]:
    """The audiences of a script with others in the place of the one that needs no name.

    Args:
        source: what stands behind `audience` in a story, or the name of an audience of the story.
        folder: where an audience's file is looked for.

    Raises StoryError.
    """
    problems: list[Diagnostic] = []
    elaborator = Elaborator(vocabulary, 1, problems.append, query=True)
    node = parse_expression(source)
    known = {audience.name: audience.observers for audience in audiences}
    if isinstance(node, ast.Name) and node.id in known:
        observers = known[node.id]
    elif isinstance(node, ast.Name | ast.Text | ast.Call):
        name, given = (node.callee, node.arguments) if isinstance(node, ast.Call) else (node, ())
        observers = Settings(elaborator, Env(module)).audience(name, given, folder)
    else:
        hint = "write `bayesian(beta = 1)` or the name of an audience of the story"
        raise error("audience", "this is no audience", node.span, hint)
    if problems:
        raise StoryError(problems)
    return ordered([Audience(VIEWERS, able(observers, vocabulary)), *audiences[1:]])


def _value(elaborator: Elaborator, node: ast.Expr, env: Env, times: range) -> ty.Typed:
    env = replace(env, times=times)
    item = elaborator.item(node, env)
    if isinstance(item.value, ty.Belief) and item.value.labels:
        return item.value
    if item.kind not in ("number", "truth"):
        raise elaborator.wrong_kind("a number", item, node, env)
    return elaborator.folded(item.value, times, node, env)


def read_assumption(elaborator: Elaborator, condition: ast.Expr | None, env: Env) -> ty.Mask:
    """The mask of an `assume`; `assume nothing` keeps every hypothesis."""
    every = (True,) * len(elaborator.world.hypotheses)
    if condition is None:
        return every
    try:
        mask = elaborator.mask(condition, env, "condition")
    except Stop:
        return every
    if not all(audience.can_hold(mask) for audience in elaborator.audiences):
        message = "no hypothesis fulfils this assumption"
        hint = UNTHINKABLE if any(mask) else None
        elaborator.report(Diagnostic("impossible", message, condition.span, hint))
        return every
    return mask
