"""Pictures of the hill: nothing is cut off, films keep the world's time, names match the files."""

import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest
from hill_performances import SLOPE, performance
from PIL import Image

from i2pdsl.render.files import FilmLook
from i2pdsl.render.hill.comic import comic_svg, together_svg
from i2pdsl.render.hill.figures import CRATES, IDLE, LONG, SHORT, muscle_color, pose_svg, rig
from i2pdsl.render.hill.film import film_frames, meters
from i2pdsl.render.hill.performance import Performance, key_frames
from i2pdsl.render.hill.pictures import HillPictures, compared
from i2pdsl.render.hill.rig import (
    ROPE_LENGTH,
    SAG,
    TAKES,
    node,
    path_data,
    pose_vector,
    smooth,
    unit,
)
from i2pdsl.render.hill.scene import camera_way, pose_at, scene_svg, svg_document, view_of
from i2pdsl.render.mind import Panel, Series, Window
from i2pdsl.render.raster import svg_rgba
from i2pdsl.worlds.hill.hopper import HAND, HIPS, HOOK, rest_positions

# ------------------------------------------------------------------------------------ performances


def test_a_performance_checks_its_shapes():
    good = performance()
    short = Panel("p", "probability", (Series("s", np.zeros(3), "#000000"),))
    for wrong, words in (
        ({"positions": good.positions[:, :, :5]}, "positions must be"),
        ({"actuation": good.actuation[:-1]}, "actuation must be"),
        ({"positions": good.positions * np.nan}, "finite"),
        ({"panels": (short,)}, "covers 2 frames"),
        ({"windows": (Window(3, 41, "late"),)}, "after the last frame"),
        ({"captions": ("one",)}, "41 captions"),
    ):
        with pytest.raises(ValueError, match=words):
            replace(good, **wrong)
    with pytest.raises(ValueError, match="first < last"):
        Window(3, 3)


def test_distance_is_measured_along_the_slope():
    one = performance()
    moved = one.positions + np.arange(41)[:, None, None] * np.array([[np.cos(SLOPE)], [0.0]])
    assert replace(one, positions=moved).distance == pytest.approx(
        one.distance + np.arange(41), abs=1e-9
    )


def test_captions_may_be_lines_a_function_or_none():
    one = performance()
    assert one.caption(3) == "at frame 3 <so> & so"
    assert replace(one, captions=tuple("x" * k for k in range(41))).caption(3) == "xxx"
    assert "up the slope" in replace(one, captions=()).caption(3)


@pytest.mark.parametrize("frames", [0, 1, 40, 200])
def test_key_frames_begin_when_the_box_has_dropped_and_end_with_the_end(frames):
    chosen = key_frames(performance(frames=frames), 8)
    assert chosen == sorted(set(chosen))
    assert (chosen[0], chosen[-1]) == (min(16, frames // 20), frames)
    assert len(chosen) <= 8


def test_key_frames_include_windows_falls_and_turns():
    one = performance(frames=200, windows=(Window(60, 90, "stumble"),))
    chosen = key_frames(replace(one, moments={130: 2.0, 132: 1.0}), 6)
    assert {60, 90, 130, 200} <= set(chosen)
    assert 132 not in chosen  # part of the fall


# ---------------------------------------------------------------------------------------- drawing


def test_a_pose_vector_holds_nodes_directions_and_sag():
    rest = rest_positions()
    vector = pose_vector(rest, SLOPE)
    assert node(3) @ vector == pytest.approx(rest[0, 3] + 1j * rest[1, 3])
    assert unit(3, 4) @ vector == pytest.approx(1)
    assert SAG @ vector == 0
    nearer = rest.copy()
    nearer[0, :11] -= 1.0
    assert (SAG @ pose_vector(nearer, SLOPE)).imag < -1
    # The arc that sags so is as long as the rope.
    hand, hook = (nearer[:, k] for k in (HAND, HOOK))
    chord = float(np.hypot(*(hand - hook)))
    sag = -(SAG @ pose_vector(nearer, SLOPE)).imag
    assert chord + 8 * sag**2 / (3 * chord) == pytest.approx(ROPE_LENGTH)


def test_every_part_has_the_points_that_its_shape_takes():
    parts = [part for layer in rig().values() for part in layer]
    for part in parts:
        assert sum(TAKES[command] for command in part.shape) == len(part.points)
    assert {part.muscle for part in parts} == {None, 0, 1, 2, 3, 4, 5}


def test_curves_go_through_their_points():
    points = [node(k) for k in (3, 6, 9, 10)]
    for closed in (False, True):
        shape, weights = smooth(points, closed)
        assert shape == "M" + "C" * (4 if closed else 3) + "Z" * closed
        assert all((a == b).all() for a, b in zip(weights[::3], points, strict=False))


def test_drawings_move_and_turn_with_their_nodes():
    one = performance()
    vector = pose_vector(one.positions[5], SLOPE)
    away = one.positions[5] + np.array([[7.0], [7.0 * np.tan(SLOPE)]])
    moved = pose_vector(away, SLOPE)
    for part in (part for layer in rig().values() for part in layer):
        shift = part.points @ moved - part.points @ vector
        assert shift == pytest.approx(np.full(len(shift), 7 + 7j * np.tan(SLOPE)))


def test_muscles_are_red_where_they_pull_and_blue_where_they_push():
    assert [muscle_color(p) for p in (-1, 0, 1)] == [SHORT, IDLE, LONG]
    drawn = pose_svg(rest_positions(), np.array([-1, 0, 0, 0, 0, 1.0]), SLOPE)
    assert drawn.count(f'stroke="{SHORT}"') == drawn.count(f'stroke="{LONG}"') == 1


def test_paths_are_in_svg_units_with_y_down():
    assert path_data("MLZ", np.array([1 + 2j, 4 - 3j])) == "M10.0 -20.0L40.0 30.0Z"


def test_between_two_frames_a_pose_is_between_them():
    one = performance()
    positions, pull = pose_at(one, 4.25)
    assert positions == pytest.approx(0.75 * one.positions[4] + 0.25 * one.positions[5])
    assert pull == pytest.approx(np.tanh(one.actuation[4]))
    assert pose_at(one, 99)[0] == pytest.approx(one.positions[40])


def test_the_camera_follows_smoothly_and_sees_everything():
    one = performance(frames=60)
    running = (
        one.positions + np.array([[1.0], [np.tan(SLOPE)]]) * 0.5 * np.arange(61)[:, None, None]
    )
    runner = replace(one, positions=running, actuation=one.actuation, panels=())
    way, view = camera_way(runner), view_of([one, runner])
    assert abs(np.diff(way, 2)).max() < abs(np.diff(running[:, 0, HIPS], 2)).max()
    for p in (one, runner):
        x = camera_way(p)
        away = p.positions[:, 0] - x[:, None]
        above = p.positions[:, 1] - np.tan(SLOPE) * x[:, None]
        assert view.left + 1 < away.min()
        assert away.max() < view.right - 3
        assert above.max() < view.top - 4
        assert view.bottom < np.tan(SLOPE) * view.left - 4


def test_the_figure_lies_inside_the_picture():
    one = performance()
    view = view_of([one])
    for frame in (0, 20, 40):
        positions, pull = pose_at(one, frame)
        x = camera_way(one)[frame]
        shown = f'<g transform="translate({-10 * x} {10 * x * np.tan(SLOPE)})">'
        shown += f"{pose_svg(positions, pull, SLOPE)}</g>"
        alpha = svg_rgba(svg_document(view, shown))[..., 3]
        assert alpha.any()
        edges = np.concatenate([alpha[0], alpha[-1], alpha[:, 0], alpha[:, -1]])
        assert not edges.any()


# ------------------------------------------------------------------------------------ comic, films


def test_the_comic_is_xml_and_tells_captions_and_windows():
    one = performance(windows=(Window(10, 20, "stumble & fall"),))
    drawn = comic_svg(one, [0, 10, 20, 40], "A <title>")
    texts = "\n".join(ET.fromstring(drawn).itertext())
    assert "A <title>" in texts
    assert "at frame 10 <so> & so" in texts
    assert texts.count("stumble & fall") == 2
    assert "2.0 s" in texts


def test_together_shows_each_performance_with_its_own_crate():
    drawn = together_svg([performance("a"), performance("b", 20)], "T", 3)
    assert all(crate in drawn for crate in CRATES[:2])
    assert "2.0 s" in "\n".join(ET.fromstring(drawn).itertext())


def test_films_show_what_the_scene_shows():
    one = performance()
    view = view_of([one])
    for time, frame in zip((0, 12.5, 40), film_frames([one], [0, 12.5, 40], 500, ""), strict=True):
        whole = svg_rgba(svg_document(view, scene_svg(one, time, view)), 500 / view.width)[..., :3]
        high = round(view.height * 500 / view.width)
        difference = abs(frame[:high].astype(int) - whole[:high]).max(axis=2)
        # The film's camera moves by whole pixels: edges may differ, areas do not.
        assert (difference > 12).mean() < 0.09, time
        assert np.median(difference) == 0


def test_a_film_of_several_is_as_wide_as_asked_and_rests_after_the_end():
    pair = [performance("a", 40), performance("b", 20, 0.5)]
    frames = [f.copy() for f in film_frames(pair, [0, 20, 30, 40], 640, "T")]
    assert all(f.shape == frames[0].shape and f.shape[1] == 640 for f in frames)
    assert frames[0].shape[0] % 2 == 0
    right = slice(330, 640)
    stage = round(view_of(pair).height * 317 / view_of(pair).width) - 2
    assert (frames[2][:stage, right] == frames[3][:stage, right]).all()
    assert (frames[2][:stage, :310] != frames[3][:stage, :310]).any()
    assert [(m[0], len(m[2])) for m in meters(pair)] == [("a: heavy", 41), ("b: heavy", 41)]


def test_windows_are_signed_in_the_film():
    plain, marked = (
        next(film_frames([performance(windows=windows)], [15], 480, "T"))
        for windows in ((), (Window(10, 20, "stumble"),))
    )
    assert (plain[8:30, 8:60] != marked[8:30, 8:60]).any()


def test_a_gif_keeps_the_worlds_time(tmp_path):
    HillPictures([performance()], "T").save_film(tmp_path / "a.gif", width=200)
    with Image.open(tmp_path / "a.gif") as image:
        assert image.n_frames == round((0.7 + 40 * 0.05 + 1.5) * 10)
        assert image.info["duration"] == 100


# --------------------------------------------------------------------------------------- all files


def test_all_pictures_of_one(tmp_path):
    seen = []
    pictures = HillPictures([performance(frames=12, windows=(Window(3, 6, "w"),))], "A\ttitle")
    pictures.look = FilmLook(pace=6)  # its films have fewer pictures
    files = pictures.save(
        tmp_path, ("png", "svg", "html", "gif", "mp4"), lambda *told: seen.append(told)
    )
    assert [(name, path.name) for name, path in files.items()] == [
        *((n, n) for n in ("comic.png", "mind.png", "comic.svg", "mind.svg")),
        ("html", "page.html"), ("gif", "film.gif"), ("mp4", "film.mp4"),
    ]  # fmt: skip
    assert all(path.stat().st_size > 1000 for path in files.values())
    assert {told[0] for told in seen} == {"film.gif", "film.mp4"}
    assert [told for told in seen if told[0] == "film.gif"][-1] == ("film.gif", 23, 23)
    assert pictures.title == "A title"
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted(p.name for p in files.values())


def test_all_pictures_of_several(tmp_path):
    pictures = HillPictures([performance("a", 12), performance("b", 6)])
    files = pictures.save(tmp_path, ("png", "html", "gif"))
    assert [path.name for path in files.values()] == [
        "together.png", "mind.png", "together.html", "together.gif",
    ]  # fmt: skip
    with pytest.raises(ValueError, match="no performance"):
        HillPictures([])


def test_no_curves_no_figure_of_them(tmp_path):
    bare = replace(performance(), panels=(), leading=None)
    assert list(HillPictures([bare]).save(tmp_path, ("png",))) == ["comic.png"]


def test_a_performance_of_no_frames_can_be_drawn(tmp_path):
    still = performance(frames=0)
    assert isinstance(still, Performance)
    files = HillPictures([still]).save(tmp_path, ("png", "html", "gif"))
    assert len(files) == 4


def test_compared_curves_pair_what_has_the_same_name():
    found = compared([performance("a"), performance("b", 20)])
    assert [p.title for p in found] == ["weight: heavy", "expected value", "distance"]
    assert all([s.label for s in p.series] == ["a", "b"] for p in found)
    short = found[0].series[1].values
    assert np.isnan(short[21:]).all()
    assert short[20] == 0.9
