"""Films have the right pictures, as many as they should, and appear only when complete."""

import subprocess
from pathlib import Path
from time import monotonic, sleep

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image

from commands_for_tests import PATIENCE
from i2pdsl.render import video
from i2pdsl.render.files import FilmLook
from i2pdsl.render.grid.choreography import choreograph
from i2pdsl.render.grid.film import default_cell, film_frames, frame_times, lengths, save_film
from i2pdsl.render.grid.scene import scene_size, scene_svg
from i2pdsl.render.grid.stage import Actor, Stage, Tile
from i2pdsl.render.grid.tracks import Film
from i2pdsl.render.raster import svg_rgba

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
    assert len(times) == round((0.7 + (1.35 + 1.5) * 0.5 + 1.5) * 20)
    assert times[0] == times[13] == 0
    assert times[-1] == times[-28] == 2
    assert np.allclose(np.diff(times)[15:26], 0.1 / 1.35), "a push"
    assert np.allclose(np.diff(times)[29:41], 0.1 / 1.5), "a fall"
    with pytest.raises(ValueError, match="positive"):
        frame_times(FILM, fps=0)


def test_a_still_turn_is_short_and_a_twist_is_looked_at():
    still = {"cheese": {"action": "stay", "moved": False},
             "robot": {"action": "stay", "moved": False}, "event": None,
             "state": SCRIPT["frames"][0]["state"]}  # fmt: skip
    frames = [SCRIPT["frames"][0], still, SCRIPT["frames"][1]]
    film = choreograph(STAGE, {**SCRIPT, "frames": frames})
    seconds, rests = lengths(film, twists={1: 2.0, 3: 1.0})
    assert seconds[1] < 0.5 * min(seconds[0], seconds[2])
    assert rests.tolist() == [pytest.approx(0.72), 0, 0], "the end is held anyway"
    quick = lengths(film, twists={1: 2.0}, pace=2)
    assert np.allclose(quick, np.array([seconds, rests]) / 2)
    times = frame_times(film, 50, twists={1: 1.0})
    assert (times == 1).sum() == pytest.approx(0.72 * 50, abs=1), "held at the end of turn 1"
    assert (np.diff(times) >= 0).all()


@pytest.mark.parametrize("size", [(640, 360), (200, 400), (160, 160)])
@pytest.mark.parametrize("meter", [True, False])
def test_films_of_a_size(size, meter):
    look = FilmLook(meter=meter, size=size)
    frame = next(film_frames(STAGE, FILM, [0.0], None, "T", METERS, look))
    assert frame.shape == (size[1], size[0], 3)
    outside = frame[0, 0].astype(int)
    scene = (abs(frame.astype(int) - outside).max(axis=2) > 8).any(axis=0)
    assert scene.mean() > 0.6, "the scene fills it"
    white = (frame[-4] == 255).all()
    assert white == meter


@pytest.mark.parametrize("kind", ["gif", "webm"])
def test_films_without_a_background(tmp_path, kind):
    path = tmp_path / f"a.{kind}"
    look = FilmLook(transparent=True, meter=False)
    save_film(path, STAGE, FILM, fps=10, seconds_per_turn=0.3, cell=40, look=look)
    wanted = next(film_frames(STAGE, FILM, [2.0], 40, look=look))
    assert wanted.shape[2] == 4
    decode = ["-f", "rawvideo", "-pix_fmt", "rgba", "-"]
    read = [*(["-c:v", "libvpx-vp9"] if kind == "webm" else []), "-i", str(path)]
    ffmpeg = [imageio_ffmpeg.get_ffmpeg_exe(), *read, *decode]
    decoded = subprocess.run(ffmpeg, capture_output=True, check=True).stdout
    last = np.frombuffer(decoded, np.uint8).reshape(-1, *wanted.shape)[-1].astype(int)
    assert (abs(last[..., 3] - wanted[..., 3]) > 140).mean() < 0.002
    assert 0.5 < (last[..., 3] == 0).mean() < 0.98, "what has moved away leaves nothing behind"
    solid = wanted[..., 3] == 255
    assert abs(last[solid] - wanted[solid]).mean() < 8


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
    save_film(
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
    save_film(path, STAGE, FILM, fps=12, seconds_per_turn=0.5, cell=31, meters=METERS)
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


@pytest.mark.parametrize("kind", ["gif", "mp4"])
def test_a_failure_leaves_nothing_behind(tmp_path, kind, monkeypatch):
    def interrupt(done, total):
        if done == 5:
            raise KeyboardInterrupt

    path = tmp_path / f"a.{kind}"
    path.write_bytes(b"old")
    with pytest.raises(KeyboardInterrupt):
        save_film(path, STAGE, FILM, cell=20, progress=interrupt)
    assert [p.name for p in tmp_path.iterdir()] == [path.name]
    assert path.read_bytes() == b"old"

    monkeypatch.setattr(video, "atomic_path", _nowhere)
    with pytest.raises(RuntimeError, match="ffmpeg failed"):
        save_film(path, STAGE, FILM, cell=20)


class _nowhere:
    """Stands for a place where ffmpeg cannot write."""

    def __init__(self, path):
        self.path = path.parent / "no such folder" / path.name

    def __enter__(self):
        return self.path

    def __exit__(self, *error):
        return None


def program(folder, text):
    path = folder / "my ffmpeg"
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)
    return str(path)


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("exit 1", "ended with status 1, and said nothing"),
        ("cat > /dev/null; printf 'one\nNo space left on device\n\n' >&2; exit 228",
         "ended with status 228: No space left on device"),
        ("kill -9 $$", "was ended by SIGKILL, and said nothing"),
    ],
)  # fmt: skip
def test_an_ffmpeg_that_fails_is_named(tmp_path, monkeypatch, text, wanted):
    chosen = program(tmp_path, text)
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", chosen)
    for kind in ("gif", "mp4"):
        path = tmp_path / f"a.{kind}"
        with pytest.raises(video.FilmError) as caught:
            save_film(path, STAGE, FILM, cell=20)
        said = str(caught.value)
        assert said == (
            f"{path.name} was not written: ffmpeg failed: {chosen} (from IMAGEIO_FFMPEG_EXE) "
            f"{wanted}; unset IMAGEIO_FFMPEG_EXE, or let it name another one"
        )
    assert [p.name for p in tmp_path.iterdir()] == ["my ffmpeg"]


@pytest.mark.parametrize("chosen", ["/no/such/ffmpeg", __file__])
def test_an_ffmpeg_that_does_not_start_is_named(tmp_path, monkeypatch, chosen):
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", chosen)
    with pytest.raises(OSError, match=f"a.mp4 was not written: .*{chosen} .*cannot be started"):
        save_film(tmp_path / "a.mp4", STAGE, FILM, cell=20)
    assert list(tmp_path.iterdir()) == []


def test_no_ffmpeg_at_all(tmp_path, monkeypatch):
    def none():
        raise RuntimeError("No ffmpeg exe could be found.")

    monkeypatch.setattr(imageio_ffmpeg, "get_ffmpeg_exe", none)
    with pytest.raises(video.FilmError, match="there is none; install one, or let IMAGEIO_"):
        save_film(tmp_path / "a.gif", STAGE, FILM, cell=20)


def test_nobody_waits_forever_for_an_ffmpeg_that_hangs(tmp_path, monkeypatch):
    """It is ended with all that it has started."""
    chosen = program(tmp_path, f"sleep 1000 & echo $! > '{tmp_path}/pid'; wait")
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", chosen)
    monkeypatch.setattr(video, "PATIENCE", 1.0)
    with pytest.raises(video.FilmError, match="did nothing for 1 s"):
        save_film(tmp_path / "a.mp4", STAGE, FILM, cell=60)
    assert not (tmp_path / "a.mp4").exists()
    status = Path(f"/proc/{int((tmp_path / 'pid').read_text())}/stat")
    begun = monotonic()
    while runs(status):  # who is killed ends when the machine has time for it
        assert monotonic() - begun < PATIENCE
        sleep(0.05)


def runs(status: Path) -> bool:
    """Whether a process does, by its file of the system."""
    try:
        return status.read_text().split()[2] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


@pytest.mark.parametrize("size", [(1, 1), (200, 1), (1, 200), (200, 200), (40, 40)])
def test_large_maps_make_no_endless_films(size):
    across, down = size
    stage = Stage("a", ("." * across,) * down, (), ())
    cell = default_cell(stage, 800)
    width, height = scene_size(stage, cell)
    assert width * height <= 2.3e6
    assert max(width, height) <= 2600
    assert cell >= 7


def test_long_stories_make_no_endless_films():
    still = Film({}, (), (), 5000.0)
    times = frame_times(still, 25)
    assert len(times) == round((0.7 + 180 + 1.5) * 25)
    assert len(frame_times(still, 25, pace=2)) == round((0.7 + 90 + 1.5) * 25)
    assert times[-1] == 5000
