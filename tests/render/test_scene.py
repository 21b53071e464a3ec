"""Scenes are well-formed SVG whose pixels show what they should."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest

from i2pdsl.render.grid.choreography import choreograph
from i2pdsl.render.grid.scene import MARGIN, labels_svg, scene_svg, stage_background, svg_document
from i2pdsl.render.grid.sprites import actor_symbols, symbol_id
from i2pdsl.render.grid.stage import Actor, Stage, Tile
from i2pdsl.render.grid.tracks import POSES
from i2pdsl.render.ink import mix
from i2pdsl.render.raster import atomic_path, composite, save_png, save_svg, svg_rgba
from i2pdsl.worlds.drawings import builtin_sprites

SVG = "{http://www.w3.org/2000/svg}"
CAST = (Actor("cheese", "cheese"), Actor("robot", "robot"), Actor("table", "table", "", "object"))
STAGE = Stage("kitchen", ("..#.", "...."), (Tile("pink & <co>", (0, 1), "hotpink"),), CAST)
SCRIPT = {
    "start": {"cheese": [2, 1], "robot": [3, 1], "table": None},
    "frames": [
        {"cheese": {"action": "west", "moved": False}, "robot": {"action": "west", "moved": True},
         "event": None, "state": {"cheese": [1, 1], "robot": [2, 1], "table": None}},
        {"event": {"deus": "table", "to": [0, 0]},
         "state": {"cheese": [1, 1], "robot": [2, 1], "table": [0, 0]}},
    ],
}  # fmt: skip
FILM = choreograph(STAGE, SCRIPT)


@pytest.mark.parametrize("time", [0, 0.3, 0.8, 1.3, 1.55, 2])
def test_scenes_are_well_formed_and_define_what_they_use(time):
    root = ET.fromstring(scene_svg(STAGE, FILM, time))
    ids = [element.get("id") for element in root.iter() if element.get("id")]
    assert len(ids) == len(set(ids))
    uses = {element.get("href") for element in root.iter(f"{SVG}use")}
    assert uses <= {f"#{name}" for name in ids}
    assert "pink & <co>" in [element.text for element in root.iter(f"{SVG}text")]


def pixels_of(stage, time, name):
    """How many pixels of a scene one of the cast changes."""
    cast = tuple(actor for actor in stage.cast if actor.name != name)
    without = Stage(stage.name, stage.rows, stage.tiles, cast, stage.floor, stage.wall)
    both = (svg_rgba(scene_svg(s, FILM, time, 40)).astype(int) for s in (stage, without))
    a, b = both
    return int((abs(a - b).max(axis=2) > 40).sum())


def test_the_cast_is_seen_where_and_when_it_is_there():
    assert pixels_of(STAGE, 0, "cheese") > 400
    assert pixels_of(STAGE, 0, "robot") > 400
    assert pixels_of(STAGE, 0, "table") == 0
    assert pixels_of(STAGE, 2, "table") > 400


def test_text_is_drawn_without_system_fonts():
    tile = Stage("x", ("..",), (Tile("MMM", (0, 0), "#aaaaaa"),), ())
    bare = Stage("x", ("..",), (Tile("", (0, 0), "#aaaaaa"),), ())
    pictures = [
        svg_rgba(svg_document(s, 80, stage_background(s, 80) + labels_svg(s, 80)))[..., :3]
        for s in (tile, bare)
    ]
    dark = [int((p.max(axis=2) < 100).sum()) for p in pictures]
    assert dark[0] > dark[1] + 50


@pytest.mark.parametrize("rows", [("...", ".#.", "..."), ("......",), (".",), ("." * 20,) * 20])
def test_maps_of_all_sizes(rows):
    stage = Stage("map", rows, (Tile("a very long name of a tile", (0, 0), "#3366cc"),), ())
    picture = svg_rgba(svg_document(stage, 20, stage_background(stage, 20)))
    assert picture.shape[1] == pytest.approx((len(rows[0]) + 2 * MARGIN) * 20, abs=1)
    assert picture[..., 3].min() == 255
    assert len(np.unique(picture.reshape(-1, 4), axis=0)) > 5


@pytest.mark.parametrize("sprite", [*builtin_sprites(), "no-such-sprite", "../../../etc/passwd"])
def test_every_sprite_has_every_pose_and_takes_a_tint(sprite):
    actor = Actor("Zoë #1", sprite, "rebeccapurple")
    root = ET.fromstring(f'<svg xmlns="{SVG[1:-1]}">{actor_symbols(actor)}</svg>')
    symbols = {s.get("id"): s for s in root.iter(f"{SVG}symbol")}
    assert set(symbols) == {symbol_id(actor, pose) for pose in POSES}
    markup = ET.tostring(root, encoding="unicode")
    assert mix("rebeccapurple", "white", 0) in markup
    assert "TINT" not in markup
    assert "data-" not in markup


def test_faces_differ_between_poses_and_look_where_they_go():
    def face(sprite, pose):
        markup = actor_symbols(Actor("a", sprite), (pose,))
        body = f'<svg xmlns="{SVG[1:-1]}" width="100" height="100"><defs>{markup}</defs>'
        return svg_rgba(body + f'<use href="#a--{pose}"/></svg>')

    for sprite in ("robot", "cheese", "blob"):
        poses = ("idle", "walk-east", "walk-west", "push-east", "try-east", "bump-east", "sad",
                 "happy", "surprised")  # fmt: skip
        faces = [face(sprite, pose) for pose in poses]
        for i, a in enumerate(faces):
            assert all((a != b).any() for b in faces[i + 1 :]), poses[i]


def test_cast_can_be_told_apart_in_grey():
    def grey(sprite):
        markup = actor_symbols(Actor("a", sprite), ("idle",))
        body = f'<svg xmlns="{SVG[1:-1]}" width="40" height="40" viewBox="0 0 100 100">'
        body += f'<rect width="100" height="100" fill="#f3e3c7"/><defs>{markup}</defs>'
        return svg_rgba(body + '<use href="#a--idle"/></svg>')[..., :3].mean(axis=2)

    greys = {name: grey(name) for name in ("robot", "cheese", "table")}
    for a, b in (("robot", "cheese"), ("robot", "table"), ("cheese", "table")):
        assert (abs(greys[a] - greys[b]) > 60).mean() > 0.15


def test_composite():
    below = np.full((1, 3, 3), 200, np.uint8)
    above = np.asarray([[[0, 0, 0, 0], [10, 20, 30, 255], [100, 0, 200, 128]]], np.uint8)
    assert composite(below, above).tolist() == [[[200] * 3, [10, 20, 30], [150, 100, 200]]]


def test_files_are_written_whole_or_not_at_all(tmp_path):
    save_svg(tmp_path / "a.svg", scene_svg(STAGE, FILM, 0))
    save_png(tmp_path / "a.png", scene_svg(STAGE, FILM, 0), zoom=2)
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    with pytest.raises(ValueError, match="root node"):
        save_png(tmp_path / "b.png", "<svg")

    def fail():
        with atomic_path(tmp_path / "a.svg") as temporary:
            temporary.write_text("half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fail()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.png", "a.svg"]
    assert (tmp_path / "a.svg").read_text(encoding="utf-8") == scene_svg(STAGE, FILM, 0)
