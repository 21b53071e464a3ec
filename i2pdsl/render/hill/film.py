"""Films of one performance, or of several side by side in the same time."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from i2pdsl.render.hill.figures import CRATES
from i2pdsl.render.hill.painter import Painter
from i2pdsl.render.hill.performance import HUES, Performance
from i2pdsl.render.hill.race import Race
from i2pdsl.render.hill.scene import view_of
from i2pdsl.render.strip import Meter, Strip
from i2pdsl.render.video import (
    PALETTE_SAMPLES,
    PathLike,
    Progress,
    shown_times,
    write_gif,
    write_mp4,
)

NUMBERS_SECONDS = 0.5  # how often numbers change, to be read
GAP = 6  # pixels between performances side by side


def film_frames(
    performances: Sequence[Performance],
    times: Sequence[float] | np.ndarray,
    width: int,
    title: str,
) -> Iterator[np.ndarray]:
    """The film's pictures at the given times (in frames), uint8 [height, width, 3], sizes even.

    Performances stand side by side at one scale, up to three in a row; those that end early rest.
    The array is reused: copy what must outlive the next step.
    """
    several = len(performances) > 1
    columns = columns_for(len(performances))
    width = width // 2 * 2
    each = (width - GAP * (columns - 1)) // columns
    view = view_of(performances)
    painters = [
        Painter(p, view, each, CRATES[k % len(CRATES)], p.title if several else "")
        for k, p in enumerate(performances)
    ]
    lasting = max(performances, key=lambda p: p.frames)
    hold = max(1, round(NUMBERS_SECONDS / lasting.frame_seconds))
    windows = tuple(dict.fromkeys(w for p in performances for w in p.windows))
    strip = Strip(
        lasting.frames, width, title, meters(performances), _clock(lasting), windows, hold
    )
    rows = -(-len(painters) // columns)
    stage = rows * painters[0].height + GAP * (rows - 1)
    below: list[Race | Strip] = [Race(performances, width, hold)] if several else []
    below.append(strip)
    height = -(-(stage + sum(part.height for part in below)) // 2) * 2
    canvas = np.full((height, width, 3), 255, dtype=np.uint8)
    for time in times:
        for number, painter in enumerate(painters):
            painter.paint(float(time))
            row, column = divmod(number, columns)
            x, y = column * (each + GAP), row * (painter.height + GAP)
            canvas[y : y + painter.height, x : x + each] = painter.picture
        top = stage
        for part in below:
            part.paint(float(time))
            canvas[top : top + part.height, : part.width] = part.picture
            top += part.height
        yield canvas


def columns_for(count: int) -> int:
    """How many performances stand side by side."""
    return count if count <= 3 else 2 if count == 4 else 3


def meters(performances: Sequence[Performance]) -> list[Meter]:
    """The curves below a film: the first panel of one performance, or, of several, the first
    series of each one's first panel, held after its end."""
    if len(performances) == 1:
        panels = performances[0].panels[:1]
        return [(s.label, s.color, s.values) for panel in panels for s in panel.series]
    last = max(p.frames for p in performances)
    found: list[Meter] = []
    for number, p in enumerate(performances):
        if p.panels:
            first = p.panels[0].series[0]
            values = np.pad(first.values, (0, last - p.frames), mode="edge")
            label = f"{p.title}: {first.label}"
            found.append((label, HUES[number % len(HUES)], values))
    return found


def save_mp4(
    path: PathLike,
    performances: Sequence[Performance],
    title: str,
    *,
    width: int | None = None,
    progress: Progress | None = None,
) -> None:
    """Every frame of the world, in its own time. `progress(done, total)` counts pictures."""
    seconds = performances[0].frame_seconds
    fps = 1 / seconds
    times = shown_times(max(p.frames for p in performances), fps, seconds)
    width = width or (800 if len(performances) == 1 else 1280)
    frames = film_frames(performances, times, width, title)
    write_mp4(path, frames, len(times), fps, progress)


def save_gif(
    path: PathLike,
    performances: Sequence[Performance],
    title: str,
    *,
    fps: float = 10,
    width: int | None = None,
    progress: Progress | None = None,
) -> None:
    """Smaller and with fewer pictures than the MP4, in the same time."""
    last, seconds = max(p.frames for p in performances), performances[0].frame_seconds
    times = shown_times(last, fps, seconds)
    width = width or (480 if len(performances) == 1 else 780)
    frames = film_frames(performances, times, width, title)
    samples = film_frames(performances, np.linspace(0, last, PALETTE_SAMPLES), width, title)
    write_gif(path, frames, samples, len(times), fps, progress)


def _clock(performance: Performance) -> Callable[[int], str]:
    seconds = performance.frame_seconds
    whole = performance.frames * seconds
    return lambda frame: f"{frame * seconds:.0f} s of {whole:.0f} s"
