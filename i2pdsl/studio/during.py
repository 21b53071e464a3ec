"""What a pin can say of a stretch of frames that is marked on the time line."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from typing import Any

from i2pdsl.language.vocabulary import Predicate, Vocabulary
from i2pdsl.studio.made import Made
from i2pdsl.studio.protocol import USAGE, Refusal

MOST_OFFERS = 80
HALF = 0.5  # of what is measured: so much more, or less, is offered of quantities


def offers(made: Made, first: int, last: int) -> list[dict[str, Any]]:
    """Conditions of the world's predicates and quantities, each with how it is in these frames of
    the film as it is: the share in which it holds, or the mean."""
    script = made.script
    if not 1 <= first <= last <= script.length:
        raise Refusal(USAGE, f"the film has frames 1 to {script.length}")
    plain = replace(script, module=replace(script.module, names={}))
    words, found = script.world.vocabulary, []
    for predicate, call in _calls(words):
        now = float(plain.query(f"mean_{{t in {first}..{last}}} [{call} @ script[t]]"))
        about = {"about": predicate.documentation, "now": now}
        if predicate.is_number:
            more, less = (_round(now + sign * HALF * abs(now)) for sign in (1, -1))
            if more != less:
                found += [{"text": f"{call} >= {more}", **about}]
                found += [{"text": f"{call} <= {less}", **about}]
        else:
            found += [{"text": call, **about}, {"text": f"not {call}", **about, "now": 1 - now}]
        if len(found) >= MOST_OFFERS:
            break
    return found


def _calls(words: Vocabulary) -> Iterator[tuple[Predicate, str]]:
    """Predicates of everybody and everything that has a name."""
    entities = (*words.characters, *words.things)
    named = {
        "character": words.characters,
        "object": words.things,
        "thing": entities,
        "place": tuple(words.places),
        "spot": (*entities, *words.places),
    }
    for predicate in words.predicates.values():
        for given in product(*(named[kind] for kind in predicate.parameters)):
            if len(set(given)) == len(given):
                yield predicate, f"{predicate.name}({', '.join(given)})"


def _round(value: float) -> str:
    """Two digits, without an exponent."""
    short = float(f"{value:.2g}") + 0.0
    return f"{short:.10f}".rstrip("0").rstrip(".")
