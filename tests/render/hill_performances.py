"""Performances on the hill for tests: the simulator under muscles that swing."""

from functools import cache

import numpy as np

from i2pdsl.render.hill.performance import Performance
from i2pdsl.render.mind import PALETTE, Panel, Series, Window
from i2pdsl.worlds.hill.hopper import build_body, initial_state, masses
from i2pdsl.worlds.hill.spec import HillSpec
from i2pdsl.worlds.hill.springs import motion_of, step

SLOPE = HillSpec().settings.slope


@cache
def wobble(frames: int = 40, weight: float = 0.1) -> tuple[np.ndarray, np.ndarray]:
    """Positions [T + 1, 2, 19] and actuation [T, 6] of a hopper that sways."""
    body, mass = build_body(HillSpec()), masses(HillSpec(), weight)
    motion = motion_of(initial_state()[None])
    positions, actuation = [motion.position[..., 0]], []
    for t in range(frames):
        swing = 1.5 * np.sin(0.3 * t + np.array([0.0, 0.5, 1.0, 3.1, 3.6, 4.1]))
        motion, _ = step(body, mass, motion, swing[:, None])
        positions.append(motion.position[..., 0])
        actuation.append(swing)
    return np.stack(positions), np.reshape(actuation, (frames, 6))


def performance(
    title: str = "mime", frames: int = 40, weight: float = 0.1, windows: tuple[Window, ...] = ()
) -> Performance:
    """A performance with two panels of made-up curves."""
    positions, actuation = wobble(frames, weight)
    rising = np.linspace(0.1, 0.9, frames + 1)
    belief = (
        Series("heavy", rising, PALETTE["hindering"]),
        Series("light", 1 - rising, PALETTE["helping"]),
    )
    value = (Series("hopper", 50 + 10 * rising, PALETTE["robot"]),)
    panels = (
        Panel("weight", "probability", belief),
        Panel("expected value", "value", value, "value"),
    )
    return Performance(
        title, SLOPE, positions, actuation, weight, panels, panels[0], windows=windows,
        captions=lambda frame: f"at frame {frame} <so> & so", source=f"story {title}\n",
    )  # fmt: skip
