"""From a finished script to keyframes: who is where, in which shape, at every moment.

Time is counted in turns: frame t of the script spans the times t-1 to t, and time 0 shows the
start. Within a turn the characters act one after the other. The same keyframes are read by the
Python renderers (`scene`, `film`) and by the HTML page, so their interpolation is kept tiny:

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
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import atan2, pi, sin
from typing import Any, NamedTuple

from i2pdsl.render.grid.stage import (
    DIRECTIONS,
    LOOKS,
    STEPS,
    Beat,
    Cell,
    Stage,
    break_down,
    held_in,
    on_map,
)

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


# ---------------------------------------------------------------------------------- sampling


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


# ------------------------------------------------------------------------------- the dope sheets
#
# A cue is a key in the actor's own terms: `u` runs from 0 to 1 over its beat, `along` is the way
# gone in the beat's direction (cells), `lean` tips toward it (turns), `press` squeezes against it,
# `squash` makes low and wide (positive) or long and thin (negative).


class Cue(NamedTuple):
    u: float
    along: float = 0.0
    squash: float = 0.0
    press: float = 0.0
    lean: float = 0.0
    lift: float = 0.0
    ease: str = "in-out"
    pose: str = "idle"


def _hop(u0: float, u1: float, start: float, end: float, height: float) -> list[Cue]:
    """A smooth leap. Height and way have different shapes, so it is cut into straight pieces."""
    cues = []
    for i in range(1, 8):
        s = i / 8
        along = start + (end - start) * s * s * (3 - 2 * s)
        stretch = 0.10 - 0.19 * sin(pi * s)
        lift = height * 4 * s * (1 - s)
        cues.append(Cue(u0 + (u1 - u0) * s, along, stretch, 0, 0.012, lift, "linear", "walk"))
    return cues


STEP = [
    Cue(0.05),
    Cue(0.22, -0.05, 0.10, ease="linear", pose="walk"),  # anticipation: crouch, a little back
    *_hop(0.22, 0.70, -0.05, 1.0, 0.15),
    Cue(0.70, 1.0, 0.11, pose="walk"),  # landing
    Cue(0.81, 1.0, -0.035),
    Cue(0.92, 1.0),
]
CONTACT = 0.16  # how far two neighbours' outlines are apart, in cells
PUSH = [
    Cue(0.05),
    Cue(0.21, -0.15, 0.09, lean=-0.034, ease="in", pose="push"),  # winds up
    Cue(0.30, CONTACT, lean=0.024, ease="out", pose="push"),  # contact comes first ...
    Cue(0.43, CONTACT, 0.03, press=0.12, lean=0.044, ease="in", pose="push"),  # ... then effort ...
    Cue(0.73, 1 + CONTACT, press=0.02, lean=0.040, ease="out", pose="push"),  # ... both go ...
    Cue(0.82, 0.97, -0.03, lean=-0.012, pose="push"),  # ... and it falls back on its feet
    Cue(0.93, 1.0),
]
PUSHED = [  # same times and eases as PUSH from 0.43 to 0.73, so that the two stay in touch
    Cue(0.30, pose="surprised"),
    Cue(0.43, press=0.14, lean=0.010, ease="in", pose="surprised"),
    Cue(0.73, 1.0, press=0.04, lean=-0.020, ease="out", pose="surprised"),
    Cue(0.81, 1.10, press=-0.06, lean=-0.034, pose="surprised"),  # is carried on, and sways
    Cue(0.90, 1.0, lean=0.014, pose="surprised"),
    Cue(0.96, 1.0),
]
PULL = [  # its face is turned to what it pulls, which follows at the same times
    Cue(0.05),
    Cue(0.21, -CONTACT, lean=-0.020, ease="in-out", pose="push"),  # takes hold ...
    Cue(0.43, -CONTACT + 0.08, 0.05, lean=0.040, ease="in", pose="push"),  # ... leans back ...
    Cue(0.78, 1.0, lean=0.020, ease="out", pose="push"),  # ... both go
    Cue(0.93, 1.0),
]
PULLED = [
    Cue(0.43, ease="in"),
    Cue(0.80, 1.0, ease="out"),
    Cue(0.96, 1.0),
]
FAIL = [
    Cue(0.05),
    Cue(0.19, -0.05, 0.12, ease="out", pose="try"),
    Cue(0.36, 0.27, -0.06, lean=0.036, pose="try"),  # reaches for the cell ...
    Cue(0.44, 0.21, 0.00, lean=0.006, pose="try"),  # ... wobbles ...
    Cue(0.52, 0.25, -0.03, lean=0.042, pose="try"),
    Cue(0.60, 0.18, 0.02, lean=0.000, pose="try"),
    Cue(0.80, 0.00, 0.13, lean=-0.012, pose="sad"),  # ... and sinks back where it was
    Cue(0.94, 0.00, 0.03, pose="sad"),
]
BUMP = [
    Cue(0.08),
    Cue(0.20, -0.09, 0.07, ease="in", pose="walk"),
    Cue(0.30, CONTACT, lean=0.020, ease="out", pose="bump"),
    Cue(0.35, CONTACT, press=0.20, ease="out", pose="bump"),  # hard stop
    Cue(0.48, -0.09, -0.05, lean=-0.030, lift=0.05, pose="bump"),  # thrown back
    Cue(0.62, 0.0, 0.06, pose="bump"),
    Cue(0.80),
]
PUT = [  # leans to where it goes, and back
    Cue(0.05),
    Cue(0.30, 0.14, lean=0.030, pose="push"),
    Cue(0.62, 0.14, lean=0.030, pose="push"),
    Cue(0.90),
]
STAY = [Cue(0.25), Cue(0.52, squash=-0.035), Cue(0.80)]
SHEETS = {"step": STEP, "push": PUSH, "pull": PULL, "put": PUT}
SHEETS |= {"fail": FAIL, "bump": BUMP, "stay": STAY}


def choreograph(stage: Stage, script: Mapping[str, Any]) -> Film:
    """Keyframes for a finished script (the dict of script.json).

    At every whole time t each actor is exactly where the script's state t has it, at rest.
    """
    beats = break_down(stage, script)
    tracks = {actor.name: [_entrance(actor.name, script, beats)] for actor in stage.cast}
    marks: list[Mark] = []
    for number, beat in enumerate(beats):
        if beat.verb == "fall":
            tracks[beat.actor] += _fall(beat)
            marks += _landing(beat)
            for actor in stage.characters:
                if actor.name != beat.actor:
                    tracks[actor.name] += _startle(beat, tracks[actor.name][-1])
                    marks.append(_exclaim(beat, tracks[actor.name][-1]))
        elif beat.verb == "vanish":
            tracks[beat.actor] += _vanish(beat)
        elif beat.verb == "laid":
            assert beat.target is not None
            tracks[beat.actor].append(Key(_let_go(beat, LAID), *beat.target))
        elif beat.verb == "handed":
            pass  # it is in one hand, and then in the other
        else:
            shown = _play(SHEETS[beat.verb], beat, beat.origin, beat.target)
            tracks[beat.actor] += _looking(shown, _intent(stage, beats, number, tracks))
            moved = {beat.actor, *(shove.name for shove in beat.pushed)}
            for actor in () if stage.together else stage.characters:
                if beat.verb != "stay" and actor.name not in moved:
                    tracks[actor.name] += _watching(beat, tracks[actor.name][-1])
            for shove in beat.pushed:
                sheet = PULLED if beat.verb == "pull" else PUSHED
                tracks[shove.name] += _play(sheet, beat, shove.origin, shove.target)
            marks += _effects(beat)
    duration = float(len(script["frames"]))
    for thing, holder, begin, end in _holdings(script, beats, duration):
        tracks[thing] += _carried(tracks[holder], begin, end)
        tracks[thing].sort(key=lambda key: key.time)
    return Film(tracks, tuple(marks), tuple(beats), duration)


def _entrance(name: str, script: Mapping[str, Any], beats: Sequence[Beat]) -> Key:
    """The first key: where it stands, or unseen where it will fall."""
    start = script["start"]
    at = on_map(start, held_in(start).get(name, name))  # what is carried appears with its holder
    if at is not None:
        return Key(0, at[0], at[1])
    falls = [beat.target for beat in beats if beat.actor == name and beat.target is not None]
    x, y = falls[0] if falls else (0, 0)
    return Key(0, x, y, opacity=0.0, ease="hold")


_BACK = {"north": "south", "south": "north", "east": "west", "west": "east"}


def facing(beat: Beat) -> str:
    """Where one turns its face: forward (aslant, to the side), or to what it pulls."""
    way = beat.direction.rpartition("_")[2]
    return _BACK[way] if beat.verb == "pull" else way


def _play(sheet: Sequence[Cue], beat: Beat, origin: Cell | None, target: Cell | None) -> Track:
    """A dope sheet set to a beat: cues become keys."""
    assert origin is not None
    assert target is not None
    dx, dy = STEPS.get(beat.direction, (0, 0))
    # How much of the plain one-cell move the script really made: 1, or 0 in place.
    gone = (target[0] - origin[0], target[1] - origin[1])
    slip = (gone[0] - dx, gone[1] - dy) if target != origin else (0, 0)
    keys = []
    for cue in sheet:
        done = min(max(cue.along, 0.0), 1.0)
        squeeze = (cue.press * abs(dx) - 0.5 * cue.press * abs(dy)) - cue.squash
        stretch = (cue.press * abs(dy) - 0.5 * cue.press * abs(dx)) + cue.squash
        directed = cue.pose in ("walk", "push", "try", "bump")
        keys.append(
            Key(
                time=beat.start + cue.u * (beat.end - beat.start),
                x=origin[0] + cue.along * dx + done * slip[0],
                y=origin[1] + cue.along * dy + done * slip[1],
                angle=cue.lean * dx,
                # Leaning away from us or toward us shows as height.
                scale_x=1 - squeeze,
                scale_y=1 - stretch - abs(cue.lean) * 1.2 * abs(dy),
                lift=cue.lift,
                ease=cue.ease,
                pose=f"{cue.pose}-{facing(beat)}" if directed else cue.pose,
            )
        )
    return keys


# ------------------------------------------------------------------------------------ where to look

AHEAD = 6  # beats of its own that a character has in mind


def _intent(stage: Stage, beats: Sequence[Beat], number: int, tracks: Mapping[str, Track]) -> str:
    """Where a character looks before it acts: at whom it pushes, at the end of the way that it
    begins, or, if it stays, at the other."""
    beat = beats[number]
    assert beat.origin is not None
    if beat.verb == "stay":
        others = (tracks[a.name][-1] for a in stage.characters if a.name != beat.actor)
        seen = [(key.x, key.y) for key in others if key.opacity > 0]
        return _toward(beat.origin, seen[0]) if seen else ""
    if beat.verb in ("push", "pull", "put"):
        return facing(beat)
    goal = beat.origin
    ways: list[Cell] = []
    for later in [b for b in beats[number:] if b.actor == beat.actor][:AHEAD]:
        back = STEPS.get(later.direction, (0, 0))
        turns = (-back[0], -back[1]) in ways
        if later.verb not in ("step", "push", "pull") or later.target is None or turns:
            break
        goal, ways = later.target, [*ways, back]
    return _toward(beat.origin, goal) or facing(beat)


def _toward(here: tuple[float, float], there: tuple[float, float]) -> str:
    """The direction of LOOKS that comes nearest to that of a place; '' where it is the same."""
    dx, dy = there[0] - here[0], there[1] - here[1]
    far = max(abs(dx), abs(dy))
    # Eyes go straight where a place is within 22.5 degrees of it.
    column, row = (0 if abs(d) <= 0.4142 * far else 1 if d > 0 else -1 for d in (dx, dy))
    return next((name for name, step in LOOKS.items() if step == (column, row)), "")


def _looking(track: Track, direction: str) -> Track:
    """The keys of a beat, with eyes that are turned before anything else moves."""
    if not direction:
        return track
    first = next((i for i, key in enumerate(track) if key.pose != "idle"), len(track))
    return [key._replace(pose=f"look-{direction}") for key in track[:first]] + track[first:]


def _watching(beat: Beat, here: Key) -> Track:
    """Who does not act looks at who does."""
    if here.opacity == 0 or beat.origin is None or here.time > beat.start + 0.1:
        return []
    direction = _toward((here.x, here.y), beat.origin)
    watching = here._replace(time=beat.start + 0.1, pose=f"look-{direction}")
    return [watching] if direction else []


# ----------------------------------------------------------------------------- falling from the sky

IMPACT = 0.50  # when a falling thing hits the floor, in turns from the frame's start


def _fall(beat: Beat) -> Track:
    """Unseen until the shadow gathers; down from above the picture, one bounce, at rest."""
    assert beat.target is not None
    t, (x, y) = beat.start, beat.target
    height = min(y + 1.6, 5.5)  # from above the picture, or not too fast to be seen
    gone: Track = []
    if beat.origin is not None:  # it was elsewhere: fades there first
        column, row = beat.origin
        gone = [Key(t, column, row), Key(t + 0.05, column, row, opacity=0.0, ease="hold")]
    return [
        *gone,
        Key(t + 0.04, x, y, opacity=0.0, lift=height, ease="linear"),
        Key(t + 0.14, x, y, opacity=1.0, lift=height, ease="in"),
        Key(t + IMPACT, x, y, scale_x=0.94, scale_y=1.08, ease="out"),
        Key(t + 0.54, x, y, scale_x=1.20, scale_y=0.74),
        Key(t + 0.59, x, y, scale_x=0.98, scale_y=1.04, ease="out"),
        Key(t + 0.67, x, y, lift=0.22, ease="in"),
        Key(t + 0.75, x, y),
        Key(t + 0.79, x, y, scale_x=1.07, scale_y=0.92),
        Key(t + 0.88, x, y),
    ]


HELD = 0.55  # how large a thing is drawn that somebody carries
LET_GO, LAID = 0.36, 0.60  # of a turn: when a hand lets go, and when what it had is there


def _vanish(beat: Beat) -> Track:
    assert beat.origin is not None
    t, (x, y), lasting = beat.start, beat.origin, beat.end - beat.start
    if beat.holder:
        return [Key(t, x, y)]
    small = Key(t + 0.6 * lasting, x, y, scale_x=0.5, scale_y=0.5, opacity=0.0)
    return [Key(t + 0.2 * lasting, x, y), small]


def _let_go(beat: Beat, share: float) -> float:
    return beat.start + share * (beat.end - beat.start)


def _holdings(
    script: Mapping[str, Any], beats: Sequence[Beat], duration: float
) -> Iterator[tuple[str, str, float, float]]:
    """What is carried by whom, from when to when."""
    begun = {thing: (holder, 0.0) for thing, holder in held_in(script["start"]).items()}
    for beat in beats:
        if beat.verb in ("laid", "handed") and beat.actor in begun:
            yield beat.actor, *begun.pop(beat.actor), _let_go(beat, LET_GO)
        if beat.holder:
            since = _let_go(beat, LAID) if beat.verb == "handed" else beat.end
            begun[beat.actor] = beat.holder, since
    for thing, (holder, since) in begun.items():
        yield thing, holder, since, duration


def _carried(holder: Track, begin: float, end: float) -> Track:
    """A thing in the hand of who has it."""
    keys = [sample(holder, begin), *(key for key in holder if begin < key.time < end)]
    keys.append(sample(holder, end))
    return [
        Key(k.time, k.x + 0.3, k.y + 0.04, 0, HELD, HELD, lift=k.lift, ease=k.ease) for k in keys
    ]


def _startle(beat: Beat, at: Key) -> Track:
    """Those who watch look up, and hop at the impact."""
    t, here = beat.start, at._replace(ease="in-out", pose="surprised")
    return [
        here._replace(time=t + 0.16, pose="idle"),
        here._replace(time=t + 0.20),
        here._replace(time=t + IMPACT, ease="out"),
        here._replace(time=t + IMPACT + 0.08, lift=0.10, scale_x=0.95, scale_y=1.06, ease="in"),
        here._replace(time=t + IMPACT + 0.16, scale_x=1.06, scale_y=0.94),
        here._replace(time=t + IMPACT + 0.26),
        here._replace(time=t + 0.92, pose="idle"),
    ]


# -------------------------------------------------------------------------------------------- marks


def _mark(kind: str, times: Sequence[float], *keys: Key) -> Mark:
    """A mark through the given keys, fading in before the first and out after the last.

    `times` are those of fade-in start, each key, and fade-out end.
    """
    first = keys[0]._replace(time=times[0], opacity=0.0)
    last = keys[-1]._replace(time=times[-1], opacity=0.0)
    timed = [key._replace(time=time) for key, time in zip(keys, times[1:-1], strict=True)]
    return Mark(kind, [first, *timed, last])


def _exclaim(beat: Beat, at: Key) -> Mark:
    """An exclamation mark above a watcher's head."""
    up = Key(0, at.x + 0.34, at.y - 0.40, scale_x=0.5, scale_y=0.5, ease="out")
    big = up._replace(y=at.y - 0.52, scale_x=0.62, scale_y=0.62)
    t = beat.start
    return _mark("bang", (t + 0.20, t + 0.26, t + 0.70, t + 0.80), up, big)


def _landing(beat: Beat) -> list[Mark]:
    """Dust to both sides of where a thing falls."""
    assert beat.target is not None
    t, (x, y) = beat.start + IMPACT, beat.target
    marks = []
    for side in (-1, 1):
        near = Key(0, x + 0.28 * side, y + 0.34, scale_x=0.4, scale_y=0.4, ease="out")
        far = near._replace(x=x + 0.62 * side, y=y + 0.28, scale_x=0.75, scale_y=0.75)
        marks.append(_mark("dust", (t - 0.01, t + 0.02, t + 0.18, t + 0.32), near, far))
    return marks


def _effects(beat: Beat) -> list[Mark]:
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
