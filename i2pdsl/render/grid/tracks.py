"""Keyframes: who is where, in which shape, at every moment.

Time is counted in turns: frame t of the script spans the times t-1 to t, and time 0 shows the
start. The same keyframes are read by the Python renderers (`scene`, `film`) and by the HTML page,
so their interpolation is kept tiny:

    sample(track, time):
      - before the first key: the first key; from the last key on: the last key
      - else take the neighbours a.time <= time < b.time (of keys with equal times the last is a)
        u = (time - a.time) / (b.time - a.time), then w = u bent by a.ease:
          linear u | in u*u | out 1-(1-u)*(1-u) | in-out u*u*(3-2*u) | hold 0
      - x y angle scale_x scale_y opacity lift = a + w * (b - a); pose = a.pose (held)
    drawing (cell size c): an actor's 100 x 100 sprite covers its cell; its foot, the pivot of scale
      and angle (turns, clockwise), is at ((x + 0.5) c, (y + 0.94 - lift) c); its shadow stays at
      lift 0. A mark is drawn about its cell's centre ((x + 0.5) c, (y + 0.5) c) in the same way.
      Actors are drawn in the order of their y, marks after all actors; opacity 0 is not drawn.
"""

from bisect import bisect_right
from dataclasses import dataclass
from typing import NamedTuple

from i2pdsl.render.grid.stage import DIRECTIONS, LOOKS, Beat

# Every pose that a track can hold; a sprite shows its idle face for those it does not know.
FACES = ("idle", "surprised", "sad", "happy")
POSES = (
    *FACES,
    *(f"{verb}-{d}" for verb in ("walk", "push", "try", "bump") for d in DIRECTIONS),
    *(f"look-{d}" for d in LOOKS),  # the idle face, its eyes turned
)
MARKS = ("puff", "dust", "sweat", "bang", "bump", "lines")
GRIP = "grip"  # the mark of a pull, on stages where somebody pulls


class Key(NamedTuple):
    """One keyframe: time in turns, x, y and lift in cells, angle in turns, opacity from 0 to 1."""

    time: float
    x: float
    y: float
    angle: float = 0.0
    scale_x: float = 1.0
    scale_y: float = 1.0
    opacity: float = 1.0
    lift: float = 0.0
    ease: str = "in-out"
    pose: str = "idle"


Track = list[Key]  # times never decrease


class Mark(NamedTuple):
    """A short-lived effect, one of MARKS or a GRIP: its track begins and ends with opacity 0."""

    kind: str
    track: Track


@dataclass(frozen=True)
class Film:
    """Keyframes of a whole script. `tracks` has one for each of the cast; `duration` is T turns."""

    tracks: dict[str, Track]
    marks: tuple[Mark, ...]
    beats: tuple[Beat, ...]
    duration: float


def sample(track: Track, time: float) -> Key:
    """The interpolated key of a track at a time in turns (see the module's text)."""
    i = bisect_right(track, time, key=lambda key: key.time)
    if i == 0:
        return track[0]._replace(time=time)
    if i == len(track):
        return track[-1]._replace(time=time)
    a, b = track[i - 1], track[i]
    w = bend(a.ease, (time - a.time) / (b.time - a.time))

    def between(p: float, q: float) -> float:
        return p + w * (q - p)

    return Key(
        time,
        between(a.x, b.x),
        between(a.y, b.y),
        between(a.angle, b.angle),
        between(a.scale_x, b.scale_x),
        between(a.scale_y, b.scale_y),
        between(a.opacity, b.opacity),
        between(a.lift, b.lift),
        a.ease,
        a.pose,
    )


def bend(ease: str, u: float) -> float:
    """Progress in [0, 1] bent by the named ease."""
    match ease:
        case "linear":
            return u
        case "in":
            return u * u
        case "out":
            return 1 - (1 - u) * (1 - u)
        case "in-out":
            return u * u * (3 - 2 * u)
        case "hold":
            return 0.0
        case _:
            raise ValueError(f"unknown ease {ease!r}")
