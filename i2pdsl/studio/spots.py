"""Where somebody can be put in a frame, if all else that is pinned is kept."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from i2pdsl.errors import Diagnostic, Source
from i2pdsl.language import ast
from i2pdsl.language import typed as ty
from i2pdsl.language.elaborate import Elaborator
from i2pdsl.language.parse import parse_expression
from i2pdsl.language.scope import Env
from i2pdsl.language.story import Pin
from i2pdsl.objective.compile import asked_of
from i2pdsl.objective.possible import holds_in, possible_states
from i2pdsl.objective.starts import allowed_starts
from i2pdsl.render.drawing import Point, Room
from i2pdsl.render.pictures import drawing_for
from i2pdsl.stories import Story
from i2pdsl.studio.hands import where
from i2pdsl.studio.outline import abilities
from i2pdsl.studio.protocol import REFUSED, USAGE, Refusal
from i2pdsl.studio.text import StoryText, parts, whose
from i2pdsl.worlds.world import World


def spots(story: Story, world: World, frame: int, who: str) -> dict[str, Any]:
    """All spots, those that somebody can be at first: of a map what `possible_states` says (nothing
    where states are computed), where bodies move whether they are near enough. And the room
    between them, where there is some."""
    typed, words, drawing = story.typed, story.typed.vocabulary, drawing_for(story.spec)
    if who not in abilities(story)["drag"]:
        raise Refusal(REFUSED, f"`{who[:40]}` cannot be moved by hand in this world")
    if not 0 <= frame <= typed.length:
        raise Refusal(USAGE, f"the story has frames 0 to {typed.length}")
    if not (frame or abilities(story)["start"]):
        raise Refusal(REFUSED, f"all films {words.where} begin like this")
    places: list[dict[str, Any]] = [
        {"place": spot.place, "label": spot.place, "at": spot.at, "shape": spot.shape}
        for spot in drawing.spots(story.spec)
    ]
    if who in words.may_be_absent:
        places.append({"place": None, "label": "absent", "at": None, "shape": None})
    if not words.enumerable:
        room = drawing.room(world, typed, frame, who)
        found = [{**each, "possible": _lies_in(room, each["at"])} for each in places]
        return {"spots": found, "room": None if room is None else asdict(room)}
    if not world.lists_states:
        return {"spots": [{**place, "possible": None} for place in places], "room": None}
    text = StoryText(typed.source.text)
    starts = _starts(story, world, text, frame, who)
    states = possible_states(typed, world, starts, frame, _of(story, text, frame, who))
    found = [
        {**place, "possible": holds_in(world, _asked(story, frame, who, place["place"]), states)}
        for place in places
    ]
    return {"spots": sorted(found, key=lambda each: not each["possible"]), "room": None}


def _lies_in(room: Room | None, at: Point) -> bool | None:
    """Whether a point lies where somebody can be; None where that is not known."""
    if room is None or room.reached is None:
        return None
    return any(x <= at[0] <= x + w and y <= at[1] <= y + h for x, y, w, h in room.reached)


def _of(story: Story, text: StoryText, frame: int, who: str) -> list[Pin]:
    """The pins that say where somebody is in a frame; another one takes their place."""
    mine = [
        statement.span.start
        for statement in text.program.of(ast.Pin)
        if statement.condition is not None
        and any(whose(part) == who for part in parts(statement.condition))
    ]
    return [p for p in story.typed.pins if p.frame == frame and p.span.start in mine]


def _starts(story: Story, world: World, text: StoryText, frame: int, who: str) -> Any:
    """The first pictures; in frame 0 without what `start` says of whoever is moved."""
    if frame or story.typed.start is None:
        return allowed_starts(world, story.typed.start)
    states = world.starts()
    for part in parts(text.program.of(ast.Start)[-1].condition):
        if whose(part) != who:
            states = states[asked_of(world, _typed(story, 1, part))(states, states, states)]
    return states


def _asked(story: Story, frame: int, who: str, place: str | None) -> ty.Typed:
    return _typed(story, max(1, frame), parse_expression(Source("pin", where(who, place))))


def _typed(story: Story, frame: int, condition: ast.Expr) -> ty.Typed:
    """A condition on what is seen, checked."""
    problems: list[Diagnostic] = []
    elaborator = Elaborator(story.typed.vocabulary, story.typed.length, problems.append)
    moment = ty.Moment((), (frame,), None)
    return elaborator.seen(condition, moment, Env(story.typed.module)).value
