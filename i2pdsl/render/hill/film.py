"""Films of one performance, or of several side by side in the same time."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from i2pdsl.render.hill.figures import CRATES
from i2pdsl.render.hill.painter import Painter
from i2pdsl.render.hill.performance import Performance
from i2pdsl.render.hill.race import Race
from i2pdsl.render.hill.scene import view_of
from i2pdsl.render.performances import meters, side_by_side, spread, windows_of
from i2pdsl.render.strip import Strip
from i2pdsl.render.video import Times

NUMBERS_SECONDS = 0.5  # how often numbers change, to be read


def film_frames(
    performances: Sequence[Performance],
    times: Times,
    width: int,
    title: str,
    meter: bool = True,
) -> Iterator[np.ndarray]:
    """The film's pictures at the given times (in frames), uint8 [height, width, 3], sizes even.

    Performances stand side by side at one scale, up to three in a row; those that end early rest.
    The array is reused: copy what must outlive the next step.
    """
    several = len(performances) > 1
    width = width // 2 * 2
    _, each = spread(len(performances), width)
    view = view_of(performances)
    painters = [
        Painter(p, view, each, CRATES[k % len(CRATES)], p.title if several else "")
        for k, p in enumerate(performances)
    ]
    lasting = max(performances, key=lambda p: p.frames)
    hold = max(1, round(NUMBERS_SECONDS / lasting.frame_seconds))
    curves, shaded = meters(performances), windows_of(performances)
    strip = Strip(lasting.frames, width, title, curves, _clock(lasting), shaded, hold)
    below: list[Race | Strip] = [Race(performances, width, hold)] if several else []
    yield from side_by_side(painters, [*below, strip] if meter else [], width, times)


def _clock(performance: Performance) -> Callable[[int], str]:
    seconds = performance.frame_seconds
    whole = performance.frames * seconds
    return lambda frame: f"{frame * seconds:.0f} s of {whole:.0f} s"
