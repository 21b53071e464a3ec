"""Raw pictures to MP4 and GIF files, by the ffmpeg binary that imageio-ffmpeg brings along.

Whoever draws hands over an iterator of pictures, uint8 [height, width, 3], both sizes even.
"""

import os
import subprocess
import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import imageio_ffmpeg
import numpy as np
from PIL import Image

from i2pdsl.resources import atomic_path

Progress = Callable[[int, int], None]  # frames done, frames in all
PathLike = str | os.PathLike[str]

OPENING, CLOSING = 0.7, 1.5  # seconds that the first and the last moment are held
PALETTE_SAMPLES = 12  # moments from which a GIF's colours are taken


def shown_times(duration: float, fps: float, seconds: float) -> np.ndarray:
    """The time in frames (each lasts `seconds`) that each picture shows, both ends held a while."""
    if fps <= 0 or seconds <= 0:
        raise ValueError("fps and the seconds for a frame must be positive")
    whole = OPENING + duration * seconds + CLOSING
    shown = np.arange(round(whole * fps)) / fps
    return np.clip((shown - OPENING) / seconds, 0.0, duration)


def write_mp4(
    path: PathLike,
    frames: Iterator[np.ndarray],
    total: int,
    fps: float,
    progress: Progress | None = None,
) -> None:
    """H.264 in yuv420p, which plays anywhere; the file appears when complete."""
    encode = ["-c:v", "libx264", "-preset", "veryfast", "-tune", "animation", "-crf", "20"]
    encode += ["-pix_fmt", "yuv420p", "-movflags", "+faststart"]
    with atomic_path(Path(path)) as temporary:
        _encode(temporary, frames, total, fps, [], encode, progress, path)


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
        encode = ["-lavfi", "paletteuse=dither=none:diff_mode=rectangle", "-loop", "0"]
        _encode(temporary, frames, total, fps, use, encode, progress, path)


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
    name: PathLike,
) -> None:
    """Feeds the frames to ffmpeg; raises RuntimeError with its words if it fails, and the `name`
    that the file should have got."""
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
            said = words.read().decode(errors="replace").strip()
            raise RuntimeError(f"ffmpeg failed: {said}: {os.fspath(name)}")


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
