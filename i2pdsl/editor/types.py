"""The type of an expression in words: a value and its axes, such as `number over t`."""

from __future__ import annotations

from dataclasses import replace

from i2pdsl.editor.surroundings import Surroundings
from i2pdsl.errors import Diagnostic
from i2pdsl.language import ast
from i2pdsl.language import typed as ty
from i2pdsl.language.elaborate import Elaborator, Item, LeavesAtZero, Stop
from i2pdsl.language.scope import Env, Module
from i2pdsl.language.statements import room_for_nesting
from i2pdsl.language.story import default_assumption

_PLACES = ("", "event", "quantity", "start")  # where an expression may make sense
_MOST_NODES = 500  # of an expression whose type is asked for
_WORDS = {
    "script": "script",
    "prefix": "the first frames of a script",
    "frame": "a frame of a script",
    "pair": "pair",
    "text": "text",
}


def type_of(node: ast.Expr, around: Surroundings, module: Module | None = None) -> str:
    """`number`, `number over t`, `event`, `distribution over rho`...; '' where it has none."""
    world = around.vocabulary
    if world is None:
        return ""
    elaborator = Elaborator(world, around.length, _ignore, query=True)
    elaborator.most_nodes = _MOST_NODES
    elaborator.assumption = default_assumption(world)
    elaborator.audiences = around.audiences
    env = Env(module or around.module, times=range(1, around.length + 1))
    with room_for_nesting():
        for inside in _PLACES:
            # An event cannot depend on t.
            times = None if inside in ("event", "start") else env.times
            try:
                item = elaborator.item(node, replace(env, inside=inside, times=times))
            except (Stop, LeavesAtZero):
                continue
            return _in_words(item, inside)
    return ""


def _ignore(_: Diagnostic) -> None:
    pass


def _in_words(item: Item, inside: str) -> str:
    if item.kind in _WORDS:
        return _WORDS[item.kind]
    value = item.value
    if isinstance(value, ty.Belief) and value.labels:
        over = " and ".join(axis.name for axis in value.labels)
        return f"distribution over {over}" + _axes(value.axes)
    if item.kind == "truth":
        return "event" if inside == "event" else "condition" + _axes(value.axes)
    return "number" + _axes(value.axes)


def _axes(axes: ty.Axes) -> str:
    over = [name for name, has in (("hypotheses", axes.hypothesis), ("t", axes.time)) if has]
    return f" over {' and '.join(over)}" if over else ""
