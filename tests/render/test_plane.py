"""Pictures of planes: everybody where the script has them, names where they can be read."""

import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from PIL import Image
from plane_performances import CROWD, DUET, ROOM, performance, svg_document

from i2pdsl.errors import StoryError
from i2pdsl.render.characters import Ink
from i2pdsl.render.files import FilmLook
from i2pdsl.render.mind import Panel, Series, Window
from i2pdsl.render.performances import compared, meters
from i2pdsl.render.plane.characters import plane_in_characters
from i2pdsl.render.plane.comic import comic_svg, together_svg
from i2pdsl.render.plane.figures import DASH, TRAIL, face_moves, film_svg, trail_pieces
from i2pdsl.render.plane.film import film_frames
from i2pdsl.render.plane.labels import Obstacles, Tag, gap, lengths_inside, placed
from i2pdsl.render.plane.names import names_svg, place_names
from i2pdsl.render.plane.performance import frame_seconds, key_frames
from i2pdsl.render.plane.pictures import PlanePictures
from i2pdsl.render.plane.room import View, view_within
from i2pdsl.render.plane.stage import stage_within
from i2pdsl.render.raster import svg_rgba
from i2pdsl.render.video import padded
from i2pdsl.worlds.plane.spec import Place

SVG = "{http://www.w3.org/2000/svg}"
ODD = "<b> & \"x\" 'y'"


def numbers(text):
    return [float(x) for x in re.findall(r"-?\d+(?:\.\d+)?", text)]


# ------------------------------------------------------------------------------------ performances


def test_a_performance_checks_its_shapes():
    good = performance()
    short = Panel("p", "probability", (Series("s", np.zeros(3), "#000000"),))
    for wrong, words in (
        ({"positions": good.positions[:, :, :1]}, "positions must be"),
        ({"positions": good.positions * np.nan}, "finite"),
        ({"panels": (short,)}, "covers 2 frames"),
        ({"tries": good.positions}, "tries must be"),
        ({"windows": (Window(3, 81, "late"),)}, "after the last frame"),
        ({"captions": ("one",)}, "81 captions"),
    ):
        with pytest.raises(ValueError, match=words):
            replace(good, **wrong)


def test_eyes_look_where_somebody_tries_to_go_and_ahead_at_rest():
    one = performance(spec=DUET)
    assert np.linalg.norm(one.gaze, axis=-1).max() <= 1 + 1e-9
    steps = np.diff(one.positions, axis=0)[10]
    for gaze, step in zip(one.gaze[10], steps, strict=True):
        assert gaze == pytest.approx(step / np.linalg.norm(step), abs=1e-6)
    still = replace(one, positions=np.repeat(one.positions[:1], 81, axis=0))
    assert not still.gaze.any()
    # Who is kept from going there looks there nevertheless.
    tries = np.zeros((80, 2, 2))
    tries[:, 0, 1] = -1.0
    assert replace(still, tries=tries).gaze[10] == pytest.approx(np.array([[0, -1], [0, 0]]))
    # North is up, and so is a pupil that looks there.
    assert [numbers(move)[1] < 0 for move in face_moves(np.array([0.0, 1.0]))] == [True, True]


def test_between_frames_everybody_is_between():
    one = performance(spec=DUET)
    places, gaze = one.at(4.25)
    assert places == pytest.approx(0.75 * one.positions[4] + 0.25 * one.positions[5])
    assert gaze == pytest.approx(0.75 * one.gaze[4] + 0.25 * one.gaze[5])
    assert one.at(999)[0] == pytest.approx(one.positions[80])
    way = one.way(1, 2.5, 5)
    assert way == pytest.approx(np.array([one.at(t)[0][1] for t in (2.5, 3, 4, 5)]))
    assert one.way(0, 0, 0) == pytest.approx(one.positions[[0, 0], 0])


@pytest.mark.parametrize(("frames", "low", "high"), [(100, 6, 8), (10, 2.4, 3), (800, 20, 25)])
def test_films_last_comfortably_long(frames, low, high):
    assert low <= frames * frame_seconds([performance(frames=frames)]) <= high


@pytest.mark.parametrize("frames", [0, 1, 5, 80])
def test_key_frames_are_in_order_with_both_ends(frames):
    chosen = key_frames(performance(frames=frames), 6)
    assert chosen == sorted(set(chosen))
    assert (chosen[0], chosen[-1]) == (0, frames)
    assert len(chosen) <= min(6, frames + 1)


def test_key_frames_show_beliefs_turns_and_meetings():
    one = performance()
    jump = np.where(np.arange(81) < 31, 0.1, 0.9)
    panel = Panel("goal", "probability", (Series("a", jump, "#000000"),))
    moving = replace(one, leading=panel, panels=(panel,))
    assert min(abs(t - 31) for t in key_frames(moving, 5)) <= 1
    turning = one.positions.copy()
    turning[:, 0] = [(2 + 0.1 * min(t, 50), 1 + 0.1 * max(t - 50, 0)) for t in range(81)]
    chosen = key_frames(replace(one, positions=turning, panels=(), leading=None), 4)
    assert min(abs(t - 51) for t in chosen) <= 8
    meeting = performance(spec=DUET).positions.copy()
    meeting[:, 0] = np.linspace((2, 1), (10, 1), 81)
    meeting[:, 1] = (6.0, 1.0)
    pair = replace(performance(spec=DUET), positions=meeting, panels=(), leading=None)
    touched = next(t for t in range(81) if 6.0 - meeting[t, 0, 0] < 1.1 * 0.8)
    assert pair.contacts == [touched]
    assert touched in key_frames(pair, 3)


# ------------------------------------------------------------------------------------------ names


def test_how_much_of_a_segment_lies_in_a_box():
    rng = np.random.default_rng(0)
    segments = rng.uniform(-3, 3, (60, 2, 2))
    segments[:10, 1, 0] = segments[:10, 0, 0]  # upright ones
    segments[10:20, 1, 1] = segments[10:20, 0, 1]  # level ones
    share = np.linspace(0, 1, 20001)[:, None, None]
    points = segments[:, 0] * (1 - share) + segments[:, 1] * share
    inside = ((points > (-1, -0.5)) & (points < (1.5, 1))).all(axis=-1).mean(axis=0)
    lengths = np.hypot(*(segments[:, 1] - segments[:, 0]).T)
    found = lengths_inside(segments, -1, -0.5, 1.5, 1)
    assert found == pytest.approx(inside * lengths, abs=1e-3)
    assert (found > 0).sum() > 10


def test_names_keep_clear_of_each_other_and_of_walls():
    rng = np.random.default_rng(3)
    nothing = np.zeros((0, 2, 2))
    for _ in range(8):
        middles = rng.uniform((30, 30), (370, 270), (9, 2))
        tags = [Tag(x, y, 10, rng.uniform(25, 70), 16) for x, y in middles]
        wall = np.array([[[200.0, 0.0], [200.0, 300.0]]])
        spots = np.column_stack([middles, np.full(9, 10.0)])
        obstacles = Obstacles((0, 0, 400, 300), wall, spots, nothing.reshape(-1, 2))
        places = placed(tags, obstacles)
        boxes = [
            (x - t.width / 2, y - t.height / 2, x + t.width / 2, y + t.height / 2)
            for t, (x, y) in zip(tags, places, strict=True)
        ]
        for a, b in combinations(boxes, 2):
            assert a[2] <= b[0] or b[2] <= a[0] or a[3] <= b[1] or b[3] <= a[1]
        for left, top, right, bottom in boxes:
            assert not lengths_inside(wall, left, top, right, bottom).any()
            assert left >= 0
            assert top >= 0
            assert right <= 400
            assert bottom <= 300
        ways = np.hypot(*(np.array(places) - middles).T)
        assert (ways < [t.width / 2 + 80 for t in tags]).all()


def test_a_lone_name_stands_below():
    free = Obstacles((0, 0, 400, 300), np.zeros((0, 2, 2)), np.zeros((0, 3)), np.zeros((0, 2)))
    assert placed([Tag(100, 100, 20, 50, 16)], free) == [pytest.approx((100, 131))]


def test_a_name_is_nearest_to_what_it_names():
    """Two spots near each other, and a name that is too wide to stand between them."""
    free = Obstacles((0, 0, 400, 300), np.zeros((0, 2, 2)), np.zeros((0, 3)), np.zeros((0, 2)))
    tags = [Tag(180, 150, 12, 90, 16), Tag(215, 150, 12, 90, 16)]
    places = placed(tags, free)
    for number, place in enumerate(places):
        own, other = (gap(tags[number], place, tags[k]) for k in (number, 1 - number))
        assert own < other


def test_a_name_that_stands_apart_has_a_line_to_its_place():
    """Ten places in a row, so near each other that not all names have room at their own."""
    row = tuple(Place(f"a_long_name_{k}", (3 + 0.7 * k, 4), 0.3) for k in range(10))
    spec = replace(ROOM, walls=(), places=row)
    view = stage_within(spec, 640, 460).view
    still = performance(spec=spec, frames=0)
    drawn = ET.fromstring(svg_document(view, names_svg(view, place_names(view), [still])))
    middles = view.pixels(np.array([place.at for place in row]))
    lines = [numbers(line.get("d")) for line in drawn.iterfind(f".//{SVG}path[@class='leader']")]
    assert lines
    for x0, y0, x1, y1 in lines:
        # It begins at the edge of a place, and ends within a tag.
        assert np.hypot(*(middles - (x0, y0)).T).min() == pytest.approx(0.3 * view.scale, abs=0.1)
        assert any(a <= x1 <= c and b <= y1 <= d for a, b, c, d in boxes_of(drawn))


def boxes_of(drawn):
    """The rectangles of names: left, top, right, bottom."""
    found = []
    for rect in drawn.iterfind(f".//{SVG}g[@class='name']/{SVG}rect"):
        x, y, w, h = (float(rect.get(key)) for key in ("x", "y", "width", "height"))
        found.append((x, y, x + w, y + h))
    return found


@pytest.mark.parametrize("spec", [ROOM, DUET, CROWD])
def test_names_in_a_room_can_be_read(spec):
    stage = stage_within(spec, 640, 460)
    drawn = ET.fromstring(svg_document(stage.view, stage.still([performance(spec=spec)])))
    boxes = boxes_of(drawn)
    assert len(boxes) == len(spec.places)
    walls = stage.view.pixels(np.array(spec.segments))
    for a, b in combinations(boxes, 2):
        assert a[2] <= b[0] or b[2] <= a[0] or a[3] <= b[1] or b[3] <= a[1]
    for left, top, right, bottom in boxes:
        assert not lengths_inside(walls, left, top, right, bottom).any()
        assert -stage.view.margin <= left
        assert right <= stage.view.width - stage.view.margin


# ----------------------------------------------------------------------------------------- trails


def test_a_trail_covers_its_time_and_fades():
    pieces = trail_pieces(3.5, 20.25, 4, 30, 0)
    assert [p.first for p in pieces] == [3.5, 4, 8, 12, 16, 20]
    assert [p.last for p in pieces] == [4, 8, 12, 16, 20, 20.25]
    strengths = [p.strength for p in pieces]
    assert strengths == sorted(strengths)
    assert strengths[-1] == 1
    assert trail_pieces(5, 5, 4, 30, 0) == []


def test_dashes_stay_where_they_are_while_a_trail_grows():
    early, late = trail_pieces(0, 40, 4, 30, 1), trail_pieces(7, 47, 4, 30, 1)
    shared = {(p.first, p.last) for p in early} & {(p.first, p.last) for p in late}
    assert len(shared) == 8
    assert all(b - a == pytest.approx(4 * DASH) for a, b in shared)


# ------------------------------------------------------------------------------------------ comics


def figures_of(panel, characters):
    """The middles of the cast in a panel's own pixels: they are drawn last."""
    drawn = [numbers(g.get("transform"))[:2] for g in panel.iterfind(f".//{SVG}g[@class='figure']")]
    return np.array(drawn[-characters:])


@pytest.mark.parametrize("spec", [ROOM, DUET])
def test_each_panel_shows_its_frame(spec):
    one, frames = performance(spec=spec), [0, 20, 45, 80]
    drawn = ET.fromstring(comic_svg(one, frames, f"title {ODD}"))
    panels = drawn.findall(f"./{SVG}g[@class='panel']")
    assert len(panels) == 4
    view = view_within(spec, 300, 250)
    for frame, panel in zip(frames, panels, strict=True):
        seen = figures_of(panel, len(spec.characters))
        assert seen == pytest.approx(view.pixels(one.positions[frame]), abs=0.01)
        assert one.captions[frame].split(" (")[0] in "".join(panel.itertext())
    texts = list(drawn.itertext())
    assert f"title {ODD}" in texts
    assert {"start", "20", "45", "80", "all", "the whole way, 80 frames"} <= set(texts)
    whole = drawn.find(f"./{SVG}g[@class='whole']")
    # Only moments that are neither the beginning nor the end are numbered on the way.
    told = [t for t in whole.itertext() if t.isdigit()]
    assert sorted(told) == sorted(["20", "45"] * len(spec.characters))


def test_the_room_is_drawn_where_it_is():
    view = View(ROOM, 20.0)
    assert view.pixels(np.array([[0, 0], [12, 8], [3, 2]])).tolist() == [
        [0, 160], [240, 0], [60, 120],
    ]  # fmt: skip
    drawn = ET.fromstring(svg_document(view, stage_within(ROOM, 260, 400).still([performance()])))
    circles = {(c.get("cx"), c.get("cy")) for c in drawn.iterfind(f".//{SVG}circle")}
    scale = stage_within(ROOM, 260, 400).view.scale
    for place in ROOM.places:
        x, y = place.at
        assert (f"{scale * x:.1f}", f"{scale * (8 - y):.1f}") in circles


def test_any_name_stays_text():
    odd = replace(
        DUET,
        places=(Place(ODD, (10.5, 1.2)), Place("]]>", (2, 6))),
        characters=tuple(replace(c, name=f"{c.name}{ODD}") for c in DUET.characters),
    )
    one = performance(ODD, spec=odd, windows=(Window(10, 30, ODD),))
    for drawn in (comic_svg(one, [0, 20, 80], ODD), together_svg([one, one], ODD)):
        texts = list(ET.fromstring(drawn).itertext())
        assert texts.count(ODD) >= 3
        assert f"mover{ODD}" in texts


@pytest.mark.parametrize(
    ("width", "height"), [(30.0, 2.0), (2.0, 20.0), (1.0, 1.0), (300.0, 200.0)]
)
def test_rooms_of_any_shape_lie_inside_their_picture(width, height):
    spec = replace(ROOM, width=width, height=height, walls=(), places=(
        Place("a", (0.1 * width, 0.1 * height), 0.05 * min(width, height)),
        Place("b", (0.9 * width, 0.9 * height), 0.05 * min(width, height)),
    ))  # fmt: skip
    corners = np.array([(0.05, 0.05), (0.95, 0.95)]) * (width, height)
    share = np.linspace(0, 1, 31)[:, None, None]
    one = replace(
        performance(frames=30), spec=spec, positions=corners[0] * (1 - share) + corners[1] * share
    )
    drawn = ET.fromstring(comic_svg(one, [0, 10, 30], "T"))
    whole = [float(drawn.get(side)) for side in ("width", "height")]
    for panel in (g for g in drawn if g.get("class") in ("panel", "whole")):
        at = numbers(panel.get("transform"))
        inner = panel.find(f"./{SVG}svg")
        for start, side, end in zip(at, ("width", "height"), whole, strict=True):
            assert start + float(inner.get(side)) < end
    assert max(whole) < 2000


def test_together_shows_each_performance_at_the_same_moments():
    pair = [performance("long"), performance("short", 40)]
    drawn = ET.fromstring(together_svg(pair, "T", 3))
    panels = drawn.findall(f"./{SVG}g[@class='panel']")
    assert len(panels) == 6
    texts = list(drawn.itertext())
    assert {"long", "short", "start", "80", "40"} <= set(texts)
    scale = view_within(ROOM, 300, 250)
    ends = [figures_of(panel, 1)[0] for panel in panels]
    for end, (one, frame) in zip(ends, [(p, t) for p in pair for t in (0, 40, 80)], strict=True):
        place = one.positions[min(frame, one.frames), 0]
        assert end == pytest.approx(scale.pixels(place), abs=0.01)


# ------------------------------------------------------------------------------------------- films


def test_films_show_what_the_scene_shows():
    one = performance(spec=DUET)
    times = (0, 12.5, 80)
    for time, frame in zip(times, film_frames([one], times, 500, "T"), strict=True):
        stage = stage_within(DUET, 500, 360)
        content = stage.still([one]) + film_svg(one, stage.view, time)
        left = stage.left - (500 - stage.width) / 2
        whole = svg_rgba(
            f'<svg xmlns="http://www.w3.org/2000/svg" width="500" height="{int(stage.height)}" '
            f'viewBox="{left:.3f} {-stage.view.margin:.3f} 500 {int(stage.height)}">{content}</svg>'
        )
        inside = whole[..., 3] == 255
        part = frame[: whole.shape[0]][inside].astype(int)
        assert inside.mean() > 0.9
        assert abs(part - whole[..., :3][inside]).max() <= 3


def test_a_film_of_several_is_as_wide_as_asked_and_rests_after_the_end():
    pair = [performance("a", 60), performance("b", 20)]
    frames = [f.copy() for f in film_frames(pair, [0, 20, 40, 60], 640, "T")]
    assert all(f.shape == frames[0].shape and f.shape[1] == 640 for f in frames)
    assert frames[0].shape[0] % 2 == 0
    stage = int(stage_within(ROOM, 317, 400).height) - 2
    assert (frames[2][:stage, 330:] == frames[3][:stage, 330:]).all()
    assert (frames[2][:stage, :310] != frames[3][:stage, :310]).any()
    assert [(m[0], len(m[2])) for m in meters(pair)] == [("a: lamp", 61), ("b: lamp", 61)]


def test_windows_are_signed_in_the_film():
    plain, marked = (
        next(film_frames([performance(windows=windows)], [15], 480, "T"))
        for windows in ((), (Window(10, 20, "dip"),))
    )
    assert (plain[8:26, 8:40] != marked[8:26, 8:40]).any()


def test_a_gif_keeps_its_time(tmp_path):
    PlanePictures([performance(frames=50)], "T").save_film(tmp_path / "a.gif", width=200)
    with Image.open(tmp_path / "a.gif") as image:
        assert image.n_frames == round((0.7 + 50 * 0.07 + 1.5) * 20)
        assert image.info["duration"] == 50


def test_old_trails_fade_from_a_film():
    one = performance()
    view = stage_within(ROOM, 400, 300).view
    drawn = ET.fromstring(svg_document(view, film_svg(one, view, 70)))
    pieces = [p for p in drawn.iterfind(f"./{SVG}path") if p.get("stroke-opacity")]
    way, *trail = pieces
    assert numbers(way.get("d"))[:2] == pytest.approx(view.pixels(one.positions[0, 0]), abs=0.05)
    begin = view.pixels(one.at(70 - TRAIL)[0][0])
    assert numbers(trail[0].get("d"))[:2] == pytest.approx(begin, abs=0.05)
    opacity = [float(p.get("stroke-opacity")) for p in trail]
    assert opacity == sorted(opacity)


# --------------------------------------------------------------------------------------- all files


def test_all_pictures_of_one(tmp_path):
    seen = []
    one = performance(frames=12, spec=DUET, windows=(Window(3, 6, "w"),))
    pictures = PlanePictures([one], "A\ttitle")
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
    assert pictures.title == "A title"


def test_all_pictures_of_several(tmp_path):
    pictures = PlanePictures([performance("a", 12), performance("b", 6)])
    files = pictures.save(tmp_path, ("png", "html"))
    assert [path.name for path in files.values()] == ["together.png", "mind.png", "together.html"]
    with pytest.raises(ValueError, match="no performance"):
        PlanePictures([])


def test_no_curves_no_figure_of_them_and_no_frames_can_be_drawn(tmp_path):
    bare = replace(performance(frames=0), panels=(), leading=None)
    files = PlanePictures([bare]).save(tmp_path, ("png", "html", "gif"))
    assert list(files) == ["comic.png", "html", "gif"]


def test_compared_curves_pair_what_has_the_same_name():
    found = compared([performance("a"), performance("b", 20)])
    assert [p.title for p in found] == [
        "mover's goal: lamp", "mover's goal: chair", "mover's goal: none", "expected value",
    ]  # fmt: skip
    assert all([s.label for s in p.series] == ["a", "b"] for p in found)
    assert np.isnan(found[0].series[1].values[21:]).all()


def test_of_two_curves_that_say_the_same_one_is_compared():
    rising = np.linspace(0, 1, 81)

    def told(second):
        series = (Series("a", rising, "#000000"), Series("b", second, "#000000"))
        one = replace(performance(), panels=(Panel("p", "probability", series),))
        return [panel.title for panel in compared([one, one])]

    assert told(1 - rising) == ["p: a"]
    assert told(rising) == ["p: a", "p: b"]


# ---------------------------------------------------------------------------------- in characters


def test_a_plane_in_characters_has_everybody_in_its_place():
    state = np.array([2.0, 1.0, 10.0, 6.5, 0, 0, 0, 0])
    told = plane_in_characters(DUET, state, Ink(False, False, 80)).split("\n")
    *lines, legend = told
    assert legend.strip() == "M mover (2.0, 1.0)  C chaser (10.0, 6.5)  l lamp  c chair"
    wide, high = len(lines[0]) - 4, len(lines)
    for letter, (x, y) in (("M", (2, 1)), ("C", (10, 6.5)), ("l", (10.5, 1.2)), ("c", (1.2, 6.6))):
        row = next(k for k, line in enumerate(lines) if letter in line)
        assert row == pytest.approx((8 - y) / 8 * (high - 1), abs=1)
        assert lines[row].index(letter) - 4 == pytest.approx(x / 12 * (wide - 1), abs=1)
    door = round((8 - 4) / 8 * (high - 1))
    middle = 4 + round((wide - 1) / 2)
    assert lines[2][middle] == "%"
    assert lines[door][middle] == " "


@pytest.mark.parametrize(("width", "height"), [(30.0, 2.0), (2.0, 30.0), (12.0, 8.0)])
@pytest.mark.parametrize("columns", [20, 80, 200])
def test_planes_fit_the_terminal(width, height, columns):
    spec = replace(ROOM, width=width, height=height, walls=(), places=())
    told = plane_in_characters(spec, np.array([1.0, 1.0, 0, 0]), Ink(True, True, columns))
    lines = re.sub(r"\x1b\[[\d;]*m", "", told).split("\n")
    assert len(lines) <= 25
    assert max(map(len, lines[:-1])) <= max(columns, 26)


def test_letters_tell_those_of_one_first_letter_apart():
    spec = replace(ROOM, places=tuple(Place(n, (x, 2)) for n, x in (("bed", 2), ("bench", 5))))
    told = plane_in_characters(spec, np.array([1.0, 1.0, 0, 0]), Ink(False, False, 80))
    assert told.endswith("M mover (1.0, 1.0)  b bed  e bench")


def test_other_rooms_are_not_drawn_side_by_side():
    from types import SimpleNamespace

    from i2pdsl.render.plane.drawing import DRAWING

    scripts = [
        SimpleNamespace(
            world=SimpleNamespace(spec=replace(ROOM, name=name)),
            record=SimpleNamespace(where="script.json"),
        )
        for name in ("room", "hall")
    ]
    with pytest.raises(StoryError, match="of one plane"):
        DRAWING.pictures(scripts)


@pytest.mark.parametrize("size", [(640, 360), (240, 480)])
def test_films_of_a_size_without_a_meter(size: tuple[int, int]) -> None:
    pictures = PlanePictures([performance(frames=10)], "T")
    pictures.look = FilmLook(meter=False, size=size)
    wide = pictures.fitting(*size)
    plain = next(pictures.film_frames([5.0], wide)).copy()
    frame = next(padded(pictures.film_frames([5.0], wide), size))
    assert frame.shape == (size[1], size[0], 3)
    top, left = (size[1] - plain.shape[0]) // 2, (size[0] - plain.shape[1]) // 2
    assert min(top, left) <= 3, "the scene is as large as fits"
    assert (frame[top : top + plain.shape[0], left : left + wide] == plain).all()
    pictures.look = FilmLook()
    assert next(pictures.film_frames([5.0], wide)).shape[0] > plain.shape[0] + 40
