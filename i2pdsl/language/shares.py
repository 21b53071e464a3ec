"""`value: weight, ...` of a latent, as a story or a world's file tells it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from i2pdsl.errors import Span, did_you_mean, shorten
from i2pdsl.language.vocabulary import Latent, Value, show_value

Problem = Callable[[str, str, Span, str], None]
CONTRADICTION = "no prior has these shares"
WHY_NONE = "they contradict each other, or ask for what no hypothesis of the world is"
OTHERS = "others"


@dataclass(frozen=True)
class Told:
    """`value: weight`, as it is written in a story or a world: a value as values are shown."""

    value: str
    weight: float
    place: Span
    weight_place: Span


def shares_of(
    latent: Latent,
    told: Sequence[Told],
    place: Span,
    problem: Callable[[str, str, Span, str], None],
) -> dict[Value, float] | None:
    """The weight of each value of a latent; `others` have theirs together. What is wrong is told to
    `problem`: a code, a message, a place and a hint; then it is None."""
    values = {show_value(value): value for value in latent.values}
    weights: dict[str, float] = {}
    wrong = False
    for each in told:
        if each.value not in values and each.value != OTHERS:
            hint = did_you_mean(each.value, values) or f"its values: {latent.domain}"
            problem(
                "no-value", f"`{latent.name}` is never `{shorten(each.value)}`", each.place, hint
            )
        elif each.value in weights:
            problem("duplicate", f"`{each.value}` is given twice", each.place, "leave one out")
        elif not (math.isfinite(each.weight) and each.weight >= 0):
            message = f"a weight is a number of at least 0, not {each.weight:g}"
            problem("prior", message, each.weight_place, "weights need not sum to 1")
        else:
            weights[each.value] = each.weight
            continue
        wrong = True
    if wrong:
        return None
    free = [show_value(value) for value in latent.values if value not in latent.forced]
    left = [value for value in free if value not in weights]
    others = weights.pop(OTHERS, None)
    found = {values[value]: weight for value, weight in weights.items()}
    if others is not None and not left:
        problem("prior", "there are no others", place, f"leave out `{OTHERS}`")
    elif others is None and left:
        message = f"no weight is given to {', '.join(left)}"
        problem("prior", message, place, f"`{OTHERS}: WEIGHT` is what they have together")
    elif not sum(weights.values()) + (others or 0.0) > 0:
        problem("prior", f"all weights of `{latent.name}` are 0", place, "one must be above 0")
    else:
        return found | {values[value]: (others or 0.0) / len(left) for value in left}
    return None
