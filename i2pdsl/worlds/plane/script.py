"""Scripts of planes: for every frame what each character tries, and where it is afterwards."""

from __future__ import annotations

import math
from typing import Any, NoReturn

import numpy as np

from i2pdsl.errors import did_you_mean, error, shorten, whole_file
from i2pdsl.worlds.plane.dynamics import velocities
from i2pdsl.worlds.plane.features import NEAR
from i2pdsl.worlds.plane.geometry import clearance
from i2pdsl.worlds.plane.world import PlaneWorld
from i2pdsl.worlds.positions import Inferred, Positions
from i2pdsl.worlds.record import Record, Trajectory

TOLERANCE = 1e-3  # units: single precision and a rounded decimal are far below
PUSHES = 30  # rounds in which velocities are looked for that lead where positions say
APART = 1.0  # units: two scripts look alike if everyone stands closer than this, on average


def state_as_json(world: PlaneWorld, state: Any) -> dict[str, Any]:
    """Where everybody is, [x, y] each."""
    return _by_name(world, np.asarray(state))


def frames_as_json(world: PlaneWorld, path: Trajectory) -> tuple[dict[str, Any], ...]:
    """The frames of a script file: {"mover": {"velocity": [vx, vy]}, "state": {...}}."""
    return tuple(
        {
            **{name: {"velocity": v} for name, v in _by_name(world, action).items()},
            "state": state_as_json(world, after),
        }
        for action, after in zip(path.actions, path.states[1:], strict=True)
    )


def _by_name(world: PlaneWorld, numbers: np.ndarray) -> dict[str, list[float]]:
    """Two numbers for each character, the shortest decimals of single precision."""
    short = [float(str(x)) for x in numbers.astype(np.float32)]
    return {c.name: short[2 * i : 2 * i + 2] for i, c in enumerate(world.spec.characters)}


def read_plane(world: PlaneWorld, record: Record) -> Trajectory:
    """The script in the world's numbers, validated frame by frame. Raises StoryError."""
    names = [c.name for c in world.spec.characters]

    def wrong(where: str, message: str, hint: str | None = None) -> NoReturn:
        raise error("script", f"{where}: {message}", whole_file(record.where), hint)

    def pair(value: Any, what: str, where: str) -> list[float]:
        right = isinstance(value, list | tuple) and len(value) == 2
        if not right or not all(type(x) in (int, float) and math.isfinite(x) for x in value):
            wrong(where, f"{what} is written [x, y]")
        return [float(x) for x in value]

    def state(value: Any, where: str) -> list[float]:
        if not isinstance(value, dict):
            wrong(where, "a state gives the place of everyone")
        for name in value:
            if name not in names:
                hint = did_you_mean(name, names)
                wrong(where, f"there is no `{shorten(name)}` in {world.name}", hint)
        return [x for name in names for x in pair(value.get(name), f"the place of `{name}`", where)]

    def action(frame: dict[str, Any], where: str) -> list[float]:
        found = []
        for name in frame:
            if name not in (*names, "state", "event"):
                wrong(where, f"there is no `{shorten(name)}`", did_you_mean(name, names))
        if frame.get("event") is not None:
            wrong(where, "there are no events in a plane")
        for name in names:
            acts = frame.get(name)
            if not isinstance(acts, dict) or "velocity" not in acts:
                wrong(where, f"what does `{name}` do?", f'"{name}": {{"velocity": [0.1, 0]}}')
            found += pair(acts["velocity"], f"the velocity of `{name}`", where)
        return found

    places = [state(record.start, "start")]
    actions = []
    for number, frame in enumerate(record.frames, 1):
        actions.append(action(frame, f"frame {number}"))
        places.append(state(frame.get("state"), f"frame {number}"))
    where = np.array(places)
    moved = np.diff(where, axis=0, prepend=where[:1])
    path = Trajectory(np.array(actions), np.concatenate([where, moved], axis=1))
    check_start(world, where[0], lambda message: wrong("start", message))
    follows = world.transition(world.tables, path.states[:-1], path.actions)
    missed = np.abs(follows - path.states[1:])[:, : where.shape[1]].max(-1)
    bad = np.flatnonzero(~(missed <= TOLERANCE))
    if len(bad):
        off = f"{missed[bad[0]]:.3g}"
        wrong(f"frame {bad[0] + 1}", f"by the world's rules someone is elsewhere (by {off} units)")
    return path


def inferred(world: PlaneWorld, table: Positions) -> Inferred:
    """The velocities that lead from picture to picture.

    Everybody is taken to have gone by itself, as far as its greatest speed allows; what is left
    must come from walls and from the other's pushes. Raises StoryError.
    """
    names = [c.name for c in world.spec.characters]
    where = np.empty((table.length + 1, 2 * len(names)))
    for frame, rows in enumerate(table.seen):
        for i, name in enumerate(names):
            row = rows.get(name)
            if row is None or row.x is None or row.y is None:
                table.wrong(frame, f"where is `{name}`?", name)
            where[frame, 2 * i : 2 * i + 2] = row.x, row.y
    check_start(world, where[0], lambda message: table.wrong(0, message))
    moved = np.diff(where, axis=0, prepend=where[:1])
    states = np.concatenate([where, moved], axis=1)
    tried = moved[1:]
    missed = np.zeros_like(tried)
    for _ in range(PUSHES):  # what did not lead far enough is tried harder
        tried = tried + missed
        after = world.transition(world.tables, states[:-1], tried)
        missed = where[1:] - after[:, : where.shape[1]]
        tried = np.concatenate(velocities(world.tables, world.cast, tried), axis=-1)
    apart = np.hypot(missed[:, ::2], missed[:, 1::2])  # [T, n]
    bad = np.argwhere(~(apart <= TOLERANCE))
    if len(bad):
        frame, who = bad[0]
        character = world.spec.characters[who]
        message = f"`{character.name}` cannot be there (by {apart[frame, who]:.3g} units)"
        hint = f"it goes at most {character.fastest:g} units a frame"
        table.wrong(int(frame) + 1, message, character.name, hint)
    path = Trajectory(tried, states)
    return Inferred(state_as_json(world, states[0]), frames_as_json(world, path))


def kept(world: PlaneWorld, path: Trajectory, first: int, last: int) -> list[str]:
    """Statements that pin where everybody is in frames `first`..`last`: as few frames as there are
    between which nobody is further from the straight way than a pin lets it be."""
    said: dict[int, list[str]] = {}
    for i, c in enumerate(world.spec.characters):
        ways = np.asarray(path.states)[first : last + 1, 2 * i : 2 * i + 2]
        for number in _bends(ways, NEAR * c.radius):
            x, y = np.round(ways[number], 3) + 0.0
            said.setdefault(first + number, []).append(f"at({c.name}, ({x:g}, {y:g}))")
    return [f"pin script[{frame}]: {' and '.join(said[frame])}" for frame in sorted(said)]


def _bends(ways: np.ndarray, near: float) -> list[int]:
    """The rows of a course [n, 2] that tell it: at even pace from one to the next, none of the
    others is further away than `near` (Douglas and Peucker 1973, DOI 10.3138/FM57-6770-U75U-7727,
    in time)."""
    last = len(ways) - 1
    share = np.linspace(0, 1, last + 1)[:, None]
    away = np.hypot(*(ways - (ways[0] + share * (ways[-1] - ways[0]))).T)
    worst = int(away.argmax())
    if away[worst] <= near:
        return [0, last] if last else [0]
    return _bends(ways[: worst + 1], near)[:-1] + [worst + n for n in _bends(ways[worst:], near)]


def check_start(world: PlaneWorld, places: np.ndarray, wrong: Any) -> None:
    """Reports a first picture that cannot be: somebody outside, in a wall or in another."""
    tables = world.tables
    for i, c in enumerate(world.spec.characters):
        at = places[2 * i : 2 * i + 2]
        low, high = c.radius - TOLERANCE, tables.size - c.radius + TOLERANCE
        if (at < low).any() or (at > high).any():
            wrong(f"`{c.name}` is outside the plane")
        if clearance(tables.walls, at) < c.radius - TOLERANCE:
            wrong(f"`{c.name}` stands in a wall")
    if len(places) == 4 and np.hypot(*(places[:2] - places[2:])) < tables.radius.sum() - TOLERANCE:
        wrong("the two overlap")


def distance(world: PlaneWorld, first: np.ndarray, second: np.ndarray) -> float:
    """How differently two scripts look, in units of what people see: the largest, over the
    characters, of the mean distance over time between where it is in the one and in the other.
    Who goes the same way a little later does not look different."""
    count = world.cast.count
    apart = (first - second)[:, : 2 * count].reshape(len(first), count, 2)
    return float(np.hypot(apart[..., 0], apart[..., 1]).mean(0).max() / APART)
