"""What a story's text is made of, for hands: its wishes, pins, numbers and drawn curves."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from i2pdsl.language import ast
from i2pdsl.language.methods import LONGEST_STORY, has_audience
from i2pdsl.language.vocabulary import Vocabulary
from i2pdsl.render.pictures import drawing_for
from i2pdsl.stories import Story
from i2pdsl.studio.folder import Folder
from i2pdsl.studio.protocol import Refusal
from i2pdsl.studio.text import StoryText, parts, whose
from i2pdsl.worlds.blocks import header
from i2pdsl.worlds.find import world_path

MOST_NUMBERS = 400


def outline(story: Story, folder: Folder) -> dict[str, Any]:
    """What is said of a version of a story."""
    typed = story.typed
    text = StoryText(typed.source.text)
    path = world_path(typed.world, story.folder)
    try:
        world = folder.uri(path.resolve().relative_to(folder.root).as_posix()) if path else None
    except (Refusal, ValueError):  # one that is built in
        world = None
    return {
        "name": typed.name,
        "world": typed.world,
        "world_uri": world,
        "about": " ".join(header(typed.source).split()),
        "length": [typed.lengths[0].length if typed.lengths else typed.length, typed.length],
        "can": abilities(story),
        "wishes": [
            {"text": _one_line(wish), "range": text.range_of(wish.span)}
            for wish in text.program.of(ast.Objective)
        ],
        "pins": list(_pins(text)),
        "start": _start(text),
        "numbers": list(_numbers(text, story))[:MOST_NUMBERS],
        "curves": list(_curves(text)),
        "beats": list(_beats(text)),
        "warnings": [each.as_json() for each in typed.warnings],
    }


def abilities(story: Story) -> dict[str, Any]:
    """What can be done by hand in a story's world."""
    words, drawing = story.typed.vocabulary, drawing_for(story.spec)
    return {
        "drag": list(drawing.held(story.spec)),
        "start": words.enumerable or words.size is not None,
        "hold": "at" in words.predicates or not words.enumerable,
        "effort": words.enumerable,
        "suggest": has_audience(story.typed.search.method),
        "events": {event: list(things) for event, things in words.events.items()},
        "formats": list(drawing.files.offered),
        "transparent": drawing.files.can_be_transparent,
    }


def _one_line(node: ast.Node) -> str:
    return " ".join(node.span.text.split())


def _start(text: StoryText) -> dict[str, Any] | None:
    for start in text.program.of(ast.Start):
        return {"text": _one_line(start.condition), "range": text.range_of(start.span)}
    return None


def _pins(text: StoryText) -> Iterator[dict[str, Any]]:
    """Every pin, those of several things once for each of them."""
    for pin in text.program.of(ast.Pin):
        frames = text.frames(pin)
        if frames is None or not frames:
            continue
        numbers = pin.first.span if pin.last is None else pin.first.span.to(pin.last.span)
        told = {
            "frame": frames[0],
            "last": frames[-1],
            "range": text.range_of(pin.span),
            "frames": text.range_of(numbers),
        }
        if pin.condition is not None:
            for part in parts(pin.condition):
                yield {**told, "text": _one_line(part), "who": whose(part), "kind": "seen"}
            continue
        if pin.file is not None:
            yield {**told, "text": f"as in {pin.file.value}", "who": None, "kind": "kept"}
        for act in pin.turn:
            who = act.who.id if isinstance(act, ast.Move) else None
            yield {**told, "text": _one_line(act), "who": who, "kind": "done"}


def _curves(text: StoryText) -> Iterator[dict[str, Any]]:
    """Drawn curves, with the expression that shall follow each, where that is said beside it."""
    for statement in text.program.statements:
        for node in ast.walk(statement):
            if not isinstance(node, ast.Call) or node.callee.id != "points":
                continue
            points = [_pair(argument.value) for argument in node.arguments]
            if None in points:
                continue
            followed = _followed(statement, node)
            yield {
                "range": text.range_of(node.span),
                "points": points,
                "expression": None if followed is None else _one_line(followed),
            }


def _pair(node: ast.Expr) -> list[float] | None:
    if not isinstance(node, ast.Pair):
        return None
    values = [_constant(part) for part in (node.first, node.second)]
    return None if None in values else [v for v in values if v is not None]


def _constant(node: ast.Expr) -> float | None:
    match node:
        case ast.Number(value=value):
            return value
        case ast.Negative(operand=ast.Number(value=value)):
            return -value
    return None


def _followed(statement: ast.Node, curve: ast.Node) -> ast.Expr | None:
    """What a statement compares with a curve: `(EXPRESSION - points(...))^2`."""
    for node in ast.walk(statement):
        if isinstance(node, ast.Sum) and len(node.terms) == 2 and node.terms[1] is curve:
            return node.terms[0]
    return None


def _beats(text: StoryText) -> Iterator[dict[str, Any]]:
    for wish in text.program.of(ast.Objective):
        for node in ast.walk(wish.value):
            if isinstance(node, ast.Call) and node.callee.id == "beats":
                for argument in node.arguments:
                    yield {"text": _one_line(argument), "range": text.range_of(argument.span)}
                return


# Numbers.


def _numbers(text: StoryText, story: Story) -> Iterator[dict[str, Any]]:
    """All numbers, each with where it can be slid to; those of moments with their frames."""
    last = text.length or story.typed.length
    words = story.typed.vocabulary
    for statement in text.program.statements:
        if isinstance(statement, ast.Pin):
            continue  # has a handle of its own
        moments, fixed = _moments(statement), _fixed(statement)
        names = _named(statement)
        for node in {each.span: each for each in ast.walk(statement)}.values():
            if isinstance(node, ast.Number) and (node.span in moments or node.span not in fixed):
                moment = node.span in moments
                what = names.get(node.span, "")
                yield _number(text, node, what, moment, last, words)
        yield from _left_out(text, story, statement, last)


def _number(
    text: StoryText, node: ast.Number, what: str, moment: bool, last: int, words: Vocabulary
) -> dict[str, Any]:
    value = node.value
    low, high, step = _scale(value)
    if moment:
        low, high, step = 0, last, 1
    elif what == "length":
        low, high, step = 1, min(LONGEST_STORY, max(60, 2 * value)), 1
    elif what in words.settings and (accepts := words.settings[what].accepts) is not None:
        low = low if accepts(low) else min(value, step)
        while high > value and not accepts(high):
            high = max(value, high / 2)
    return {
        "range": text.range_of(node.span),
        "value": value,
        "low": low,
        "high": high,
        "step": step,
        "what": what,
        "frame": int(value) if moment else None,
        "prefix": "",
    }


def _scale(value: float) -> tuple[float, float, float]:
    """Where a number can be slid to: a range that is round, and a hundredth of it or a whole."""
    if value == int(value) and abs(value) >= 2:
        high = max(10.0, 2.0 * abs(value))
        return (-high if value < 0 else 0.0), high, 1.0
    high = 1.0
    while high < abs(value):
        high *= 2
    while abs(value) and abs(value) < high / 20:
        high /= 10
    return (-high if value < 0 else 0.0), high, high / 100


def _moments(statement: ast.Node) -> set[Any]:
    """The places of numbers that are frames: indices, ends of ranges, comparisons with t."""
    found = set()
    for node in ast.walk(statement):
        ends: tuple[ast.Node | None, ...] = ()
        match node:
            case ast.FrameOf(number=number):
                ends = (number,)
            case ast.Prefix(end=end):
                ends = (end,)
            case ast.Reduction(first=first, last=last):
                ends = (first, last)
            case ast.Compare(operands=operands) if any(isinstance(o, ast.Time) for o in operands):
                ends = operands
            case ast.Call(arguments=arguments):
                ends = tuple(a.value for a in arguments if a.name and a.name.id in _MOMENTS)
        found |= {end.span for end in ends if isinstance(end, ast.Number)}
    return found


_MOMENTS = ("turn", "moment", "hint", "comes")  # parameters of standard patterns


def _fixed(statement: ast.Node) -> set[Any]:
    """The places of numbers that are names of something: cells, values of latents, exponents."""
    found = set()
    for node in ast.walk(statement):
        parts: tuple[ast.Node, ...] = ()
        match node:
            case ast.Pair(first=first, second=second):
                parts = (first, second)
            case ast.SetOf(items=items):
                parts = items
            case ast.Compare(operands=operands):
                parts = operands
            case ast.Power(exponent=exponent):
                parts = (exponent,)
        below = [part.operand if isinstance(part, ast.Negative) else part for part in parts]
        found |= {part.span for part in below}
    return found


def _named(statement: ast.Node) -> dict[Any, str]:
    """What numbers are called, where they are the value of something."""
    found: dict[Any, str] = {}
    if isinstance(statement, ast.LengthIs):
        for number in (statement.frames, statement.most):
            if number is not None:
                found[number.span] = "length"
    if isinstance(statement, ast.Weight):
        found[statement.value.span] = statement.term
    if isinstance(statement, ast.Let):
        found[statement.value.span] = statement.name.id
    settings = getattr(statement, "settings", ())
    calls = [n for n in ast.walk(statement) if isinstance(n, ast.Call)]
    for argument in (*settings, *(a for call in calls for a in call.arguments)):
        if argument.name is not None:
            found[argument.value.span] = argument.name.id
    return found


def _left_out(
    text: StoryText, story: Story, statement: ast.Node, last: int
) -> Iterator[dict[str, Any]]:
    """Moments of patterns that a call leaves at their default: where they would be written."""
    if not isinstance(statement, ast.Objective):
        return
    for call in ast.walk(statement):
        if not isinstance(call, ast.Call):
            continue
        found = story.typed.module.find(call.callee.id)
        if found is None or not isinstance(found.item, ast.Pattern):
            continue
        parameters = found.item.parameters
        count = sum(1 for argument in call.arguments if argument.name is None)
        given = {a.name.id for a in call.arguments if a.name is not None}
        given |= {p.name.id for p in parameters[:count]}
        for parameter in parameters:
            name, default = parameter.name.id, parameter.default
            if name in given or name not in _MOMENTS or default is None:
                continue
            frame = _share(default, last)
            if frame is not None:
                at = call.span.end - 1
                yield {
                    "range": text.range(at, at),
                    "value": None,
                    "low": 0,
                    "high": last,
                    "step": 1,
                    "what": name,
                    "frame": frame,
                    "prefix": f"{', ' if call.arguments else ''}{name} = ",
                }


def _share(default: ast.Expr, last: int) -> int | None:
    """The frame of `T/2`, `3/4 * T` and their like."""
    if not isinstance(default, ast.Product):
        return None
    value = 1.0
    for operator, factor in zip(("*", *default.operators), default.factors, strict=True):
        number = float(last) if isinstance(factor, ast.Length) else _constant(factor)
        if number is None or not number:
            return None
        value = value * number if operator == "*" else value / number
    return int(value)
