"""From a finished script to keyframes: within a turn the characters act one after the other."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from i2pdsl.render.grid.marks import IMPACT, effects, exclaim, landing
from i2pdsl.render.grid.sheets import PULLED, PUSHED, SHEETS, Cue
from i2pdsl.render.grid.stage import (
    LOOKS,
    STEPS,
    Beat,
    Cell,
    Stage,
    break_down,
    held_in,
    on_map,
)
from i2pdsl.render.grid.tracks import Film, Key, Mark, Track, sample


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
            marks += landing(beat)
            for actor in stage.characters:
                if actor.name != beat.actor:
                    tracks[actor.name] += _startle(beat, tracks[actor.name][-1])
                    marks.append(exclaim(beat, tracks[actor.name][-1]))
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
            marks += effects(beat)
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
