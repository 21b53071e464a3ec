"""The proof that a pattern fits a world.

What is proved: a story of that world whose objective is a call of the pattern is accepted by the
checker, for LENGTH frames and the default assumption (everyone is rational),

- with every choice of the world's characters for the parameters that are characters, and for each
  of these choices with some choice of the others: an event for an event, a latent for a latent, a
  number for a number, as `candidates` lists them;
- parameters with a default keep it.

So the pattern names nothing that the world has not, uses no form that the world cannot have
(appended turns need actions with names), and there is something in the world to use it with. It
is not proved that every event fits (a condition may be impossible together with another), nor that
other lengths do (`script[:40]` needs 40 frames), nor that the stories are good.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice, product
from typing import Any

from i2pdsl.errors import Diagnostic, Source, StoryError
from i2pdsl.language.elaborate import Elaborator, LeavesAtZero, Stop
from i2pdsl.language.parse import parse_expression
from i2pdsl.language.scope import Env, Module
from i2pdsl.language.statements import room_for_nesting
from i2pdsl.language.story import VIEWERS, default_assumption
from i2pdsl.language.vocabulary import Latent, Vocabulary, show_value

LENGTH = 25  # frames of the stories that are proved to be accepted
MOST_TRIES = 300  # choices for the parameters of one pattern in one world
MOST_CASTS = 256  # choices of characters
MOST_WORK = 500_000  # parts of expressions, for all patterns of a library: about ten seconds
_PARTS_OF_A_TRY = 50  # what reading a call costs beside them; the standard patterns need 24,000
NOT_TRIED = f"not tried, since the patterns grow to more than {MOST_WORK:,} parts in all"
_FOR_CERTAIN = 40  # of them, those in which an example without warnings is looked for

_WHATEVER_IS_GIVEN = ("nesting", "recursion")  # mistakes that no other argument mends
_WHATEVER_THE_WORLD = (
    NOT_TRIED,
    "the patterns grow to more",
    "the story grows to more",
    "nested deeper",
)

# How a pattern of each kind of result is used in an objective.
_USES = {
    "number": ("{}",),
    "event": ("sum_t P({} | script[:t])", "sum_t [{} @ script[t]]", "sum_t (if {} then 1 else 0)"),
    "shape": ("sum_t ({})",),
    "script": ("last({})",),
    "first frames": ("sum_t entropy({})",),
    "one frame": ("sum_t surprise({})", "surprise({})"),
    "predicate": ("sum_t [{} @ script[t]]",),
    "frame": ("{}",),
}
_EITHER = tuple(dict.fromkeys(use for uses in _USES.values() for use in uses))


class _Work:
    """What the proofs of a library cost so far, in parts of expressions."""

    def __init__(self) -> None:
        self.parts = 0

    @property
    def is_too_much(self) -> bool:
        return self.parts >= MOST_WORK


def fit_all(patterns: list[dict[str, Any]], module: Module, worlds: dict[str, Vocabulary]) -> None:
    """Gives each record of a pattern (library/description.py) what `fit` finds for each of these
    worlds, by name, as `worlds`.

    Beyond MOST_WORK for all of them it is not tried: NOT_TRIED says so.
    """
    work = _Work()
    for pattern in patterns:
        found = pattern["worlds"] = {}
        hopeless: dict[str, Any] | None = None
        for name, world in worlds.items():
            found[name] = hopeless or fit(pattern, module, world, work)
            if found[name].get("because", "").startswith(_WHATEVER_THE_WORLD):
                hopeless = found[name]


def fit(
    pattern: dict[str, Any], module: Module, world: Vocabulary, work: _Work | None = None
) -> dict[str, Any]:
    """`{"fits": true}`, or `{"fits": false, "because": MESSAGE}`.

    Args:
        pattern: its record (library/description.py).
        module: where the pattern's name is known.
    """
    work = work or _Work()
    characters = [p for p in _needed(pattern) if p["kind"] == "character"]
    if len(world.characters) ** len(characters) > MOST_CASTS:
        because = f"there are more than {MOST_CASTS} ways to choose its characters"
        return {"fits": False, "because": because}
    because = "nobody is in this world"
    for who in product(world.characters, repeat=len(characters)):
        call, because = _some_call(pattern, who, module, world, work)
        if call is None:
            break
    return {"fits": False, "because": because} if because else {"fits": True}


def example_call(pattern: dict[str, Any], module: Module, world: Vocabulary) -> str | None:
    """A call that is accepted in a world that a pattern fits, without a warning if that is found
    soon."""
    who = tuple(world.characters[0] for p in _needed(pattern) if p["kind"] == "character")
    return _some_call(pattern, who, module, world, _Work(), tries_for_certain=_FOR_CERTAIN)[0]


def _needed(pattern: dict[str, Any]) -> list[dict[str, Any]]:
    return [p for p in pattern["parameters"] if p["default"] is None]


def was_tried(pattern: dict[str, Any]) -> bool:
    """Whether it is known of all worlds if a pattern fits them."""
    return all(proof.get("because") != NOT_TRIED for proof in pattern["worlds"].values())


def uses_of(result: str) -> tuple[str, ...]:
    """How a pattern of a kind of result is used in an objective: texts with `{}` for its call."""
    return _USES.get(result, _EITHER)


def _some_call(
    pattern: dict[str, Any],
    who: tuple[str, ...],
    module: Module,
    world: Vocabulary,
    work: _Work,
    tries_for_certain: int = 0,
) -> tuple[str | None, str]:
    """A call that is accepted, else why the first is not.

    Among so many tries one without a warning is looked for.
    """
    needed = _needed(pattern)
    accepted: str | None = None
    because = "there is nothing in this world to use it with"
    for number, arguments in enumerate(_choices(needed, who, world)):
        call = f"{pattern['name']}({', '.join(arguments)})" if needed else pattern["name"]
        if pattern["parameters"] and not needed:
            call += "()"
        for use in uses_of(pattern["result"]):
            if work.is_too_much:
                return accepted, "" if accepted else NOT_TRIED
            mistake, warned = _mistakes(use, call, module, world, work)
            if mistake is None and not warned:
                return call, ""
            if mistake is not None and mistake.code in _WHATEVER_IS_GIVEN:
                return None, mistake.message
            if mistake is None:
                accepted = accepted or call
            elif number == 0 and use == uses_of(pattern["result"])[0]:
                because = mistake.message
        if accepted is not None and number >= tries_for_certain:
            break
    return accepted, "" if accepted else because


def _choices(
    needed: list[dict[str, Any]], who: tuple[str, ...], world: Vocabulary
) -> Iterator[tuple[str, ...]]:
    """Arguments for the parameters without a default. The first choices differ from each other."""
    cast = iter(who)
    lists = []
    for number, parameter in enumerate(needed):
        if parameter["kind"] == "character":
            lists.append([next(cast)])
            continue
        found = candidates(parameter["kind"], world)
        first = number % len(found) if found else 0
        lists.append([*found[first:], *found[:first]])
    return islice(product(*lists), MOST_TRIES)


def candidates(kind: str, world: Vocabulary) -> list[str]:
    """What a parameter of a kind can be in a world, as it would be written."""
    latents = [x for x in world.latents.values() if x.kind != "truth"]
    match kind:
        case "event":
            rational = [x.name for x in world.latents.values() if x.kind == "truth"]
            return [event for latent in latents for event in _events(latent)] + rational
        case "number":
            return ["1", "0.5"]
        case "shape":
            return ["sin(t/T * 2*pi)", "t/T"]
        case "frame":
            return ["T/2", "T", "1"]
        case "script":
            return ["script"]
        case "latent":
            return [x.name for x in latents]
        case "value":
            values = [show_value(v) for x in latents for v in x.values]
            return list(dict.fromkeys(values))
        case "predicate":
            return _predicates(world)
        case "character":
            return list(world.characters)
        case "audience":
            return [VIEWERS]
        case _:
            places = [*world.characters, *world.things, *world.places]
            rest = ("event", "latent", "number", "script", "predicate", "shape")
            return [*(c for k in rest for c in candidates(k, world)[:6]), *places]


def _events(latent: Latent) -> list[str]:
    """Events that one latent decides, those that tell most stories first."""
    numbers = [v for v in latent.values if isinstance(v, int | float)]
    found = []
    if numbers and min(numbers) < 0 < max(numbers):
        found = [f"{latent.name} > 0", f"{latent.name} < 0"]
    return found + [f"{latent.name} = {show_value(v)}" for v in reversed(latent.values)]


def _predicates(world: Vocabulary) -> list[str]:
    words = {
        "character": world.characters,
        "thing": (*world.characters, *world.things),
        "object": world.things,
        "place": tuple(world.places),
        "spot": (*world.characters, *world.things, *world.places),
    }
    found = []
    for predicate in world.predicates.values():
        choices = product(*(words.get(p, ()) for p in predicate.parameters))
        differing = (c for c in choices if len(set(c)) == len(c))
        found += [f"{predicate.name}({', '.join(c)})" for c in islice(differing, 4)]
    return found


def _mistakes(
    use: str, call: str, module: Module, world: Vocabulary, work: _Work
) -> tuple[Diagnostic | None, bool]:
    """The first mistake of an objective, and whether there is a warning."""
    problems: list[Diagnostic] = []
    elaborator = Elaborator(world, LENGTH, problems.append)
    elaborator.assumption = default_assumption(world)
    with room_for_nesting():
        try:
            node = parse_expression(Source("call", use.format(call)))
            elaborator.number(node, Env(module))
        except StoryError as problem:
            problems.extend(problem.diagnostics)
        except (Stop, LeavesAtZero):
            pass
    work.parts += elaborator.all_nodes + _PARTS_OF_A_TRY
    errors = [d for d in problems if d.severity == "error"]
    return (errors[0] if errors else None), bool(problems)
