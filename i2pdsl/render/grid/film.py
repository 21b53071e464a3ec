"""A choreographed script as a GIF or MP4 film, with what viewers believe drawn live below it.

Rasterising a whole scene takes longer than playing it, so the background is drawn once, and of
each frame only the rectangle in which something changed. Both formats are written by the ffmpeg
binary that imageio-ffmpeg brings along, fed with raw frames.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from i2pdsl.render.grid.choreography import Film, Key, sample
from i2pdsl.render.grid.scene import (
    MARGIN,
    cast_svg,
    life,
    margin,
    scene_size,
    stage_background,
    stage_symbols,
    svg_document,
)
from i2pdsl.render.grid.stage import Stage
from i2pdsl.render.raster import composite, svg_rgba
from i2pdsl.render.strip import Meter, Strip
from i2pdsl.render.video import PathLike, Progress, Times, shown_times, write_film

LONGEST_SIDE, LARGEST = 2500.0, 2.2e6  # pixels of a large map, along a side and in all
USUAL = {".mp4": (24, 800), ".gif": (25, 640)}  # pictures a second, and how wide
SECONDS, LONGEST = 0.9, 180.0  # of a turn; of a film, whose turns are shorter where it has many


def frame_times(film: Film, fps: float, seconds_per_turn: float | None = None) -> np.ndarray:
    """The time in turns that each film frame shows, first and last moment held a while."""
    usual = min(SECONDS, LONGEST / max(film.duration, 1.0))
    return shown_times(film.duration, fps, seconds_per_turn or usual)


def film_frames(
    stage: Stage,
    film: Film,
    times: Times,
    cell: int | None = None,
    title: str = "",
    meters: Sequence[Meter] = (),
) -> Iterator[np.ndarray]:
    """The film's pictures at the given times, uint8 [height, width, 3], both sizes even.

    `cell` is in pixels (None: chosen so that the picture is at most about 640 wide). The array is
    reused: copy what must outlive the next step.
    """
    cell = cell or default_cell(stage, 640)
    clock = lambda turn: "start" if turn == 0 else f"turn {turn} of {film.duration:g}"
    strip = Strip(film.duration, max(scene_size(stage, cell)[0], 360.0), title, meters, clock)
    scene = _Scene(stage, film, cell)
    width = -(-max(scene.picture.shape[1], strip.width) // 2) * 2
    height = -(-(scene.picture.shape[0] + strip.height) // 2) * 2
    canvas = np.full((height, width, 3), 255, dtype=np.uint8)
    canvas[: scene.picture.shape[0]] = scene.picture[0, 0]  # what lies outside the room
    left = (width - scene.picture.shape[1]) // 2
    for time in times:
        scene.paint(float(time))
        strip.paint(float(time))
        canvas[: scene.picture.shape[0], left : left + scene.picture.shape[1]] = scene.picture
        top = scene.picture.shape[0]
        canvas[top : top + strip.height, : strip.width] = strip.picture
        yield canvas


def default_cell(stage: Stage, width: int) -> int:
    """Pixels for a cell so that a picture is about `width` wide and not much higher than that."""
    across, down = stage.width + 2 * MARGIN, stage.height + 2 * MARGIN
    wanted = max(12, min(round(width / across), round(width / down), width // 8))
    most = min(LONGEST_SIDE / max(across, down), (LARGEST / (across * down)) ** 0.5)
    return max(1, min(wanted, int(most)))


# -------------------------------------------------------------------------------- what is painted


class _Scene:
    """The picture of a stage, repainted only where somebody moved."""

    def __init__(self, stage: Stage, film: Film, cell: int) -> None:
        self.stage, self.film, self.cell = stage, film, cell
        self.symbols = stage_symbols(stage)
        document = svg_document(stage, cell, stage_background(stage, cell))
        self.background = np.ascontiguousarray(svg_rgba(document)[..., :3])
        self.picture = self.background.copy()
        self.seen: dict[str, Key] = {}

    def paint(self, time: float) -> None:
        before, self.seen = self.seen, self._look(time)
        names = before.keys() | self.seen.keys()
        changed = [name for name in names if before.get(name) != self.seen.get(name)]
        keys = [k for name in changed for k in (before.get(name), self.seen.get(name)) if k]
        if not keys:
            return
        x0, y0, x1, y1 = self._box(keys)
        if x0 >= x1 or y0 >= y1:
            return
        origin = margin(self.cell)  # of the drawing, in the picture
        cast = cast_svg(self.stage, self.film, time, self.cell)
        drawn = svg_rgba(
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{x1 - x0}" height="{y1 - y0}" '
            f'viewBox="{x0 - origin:g} {y0 - origin:g} {x1 - x0} {y1 - y0}">'
            f"<defs>{self.symbols}</defs>{cast}</svg>"
        )
        self.picture[y0:y1, x0:x1] = composite(self.background[y0:y1, x0:x1], drawn)

    def _look(self, time: float) -> dict[str, Key]:
        """Everything that can be seen at a time, as keys without their time."""
        tracks = list(self.film.tracks.items())
        marks = enumerate(self.film.marks)
        tracks += [(f"{i} {m.kind}", m.track) for i, m in marks if m.track[-1].time > time]
        keys = ((name, sample(track, time)._replace(time=0, ease="")) for name, track in tracks)
        return {name: key for name, key in keys if key.opacity > 0}

    def _box(self, keys: Sequence[Key]) -> tuple[int, int, int, int]:
        """The rectangle (left, top, right, bottom; pixels) that drawings at the keys may touch."""
        reach = life(self.cell)
        left = min(key.x for key in keys) + 0.5 - reach
        top = min(key.y - key.lift for key in keys) + 0.5 - 1.1 * reach
        right = max(key.x for key in keys) + 0.5 + reach
        bottom = max(key.y for key in keys) + 0.5 + reach
        height, width = self.picture.shape[:2]
        edges = (left, top, right, bottom)
        x0, y0, x1, y1 = (edge * self.cell + margin(self.cell) for edge in edges)
        return max(int(x0), 0), max(int(y0), 0), min(int(x1), width), min(int(y1), height)


# -------------------------------------------------------------------------------- files


def save_film(
    path: PathLike,
    stage: Stage,
    film: Film,
    *,
    fps: float | None = None,
    seconds_per_turn: float | None = None,
    cell: int | None = None,
    title: str = "",
    meters: Sequence[Meter] = (),
    progress: Progress | None = None,
) -> None:
    """Writes the film as a GIF or MP4 by the suffix; the file appears when complete.

    `cell` is pixels for a cell (None: about 640 pixels wide in all, of an MP4 800). `meters` are
    curves over the frames 0..T, shown as far as the film has come. `progress(done, total)` counts
    pictures.
    """
    usual_fps, width = USUAL[Path(path).suffix]
    fps, cell = fps or usual_fps, cell or default_cell(stage, width)
    times = frame_times(film, fps, seconds_per_turn)
    write_film(
        path, lambda at: film_frames(stage, film, at, cell, title, meters), times, fps, progress
    )
