"""Worlds whose actions have names: turns by hand, as they are typed behind `play`, and tables of
what is done in a script."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from i2pdsl.errors import Diagnostic, Source, Span, StoryError, moved
from i2pdsl.language import typed as ty
from i2pdsl.language.elaborate import Elaborator, Stop
from i2pdsl.language.forms import Word
from i2pdsl.language.naming import NAME, same_name
from i2pdsl.language.parse import parse_expression
from i2pdsl.language.scope import Env, Module
from i2pdsl.language.statements import split_outside
from i2pdsl.language.vocabulary import STAY, Vocabulary
from i2pdsl.worlds.kind import refused
from i2pdsl.worlds.record import Record, Trajectory, extended
from i2pdsl.worlds.world import World

_ACT = re.compile(rf"\s*(?P<who>{NAME})(?:\s*:\s*|\s+)(?P<what>{NAME}\s*!?)\s*$")
_EVENT = re.compile(rf"\s*(?P<who>{NAME})(?:\s*:\s*|\s+)(?P<what>{NAME}\s+at\b.*)$", re.DOTALL)
_BEFORE = "script ++ "


@dataclass(frozen=True)
class WrittenTurn:
    """A turn as stories write it, and where its words were typed.

    Attributes:
        text: `[cheese: west!, robot: stay]`.
        places: (start, end, start in what was typed) of each piece.
    """

    text: str
    places: tuple[tuple[int, int, int], ...]

    def typed_place(self, start: int, end: int) -> tuple[int, int] | None:
        """The range of what was typed that a range of the turn comes from."""
        found = [(a, b, at) for a, b, at in self.places if a < end and start < b]
        if not found:
            return None
        (a, _, first), (c, d, last) = found[0], found[-1]
        return first + max(0, start - a), last + min(end, d) - c


def play(words: Vocabulary) -> Word:
    """What `play` is here: `play cheese west!`."""
    who = words.characters[0]
    action = next(a for a in words.actions_of(who)[::-1] if a != STAY)
    fails, several = bool(words.can_fail), len(words.characters) > 1
    told = ["`!`: the move fails"] * fails + ["who is not named stays"] * several
    return Word(
        "play",
        f"play WHO ACTION{'[!]' * fails}{', ...' * several}",
        "adds a frame by hand" + (f" ({'; '.join(told)})" if told else ""),
        f"play {who} {action}{'!' * (who in words.can_fail)}",
    )


def written_turn(typed: str, words: Vocabulary) -> WrittenTurn:
    """`cheese west!` as `[cheese: west!, robot: stay]`: who is not named stays."""
    begins, ends = 0, len(typed)
    if typed.startswith("[") and typed.endswith("]"):
        begins, ends = 1, len(typed) - 1
    text, places, named, has_event = "[", [], set(), False

    def put(piece: str, at: int) -> None:
        nonlocal text
        places.append((len(text), len(text) + len(piece), at))
        text += piece

    for part in split_outside(typed[begins:ends], ","):
        text += ", " if begins > (typed[:1] == "[") else ""
        event = _EVENT.match(part)
        match = event or _ACT.match(part)
        has_event = has_event or event is not None
        if match is None:  # the parser says what is wrong
            put(part.strip(), begins + len(part) - len(part.lstrip()))
        else:
            named.add(same_name(match["who"]))
            put(match["who"], begins + match.start("who"))
            text += ": "
            put(match["what"].rstrip(), begins + match.start("what"))
        begins += len(part) + 1
    if not has_event:
        for who in words.characters:
            text += f", {who}: {STAY}" if who not in named else ""
    return WrittenTurn(f"{text}]", tuple(places))


def appended(world: World, module: Module, length: int, turn: str) -> tuple[ty.Turn, ...]:
    """The checked turns of `script ++ TURN` as the elaborator has them. Raises StoryError."""
    source = Source("play", _BEFORE + turn)
    problems: list[Diagnostic] = []
    elaborator = Elaborator(world.vocabulary, length, problems.append, query=True)
    try:
        item = elaborator.item(parse_expression(source), Env(module))
    except Stop:
        raise StoryError(problems) from None
    return item.value


def played(world: World, module: Module, path: Trajectory, typed: str) -> tuple[Trajectory, str]:
    """A script with one more turn, and the turn as stories write it. Raises StoryError."""
    turn = written_turn(typed, world.vocabulary)

    def put(span: Span) -> Span:
        if span.source.name != "play":
            return span
        start, end = span.start - len(_BEFORE), span.end - len(_BEFORE)
        return Span(Source("play", typed), *(turn.typed_place(start, end) or (0, len(typed))))

    if world.vocabulary.longest is not None and len(path.actions) >= world.vocabulary.longest:
        raise refused("the time is up", typed)
    try:
        (act,) = appended(world, module, len(path.actions), turn.text)
    except StoryError as problem:
        raise StoryError(moved(problem.diagnostics, put)) from None
    state = np.asarray(path.states[-1])
    action, possible = world.act(world.tables, state, act)
    if not possible:
        raise refused("this cannot happen: it is there already, or its place is taken", typed)
    return extended(world, path, [int(action)]), turn.text


def options(words: Vocabulary, before: Sequence[str]) -> list[tuple[str, str]]:
    """What may be typed next: who, then what."""
    if not before:
        found = [(c, "character") for c in words.characters]
        return found + [(e, "event") for e in words.events]
    who, *more = before
    if more:
        return []
    if who in words.characters:
        actions = words.actions_of(who)
        found = [(a, "action") for a in actions]
        return found + [(f"{a}!", "action") for a in actions if a != STAY and who in words.can_fail]
    return [(f"{thing} at (", "object") for thing in words.events.get(who, ())]


def columns(words: Vocabulary, record: Record) -> dict[str, tuple[list[Any], str]]:
    """NAME_action and NAME_moved of each character, NAME_column and NAME_row of everything
    (missing where it is absent or carried)."""
    found: dict[str, tuple[list[Any], str]] = {}
    frames: list[Mapping[str, Any]] = [{"state": record.start}, *record.frames]
    for who in words.characters:
        turns = [frame.get(who) or {} for frame in frames]
        found[f"{who}_action"] = [turn.get("action") for turn in turns], "string"
        found[f"{who}_moved"] = [turn.get("moved") for turn in turns], "boolean"
    for thing in (*words.characters, *words.things):
        states = [frame["state"].get(thing) for frame in frames]
        places = [(None, None) if s is None or isinstance(s, str) else s for s in states]
        for axis, name in enumerate(("column", "row")):
            found[f"{thing}_{name}"] = [place[axis] for place in places], "Int64"
    return found
