"""Raw pictures to MP4 and GIF files, by the ffmpeg binary that imageio-ffmpeg brings along.

Whoever draws hands over an iterator of pictures, uint8 [height, width, 3], both sizes even.
"""

from __future__ import annotations

import itertools
import os
import signal
import subprocess
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from i2pdsl.resources import atomic_path

Progress = Callable[[int, int], None]  # frames done, frames in all
PathLike = str | os.PathLike[str]
Times = Sequence[float] | np.ndarray

OPENING, CLOSING = 0.7, 1.5  # seconds that the first and the last moment are held
PATIENCE = 120.0  # seconds in which ffmpeg takes in a picture, or ends after the last one
_VARIABLE = "IMAGEIO_FFMPEG_EXE"
PALETTE_SAMPLES = 12  # moments from which a GIF's colours are taken


def shown_times(duration: float, fps: float, seconds: float) -> np.ndarray:
    """The time in frames (each lasts `seconds`) that each picture shows, both ends held a while."""
    if fps <= 0 or seconds <= 0:
        raise ValueError("fps and the seconds for a frame must be positive")
    whole = OPENING + duration * seconds + CLOSING
    shown = np.arange(round(whole * fps)) / fps
    return np.clip((shown - OPENING) / seconds, 0.0, duration)


def paced_times(seconds: np.ndarray, rests: np.ndarray, fps: float) -> np.ndarray:
    """The time in frames that each picture shows, where frames last differently long.

    Args:
        seconds: [T] how long each frame lasts.
        rests: [T] how long the moment at its end is held.
        fps: pictures a second.
    """
    if fps <= 0 or (np.asarray(seconds) <= 0).any():
        raise ValueError("fps and the seconds for a frame must be positive")
    steps = np.stack([seconds, rests], axis=1).ravel()
    clock = OPENING + np.concatenate([[0.0], np.cumsum(steps)])
    frame = np.concatenate([[0.0], np.repeat(np.arange(1.0, len(seconds) + 1), 2)])
    shown = np.arange(round((clock[-1] + CLOSING) * fps)) / fps
    return np.interp(shown, clock, frame)


def padded(frames: Iterator[np.ndarray], size: tuple[int, int]) -> Iterator[np.ndarray]:
    """Pictures in the middle of larger ones (width, height), in the colour of their corner."""
    canvas: np.ndarray | None = None
    for frame in frames:
        height, width = frame.shape[:2]
        if canvas is None:
            canvas = np.empty((size[1], size[0], frame.shape[2]), np.uint8)
            canvas[:] = frame[0, 0]
        top, left = (size[1] - height) // 2, (size[0] - width) // 2
        canvas[top : top + height, left : left + width] = frame
        yield canvas


_CODECS = {
    # H.264 in yuv420p plays anywhere; VP9 is see-through where the pictures are.
    ".mp4": (
        *("-c:v", "libx264", "-preset", "veryfast", "-tune", "animation", "-crf", "20"),
        *("-pix_fmt", "yuv420p", "-movflags", "+faststart"),
    ),
    ".webm": (
        *("-c:v", "libvpx-vp9", "-crf", "24", "-b:v", "0", "-deadline", "good"),
        *("-cpu-used", "5", "-row-mt", "1", "-auto-alt-ref", "0", "-pix_fmt", "yuva420p"),
    ),
}


def write_film(
    path: PathLike,
    frames: Callable[[Times], Iterator[np.ndarray]],
    times: np.ndarray,
    fps: float,
    progress: Progress | None = None,
) -> None:
    """A GIF, an MP4 (H.264 in yuv420p) or a WebM (VP9), by the suffix; the file appears when
    complete.

    Args:
        frames: the pictures at some times; GIF and WebM also take RGBA.
        times: those that the film shows. GIF counts hundredths of a second: 10, 20, 25 or 50
            pictures a second are kept exactly.
        progress: told the pictures done and those in all.
    """
    if Path(path).suffix == ".gif":
        samples = frames(np.linspace(0, times[-1], PALETTE_SAMPLES))
        write_gif(path, frames(times), samples, len(times), fps, progress)
        return
    encode = list(_CODECS[Path(path).suffix])
    with atomic_path(Path(path)) as temporary:
        _encode(Path(path).name, temporary, frames(times), len(times), fps, [], encode, progress)


def write_gif(
    path: PathLike,
    frames: Iterator[np.ndarray],
    samples: Iterator[np.ndarray],
    total: int,
    fps: float,
    progress: Progress | None = None,
) -> None:
    """An endless GIF in the colours of the sample pictures; the file appears when complete.

    GIF counts hundredths of a second: 10, 20, 25 or 50 pictures a second are kept exactly.
    """
    palette = _palette(samples)
    with atomic_path(Path(path)) as temporary, tempfile.TemporaryDirectory() as folder:
        colors = Path(folder, "palette.png")
        palette.save(colors)
        use = ["-i", str(colors)]
        # Whole pictures, each laid on nothing: what has moved away must not stay behind.
        encode = ["-lavfi", "paletteuse=dither=none:diff_mode=rectangle", "-loop", "0"]
        first = next(frames)
        if first.shape[2] == 4:
            encode += ["-gifflags", "0"]
        frames = itertools.chain([first.copy()], frames)
        _encode(Path(path).name, temporary, frames, total, fps, use, encode, progress)


def _palette(frames: Iterator[np.ndarray]) -> Image.Image:
    """255 colours for all of the film and a transparent one, 16 x 16, as ffmpeg wants it."""
    weights = np.asarray([65536, 256, 1])
    codes = np.concatenate([_opaque(frame[::2, ::2]) @ weights for frame in frames])
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


def _opaque(picture: np.ndarray) -> np.ndarray:
    """[n, 3] The colours of a picture's pixels, without those that can be seen through."""
    colors: np.ndarray = picture[..., :3].reshape(-1, 3)
    return colors if picture.shape[2] == 3 else colors[picture[..., 3].ravel() > 127]


def _encode(
    film: str,
    path: Path,
    frames: Iterator[np.ndarray],
    total: int,
    fps: float,
    inputs: Sequence[str],
    options: Sequence[str],
    progress: Progress | None,
) -> None:
    """Feeds the frames to ffmpeg; raises FilmError with its words if it fails.

    Args:
        film: the name of the file that `path` will be.
    """
    program = _ffmpeg(film)
    first = next(frames)
    height, width = first.shape[:2]
    raw = [
        "-f",
        "rawvideo",
        "-pix_fmt",
        "rgb24" if first.shape[2] == 3 else "rgba",
        "-s",
        f"{width}x{height}",
        "-r",
        f"{fps:g}",
    ]
    command = [program, "-y", "-v", "error", *raw, "-i", "-", *inputs, *options, f"file:{path}"]
    with tempfile.TemporaryFile() as words:
        try:
            process = subprocess.Popen(
                command,
                bufsize=0,
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                stderr=words,
                start_new_session=True,  # Ctrl-C is for us: we end it and clear up
            )
        except OSError as problem:
            what = f"cannot be started: {problem.strerror or problem}"
            raise FilmError([film], _blame(program, what)) from None
        with process, _Patience(process) as patience:
            try:
                _feed(process.stdin, first, frames, total, progress, patience)
                process.wait()
            except BrokenPipeError:
                pass  # ffmpeg gave up; it says why
            except BaseException:
                _end(process)
                raise
        if process.returncode == 0:
            return
        words.seek(0)
        said = words.read().decode(errors="replace").split("\n")
        last = next((" ".join(line.split()) for line in reversed(said) if line.strip()), "")
    how = f"did nothing for {PATIENCE:g} s" if patience.is_over else _ended(process.returncode)
    how = f"{how}: {last}" if last else f"{how}, and said nothing"
    raise FilmError([film], _blame(program, how))


class FilmError(OSError, RuntimeError):
    """Films that ffmpeg could not write; the message is for people, on one line.

    Attributes:
        films: their files' names.
        reason: what is the matter with ffmpeg.
    """

    def __init__(self, films: Sequence[str], reason: str):
        self.films, self.reason = tuple(films), reason
        not_written = f"{' and '.join(films)} {'was' if len(films) == 1 else 'were'} not written"
        super().__init__(f"{not_written}: ffmpeg failed: {reason}")


def _blame(program: str, what: str) -> str:
    """What is the matter with an ffmpeg, and how to take another one."""
    chosen = os.environ.get(_VARIABLE)
    if not chosen:
        return f"{program} {what}; {_VARIABLE} can name another one"
    return f"{program} (from {_VARIABLE}) {what}; unset {_VARIABLE}, or let it name another one"


def _ffmpeg(film: str) -> str:
    """The program: the one that the environment names, else that of imageio-ffmpeg."""
    import imageio_ffmpeg

    try:
        return str(imageio_ffmpeg.get_ffmpeg_exe())
    except RuntimeError:
        reason = f"there is none; install one, or let {_VARIABLE} name it"
        raise FilmError([film], reason) from None


def _end(process: subprocess.Popen[bytes]) -> None:
    """Ends ffmpeg, and what it may have started itself, being a script."""
    if hasattr(os, "killpg"):
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)
    process.kill()


def _ended(status: int) -> str:
    if status > 0:
        return f"ended with status {status}"
    try:
        return f"was ended by {signal.Signals(-status).name}"
    except ValueError:
        return f"was ended by signal {-status}"


class _Patience:
    """Ends a process that takes nothing in for too long, so that nobody waits forever.

    Attributes:
        is_over: whether that happened.
    """

    def __init__(self, process: subprocess.Popen[bytes]):
        self.process, self.is_over = process, False
        self.heard = time.monotonic()
        self.done = threading.Event()
        self.thread = threading.Thread(target=self._wait, daemon=True)

    def __enter__(self) -> _Patience:
        self.thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.process.wait()  # this, too, has its end
        self.done.set()

    def hear(self) -> None:
        """It took something in."""
        self.heard = time.monotonic()

    def _wait(self) -> None:
        while not self.done.wait(min(1.0, PATIENCE / 4)):
            if time.monotonic() - self.heard > PATIENCE:
                self.is_over = True
                _end(self.process)
                return


def _feed(
    pipe: Any,
    first: np.ndarray,
    frames: Iterator[np.ndarray],
    total: int,
    progress: Progress | None,
    patience: _Patience,
) -> None:
    picture = first
    for done in range(1, total + 1):
        rest = memoryview(picture.tobytes())
        while rest:
            patience.hear()
            rest = rest[pipe.write(rest) :]
        if progress is not None:
            progress(done, total)
        if done < total:
            picture = next(frames)
    patience.hear()
    pipe.close()
