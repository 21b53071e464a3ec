"""Own sprites: what is kept of a file that anyone may have drawn, and how it is shown."""

from __future__ import annotations

import io
import json
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from PIL import Image

from i2pdsl.errors import Source, StoryError
from i2pdsl.render.grid.pictures import stage_of
from i2pdsl.render.grid.scene import stage_background, svg_document
from i2pdsl.render.grid.sprites import actor_symbols
from i2pdsl.render.grid.stage import Actor
from i2pdsl.render.raster import svg_rgba
from i2pdsl.scripts import make_record, script_from
from i2pdsl.untrusted import WrongData
from i2pdsl.worlds.drawings import as_svg, beside, builtin_sprites, kept_drawing, within
from i2pdsl.worlds.find import find_spec
from i2pdsl.worlds.grid.kind import KIND
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.record import empty, extended, parse_record

HEAD = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 40 20"'
LINK = 'xmlns:xlink="http://www.w3.org/1999/xlink"'
RED = '<rect width="40" height="20" style="fill:#ff0000;-inkscape-x:1"/>'
DUCK = (
    f'{HEAD} xmlns:i="http://example.org/i" data-faces="east"><!-- x --><metadata>m</metadata>'
    '<defs><linearGradient id="a"><stop offset="0" stop-color="#00f"/></linearGradient></defs>'
    f'<g id="layer" i:label="l" class="c">{RED}'
    '<circle cx="35" cy="5" r="4" fill="url(#a)"/></g></svg>'
)
WORLD = """map
    P..
    #..
tile pond
    symbol = P
    sprite = "{tile}"
character duck
    goals = {{pond}}
    sprite = "{sprite}"
drawing
    wall_sprite = "{wall}"
"""


def svg(inside: str, more: str = "") -> bytes:
    return f"{HEAD} {more}>{RED}{inside}</svg>".encode()


def png(size: tuple[int, int] = (30, 20), color: str = "#00ff00", **more: object) -> bytes:
    made = io.BytesIO()
    Image.new("RGBA", size, color).save(made, "PNG", **more)
    return made.getvalue()


def world(sprite: str, tile: str = "pond", wall: str = "tree") -> Source:
    return Source("w.world", WORLD.format(sprite=sprite, tile=tile, wall=wall))


REFUSED = {
    "script": svg("<script>alert(1)</script>"),
    "event": svg('<rect width="1" height="1" onclick="alert(1)"/>'),
    "event on the root": svg("", 'onload="alert(1)"'),
    "style": svg("<style>@import url(http://example.org/a.css);</style>"),
    "image": svg('<image href="http://example.org/a.png" width="9" height="9"/>'),
    "use": svg('<use href="other.svg#a"/>'),
    "foreign": svg("<foreignObject><b xmlns='http://www.w3.org/1999/xhtml'/></foreignObject>"),
    "link": svg(f'<linearGradient {LINK} xlink:href="http://example.org/#a" id="a"/>'),
    "paint": svg('<rect width="1" height="1" fill="url(http://example.org/#a)"/>'),
    "paint in a style": svg('<rect width="1" height="1" style="fill: URL(x.svg#a)"/>'),
    "animation": svg('<animate attributeName="x" to="9"/>'),
    "nothing to refer to": svg('<rect width="1" height="1" fill="url(#none)"/>'),
    "entities": b'<!DOCTYPE svg [<!ENTITY a "x">]>' + svg("&a;"),
    "no xml": b"\x89PNG",
    "no svg": b"<html/>",
    "no shapes": f"{HEAD}/>".encode(),
    "no size": b'<svg xmlns="http://www.w3.org/2000/svg"><rect/></svg>',
    "endless size": b'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 inf 1"><rect/></svg>',
    "too many": svg("<rect/>" * 3001),
    "too deep": svg("<g>" * 50 + "</g>" * 50),
    "far": svg('<circle r="1e30"/>'),
    "far by steps": svg(f'<path d="M0 0 {"l9999 0" * 99}"/>'),
    "far box": svg("").replace(b"0 0 40 20", b"1e9 0 40 20"),
    "moved far": svg('<g transform="translate(1e9)"/>'),
    "magnified": svg('<g transform="scale(9)"><g transform="matrix(9 0 0 9 0 0)"/></g>'),
    "skewed": svg('<g transform="skewX(89.9999)"/>'),
    "look": svg('<g data-look="1e9"/>'),
}


@pytest.mark.parametrize("wrong", REFUSED)
def test_what_is_refused(wrong: str) -> None:
    with pytest.raises(WrongData):
        kept_drawing("a.svg", REFUSED[wrong])


def test_what_is_kept_is_what_is_seen() -> None:
    kept = kept_drawing("duck.svg", DUCK.encode())
    names = {e.tag.rpartition("}")[2] for e in ET.fromstring(kept).iter()}
    assert names == {"svg", "defs", "linearGradient", "stop", "g", "rect", "circle"}
    assert not any(word in kept for word in ("label", "class", "layer", "inkscape", "example"))
    assert kept_drawing("duck.svg", kept.encode()) == kept, "what is kept is kept again"
    assert (svg_rgba(kept) == svg_rgba(DUCK)).all()


def test_pngs_lose_all_but_their_pixels() -> None:
    kept = kept_drawing("A.PNG", png((600, 300), dpi=(300, 300)))
    shown = as_svg("A.PNG", kept)
    assert 'viewBox="0 0 256 128"' in shown
    assert svg_rgba(shown)[64, 128].tolist() == [0, 255, 0, 255]
    for wrong in (b"", b"GIF89a", png()[:60], png((2049, 1)), svg("")):
        with pytest.raises(WrongData):
            kept_drawing("a.png", wrong)


def test_only_files_beside_the_world(tmp_path: Path) -> None:
    folder = tmp_path / "in"
    folder.mkdir()
    (folder / "duck.svg").write_text(DUCK)
    (tmp_path / "out.svg").write_text(DUCK)
    (folder / "link.svg").symlink_to(tmp_path / "out.svg")
    (folder / "large.svg").write_bytes(b" " * 200_001)
    (folder / "folder.svg").mkdir()
    files = beside(folder)
    assert parse_world(world("duck.svg"), "w", files).look.drawings
    wrong = ("../out.svg", str(folder / "duck.svg"), "link.svg", "large.svg", "folder.svg", ".svg",
             "none.svg")  # fmt: skip
    for name in wrong:
        with pytest.raises(StoryError) as problem:
            parse_world(world(name), "w", files)
        (found,) = problem.value.diagnostics
        assert (found.code, found.span.text) == ("world-sprite", f'"{name}"')


def test_unknown_sprites_are_mistakes_with_suggestions() -> None:
    with pytest.raises(StoryError) as problem:
        parse_world(world("duk", "pont", "tre"), "w")
    hints = [d.hint for d in problem.value.diagnostics]
    assert [h.split(";")[0] for h in hints if h] == [
        "did you mean `pond`?", "did you mean `duck`?", "did you mean `tree`?",
    ]  # fmt: skip
    assert {"dog", "duck", "cat", "child", "ghost", "ball", "cart", "pond", "nest", "door"} <= {
        *builtin_sprites()
    }


def test_a_drawing_that_faces_east_is_mirrored_westward() -> None:
    actor = Actor("a/1", "duck.svg", "#123456", drawing=kept_drawing("duck.svg", DUCK.encode()))

    def seen(pose: str, who: Actor = actor) -> object:
        symbols = actor_symbols(who, (pose,))
        ids = [e.get("id") for e in ET.fromstring(f"<g>{symbols}</g>").iter() if e.get("id")]
        assert len(ids) == len(set(ids))
        return svg_rgba(
            f'<svg xmlns="http://www.w3.org/2000/svg" width="100" height="100"><defs>{symbols}'
            f'</defs><use href="#a_2f1--{pose}"/></svg>'
        )

    east, west, idle = (seen(pose) for pose in ("walk-east", "push-west", "idle"))
    assert (east == idle).all()
    assert (east[:, 80] != west[:, 80]).any()
    assert abs(east[:, ::-1].astype(int) - west).max() < 40
    rows = east[..., 3].any(axis=1).nonzero()[0]
    assert rows[-1] == 93, "it stands where others do"
    # The blue of its own gradient, though its id is that of another's.
    assert east[55:70, 75:92, 2].max() == 255


def test_tiles_and_walls_are_drawn_as_sprites(tmp_path: Path) -> None:
    (tmp_path / "duck.svg").write_text(DUCK)
    (tmp_path / "hedge.png").write_bytes(png(color="#00ff00"))
    spec = parse_world(world("dog", "duck.svg", "hedge.png"), "w", beside(tmp_path))
    stage = stage_of(spec)
    seen = svg_rgba(svg_document(stage, 50, stage_background(stage, 50)))
    assert seen[21 + 25, 21 + 25, :3].tolist() == [255, 0, 0]
    assert seen[21 + 75, 21 + 25, :3].tolist() == [0, 255, 0]
    assert spec.planning_key == parse_world(world("dog"), "w").planning_key


def test_a_script_carries_its_drawings(tmp_path: Path) -> None:
    (tmp_path / "duck.svg").write_text(DUCK)
    source = world("duck.svg", "duck.svg", "duck.svg")
    (tmp_path / "w.world").write_text(source.text)
    spec = find_spec("w", tmp_path)
    made = KIND.rules(spec)
    path = extended(made, empty(made, made.starts()[0]), [4])
    text = json.dumps(make_record(made, path, {}, {}, None).as_json())
    record = parse_record(Source("sent/script.json", text))
    away = script_from(record, tmp_path / "elsewhere").world.spec
    assert away.look == spec.look
    harmful = text.replace("<defs>", "<script>x</script><defs>")
    with pytest.raises(StoryError, match="scripts"):
        script_from(parse_record(Source("s.json", harmful)), None)
    bare = json.loads(text)
    del bare["world"]["drawings"]
    alone = script_from(parse_record(Source("s.json", json.dumps(bare))), None).world.spec
    assert alone.look.drawings == (), "nothing beside a script is read"
    assert (stage_of(alone).tiles[0].sprite, stage_of(alone).wall_sprite) == ("", "")
    bare["world"]["drawings"] = {"duck.svg": 3}
    with pytest.raises(StoryError, match="drawings"):
        parse_record(Source("s.json", json.dumps(bare)))
    with pytest.raises(OSError, match="base64"):
        within({"a.png": "!"})("a.png")
