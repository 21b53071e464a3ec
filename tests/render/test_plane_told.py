"""A script of the plane as its pictures show it."""

import numpy as np
import pytest

from i2pdsl.render.pictures import pictures_of
from i2pdsl.render.plane.pictures import PlanePictures
from i2pdsl.scripts import Script, script_from
from i2pdsl.worlds.record import Record

YARD = """\
kind = plane

size
    width = 8
    height = 5

place nest
    at = (7, 4)
place pond
    at = (7, 1)

character little
    at = (2, 2)
    goals = {nest, pond}
character big
    at = (1, 4)
    goals = {approach, avoid, none}
"""
SOCIAL = "    toward = little\n    attitude = {-2, 0, 2}\n"
STEP = 0.1


def script(world=YARD, frames=12) -> Script:
    """`little` goes straight up north-east, to the nest, and `big` stays."""
    names = ["little", "big"] if "character big" in world else ["little"]
    at = {"little": np.array([2.0, 2.0]), "big": np.array([1.0, 4.0])}
    way = {"little": STEP * np.array([5, 2]) / np.hypot(5, 2), "big": np.zeros(2)}
    start, told = {name: at[name].tolist() for name in names}, []
    for _ in range(frames):
        at = {name: at[name] + way[name] for name in names}
        frame = {name: {"velocity": way[name].tolist()} for name in names}
        told.append({**frame, "state": {name: at[name].tolist() for name in names}})
    about = {"name": "yard", "source": world, "settings": {}}
    return script_from(Record({}, about, None, start, tuple(told)), None)


@pytest.fixture(scope="module")
def duet() -> Script:
    return script()


def test_curves_are_those_of_what_viewers_do_not_know(duet):
    pictures = pictures_of([duet], "A\ttitle")
    assert isinstance(pictures, PlanePictures)
    assert pictures.title == "A title"
    assert [(p.title, [s.label for s in p.series]) for p in pictures.panels] == [
        ("little's goal", ["nest", "pond"]),
        ("big's goal", ["approach", "avoid", "none"]),
        ("rationality", ["little", "big"]),
        ("expected value", ["little", "big"]),
    ]
    nest = duet.query("P(G_little = nest | script[:t])")
    assert pictures.panels[0].series[0].values == pytest.approx(nest)
    one = pictures.performances[0]
    moved = np.array([2, 2]) + 12 * STEP * np.array([5, 2]) / np.hypot(5, 2)
    assert one.positions[12] == pytest.approx(np.array([moved, (1, 4)]), abs=1e-5)
    assert one.leading is not None
    assert [s.label for s in one.leading.series] == ["little's goal: nest", "little's goal: pond"]


def test_captions_say_what_is_believed(duet):
    one = pictures_of([duet]).performances[0]
    assert one.captions[0] == "viewers cannot tell what little wants, and what big wants"
    last = one.panels[0].series[0].values[12]
    assert last > 0.6
    assert f"that little wants nest ({100 * last:.0f} %), and" in one.captions[12]
    assert "big wants nothing (" in one.captions[12]


def test_an_attitude_is_told_before_goals():
    social = script(YARD.replace("avoid, none}\n", "avoid, none}\n" + SOCIAL), 3)
    one = pictures_of([social]).performances[0]
    assert "big's alignment" in [p.title for p in one.panels]
    assert one.leading is not None
    assert [s.label for s in one.leading.series] == ["hindering", "indifferent", "helping"]
    total = np.sum([s.values for s in one.leading.series], axis=0)
    assert total == pytest.approx(np.ones(4), abs=1e-6)
    assert all("little wants" not in caption for caption in one.captions)
    assert one.captions[0] == "viewers cannot tell what big means to little"


def test_goals_that_are_known_have_no_curves():
    alone = script(YARD.split("character big")[0].replace("{nest, pond}", "{nest}"), 3)
    pictures = pictures_of([alone])
    assert [p.title for p in pictures.panels] == ["rationality", "expected value"]
    assert pictures.performances[0].captions == ["", "", "", ""]
    assert "whole way" in pictures.comic()


def test_scripts_of_one_plane_stand_side_by_side(duet):
    pictures = pictures_of([duet, script(frames=5)], "Both")
    assert pictures.names == ("together",) * 3
    assert [p.frames for p in pictures.performances] == [12, 5]
