"""Frames of other scripts that a descent shall keep: `pin script[1..40] = "take.json"`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from i2pdsl.errors import StoryError, error
from i2pdsl.language.story import KeptFrames
from i2pdsl.scripts import Script
from i2pdsl.worlds.kind import Watch
from i2pdsl.worlds.kinds import kind_of
from i2pdsl.worlds.record import Kept, Trajectory


def kept_of(
    told: Sequence[KeptFrames], spec: Any, folder: Path | None, also: Kept | None, watch: Watch
) -> Kept | None:
    """The frames that a story's pins take from scripts beside it, and those that are kept besides.

    Where two stretches meet, the picture between them is that of the later one.

    Args:
        spec: the story's world.
        also: frames of another script, of the same world.

    Raises StoryError, at the pin, where a script cannot be read, happens in another world, or does
    not have the frames.
    """
    runs = [] if also is None else [(range(a, b + 1), also.path) for a, b in also.runs]
    known: dict[str, Script] = {}
    for each in told:
        if each.file not in known:
            known[each.file] = _script(each, spec, folder, watch)
        script = known[each.file]
        if script.length < each.frames[-1]:
            message = f"`{each.file}` has {script.length:,} frames"
            raise error("keep", message, each.span)
        runs.append((each.frames, script.trajectory))
    if not runs:
        return None
    last = max(frames[-1] for frames, _ in runs)
    _, like = runs[0]
    actions = np.zeros((last, *like.actions.shape[1:]))
    states = np.zeros((last + 1, *like.states.shape[1:]))
    for frames, path in sorted(runs, key=lambda run: run[0][0]):
        here = slice(frames[0] - 1, frames[-1])
        actions[here] = path.actions[here]
        states[frames[0] - 1 : frames[-1] + 1] = path.states[frames[0] - 1 : frames[-1] + 1]
    numbers = sorted({frame for frames, _ in runs for frame in frames})
    return Kept(tuple(numbers), Trajectory(actions, states))


def _script(each: KeptFrames, spec: Any, folder: Path | None, watch: Watch) -> Script:
    try:
        script = Script.load(each.path(folder), watch)
    except StoryError as problem:
        raise StoryError([replace(d, span=each.span) for d in problem.diagnostics[:1]]) from None
    if not kind_of(spec).has_same_rules(spec, script.world.spec):
        message = f"`{each.file}` happens in another world, {script.world.name}"
        raise error("keep", message, each.span)
    return script
