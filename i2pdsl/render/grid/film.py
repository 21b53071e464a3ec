"""A choreographed script as a GIF, MP4 or WebM film, with what viewers believe drawn live below it.

Rasterising a whole scene takes longer than playing it, so the background is drawn once, and of
each frame only the rectangle in which something changed. All formats are written by the ffmpeg
binary that imageio-ffmpeg brings along, fed with raw frames.
"""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from i2pdsl.render.files import FilmLook
from i2pdsl.render.grid.scene import (
    LARGEST_SCENE,
    MARGIN,
    cast_svg,
    labels_svg,
    life,
    margin,
    scene_size,
    stage_background,
    stage_symbols,
    svg_document,
)
from i2pdsl.render.grid.stage import Stage
from i2pdsl.render.grid.tracks import Film, Key, sample
from i2pdsl.render.raster import composite, svg_rgba
from i2pdsl.render.strip import Meter, Strip
from i2pdsl.render.video import PathLike, Progress, Times, paced_times, write_film

USUAL_LOOK = FilmLook()
LONGEST_SIDE = 2500.0  # pixels of a large map, along a side
# Pictures a second, and how wide.
USUAL = {".mp4": (24, 800), ".webm": (24, 800), ".gif": (25, 640)}
SECONDS, LONGEST = 0.9, 180.0  # of a turn; of a film, whose turns are shorter where it has many
# How long a turn lasts in which this is the most that happens, in usual turns.
WEIGHTS = {"stay": 0.4, "step": 1.0, "bump": 1.05, "fail": 1.15, "vanish": 1.2, "push": 1.35,
           "pull": 1.35, "put": 1.2, "laid": 1.2, "handed": 1.2, "fall": 1.5}  # fmt: skip
REST = 0.8  # of a usual turn: how long a twist is looked at


def frame_times(
    film: Film,
    fps: float,
    seconds_per_turn: float | None = None,
    twists: Mapping[int, float] | None = None,
    pace: float = 1.0,
) -> np.ndarray:
    """The time in turns that each film frame shows, first and last moment held a while.

    The arguments are those of `lengths`; `fps` counts pictures a second.
    """
    return paced_times(*lengths(film, seconds_per_turn, twists, pace), fps)


def lengths(
    film: Film,
    seconds_per_turn: float | None = None,
    twists: Mapping[int, float] | None = None,
    pace: float = 1.0,
) -> tuple[np.ndarray, np.ndarray]:
    """How long each turn lasts, [T], and how long its end is held, [T], in seconds.

    Args:
        seconds_per_turn: how long a turn lasts in which somebody goes somewhere.
        twists: turns after which the film rests a beat, and how much they matter, up to 1.
        pace: how many times faster than that.
    """
    turns = round(film.duration)
    lasting, rests = np.full(turns, WEIGHTS["stay"]), np.zeros(turns)
    for beat in film.beats:
        at = beat.frame - 1
        lasting[at] = max(lasting[at], WEIGHTS[beat.verb])
    for frame, weight in (twists or {}).items():
        if 0 < frame < turns:  # the end is held anyway
            rests[frame - 1] = REST * min(weight, 1.0)
    whole = max(float((lasting + rests).sum()), 1e-9)
    seconds = min(SECONDS, LONGEST / whole) if seconds_per_turn is None else seconds_per_turn
    return seconds / pace * lasting, seconds / pace * rests


def film_frames(
    stage: Stage,
    film: Film,
    times: Times,
    cell: int | None = None,
    title: str = "",
    meters: Sequence[Meter] = (),
    look: FilmLook = USUAL_LOOK,
) -> Iterator[np.ndarray]:
    """The film's pictures at the given times, uint8 [height, width, 3 or 4], both sizes even.

    `cell` is in pixels (None: chosen so that the picture is at most about 640 wide, or has the
    size of `look`). The array is reused: copy what must outlive the next step.
    """
    clock = lambda turn: "start" if turn == 0 else f"turn {turn} of {film.duration:g}"
    strip: Strip | None = None
    if look.size is None:
        cell = cell or default_cell(stage, 640)
    if look.meter and not look.transparent:
        wide = look.size[0] if look.size else max(scene_size(stage, cell or 1)[0], 360.0)
        strip = Strip(film.duration, wide, title, meters, clock)
    below = strip.height if strip else 0
    if look.size is not None:
        cell = fitting_cell(stage, look.size[0], look.size[1] - below)
    scene = _Scene(stage, film, cell or 1, look.transparent)
    high, across = scene.picture.shape[:2]
    width, height = look.size or (
        -(-max(across, strip.width if strip else 0) // 2) * 2,
        -(-(high + below) // 2) * 2,
    )
    canvas = np.full((height, width, scene.picture.shape[2]), 255, dtype=np.uint8)
    top, left = max(0, (height - below - high) // 2), (width - across) // 2
    canvas[: height - below] = scene.picture[0, 0]  # what lies outside the room
    for time in times:
        scene.paint(float(time))
        canvas[top : top + high, left : left + across] = scene.picture
        if strip:
            strip.paint(float(time))
            canvas[height - below :, : strip.width] = strip.picture
        yield canvas


def fitting_cell(stage: Stage, width: int, height: int) -> int:
    """Pixels for a cell so that a picture is no larger than this, where that can be."""
    cell = max(1, min(width // stage.width, height // stage.height))
    while cell > 1 and any(np.array(scene_size(stage, cell)) > (width, height)):
        cell -= 1
    return cell


def default_cell(stage: Stage, width: int) -> int:
    """Pixels for a cell so that a picture is about `width` wide and not much higher than that."""
    across, down = stage.width + 2 * MARGIN, stage.height + 2 * MARGIN
    wanted = max(12, min(round(width / across), round(width / down), width // 8))
    most = min(LONGEST_SIDE / max(across, down), (LARGEST_SCENE / (across * down)) ** 0.5)
    return max(1, min(wanted, int(most)))


# -------------------------------------------------------------------------------- what is painted


class _Scene:
    """The picture of a stage, repainted only where somebody moved."""

    def __init__(self, stage: Stage, film: Film, cell: int, transparent: bool = False) -> None:
        self.stage, self.film, self.cell = stage, film, cell
        self.transparent = transparent
        poses = {name: tuple({key.pose for key in track}) for name, track in film.tracks.items()}
        self.symbols, self.labels = stage_symbols(stage, poses), labels_svg(stage, cell)
        document = svg_document(stage, cell, stage_background(stage, cell) + self.labels)
        self.background = np.ascontiguousarray(svg_rgba(document)[..., :3])
        if transparent:
            self.labels, self.background = "", np.zeros((*self.background.shape[:2], 4), np.uint8)
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
            f"<defs>{self.symbols}</defs>{cast}{self.labels}</svg>"
        )
        below = self.background[y0:y1, x0:x1]
        self.picture[y0:y1, x0:x1] = drawn if self.transparent else composite(below, drawn)

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
    look: FilmLook = USUAL_LOOK,
    twists: Mapping[int, float] | None = None,
    progress: Progress | None = None,
) -> None:
    """Writes the film as a GIF, MP4 or WebM by the suffix; the file appears when complete.

    `cell` is pixels for a cell (None: about 640 pixels wide in all, of an MP4 800). `meters` are
    curves over the frames 0..T, shown as far as the film has come. `progress(done, total)` counts
    pictures.
    """
    usual_fps, width = USUAL[Path(path).suffix]
    fps, cell = fps or usual_fps, cell or default_cell(stage, width)
    times = frame_times(film, fps, seconds_per_turn, twists, look.pace)
    frames = lambda at: film_frames(stage, film, at, cell, title, meters, look)
    write_film(path, frames, times, fps, progress)
