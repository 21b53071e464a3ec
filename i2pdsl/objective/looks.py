"""Which frames an objective looks at: what a fold over them must keep."""

from __future__ import annotations

from i2pdsl.language import typed as ty
from i2pdsl.language.evaluate import COMPARISONS
from i2pdsl.language.forms import BY_NAME

COMPARED = frozenset(name for name, _ in COMPARISONS.values())


def looks_far(node: object, length: int) -> bool:
    """Whether a form looks at frames that a fold which keeps none cannot reach."""
    match node:
        case ty.Belief(moment=ty.Moment()):
            return True
        case ty.Moment(first=None):
            return 0 < node.frames[0] < length
        case ty.Moment():
            return node.offset not in (0, -1)
        case ty.Reduction() | ty.Beats():
            # A fixed frame inside a sum (the prior excepted) changes terms already taken.
            bodies = node.parts if isinstance(node, ty.Beats) else (node.body,)
            nodes = [n for body in bodies for n in ty.walk(body)]
            moments = [n for n in nodes if isinstance(n, ty.Moment)]
            frames = [m for n in nodes for m in _asked(n)]
            fixed = any(m.first is None and m.frames[0] != 0 for m in moments)
            return fixed or any(m.offset != 0 for m in frames) or any(map(looks_ahead, bodies))
    return False


def asks_holdings(node: object) -> bool:
    """Whether a form is about what differs between the hypotheses that a row stands for."""
    if not isinstance(node, ty.Belief):
        return False
    values = any(isinstance(part, ty.ValueAt) for part in ty.walk(node))
    form = BY_NAME[node.form]
    return values or form.looks_ahead != "" or (form.about == "latent" and node.about is None)


def looks_back(node: object) -> bool:
    """Whether such a form is about a frame of which nothing is held when the next one is over."""
    return asks_holdings(node) and any(
        isinstance(part, ty.Moment) and part.offset == -1 for part in ty.walk(node)
    )


def looks_ahead(node: object) -> bool:
    """Whether a term of a sum depends on what happens after its frame t.

    `t < when [...]` does not: where it has not happened up to frame t, it is later than t.
    """
    match node:
        case ty.Reduction() | ty.When():
            return True
        case (
            ty.Apply(arguments=(ty.When() as when, ty.TimeTable() as table))
            | ty.Apply(arguments=(ty.TimeTable() as table, ty.When() as when))
        ) if node.operation in COMPARED:
            first = table.first - when.before
            return any(value > first + i for i, value in enumerate(table.values) if first + i > 0)
    return any(looks_ahead(child) for child in ty.children(node))


def looks_around(expression: ty.Typed) -> bool:
    """Whether it asks what else may happen after a frame."""
    beliefs = (node for node in ty.walk(expression) if isinstance(node, ty.Belief))
    return any(BY_NAME[belief.form].looks_ahead for belief in beliefs)


def looks_within(expression: ty.Typed) -> bool:
    """Whether it asks more of a script than its states and actions and what viewers believe after
    each frame: what they believe and expect within a frame, or once turns are appended."""
    for node in ty.walk(expression):
        match node:
            case ty.Moment() if node.turns or node.seen is not None:
                return True
            case ty.Belief(form=form, moment=moment):
                if moment is not None or BY_NAME[form].asks_frame:
                    return True
    return False


def _asked(node: object) -> list[ty.Moment]:
    """The frames that a form asks of themselves, not only of the belief or the state after them."""
    match node:
        case ty.Feature(moment=ty.Moment() as moment):
            return [moment]
        case ty.Moment() if node.seen is not None:
            return [node]
        case ty.Belief(form=form, given=given) if BY_NAME[form].asks_frame:
            return [g.moment for g in given]
    return []
