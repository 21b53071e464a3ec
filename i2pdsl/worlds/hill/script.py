"""Scripts of the hill: for every frame the residual on the muscles, and the state.

Rollouts are chaotic, so what viewers believe is computed from the stored states. One frame is
not: each state must follow from the one before it and the residual.
"""

from __future__ import annotations

from typing import Any, NoReturn

import numpy as np

from i2pdsl.errors import did_you_mean, error, shorten, whole_file
from i2pdsl.worlds.hill.hopper import MUSCLE_COUNT, NODE_COUNT
from i2pdsl.worlds.hill.world import HillWorld
from i2pdsl.worlds.record import Record, Trajectory

TOLERANCE = 0.005  # units, and units a time: single precision and a rounded decimal are far below
_LARGEST = 1e9  # of a number
_PARTS = ("positions", "velocities")


def hill_state(state: np.ndarray) -> dict[str, Any]:
    """A state as the script file has it: [x, y] of each of the 19 nodes, and their velocities."""
    moved = np.asarray(state, np.float32).reshape(2, 2, NODE_COUNT).transpose(0, 2, 1)
    return {name: _short(part) for name, part in zip(_PARTS, moved, strict=True)}


def hill_frames(path: Trajectory) -> tuple[dict[str, Any], ...]:
    """The frames of a script file."""
    return tuple(
        {"residual": _short(np.asarray(action, np.float32)), "state": hill_state(after)}
        for action, after in zip(path.actions, path.states[1:], strict=True)
    )


def _short(values: np.ndarray) -> Any:
    """Nested lists of the shortest decimals that give the same single-precision numbers."""
    if values.ndim:
        return [_short(part) for part in values]
    return float(str(values))


def _are_numbers(value: Any, shape: tuple[int, ...]) -> bool:
    """Whether plain data are finite numbers in lists of these lengths."""
    if not shape:
        return type(value) in (int, float) and abs(value) <= _LARGEST
    first, *rest = shape
    right = isinstance(value, list | tuple) and len(value) == first
    return right and all(_are_numbers(part, tuple(rest)) for part in value)


def read_hill(world: HillWorld, record: Record) -> Trajectory:
    """The script in the world's numbers, validated frame by frame. Raises StoryError."""

    def wrong(where: str, message: str, hint: str | None = None) -> NoReturn:
        raise error("script", f"{where}: {message}", whole_file(record.where), hint)

    def numbers(value: Any, shape: tuple[int, ...], what: str, where: str) -> np.ndarray:
        if not _are_numbers(value, shape):
            size = " x ".join(map(str, shape))
            wrong(where, f'"{what}" must be {size} numbers')
        return np.array(value, dtype=float)

    def state(value: Any, where: str) -> np.ndarray:
        if not isinstance(value, dict):
            wrong(where, "a state gives the positions and velocities of the 19 nodes")
        for name in value:
            if name not in _PARTS:
                hint = did_you_mean(name, _PARTS)
                wrong(where, f"a state of the hill has no `{shorten(name)}`", hint)
        parts = [numbers(value.get(name), (NODE_COUNT, 2), name, where) for name in _PARTS]
        return np.concatenate([part.T.reshape(-1) for part in parts])

    def residual(frame: dict[str, Any], where: str) -> np.ndarray:
        for name in frame:
            if name not in ("residual", "state", "event"):
                hint = did_you_mean(name, ("residual", "state"))
                wrong(where, f"a frame of the hill has no `{shorten(name)}`", hint)
        if frame.get("event") is not None:
            wrong(where, "there are no events on the hill")
        return numbers(frame.get("residual"), (MUSCLE_COUNT,), "residual", where)

    states = [state(record.start, "start")]
    actions = []
    for number, frame in enumerate(record.frames, 1):
        actions.append(residual(frame, f"frame {number}"))
        states.append(state(frame.get("state"), f"frame {number}"))
    path = Trajectory(np.array(actions), np.array(states))
    with np.errstate(all="ignore"):  # what is no number is wrong, and said below
        follows = world.transition(world.tables, path.states[:-1], path.actions)
        missed = np.abs(follows - path.states[1:]).max(-1)
        far = np.abs(path.states[:-1]).max(-1)  # single precision is coarser there
        bad = np.flatnonzero(~(missed <= TOLERANCE * (1 + far / 500)))
    if len(bad):
        off = f"{missed[bad[0]]:.3g}"
        message = f"by the world's rules its state is another (a number is off by {off})"
        settings = world.spec.settings
        hint = (
            f"was it made with the weight {settings.weight:g}, and with the same controllers "
            f"(training seed {settings.controller})?"
        )
        wrong(f"frame {bad[0] + 1}", message, hint)
    return path
