"""From the syntax tree of an expression to its checked form (typed.py).

Patterns, lets and arguments are put in as expressions; names are resolved against the world's
vocabulary; events become masks over hypotheses. Every mistake is reported once and stops the
expression that holds it, while its neighbours are still checked.

One class in layers, one module for each, from names to patterns:

    elaboration   reporting, wanted kinds, what names stand for
    arithmetic    numbers, functions, `if`, comparisons
    predicates    [predicate @ script[k]], places, characters
    frames        scripts, indices, appended turns, sums over t
    beliefs       the forms of forms.py: P, E, KL, ...
    calls         functions and patterns

`Elaboration.item` finds the method for a node by its class: `on_sum` for ast.Sum.
"""

from __future__ import annotations

from i2pdsl.language.calls import Calls
from i2pdsl.language.elaboration import Item, LeavesAtZero, Stop


class Elaborator(Calls):
    """Checks expressions for one world, one length and one assumption."""


__all__ = ["Elaborator", "Item", "LeavesAtZero", "Stop"]
