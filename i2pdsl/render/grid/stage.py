"""What a picture needs to know of a grid world: its map, its cast, and what happens on it.

Plain records, so that every renderer (SVG, film, comic, HTML page) can be handed the same small
description and none of them needs the world, its planner or JAX. `break_down` reads a finished
script as a list of beats: who stepped, pushed whom, failed or bumped, one after the other.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

Cell = tuple[int, int]  # (column, row) from the map's top left, from 0
DIRECTIONS: dict[str, Cell] = {"north": (0, -1), "south": (0, 1), "east": (1, 0), "west": (-1, 0)}
LOOKS: dict[str, Cell] = DIRECTIONS | {  # where eyes go, too
    "northeast": (1, -1), "northwest": (-1, -1), "southeast": (1, 1), "southwest": (-1, 1),
}  # fmt: skip

STEPS: dict[str, Cell] = DIRECTIONS | {  # where one goes
    "north_east": (1, -1), "north_west": (-1, -1), "south_east": (1, 1), "south_west": (-1, 1),
}  # fmt: skip
TURNING = ("fall", "vanish", "laid", "handed")  # verbs of what is always told
WALL, PULL, PUT = "#", "pull_", "put_"


@dataclass(frozen=True)
class Tile:
    """A named, coloured goal tile. `color` is any CSS colour; `sprite` and `drawing` are as an
    actor's, and without them its name or a rug tells what it is; `ways` are the only directions
    in which one gets onto it and off it."""

    name: str
    cell: Cell
    color: str
    sprite: str = ""
    drawing: str = ""
    ways: tuple[str, ...] = ()


@dataclass(frozen=True)
class Actor:
    """One of the cast: a 'character' acts, an 'object' is only ever moved.

    `sprite` names a drawing (robot, cheese, table, ...); one that is not there is drawn as 'blob'.
    `drawing` is what is kept of an own one (worlds/drawings.py). `color` tints its body; '' keeps
    the drawing's own colour.
    """

    name: str
    sprite: str
    color: str = ""
    kind: str = "character"
    drawing: str = ""


@dataclass(frozen=True)
class Stage:
    """A map with its cast. `rows` are strings of equal length; '#' is wall, the rest is floor.

    The characters among `cast` stand in acting order. `floor`, `wall` and `frame` are CSS colours
    (the frame's '' is one that suits the walls); `ground` is how the floor is laid, checker,
    boards, grass or plain. `wall_sprite` and `wall_drawing` are as an actor's. `fences` are walls
    between two cells; `together` says that characters act at the same time, `pulls` that one of
    them pulls something; `alike` are the names of things that are not told apart.
    """

    name: str
    rows: tuple[str, ...]
    tiles: tuple[Tile, ...]
    cast: tuple[Actor, ...]
    floor: str = "#f3e3c7"
    wall: str = "#b08968"
    frame: str = ""
    ground: str = "checker"
    wall_sprite: str = ""
    wall_drawing: str = ""
    fences: tuple[tuple[Cell, Cell], ...] = ()
    together: bool = False
    pulls: bool = False
    alike: tuple[tuple[str, ...], ...] = ()

    @property
    def width(self) -> int:
        """Columns of the map."""
        return max((len(row) for row in self.rows), default=0)

    @property
    def height(self) -> int:
        """Rows of the map."""
        return len(self.rows)

    @property
    def characters(self) -> tuple[Actor, ...]:
        """Those of the cast who act, in acting order."""
        return tuple(actor for actor in self.cast if actor.kind == "character")

    @property
    def has_counters(self) -> bool:
        """Whether its blocks are drawn as a kitchen's, after its name as tiles are after theirs."""
        return "kitchen" in self.name.lower()

    def is_wall(self, cell: Cell) -> bool:
        """Whether the cell cannot be walked on; outside the map counts as wall."""
        column, row = cell
        inside = 0 <= row < self.height and 0 <= column < len(self.rows[row])
        return not inside or self.rows[row][column] == WALL

    def is_closed(self, here: Cell, there: Cell) -> bool:
        """Whether a wall is in the way from a cell to the next."""
        between = (here, there) in self.fences or (there, here) in self.fences
        return between or self.is_wall(there)


class Shove(NamedTuple):
    """One actor moved by another's action."""

    name: str
    origin: Cell
    target: Cell


@dataclass(frozen=True)
class Beat:
    """One thing that happens in a frame (1..T), from `start` to `end` in turns.

    `verb`: 'step', 'push', 'pull', 'put' (something down, or into another's hand), 'fail' (chance
    was against it), 'bump' (something was in the way), 'stay', 'fall' (an event), 'vanish', and of
    what somebody put: 'laid' (onto a cell), 'handed'. `origin` is None for what was absent or
    carried before. `by` is who did it, and `holder` who carries it since.
    """

    frame: int
    start: float
    end: float
    actor: str
    verb: str
    direction: str
    origin: Cell | None
    target: Cell | None
    pushed: tuple[Shove, ...] = ()
    by: str = ""
    holder: str = ""


def break_down(stage: Stage, script: Mapping[str, Any]) -> list[Beat]:
    """The beats of a script in order: mid-turn positions worked out, pushes told from steps.

    A character whose own action moved it goes one cell that way; whoever stands there is pushed
    on. What these rules do not explain (another world's physics) is bent to fit: a character's
    own step goes where the script has it, a thing is pushed there by the last to act. So every
    frame ends exactly in the script's own state.
    """
    beats: list[Beat] = []
    script = followed(stage, script)
    here, state = _cells(script["start"]), script["start"]
    for t, frame in enumerate(script["frames"], start=1):
        there = _cells(frame["state"])
        if frame.get("event"):
            beats += _event_beats(t, here, there)
        else:
            beats += _turn_beats(stage, t, here, there, frame, held_in(state))
        here, state = there, frame["state"]
    return beats


def followed(stage: Stage, script: Mapping[str, Any]) -> Mapping[str, Any]:
    """The script with each of the things that are alike under one name from first to last.

    A state names them in reading order, whichever was moved where. What stands still keeps its
    name; who else there is goes the shortest way.
    """
    if not stage.alike:
        return script
    frames, before = [], script["start"]
    for frame in script["frames"]:
        state = dict(frame["state"])
        for group in stage.alike:
            left = [tuple(state[name]) for name in group]
            were = {name: tuple(before[name]) for name in group}
            stayed = {name: cell for name, cell in were.items() if cell in left}
            left = [cell for cell in left if cell not in stayed.values()]
            for name, (x, y) in were.items():
                if name not in stayed:
                    _, nearest = min((abs(c[0] - x) + abs(c[1] - y), c) for c in left)
                    stayed[name] = nearest
                    left.remove(nearest)
            state |= {name: list(cell) for name, cell in stayed.items()}
        before = state
        frames.append({**frame, "state": state})
    return {**script, "frames": frames}


def _cells(state: Mapping[str, Any]) -> dict[str, Cell | None]:
    return {name: on_map(state, name) for name in state}


def on_map(state: Mapping[str, Any], name: str) -> Cell | None:
    """The cell of something in a state of a script file; None if it is absent, or carried."""
    at = state.get(name)
    return None if at is None or isinstance(at, str) else (int(at[0]), int(at[1]))


def held_in(state: Mapping[str, Any]) -> dict[str, str]:
    """What is carried in a state of a script file, and by whom."""
    return {name: place for name, place in state.items() if isinstance(place, str)}


def _event_beats(
    t: int, here: Mapping[str, Cell | None], there: Mapping[str, Cell | None]
) -> Iterable[Beat]:
    for name, cell in there.items():
        if cell != here.get(name):
            verb = "vanish" if cell is None else "fall"
            yield Beat(t, t - 1, t, name, verb, "", here.get(name), cell)


def _turn_beats(
    stage: Stage,
    t: int,
    here: Mapping[str, Cell | None],
    there: Mapping[str, Cell | None],
    frame: Mapping[str, Any],
    held: Mapping[str, str],
) -> list[Beat]:
    acting = [a.name for a in stage.characters if frame.get(a.name) and here.get(a.name)]
    # Of two who act together, the first may have waited for the other to make way.
    for order in (acting, acting[::-1]) if stage.together else (acting,):
        now = dict(here)
        beats = _acts(stage, t, now, order, frame, held)
        if all(now.get(name) == cell for name, cell in there.items()):
            break
    for name, cell in there.items():
        before = now.get(name)
        if cell == before:
            continue
        if cell is None or before is None:
            beats.append(Beat(t, t - 1, t, name, "vanish" if before else "fall", "", before, cell))
        else:
            _reconcile(beats, name, before, cell)
    return beats


def _acts(
    stage: Stage,
    t: int,
    now: dict[str, Cell | None],
    acting: Sequence[str],
    frame: Mapping[str, Any],
    held: Mapping[str, str],
) -> list[Beat]:
    """The beats of a turn in which some act in this order; moves `now` as they move."""
    beats: list[Beat] = []
    leaving = {thing for thing, cell in _cells(frame["state"]).items() if cell is None}
    for i, name in enumerate(acting):
        start, end = _slot(t, i, len(acting))
        action, moved = frame[name]["action"], frame[name]["moved"]
        origin = now[name]
        assert origin is not None  # `acting` holds only those who are present
        is_pull, action = action.startswith(PULL), action.removeprefix(PULL)
        if action.startswith(PUT):
            way = action.removeprefix(PUT)
            put = _put(t, (start, end), name, frame["state"], held, _beyond(origin, way), now)
            verb = "put" if put else "stay"
            beats += [Beat(t, start, end, name, verb, way if put else "", origin, origin), *put]
        elif action not in STEPS:
            beats.append(Beat(t, start, end, name, "stay", "", origin, origin))
        elif not moved:
            target = _beyond(origin, action)
            taken = is_pull or stage.is_closed(origin, target) or target in now.values()
            verb = "bump" if taken else "fail"
            beats.append(Beat(t, start, end, name, verb, action, origin, origin))
        else:
            target = _beyond(origin, action)
            gone = [thing for thing, cell in now.items() if cell == target and thing in leaving]
            for thing in gone:
                place = frame["state"][thing]
                holder = name if isinstance(place, str) else ""
                beats.append(
                    Beat(t, start, end, thing, "vanish", "", target, None, (), name, holder)
                )
                now[thing] = None
            pushed = _push(now, target, action, name)
            now[name] = target
            verb = "push" if pushed else "step"
            if is_pull:
                verb, pushed = "pull", _pull(now, origin, action, name)
            beats.append(Beat(t, start, end, name, verb, action, origin, target, pushed))
    others = {shove.name for beat in beats for shove in beat.pushed}
    if stage.together and len(beats) == 2 and not others & set(acting):
        begin, done = _slot(t, 0, 1)
        beats = [replace(beat, start=begin, end=done) for beat in beats]
    return beats


def _put(
    t: int,
    slot: tuple[float, float],
    who: str,
    after: Mapping[str, Any],
    held: Mapping[str, str],
    target: Cell,
    now: dict[str, Cell | None],
) -> list[Beat]:
    """What becomes of what somebody had and puts down, or hands over; moves `now`."""
    for thing in (thing for thing, holder in held.items() if holder == who):
        place, given = on_map(after, thing), after[thing]
        if place == target:
            now[thing] = target
            return [Beat(t, *slot, thing, "laid", "", None, target, (), who)]
        if isinstance(given, str) and given != who:
            return [Beat(t, *slot, thing, "handed", "", None, None, (), who, given)]
    return []


def _reconcile(beats: list[Beat], name: str, before: Cell, cell: Cell) -> None:
    """Makes the turn's beats lead `name` to `cell`, where the plain rules leave it at `before`."""
    own = [i for i, beat in enumerate(beats) if beat.actor == name]
    if own or not beats:
        i = own[0] if own else -1
        beats[i] = replace(beats[i], verb="step", target=cell)
        return
    last = beats[-1]
    origins = {shove.name: shove.origin for shove in last.pushed}
    rest = tuple(shove for shove in last.pushed if shove.name != name)
    shove = Shove(name, origins.get(name, before), cell)
    beats[-1] = replace(last, verb="push", pushed=(*rest, shove))


def _beyond(cell: Cell, direction: str) -> Cell:
    dx, dy = STEPS[direction]
    return cell[0] + dx, cell[1] + dy


def _push(
    now: dict[str, Cell | None], cell: Cell, direction: str, pusher: str
) -> tuple[Shove, ...]:
    """Moves whoever stands on `cell` one on, and whoever stands there, nearest first."""
    shoves: list[Shove] = []
    while True:
        standing = [name for name, at in now.items() if at == cell and name != pusher]
        standing = [name for name in standing if all(s.name != name for s in shoves)]
        if not standing:
            break
        shoves.append(Shove(standing[0], cell, _beyond(cell, direction)))
        cell = shoves[-1].target
    for shove in shoves:
        now[shove.name] = shove.target
    return tuple(shoves)


def _pull(
    now: dict[str, Cell | None], cell: Cell, direction: str, puller: str
) -> tuple[Shove, ...]:
    """Moves whoever stands behind a cell onto it."""
    dx, dy = DIRECTIONS[direction]
    behind = cell[0] - dx, cell[1] - dy
    names = [name for name, at in now.items() if at == behind and name != puller]
    for name in names:
        now[name] = cell
    return tuple(Shove(name, behind, cell) for name in names)


def _slot(t: int, i: int, n: int) -> tuple[float, float]:
    """When the i-th of n characters acts in frame t; a lone one does not dawdle all turn long."""
    if n == 1:
        return t - 1 + 0.08, t - 1 + 0.80
    return t - 1 + i / n, t - 1 + (i + 1) / n


def describe(beat: Beat) -> str:
    """A beat in words, for captions and alternative texts: 'robot pushes cheese west'."""
    match beat.verb:
        case "push":
            pushed = " and ".join(shove.name for shove in beat.pushed)
            return f"{beat.actor} pushes {pushed} {beat.direction}"
        case "pull":
            pulled = " and ".join(shove.name for shove in beat.pushed)
            return f"{beat.actor} pulls {pulled} {beat.direction}"
        case "step":
            return f"{beat.actor} goes {beat.direction.replace('_', ' ')}".rstrip()
        case "fail":
            return f"{beat.actor} tries {beat.direction.replace('_', ' ')} and fails"
        case "bump":
            return f"{beat.actor} bumps {beat.direction.replace('_', ' ')}"
        case "fall":
            return f"{beat.actor} falls from the sky"
        case "vanish" if beat.by:
            return f"{beat.by} {'takes' if beat.holder else 'opens'} {beat.actor}"
        case "laid":
            return f"{beat.by} puts {beat.actor} down"
        case "handed":
            return f"{beat.by} hands {beat.actor} to {beat.holder}"
        case "put":
            return f"{beat.actor} puts something down"
        case "vanish":
            return f"{beat.actor} is gone"
        case _:
            return f"{beat.actor} stays"
