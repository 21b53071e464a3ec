"""A choreographed script as a GIF or MP4 film, with what viewers believe drawn live below it.

Rasterising a whole scene takes longer than playing it, so the background is drawn once, and of
each frame only the rectangle in which something changed. Both formats are written by the ffmpeg
binary that imageio-ffmpeg brings along, fed with raw frames.
"""

import os
import subprocess
import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape, quoteattr

import imageio_ffmpeg
import numpy as np
from PIL import Image, ImageColor

from i2pdsl.render.choreography import Film, Key, sample
from i2pdsl.render.raster import composite, svg_rgba, text_width
from i2pdsl.render.scene import (
    FONTS,
    MARGIN,
    cast_svg,
    scene_size,
    stage_background,
    stage_symbols,
    svg_document,
)
from i2pdsl.render.sprites import INK
from i2pdsl.render.stage import Stage
from i2pdsl.resources import atomic_path

Meter = tuple[str, str, Sequence[float]]  # label, CSS colour, values [T + 1]
Progress = Callable[[int, int], None]  # frames done, frames in all
PathLike = str | os.PathLike[str]

OPENING, CLOSING = 0.7, 1.5  # seconds that the first and the last moment are held


def frame_times(film: Film, fps: float, seconds_per_turn: float = 0.9) -> np.ndarray:
    """The time in turns that each film frame shows, first and last moment held a while."""
    if fps <= 0 or seconds_per_turn <= 0:
        raise ValueError("fps and seconds_per_turn must be positive")
    seconds = OPENING + film.duration * seconds_per_turn + CLOSING
    shown = np.arange(round(seconds * fps)) / fps
    return np.clip((shown - OPENING) / seconds_per_turn, 0.0, film.duration)


def film_frames(
    stage: Stage,
    film: Film,
    times: Sequence[float] | np.ndarray,
    cell: int | None = None,
    title: str = "",
    meters: Sequence[Meter] = (),
) -> Iterator[np.ndarray]:
    """The film's pictures at the given times, uint8 [height, width, 3], both sizes even.

    `cell` is in pixels (None: chosen so that the picture is at most about 640 wide). The array is
    reused: copy what must outlive the next step.
    """
    cell = cell or default_cell(stage, 640)
    strip = _Strip(film, max(scene_size(stage, cell)[0], 360.0), title, meters)
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
    return max(12, min(round(width / across), round(width / down), width // 8))


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
        origin = MARGIN * self.cell  # of the drawing, in the picture
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
        left = min(key.x for key in keys) - 0.5
        top = min(key.y - key.lift for key in keys) - 0.6
        right, bottom = max(key.x for key in keys) + 1.5, max(key.y for key in keys) + 1.5
        height, width = self.picture.shape[:2]
        x0, y0, x1, y1 = ((edge + MARGIN) * self.cell for edge in (left, top, right, bottom))
        return max(int(x0), 0), max(int(y0), 0), min(int(x1), width), min(int(y1), height)


class _Strip:
    """Below the scene: title, number of the turn, and the meters' curves as far as known."""

    def __init__(self, film: Film, width: float, title: str, meters: Sequence[Meter]) -> None:
        turns = round(film.duration)
        for label, _, values in meters:
            if len(values) != turns + 1:
                raise ValueError(f"meter {label!r} needs {turns + 1} values, not {len(values)}")
        self.duration, self.title, self.meters = film.duration, title, meters
        self.width = round(width)
        self.plot_top, self.plot_height = 30, 66 if meters else 8
        self.legend = self._legend_places()
        rows = 1 + max((row for _, row in self.legend), default=-1)
        self.height = self.plot_top + self.plot_height + 12 + 19 * rows
        self.low, self.high = self._range()
        numbers = max(text_width(f"{value:.3g}", 11) for value in (self.low, self.high))
        self.left, self.right = (max(34.0, numbers + 16) if meters else 12.0), self.width - 14.0
        self.ahead, self.known = self._plot(False), self._plot(True)
        self.texts: dict[tuple[int, int], np.ndarray] = {}
        self.picture = self.ahead.copy()

    def paint(self, time: float) -> None:
        """The strip at a time: curves are drawn up to it, numbers are those after the last turn."""
        # Curves run on during a turn, for the eye; a turn's belief is a number only at its end.
        turn, done = int(np.ceil(time - 1e-9)), int(np.floor(time + 1e-9))
        if (turn, done) not in self.texts:
            self.texts[turn, done] = self._drawn(self._words(turn, done))
        text = self.texts[turn, done]
        self.picture[:] = text
        plot = slice(self.plot_top - 6, self.plot_top + self.plot_height + 6)
        x = round(self._x(time))
        self.picture[plot, x:] = self.ahead[plot, x:]
        self.picture[plot, :x] = self.known[plot, :x]
        for _, color, values in self.meters:
            at = float(np.interp(time, np.arange(len(values)), values))
            if np.isfinite(at):
                self._dot(self._x(time), self._y(at), color)

    def _x(self, time: float) -> float:
        return self.left + (self.right - self.left) * time / max(self.duration, 1e-9)

    def _y(self, value: float) -> float:
        share = (value - self.low) / (self.high - self.low)
        return self.plot_top + self.plot_height * (1 - share)

    def _range(self) -> tuple[float, float]:
        """Probabilities share the axis from 0 to 1; anything else gets its own."""
        values = np.asarray([v for _, _, vs in self.meters for v in vs], dtype=float)
        values = values[np.isfinite(values)]
        if not values.size or (values.min() >= 0 and values.max() <= 1):
            return 0.0, 1.0
        low, high = float(values.min()), float(values.max())
        return (low, high) if high > low else (low - 0.5, high + 0.5)

    def _drawn(self, content: str) -> np.ndarray:
        document = (
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{self.width}" height="{self.height}">'
            f'<rect width="100%" height="100%" fill="#fff"/>{content}</svg>'
        )
        return np.ascontiguousarray(svg_rgba(document)[..., :3])

    def _plot(self, known: bool) -> np.ndarray:
        """The plot with or without what is still to come."""
        y, h, wide = self.plot_top, self.plot_height, self.right - self.left
        box = f'x="{self.left:g}" y="{y}" width="{wide:g}" height="{h}"'
        if not self.meters:  # a plain bar that fills
            return self._drawn(f'<rect {box} rx="4" fill="{"#d9a441" if known else "#eee6d8"}"/>')
        shade = "#faf5ea" if known else "#f3f0ea"
        middle = f"M{self.left:g} {y + h / 2:g} h{wide:g}"
        parts = [f'<rect {box} fill="{shade}"/>', f'<path d="{middle}" stroke="#ddd3c2"/>']
        for value, place in ((self.high, y + 8), (self.low, y + h)):
            parts.append(_text(self.left - 6, place, f"{value:.3g}", 11, ' text-anchor="end"'))
        for _, color, values in self.meters if known else ():
            paint = quoteattr(color)
            parts.append(
                f'<path d="{self._curve(values)}" fill="none" stroke={paint} stroke-width="2.4" '
                'stroke-linejoin="round"/>'
            )
        return self._drawn("".join(parts))

    def _curve(self, values: Sequence[float]) -> str:
        """Path data through the finite values; others leave gaps."""
        path, pen = "", "M"
        for t, value in enumerate(values):
            if np.isfinite(value):
                path += f"{pen}{self._x(t):.1f} {self._y(float(value)):.1f} "
                pen = "L"
            else:
                pen = "M"
        return path or "M0 0"

    def _legend_places(self) -> list[tuple[float, int]]:
        """(x, row) of each meter's name, as many in a row as there is room for."""
        places, x, row = [], 34.0, 0
        for label, _, _ in self.meters:
            wide = text_width(label, 12.5) + 74
            if x + wide > self.width and x > 34:
                x, row = 34.0, row + 1
            places.append((x, row))
            x += wide
        return places

    def _words(self, turn: int, done: int) -> str:
        """Title, number of the turn, and the meters' names with their values after turn `done`."""
        number = "start" if turn == 0 else f"turn {turn} of {self.duration:g}"
        room = self.width - text_width(number, 13) - 40
        title = self.title
        while title and text_width(title, 14, bold=True) > room:
            title = title.rstrip("…")[:-1].rstrip() + "…" if len(title) > 2 else ""
        parts = [
            _text(12, 20, title, 14, ' font-weight="bold"'),
            _text(self.width - 12, 20, number, 13, ' text-anchor="end"'),
        ]
        for (label, color, values), (x, row) in zip(self.meters, self.legend, strict=True):
            y = self.plot_top + self.plot_height + 21 + 19 * row
            value = f"{values[done]:.2f}" if np.isfinite(values[done]) else "–"
            parts.append(f'<circle cx="{x + 5:g}" cy="{y - 4.5:g}" r="5" fill={quoteattr(color)}/>')
            parts.append(_text(x + 15, y, label, 12.5))
            wide = text_width(label, 12.5)
            parts.append(_text(x + 22 + wide, y, value, 12.5, ' font-weight="bold"'))
        return "".join(parts)

    def _dot(self, x: float, y: float, color: str) -> None:
        """A round dot with a soft edge, straight into the pixels: it moves in every frame."""
        radius = 4.5
        x0, y0 = int(x - radius - 1), int(y - radius - 1)
        x1, y1 = x0 + int(2 * radius + 4), y0 + int(2 * radius + 4)
        x0, y0, x1, y1 = max(x0, 0), max(y0, 0), min(x1, self.width), min(y1, self.height)
        rows, columns = np.mgrid[y0:y1, x0:x1]
        distance = np.hypot(columns + 0.5 - x, rows + 0.5 - y)
        cover = np.clip(radius - distance + 0.5, 0, 1)[..., None]
        patch = self.picture[y0:y1, x0:x1]
        ink = np.asarray(ImageColor.getrgb(color)[:3], dtype=float)
        patch[:] = np.round(patch * (1 - cover) + ink * cover).astype(np.uint8)


def _text(x: float, y: float, text: str, size: float, more: str = "") -> str:
    return (
        f'<text x="{x:g}" y="{y:g}" {FONTS} font-size="{size:g}" fill="{INK}"{more}>'
        f"{escape(text)}</text>"
    )


# -------------------------------------------------------------------------------- files


def save_mp4(
    path: PathLike,
    stage: Stage,
    film: Film,
    *,
    fps: float = 24,
    seconds_per_turn: float = 0.9,
    cell: int | None = None,
    title: str = "",
    meters: Sequence[Meter] = (),
    progress: Progress | None = None,
) -> None:
    """Writes the film as H.264 in yuv420p, which plays anywhere; the file appears when complete.

    `cell` is pixels for a cell (None: about 800 pixels wide in all). `meters` are curves over the
    frames 0..T, shown as far as the film has come. `progress(done, total)` counts pictures.
    """
    times = frame_times(film, fps, seconds_per_turn)
    frames = film_frames(stage, film, times, cell or default_cell(stage, 800), title, meters)
    encode = ["-c:v", "libx264", "-preset", "veryfast", "-tune", "animation", "-crf", "20"]
    encode += ["-pix_fmt", "yuv420p", "-movflags", "+faststart"]
    with atomic_path(Path(path)) as temporary:
        _encode(temporary, frames, len(times), fps, [], encode, progress)


def save_gif(
    path: PathLike,
    stage: Stage,
    film: Film,
    *,
    fps: float = 25,
    seconds_per_turn: float = 0.9,
    cell: int | None = None,
    title: str = "",
    meters: Sequence[Meter] = (),
    progress: Progress | None = None,
) -> None:
    """Writes the film as an endless GIF; the file appears when complete. Options as for MP4.

    GIF counts hundredths of a second: 25, 20 or 50 pictures a second are kept exactly.
    """
    times = frame_times(film, fps, seconds_per_turn)
    frames = film_frames(stage, film, times, cell, title, meters)
    few = np.linspace(0, film.duration, 12)
    palette = _palette(film_frames(stage, film, few, cell, title, meters))
    with atomic_path(Path(path)) as temporary, tempfile.TemporaryDirectory() as folder:
        colors = Path(folder, "palette.png")
        palette.save(colors)
        use = ["-i", str(colors)]
        encode = ["-lavfi", "paletteuse=dither=none:diff_mode=rectangle", "-loop", "0"]
        _encode(temporary, frames, len(times), fps, use, encode, progress)


def _palette(frames: Iterator[np.ndarray]) -> Image.Image:
    """255 colours for all of the film and a transparent one, 16 x 16, as ffmpeg wants it."""
    weights = np.asarray([65536, 256, 1])
    codes = np.concatenate([(frame[::2, ::2] @ weights).ravel() for frame in frames])
    codes, counts = np.unique(codes, return_counts=True)
    order = np.argsort(-counts, kind="stable")
    colors = np.stack([codes // 65536, codes // 256 % 256, codes % 256], axis=-1).astype(np.uint8)
    # Floor and walls have most of the pixels and few of the colours: those are kept exactly, and
    # what remains is shared out by how many shades there are rather than by area.
    flat, rest = order[:48], order[48:]
    table = np.zeros((256, 4), dtype=np.uint8)
    table[:255, 3] = 255
    table[: len(flat), :3] = colors[flat]
    if rest.size:
        shades = np.repeat(colors[rest], np.minimum(counts[rest], 60), axis=0)[None]
        chosen = Image.fromarray(shades).quantize(255 - len(flat), Image.Quantize.MEDIANCUT)
        mixed = np.asarray(chosen.getpalette(), dtype=np.uint8).reshape(-1, 3)[: 255 - len(flat)]
        table[len(flat) : len(flat) + len(mixed), :3] = mixed
    return Image.fromarray(table.reshape(16, 16, 4))


def _encode(
    path: Path,
    frames: Iterator[np.ndarray],
    total: int,
    fps: float,
    inputs: Sequence[str],
    options: Sequence[str],
    progress: Progress | None,
) -> None:
    """Feeds the frames to ffmpeg; raises RuntimeError with its words if it fails."""
    first = next(frames)
    height, width = first.shape[:2]
    raw = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", f"{fps:g}"]
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-y", "-v", "error", *raw, "-i", "-", *inputs]
    command += [*options, str(path)]
    with tempfile.TemporaryFile() as words:
        with subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=words,
            start_new_session=True,  # Ctrl-C is for us: we end it and clear up
        ) as process:
            try:
                _feed(process.stdin, first, frames, total, progress)
            except BrokenPipeError:
                pass  # ffmpeg gave up; it says why
            except BaseException:
                process.kill()
                raise
        if process.returncode != 0:
            words.seek(0)
            raise RuntimeError(f"ffmpeg failed: {words.read().decode(errors='replace').strip()}")


def _feed(
    pipe: Any,
    first: np.ndarray,
    frames: Iterator[np.ndarray],
    total: int,
    progress: Progress | None,
) -> None:
    with pipe:
        pipe.write(first.tobytes())
        for done in range(1, total + 1):
            if progress is not None:
                progress(done, total)
            if done < total:
                pipe.write(next(frames).tobytes())
