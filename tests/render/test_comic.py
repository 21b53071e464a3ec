"""Comics show the frames that matter, in panels that say what led to them."""

import re
import xml.etree.ElementTree as ET

import pytest

from i2pdsl.render.grid import comic
from i2pdsl.render.grid.comic import comic_svg
from i2pdsl.render.grid.scene import actor_svg, scene_size
from i2pdsl.render.grid.stage import Actor, Stage, Tile
from i2pdsl.render.grid.tracks import Key
from i2pdsl.render.raster import svg_rgba

SVG = "{http://www.w3.org/2000/svg}"


CAST = (Actor("cheese", "cheese"), Actor("robot", "robot"))
STAGE = Stage("kitchen", (".....", "..#.."), (Tile("pink", (0, 0), "#f08fb0"),), CAST)
SCRIPT = {
    "start": {"cheese": [2, 0], "robot": [4, 0]},
    "frames": [
        {"cheese": {"action": "west", "moved": False}, "robot": {"action": "west", "moved": True},
         "event": None, "state": {"cheese": [2, 0], "robot": [3, 0]}},
        {"cheese": {"action": "south", "moved": False}, "robot": {"action": "west", "moved": True},
         "event": None, "state": {"cheese": [1, 0], "robot": [2, 0]}},
    ],
}  # fmt: skip


def test_a_comic_has_a_panel_for_each_frame_with_number_and_caption():
    svg = comic_svg(STAGE, SCRIPT, [0, 1, 2], ["P(x < 0) = .1", "b", "c " * 300], "A & B")
    root = ET.fromstring(svg)
    words = [element.text for element in root.iter(f"{SVG}text")]
    for expected in ("A & B", "start", "1", "2", "P(x < 0) = .1", "b", "own steps", "pushed"):
        assert expected in words
    assert any(word.endswith("…") for word in words)
    assert len([u for u in root.iter(f"{SVG}use") if u.get("href") == "#room"]) == 3
    ids = [element.get("id") for element in root.iter() if element.get("id")]
    assert len(ids) == len(set(ids))


def test_own_and_pushed_steps_are_drawn_differently():
    stepped, pushed = (comic_svg(STAGE, SCRIPT, frames) for frames in ([0, 1], [0, 2]))
    assert pushed.count("stroke-dasharray") == stepped.count("stroke-dasharray") + 1


def test_pictures_are_not_blank():
    picture = svg_rgba(comic_svg(STAGE, SCRIPT, [0, 1, 2], title="x"))
    assert picture[..., 3].min() == 255
    assert (picture[..., :3].max(axis=2) < 100).mean() > 0.005
    with pytest.raises(ValueError, match="3 frames, but 1 captions"):
        comic_svg(STAGE, SCRIPT, [0, 1, 2], ["one"])


@pytest.mark.parametrize(
    "size", [(1, 1), (2, 1), (5, 2), (40, 40), (120, 5), (200, 1), (1, 200), (200, 200)]
)
@pytest.mark.parametrize("count", [1, 2, 8])
def test_comics_of_any_map_are_bounded(size, count):
    across, down = size
    stage = Stage("a", ("." * across,) * down, (), ())
    columns, cell = comic._fitted(stage, count, None)
    assert 1 <= columns <= comic.columns_of(count)
    width, height = scene_size(stage, cell)
    assert count * width * height <= 1.2 * comic.AREA
    assert height <= 1.02 * comic.TALLEST
    assert max(width, 180) * columns <= 1.1 * comic.WIDEST
    assert cell >= 4.5


def test_the_cast_is_seen_however_small_the_cells_are():
    key = Key(0, 1, 1)
    for cell in (2.0, 7.0, 16.0, 40.0):
        drawn = actor_svg(STAGE.cast[0], key, cell)
        scale = float(re.search(r"scale\(([\d.]+)", drawn)[1])
        assert scale * 100 == pytest.approx(max(cell, 16.0))


def test_who_is_who_is_told_where_the_drawings_do_not():
    script = {"start": {"ann": [0, 0], "bob": [1, 0]}, "frames": []}
    cast = (Actor("ann", "blob", "#7c9cc0"), Actor("bob", "blob", "#d98b4a"))
    told = comic_svg(Stage("a", ("...",), (), cast), script, [0])
    assert ">ann<" in told
    assert ">bob<" in told
    assert ">robot<" not in comic_svg(STAGE, SCRIPT, [0, 1])
