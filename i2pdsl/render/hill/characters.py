"""A state of the hill in characters: the figures as lines of dots."""

from __future__ import annotations

import numpy as np

from i2pdsl.render.characters import Canvas, Ink
from i2pdsl.worlds.hill.hopper import BONES, CRATE, HOPPER, MUSCLES, NODE_COUNT, ROPE
from i2pdsl.worlds.hill.world import HillWorld


def hill_in_characters(world: HillWorld, state: np.ndarray, ink: Ink) -> str:
    """The hopper, the rope and the box on the slope, as lines of dots."""
    x, y = state[: 2 * NODE_COUNT].reshape(2, NODE_COUNT)
    canvas = Canvas(min(72, ink.columns - 6), 14, ink)
    across, down = canvas.size
    left, right = float(x.min()) - 2, float(x.max()) + 2
    slope = np.tan(world.spec.settings.slope)
    low = min(float(y.min()), left * slope) - 0.5
    # A character is about twice as high as it is wide.
    shape = 1.0 if canvas.fine else 2.0
    scale = min((across - 1) / (right - left), (down - 1) * shape / (float(y.max()) - low + 0.5))

    def place(px: float, py: float) -> tuple[float, float]:
        return (px - left) * scale, down - 1 - (py - low) * scale / shape

    end = left + (across - 1) / scale
    canvas.line(*place(left, left * slope), *place(end, end * slope), 5)
    for number, springs in ((3, ROPE), (0, CRATE), (1, BONES), (1, MUSCLES)):
        for first, second in springs:
            ends = (x[first], y[first]), (x[second], y[second])
            canvas.line(*place(*ends[0]), *place(*ends[1]), number)
    told = f"hopper at x = {x[list(HOPPER)].mean():.1f}, box at x = {x[11:].mean():.1f}"
    return "\n".join((*("    " + line for line in canvas.lines()), f"    {told}"))
