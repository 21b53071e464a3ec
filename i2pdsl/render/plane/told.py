"""A script of the plane as a performance: what the pictures show of what viewers believe."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from i2pdsl.errors import Source
from i2pdsl.language.scope import Module
from i2pdsl.render.beliefs import Beliefs
from i2pdsl.render.files import printable
from i2pdsl.render.focus import focus_of, led, whose
from i2pdsl.render.mind import Window
from i2pdsl.render.plane.performance import Performance
from i2pdsl.scripts import Script
from i2pdsl.worlds.plane.dynamics import velocities
from i2pdsl.worlds.plane.spec import APPROACH, AVOID, NO_GOAL, PlaneSpec

WANTS = {APPROACH: "approaches {other}", AVOID: "avoids {other}", NO_GOAL: "wants nothing"}


def beliefs_of(spec: PlaneSpec) -> Beliefs:
    """Words and curves of what viewers believe of its cast."""
    return Beliefs(spec, WANTS)


def performance_of(script: Script, title: str | None = None) -> Performance:
    """What a script of the plane looks like, with the curves that belong to it."""
    # The story's own names must not get into the questions that are asked here.
    script = replace(script.shown(), module=Module(Source("pictures", "")))
    world: Any = script.world
    spec: PlaneSpec = world.spec
    count = len(spec.characters)
    states = np.asarray(script.trajectory.states, float)
    beliefs = beliefs_of(spec)
    usual = beliefs.panels(script)
    focus = focus_of(script, usual, beliefs.sentence)
    return Performance(
        title=printable(title or script.record.title or world.name),
        spec=spec,
        positions=states[:, : 2 * count].reshape(-1, count, 2),
        panels=led(focus.leading, usual),
        windows=tuple(Window(*window) for window in script.windows),
        captions=[focus.caption(t) for t in range(len(states))],
        leading=whose(focus.leading, usual),
        turns=focus.turns,
        source=script.record.text,
        tries=np.stack(velocities(world.tables, world.cast, script.trajectory.actions), axis=1),
    )
