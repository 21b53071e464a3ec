"""Fixed frames: `pin script[4] = [cheese: west]`, `pin script[8..10]: at(robot, pink)`, and
`pin script[1..40] = "take.json"` where actions have no names."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from i2pdsl.errors import Diagnostic, Note
from i2pdsl.language import ast
from i2pdsl.language import typed as ty
from i2pdsl.language.elaborate import Elaborator, Stop
from i2pdsl.language.scope import Env
from i2pdsl.language.start import can_start
from i2pdsl.language.story import KeptFrames, Pin
from i2pdsl.untrusted import is_plain_name


def read_pins(
    statements: Sequence[ast.Pin],
    elaborator: Elaborator,
    env: Env,
    allowed: tuple[tuple[str, str], ...],
) -> tuple[Pin, ...]:
    """The pins of a story, one for each statement and frame.

    Reports what is wrong with them, and frames whose pins contradict each other.

    Args:
        allowed: the events that may happen.
    """
    found: list[Pin] = []
    for statement in statements:
        if statement.file is not None:
            continue
        try:
            found += _read(statement, elaborator, env, allowed)
        except Stop:
            continue
    for frame in sorted({pin.frame for pin in found}):
        _check_agreement([pin for pin in found if pin.frame == frame], elaborator)
    return tuple(found)


def read_kept(
    statements: Sequence[ast.Pin], elaborator: Elaborator, env: Env, folder: Path | None
) -> tuple[KeptFrames, ...]:
    """Frames that are those of scripts beside the story; reports what is wrong with them. The
    scripts themselves are read when the story is solved."""
    found: list[KeptFrames] = []
    for statement in statements:
        if statement.file is None:
            continue
        try:
            frames = _frames(statement, elaborator, env)
            found.append(_kept(statement.file, frames, elaborator, env))
        except Stop:
            continue
        if not found[-1].path(folder).is_file():
            message = f"there is no `{found[-1].file}` beside this story"
            elaborator.report(Diagnostic("keep", message, statement.file.span, None, (), "warning"))
    return tuple(found)


def _kept(file: ast.Text, frames: range, elaborator: Elaborator, env: Env) -> KeptFrames:
    name = file.value
    if elaborator.world.enumerable:
        message = f"{elaborator.world.where} frames are pinned in words"
        hint = "`i2p run STORY --keep SCRIPT --frames 1-5` writes those of a script"
        raise elaborator.fail("keep", message, file.span, env, hint)
    if not all(map(is_plain_name, name.split("/"))) or not name.endswith(".json"):
        message = f"`{name[:60]}` is no script beside this story"
        raise elaborator.fail("keep", message, file.span, env, 'it is called as `"take.json"`')
    return KeptFrames(name, frames, file.span)


def _read(
    statement: ast.Pin, elaborator: Elaborator, env: Env, allowed: tuple[tuple[str, str], ...]
) -> list[Pin]:
    frames, turn = elaborator.both(
        lambda: _frames(statement, elaborator, env),
        lambda: elaborator.turn(statement.turn, env) if statement.turn else None,
    )
    if isinstance(turn, ty.Drop) and (turn.event, turn.thing) not in allowed:
        message = f"the story does not allow `{turn.event}({turn.thing})`"
        hint = f"add `allow {turn.event}({turn.thing})`"
        raise elaborator.fail("turn", message, statement.turn[0].span, env, hint)
    pins = []
    for frame in frames:
        moment = ty.Moment((), (frame,), None)
        condition: ty.Typed
        if turn is not None:
            condition = ty.Acted(turn, moment)
        else:
            assert statement.condition is not None
            item = elaborator.seen(statement.condition, moment, env)
            if item.kind != "truth":
                message = "a pin needs what holds or does not, this is a number"
                hint = "compare it: `... > 1`"
                raise elaborator.blame("type", message, statement.condition, env, hint)
            condition = item.value
        pins.append(Pin(condition, statement.span, frame))
    return pins


def _frames(statement: ast.Pin, elaborator: Elaborator, env: Env) -> range:
    """The frames that a statement pins."""
    if statement.first == ast.Number(statement.first.span, 0):
        hint = "the first picture is described by `start CONDITION`"
        raise elaborator.fail("index", "frames count from 1", statement.first.span, env, hint)
    script = ast.Script(statement.span)
    indices = [statement.first, *([statement.last] if statement.last is not None else [])]
    numbers = elaborator.each(
        [lambda i=i: elaborator.at(script, i, 1, env).frames[0] for i in indices]  # type: ignore[misc]
    )
    if numbers[0] > numbers[-1]:
        message = f"there is no frame in {numbers[0]}..{numbers[-1]}"
        raise elaborator.fail("range", message, indices[0].span.to(indices[-1].span), env)
    return range(numbers[0], numbers[-1] + 1)


def _check_agreement(pins: list[Pin], elaborator: Elaborator) -> None:
    """Reports the first pin of a frame that contradicts those before it."""
    for count, pin in enumerate(pins, 1):
        message = _contradiction(pins[:count], elaborator)
        if message:
            others = [p for p in pins[: count - 1] if p.span != pin.span]
            notes = tuple(Note("and this one", p.span) for p in others)
            told = f"frame {pin.frame} cannot be so: {message}"
            elaborator.report(Diagnostic("impossible", told, pin.span, None, notes))
            return


def _contradiction(pins: list[Pin], elaborator: Elaborator) -> str:
    """Why no frame is as all pins say; empty where one may be."""
    turns = [p.condition.turn for p in pins if isinstance(p.condition, ty.Acted)]
    falls = {turn for turn in turns if isinstance(turn, ty.Drop)}
    if len(falls) > 1 or (falls and len(falls) < len(set(turns))):
        return "an event has its frame for itself"
    for who, name in enumerate(elaborator.world.characters):
        acts = {turn[who] for turn in turns if isinstance(turn, tuple)} - {None}
        if len(acts) > 1:
            return f"{name} cannot do two things at once"
    seen = tuple(p.condition for p in pins if not isinstance(p.condition, ty.Acted))
    if seen and can_start(ty.Apply("and", seen), elaborator.world) is False:
        return "no picture is as it says" if len(seen) == 1 else "no picture is as all pins say"
    return ""
