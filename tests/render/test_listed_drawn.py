"""How listed worlds are drawn where their kind says nothing else."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from alley_for_tests import in_the_table
from i2pdsl.errors import Source, StoryError
from i2pdsl.render.characters import Ink
from i2pdsl.render.pictures import drawing_for, pictures_of
from i2pdsl.render.raster import svg_png
from i2pdsl.scripts import Script
from i2pdsl.stories import story_from

STORY = """\
world "alley.world"
length 5
start at(bob, (0, 0)) and at(ann, (2, 0))
maximize sum_t P(G_ann = first | script[:t])
search naive
"""


@pytest.fixture(scope="module")
def script(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Script]:
    folder = tmp_path_factory.mktemp("alley")
    (folder / "alley.world").write_text("kind = alley\n", encoding="utf-8")
    with in_the_table():
        yield story_from(Source("al.story", STORY), folder).solve(seed=0).script


def test_a_strip_shows_every_frame(script: Script) -> None:
    """What is done above, and who stands where: side by side and smaller on one cell."""
    comic = pictures_of([script]).comic()
    told = re.findall(r">([^<>]+)</text>", comic)
    assert next(line for line in told if line[0].isdecimal()) == "0  the start"
    assert sum(line.startswith("bob: ") for line in told) == script.length
    assert {"A", "Bob", "Box"} <= set(told)
    cells = [dict(s) for s in (script.record.start, *(f["state"] for f in script.record.frames))]
    shared = sum(len({tuple(p) for p in state.values()}) < 3 for state in cells)
    assert shared
    small = re.findall(r"scale\((\S+)\)", comic.replace("scale(1)", ""))
    assert len(small) == 2 * shared
    assert svg_png(comic).startswith(b"\x89PNG")


def test_its_curves(script: Script) -> None:
    """Of each latent; whether somebody acts at random is asked without taking it for granted."""
    panels = {panel.title: panel for panel in pictures_of([script]).panels}
    assert set(panels) == {"G_ann", "rationality"}
    first, last = panels["G_ann"].series
    assert (first.label, last.label) == ("first", "last")
    assert np.allclose(first.values, script.query("P(G_ann = first | script[:t])"))
    (bob,) = panels["rationality"].series
    assert np.allclose(bob.values, script.query("P(R_bob | script[:t])", assume="nothing"))
    assert bob.values.min() < 1


def test_in_letters(script: Script) -> None:
    drawing = drawing_for(script.world.spec)
    drawn = drawing.in_characters(script.world, script.trajectory.start, Ink())
    assert drawn == "    BBA"
    with pytest.raises(StoryError, match="side by side"):
        drawing.pictures([script, script])


def test_candidates_stand_below_each_other(script: Script) -> None:
    drawing = drawing_for(script.world.spec)
    sheet, one = drawing.sheet([script, script], "two"), drawing.pictures([script])
    high = [int(re.findall(r'height="(\d+)"', svg)[0]) for svg in (sheet.comic(), one.comic())]
    assert high[0] > 2 * high[1]
    assert "html" not in sheet.offered


def test_how_it_shows_itself_in_notebooks(script: Script, tmp_path: Path) -> None:
    """A strip, for there is no film."""
    data, _ = script._repr_mimebundle_()
    assert "<img" in data["text/html"]
    assert "<iframe" not in data["text/html"]
