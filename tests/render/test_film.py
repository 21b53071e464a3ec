"""Films have the right pictures, as many as they should, and appear only when complete."""

import subprocess

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image

from i2pdsl.render import video
from i2pdsl.render.choreography import choreograph
from i2pdsl.render.film import film_frames, frame_times, save_gif, save_mp4
from i2pdsl.render.raster import svg_rgba
from i2pdsl.render.scene import scene_svg
from i2pdsl.render.stage import Actor, Stage, Tile

CAST = (Actor("cheese", "cheese"), Actor("robot", "robot"), Actor("table", "table", "", "object"))
STAGE = Stage("kitchen", ("...#.", "....."), (Tile("pink", (0, 1), "#f08fb0"),), CAST)
SCRIPT = {
    "start": {"cheese": [2, 1], "robot": [3, 1], "table": None},
    "frames": [
        {"cheese": {"action": "west", "moved": False}, "robot": {"action": "west", "moved": True},
         "event": None, "state": {"cheese": [1, 1], "robot": [2, 1], "table": None}},
        {"event": {"deus": "table", "to": [4, 0]},
         "state": {"cheese": [1, 1], "robot": [2, 1], "table": [4, 0]}},
    ],
}  # fmt: skip
FILM = choreograph(STAGE, SCRIPT)
METERS = [("P(rho > 0)", "#3b6ea5", [0.4, 0.7, 0.9]), ("P(x)", "crimson", [0.5, float("nan"), 1])]


def test_frame_times_hold_both_ends():
    times = frame_times(FILM, fps=20, seconds_per_turn=0.5)
    assert len(times) == round((0.7 + 2 * 0.5 + 1.5) * 20)
    assert times[0] == times[13] == 0
    assert times[-1] == times[-28] == 2
    assert np.allclose(np.diff(times)[15:30], 0.1)
    with pytest.raises(ValueError, match="positive"):
        frame_times(FILM, fps=0)


def test_repainting_parts_gives_the_whole_picture():
    times = np.linspace(0, 2, 23)
    for time, frame in zip(times, film_frames(STAGE, FILM, times, cell=50), strict=True):
        whole = svg_rgba(scene_svg(STAGE, FILM, time, 50))[..., :3]
        left = (frame.shape[1] - whole.shape[1]) // 2
        shown = frame[: whole.shape[0], left : left + whole.shape[1]]
        difference = abs(shown.astype(int) - whole).max(axis=2)
        # Single pixels at soft edges come out a little different when a part is drawn alone.
        assert difference.max() < 40, time
        assert (difference > 3).mean() < 0.002, time


def test_meters_are_drawn_as_far_as_known():
    frames = [f.copy() for f in film_frames(STAGE, FILM, [0, 1, 2], 40, "Title", METERS)]
    assert all(side % 2 == 0 for side in frames[0].shape[:2])
    blue = [int((abs(f.astype(int) - (0x3B, 0x6E, 0xA5)).max(axis=2) < 30).sum()) for f in frames]
    assert blue[0] + 100 < blue[1]
    assert blue[1] + 100 < blue[2]
    with pytest.raises(ValueError, match="needs 3 values"):
        next(film_frames(STAGE, FILM, [0], 40, "", [("short", "red", [1.0])]))


def test_gif_has_all_its_frames(tmp_path):
    seen = []
    save_gif(
        tmp_path / "a.gif", STAGE, FILM, fps=20, seconds_per_turn=0.5, cell=30, title="T",
        meters=METERS, progress=lambda done, total: seen.append((done, total)),
    )  # fmt: skip
    total = len(frame_times(FILM, 20, 0.5))
    assert seen == [(i, total) for i in range(1, total + 1)]
    with Image.open(tmp_path / "a.gif") as image:
        assert image.n_frames == total
        assert image.info["loop"] == 0
        milliseconds = []
        for i in range(total):
            image.seek(i)
            milliseconds.append(image.info["duration"])
        last = np.asarray(image.convert("RGB")).astype(int)
    assert sum(milliseconds[:-1]) == 50 * (total - 1)
    wanted = next(film_frames(STAGE, FILM, [2.0], 30, "T", METERS))
    assert abs(last - wanted).mean() < 2


def test_mp4_has_all_its_frames(tmp_path):
    path = tmp_path / "a.mp4"
    save_mp4(path, STAGE, FILM, fps=12, seconds_per_turn=0.5, cell=31, meters=METERS)
    total = len(frame_times(FILM, 12, 0.5))
    ffmpeg = [imageio_ffmpeg.get_ffmpeg_exe(), "-i", str(path)]
    decode = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    decoded = subprocess.run(ffmpeg + decode, capture_output=True, check=True)
    wanted = next(film_frames(STAGE, FILM, [2.0], 31, "", METERS))
    frames = np.frombuffer(decoded.stdout, np.uint8).reshape(-1, *wanted.shape)
    assert len(frames) == total
    assert b"yuv420p" in decoded.stderr
    assert all(side % 2 == 0 for side in wanted.shape[:2])
    assert abs(frames[-1].astype(int) - wanted).mean() < 5


@pytest.mark.parametrize("save", [save_gif, save_mp4])
def test_a_failure_leaves_nothing_behind(tmp_path, save, monkeypatch):
    def interrupt(done, total):
        if done == 5:
            raise KeyboardInterrupt

    path = tmp_path / f"a.{save.__name__[-3:]}"
    path.write_bytes(b"old")
    with pytest.raises(KeyboardInterrupt):
        save(path, STAGE, FILM, cell=20, progress=interrupt)
    assert [p.name for p in tmp_path.iterdir()] == [path.name]
    assert path.read_bytes() == b"old"

    monkeypatch.setattr(video, "atomic_path", _nowhere)
    with pytest.raises(RuntimeError, match="ffmpeg failed"):
        save(path, STAGE, FILM, cell=20)


class _nowhere:
    """Stands for a place where ffmpeg cannot write."""

    def __init__(self, path):
        self.path = path.parent / "no such folder" / path.name

    def __enter__(self):
        return self.path

    def __exit__(self, *error):
        return None
