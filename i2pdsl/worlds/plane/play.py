"""Frames of a plane by hand: `mover east`, `mover 30 1.5 20, cat west`."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

import numpy as np

from i2pdsl.errors import Source, Span, StoryError, did_you_mean, error
from i2pdsl.language.forms import Word
from i2pdsl.language.vocabulary import Vocabulary
from i2pdsl.worlds.kind import refused
from i2pdsl.worlds.plane.world import PlaneWorld
from i2pdsl.worlds.record import Trajectory, extended

DIRECTIONS = {
    name: 45.0 * number
    for number, name in enumerate(
        ("east", "northeast", "north", "northwest", "west", "southwest", "south", "southeast")
    )
}
STAY = "stay"
USUAL, MOST_FRAMES = 10, 1000
FORM = "write `WHO DIRECTION SPEED FRAMES`, such as `mover east` or `mover 30 1.5 20`"


def play(words: Vocabulary) -> Word:
    """What `play` is here."""
    several = "; who is not named stays" if len(words.characters) > 1 else ""
    return Word(
        "play",
        "play WHO DIRECTION [SPEED [FRAMES]]" + ", ..." * bool(several),
        f"adds {USUAL} frames by hand, or so many: directions are names or degrees (0 east, 90 "
        f"north), speeds factors of the one that it likes{several}",
        f"play {words.characters[0]} east",
    )


def played(world: PlaneWorld, path: Trajectory, typed: str) -> tuple[Trajectory, str]:
    """A script with what was typed, and that in words. Raises StoryError.

    Directions are names or degrees (0 east, 90 north), speeds factors of the one that it likes,
    1 if not given; who is not named stays.
    """
    names = [c.name for c in world.spec.characters]
    velocity, frames, told = np.zeros(2 * len(names)), 0, {n: f"{n}: {STAY}" for n in names}
    for part in re.finditer(r"[^,]+", typed):
        words = list(re.finditer(r"\S+", part[0]))

        def wrong(message: str, hint: str | None, number: int = 0) -> StoryError:
            at = words[number]  # noqa: B023
            start = part.start() + at.start()  # noqa: B023
            span = Span(Source("play", typed), start, start + len(at[0]))
            return error("command", message, span, hint)

        if not 2 <= len(words) <= 4:
            raise wrong("who moves where?", FORM) if words else refused("nobody moves", typed, FORM)
        who, where, *more = (w[0] for w in words)
        if who not in names:
            raise wrong(f"there is no character `{who}`", did_you_mean(who, names) or FORM)
        angle = DIRECTIONS.get(where, _number(where))
        if where != STAY and angle is None:
            hint = did_you_mean(where, (*DIRECTIONS, STAY)) or "a name or degrees: 0 east, 90 north"
            raise wrong(f"`{where}` is no direction", hint, 1)
        speed = _number(more[0]) if more else 1.0
        if speed is None or not 0 <= speed <= 2:
            message = "expected a speed from 0 to 2, in units of the one that it likes"
            raise wrong(message, FORM, 2)
        count = more[1] if len(more) > 1 else str(USUAL)
        if not count.isdecimal() or not 1 <= int(count) <= MOST_FRAMES:
            raise wrong(f"expected a number of frames from 1 to {MOST_FRAMES:,}", FORM, 3)
        frames = max(frames, int(count))
        number = names.index(who)
        if where != STAY:
            pace = speed * world.spec.characters[number].speed
            turn = math.radians(angle or 0.0)
            velocity[2 * number : 2 * number + 2] = pace * math.cos(turn), pace * math.sin(turn)
            told[who] = f"{who}: {where} {speed:g}"
    if not frames:
        raise refused("nobody moves", typed, FORM)
    longer = extended(world, path, np.repeat(velocity[None], frames, axis=0))
    return longer, f"[{', '.join(told.values())}; {frames} frame{'s' * (frames > 1)}]"


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def options(words: Vocabulary, before: Sequence[str]) -> list[tuple[str, str]]:
    """What may be typed next: who, then in which direction."""
    if not before:
        return [(c, "character") for c in words.characters]
    if len(before) == 1 and before[0] in words.characters:
        return [(d, "direction") for d in (*DIRECTIONS, STAY)]
    return []


def frame_in_words(world: PlaneWorld, path: Trajectory, frame: int) -> str:
    """Who moves in which direction, and how fast: `mover: 30 degrees at 1.2 of its speed`."""
    told = []
    for number, c in enumerate(world.spec.characters):
        x, y = path.actions[frame - 1][2 * number : 2 * number + 2]
        speed = math.hypot(x, y) / c.speed
        angle = round(math.degrees(math.atan2(y, x))) % 360
        name = next((n for n, a in DIRECTIONS.items() if a == angle), f"{angle}°")
        told.append(f"{c.name}: {STAY}" if speed < 0.01 else f"{c.name}: {name} {speed:.2g}")
    return ", ".join(told)
