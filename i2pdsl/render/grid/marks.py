"""Marks: short-lived effects beside what bodies do."""

from collections.abc import Sequence
from math import atan2, pi

from i2pdsl.render.grid.stage import STEPS, Beat
from i2pdsl.render.grid.tracks import GRIP, Key, Mark

IMPACT = 0.50  # when a falling thing hits the floor, in turns from the frame's start


def _mark(kind: str, times: Sequence[float], *keys: Key) -> Mark:
    """A mark through the given keys, fading in before the first and out after the last.

    `times` are those of fade-in start, each key, and fade-out end.
    """
    first = keys[0]._replace(time=times[0], opacity=0.0)
    last = keys[-1]._replace(time=times[-1], opacity=0.0)
    timed = [key._replace(time=time) for key, time in zip(keys, times[1:-1], strict=True)]
    return Mark(kind, [first, *timed, last])


def exclaim(beat: Beat, at: Key) -> Mark:
    """An exclamation mark above a watcher's head."""
    up = Key(0, at.x + 0.34, at.y - 0.40, scale_x=0.5, scale_y=0.5, ease="out")
    big = up._replace(y=at.y - 0.52, scale_x=0.62, scale_y=0.62)
    t = beat.start
    return _mark("bang", (t + 0.20, t + 0.26, t + 0.70, t + 0.80), up, big)


def landing(beat: Beat) -> list[Mark]:
    """Dust to both sides of where a thing falls."""
    assert beat.target is not None
    t, (x, y) = beat.start + IMPACT, beat.target
    marks = []
    for side in (-1, 1):
        near = Key(0, x + 0.28 * side, y + 0.34, scale_x=0.4, scale_y=0.4, ease="out")
        far = near._replace(x=x + 0.62 * side, y=y + 0.28, scale_x=0.75, scale_y=0.75)
        marks.append(_mark("dust", (t - 0.01, t + 0.02, t + 0.18, t + 0.32), near, far))
    return marks


def effects(beat: Beat) -> list[Mark]:
    """The marks that tell pushes, failures and bumps apart at a glance."""
    if beat.origin is None or not beat.direction:
        return []
    (x, y), (dx, dy) = beat.origin, STEPS[beat.direction]
    angle = atan2(dy, dx) / (2 * pi) % 1

    def times(*us: float) -> list[float]:
        return [beat.start + u * (beat.end - beat.start) for u in us]

    match beat.verb:
        case "push":  # speed lines run behind the pusher
            lines = Key(0, x - 0.40 * dx, y - 0.40 * dy, angle, 0.8, 0.8)
            later = lines._replace(x=lines.x + 0.9 * dx, y=lines.y + 0.9 * dy)
            return [_mark("lines", times(0.45, 0.53, 0.74, 0.86), lines, later)]
        case "pull":  # what it holds it by
            held = Key(0, x - 0.5 * dx, y - 0.5 * dy + 0.08, angle)
            gone = held._replace(x=held.x + dx, y=held.y + dy, ease="out")
            held = held._replace(ease="in")
            return [_mark(GRIP, times(0.21, 0.43, 0.79, 0.98), held, gone)]
        case "fail":  # a drop of sweat while it tries, a puff where it sinks back
            drop = Key(0, x - 0.36 if dx >= 0 else x + 0.36, y - 0.30, 0.0, 0.40, 0.40)
            fallen = drop._replace(y=y - 0.18)
            puff = Key(0, x + 0.42 * dx, y + 0.36 + 0.10 * dy, 0.0, 0.34, 0.34, ease="out")
            gone = puff._replace(y=puff.y - 0.08, scale_x=0.5, scale_y=0.5)
            return [
                _mark("sweat", times(0.32, 0.40, 0.74, 0.84), drop, fallen),
                _mark("puff", times(0.62, 0.70, 0.86, 1.0), puff, gone),
            ]
        case "bump":  # a star where it hits
            star = Key(0, x + 0.56 * dx, y + 0.54 * dy, angle, 0.45, 0.45, ease="out")
            burst = star._replace(scale_x=0.78, scale_y=0.78)
            return [_mark("bump", times(0.29, 0.31, 0.46, 0.58), star, burst)]
        case _:
            return []
