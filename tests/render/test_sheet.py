"""Candidates side by side: the command, the picture and the page."""

import json
import re
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

from commands_for_tests import Run
from i2pdsl.render.grid.pictures import GridPictures
from i2pdsl.render.grid.sheet import GridSheet, stacked
from i2pdsl.scripts import Script

STORY = """world fork
length 5
maximize sum_t P(G_robot = left | script[:t])
"""


@pytest.fixture
def made(tmp_path, i2p: Run):
    """The document of `i2p sheet`, and its folder."""
    (tmp_path / "left.story").write_text(STORY)
    done = i2p(
        *("sheet", tmp_path / "left.story", "--candidates", "3", "--out", tmp_path / "out"),
        "--json",
    )
    assert done.status == 0, done.err
    return json.loads(done.out), tmp_path


def numbers(text):
    return [float(x) for x in re.findall(r"-?\d+(?:\.\d+)?", text)]


def test_all_candidates_are_in_the_picture_and_on_the_page(made, i2p, open_page):
    document, folder = made
    out = folder / "out"
    assert document["files"] == {"png": f"{out}/sheet.png", "html": f"{out}/sheet.html"}
    candidates = document["candidates"]
    assert len(candidates) == 3
    run = json.loads(
        i2p(
            *("run", folder / "left.story", "--candidates", "3", "--out", folder / "run"),
            *("--format", "svg", "--json"),
        ).out
    )
    for ours, theirs in zip(candidates, run["candidates"], strict=True):
        assert ours["score"] == theirs["score"]
        assert ours["panel"] == theirs["panel"]
    with Image.open(out / "sheet.png") as picture:
        assert picture.width > picture.height > 400

    page = (out / "sheet.html").read_text()
    ids = re.findall(r'<(?:svg|g|p|div|input|symbol)[^>]* id="([^"]+)"', page)
    assert {"actors-0", "actors-1", "actors-2"} <= set(ids)
    assert len(ids) == len(set(ids))
    # They play together: each frame lasts as long as any of them needs, as in films.
    scripts = [Script.load(told["script"]) for told in candidates]
    clocks = [GridPictures(script).clock for script in scripts]
    clock = json.loads(re.search(r'id="film-data">(.*?)</script>', page, re.S)[1])
    for number, each in enumerate(("seconds", "rests")):
        longest = np.max([one[number] for one in clocks], axis=0)
        assert clock[each] == pytest.approx(longest, abs=1e-4)
    shown = open_page(page)
    labels = shown.locator(".show .label").all_inner_texts()
    for label, told in zip(labels, candidates, strict=True):
        panel = told["panel"]
        expected = [told["score"], panel["mean"], panel["worst"]]
        assert numbers(label)[1:] == pytest.approx(expected, rel=1e-3)
    # At the end of each frame all of them stand where their scripts say.
    for t in range(1, 6):
        shown.locator("#forward").click()
        for number, script in enumerate(scripts):
            robot = shown.locator(f"#actors-{number} [data-actor=robot]")
            x, y = numbers(robot.get_attribute("transform"))[:2]
            here = [x / 100 - 0.5, y / 100 - 0.94]
            assert here == pytest.approx(script.record.frames[t - 1]["state"]["robot"], abs=1e-6)


def test_a_row_for_each_and_one_explanation(made):
    document, _ = made
    scripts = [Script.load(told["script"]) for told in document["candidates"]]
    drawing = GridSheet(scripts, "left & <right>").comic()
    root = ElementTree.fromstring(drawing)
    rows = [child for child in root if child.tag.endswith("svg")]
    assert len(rows) == 3
    ends = [float(row.get("y")) + float(row.get("height")) for row in rows]
    assert [float(row.get("y")) for row in rows[1:]] == pytest.approx(ends[:-1])
    assert ends[-1] == pytest.approx(float(root.get("height")))
    assert drawing.count("own steps") == 1
    assert "left &amp; &lt;right&gt;" in drawing


def test_the_widest_drawing_fits():
    svg = '<svg xmlns="http://www.w3.org/2000/svg" width="{}" height="50" viewBox="0 0 9 9"></svg>'
    root = ElementTree.fromstring(stacked([svg.format(120), svg.format(300.5)], "two"))
    assert float(root.get("width")) == 300.5


def test_mistakes_are_said(tmp_path, i2p: Run):
    (tmp_path / "wrong.story").write_text("world fork\nlength 4\nmaximise T\n")
    wrong = i2p("sheet", tmp_path / "wrong.story")
    assert wrong.status == 1
    assert "wrong.story:3:1" in wrong.err
    assert i2p("sheet", tmp_path / "wrong.story", "--candidates", "0").status == 2
    missing = i2p("sheet", tmp_path / "missing.story")
    assert missing.status == 1
    assert "missing.story" in missing.err
