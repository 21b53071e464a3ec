"""The examples of `help`, which speak of the kitchen, in the words of the world at hand."""

from __future__ import annotations

import operator
import re
from collections.abc import Sequence

from i2pdsl.errors import Source, StoryError
from i2pdsl.language.builtins import STATEMENT_WORDS
from i2pdsl.language.query import check_query
from i2pdsl.language.vocabulary import Value, Vocabulary, show_value
from i2pdsl.repl.program import Part
from i2pdsl.repl.state import State
from i2pdsl.repl.words import COMMAND_WORDS

_EVENT = re.compile(r"\b(rho|G_cheese|G_robot) (<|>|=|in) ([-\w]+|\{[^}]*\})")
_WORD = re.compile(r"[^\W\d]\w*")
_LATENTS = frozenset(("rho", "G_cheese", "G_robot", "R_cheese", "R_robot"))
_KITCHEN = _LATENTS | {"kitchen", "cheese", "robot", "table", "deus", "pink", "none"}
_NUMBER = re.compile(r"-?\d+")
_TESTS = {"<": operator.lt, ">": operator.gt, "=": operator.eq}


def example_here(example: str, state: State) -> str | None:
    """An example with the names of the session's world; None where it has nothing of the kind."""
    words = state.typed.vocabulary
    first, _, rest = example.partition(" ")
    if first in COMMAND_WORDS:  # `table` is one of them, and no thing of the kitchen
        is_said = first in ("load", "save") or not rest
        said = rest if is_said else in_words_of(rest, words)
        return None if said is None else f"{first} {said}".strip()
    told = in_words_of(example, words)
    if told is None or told == example:
        return told
    try:
        if first in STATEMENT_WORDS:
            state.program.with_part(Part("", told)).understood()
        else:
            module, length = state.typed.module, state.typed.length
            check_query(Source("example", told), words, module, length, state.typed.assumption)
    except StoryError:
        return None
    return told


def in_words_of(example: str, words: Vocabulary) -> str | None:
    """The same said of another world, as far as it has something for each name."""
    here = {*words.characters, *words.things, *words.places, *words.events, *words.latents}
    here |= {words.world, *(show_value(v) for x in words.latents.values() for v in x.values)}
    if _KITCHEN.isdisjoint(set(_WORD.findall(example)) - here):
        return example
    names = _counterparts(words)
    meant = [names.get(name) for name in _LATENTS.intersection(_WORD.findall(example))]
    if len(set(meant)) < len(meant):
        return None  # of several latents, and there is only one
    hidden = [x for x in words.latents.values() if x.name not in words.rational.values()]
    by_name = {x.name: x for x in hidden}

    def event(match: re.Match[str]) -> str:
        """`rho > 0` of a latent that may be no number, and may have no sign."""
        name, sign, value = match.groups()
        latent = by_name.get(names.get(name, ""))
        if latent is None or latent.name == name:
            return match[0]
        values = latent.values
        if latent.kind == "number" and _parts(values, sign, value):
            return f"{latent.name} {sign} {value}"
        if sign == "in":
            some = values[: max(1, min(2, len(values) - 1))]  # of all values it is certain
            return f"{latent.name} in {{{', '.join(map(show_value, some))}}}"
        place = -1 if sign == "<" or value == "none" else int(value == "1")
        return f"{latent.name} = {show_value(values[place % len(values)])}"

    told = _EVENT.sub(event, example)
    told = _WORD.sub(lambda match: names.get(match[0], match[0]), told)
    return told if _KITCHEN.isdisjoint(set(_WORD.findall(told)) - here) else None


def _counterparts(words: Vocabulary) -> dict[str, str]:
    """For names of the kitchen what is most like them in a world."""
    hidden = [x for x in words.latents.values() if x.name not in words.rational.values()]
    goals = [x.name for x in hidden if x.kind == "symbol"] or [x.name for x in hidden]
    numbers = [x.name for x in hidden if x.kind == "number"] or goals
    events = list(words.events.items())
    things = [*(thing for _, of in events for thing in of), *words.things]
    rational = [words.rational[who] for who in words.characters if who in words.rational]
    symbols = [show_value(v) for x in hidden if x.name in goals for v in x.values]
    lists: dict[str, tuple[list[str], int]] = {
        "kitchen": ([words.world], 0),
        "cheese": ([*words.characters], 0),
        "robot": ([*words.characters], -1),
        "G_cheese": (goals, 0),
        "G_robot": (goals, -1),
        "R_cheese": (rational, 0),
        "R_robot": (rational, -1),
        "rho": (numbers, 0),
        "pink": (symbols, 0),
        "table": (things, 0),
        "deus": ([event for event, _ in events], 0),
    }
    return {name: found[place] for name, (found, place) in lists.items() if found}


def _parts(values: Sequence[Value], sign: str, bound: str) -> bool:
    """Whether a comparison holds for some of the values only."""
    if sign not in _TESTS or not _NUMBER.fullmatch(bound):
        return False
    holds = {_TESTS[sign](float(v), float(bound)) for v in values}
    return holds == {True, False}
