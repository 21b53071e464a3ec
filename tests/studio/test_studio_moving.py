"""Planes and the hill by hand: positions and stretches of frames that are pinned."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from i2pdsl.errors import Source, StoryError
from i2pdsl.language.check import check_source
from i2pdsl.objective.starts import allowed_starts
from i2pdsl.render.pictures import drawing_for
from i2pdsl.render.plane.page import page_view
from i2pdsl.stories import Script
from i2pdsl.studio import hands, making
from i2pdsl.studio.asking import first_picture
from i2pdsl.studio.during import offers
from i2pdsl.studio.made import Made
from i2pdsl.studio.outline import outline
from i2pdsl.studio.protocol import Refusal
from i2pdsl.studio.spots import spots
from i2pdsl.studio.text import StoryText
from i2pdsl.worlds.find import find_spec
from i2pdsl.worlds.kind import Watch
from i2pdsl.worlds.kinds import kind_of, parse_world
from i2pdsl.worlds.record import Record
from studio.conftest import Desk
from studio_for_tests import Served

# What is naive is found at once: nothing is compiled here.
WALK = (
    "world house\nlength 40\nstart at(big, (2, 7))\nmaximize depict(G_little = inside)\n"
    "search naive\npin script[24]: at(big, (4, 6))\n"
)
PULL = "world hill\nlength 30\nmaximize depict(weight = 0.5)\nsearch naive\n"

TINY = """\
map
    G..

tile goal
    symbol = G
character she
    goals = goal
    pushes = ball
object ball
    may_be_absent = yes
"""


def made(text: str) -> Made:
    story = making.read(text, "moving.story", Path())
    script: Script = story.solve(seed=0, choose="score").script
    return Made("f1", "file:///moving.story", 1, 0, "best", story, script)


@pytest.fixture(scope="module")
def walk() -> Made:
    return made(WALK)


@pytest.fixture(scope="module")
def pull() -> Made:
    return made(PULL)


def test_what_can_be_reached_in_a_plane(walk: Made) -> None:
    """By straight ways and no further: from the start, and to where the pin says."""
    world = making.world_of(walk.story, Watch())
    found = spots(walk.story, world, 12, "big")
    boxes, scale = np.array(found["room"]["reached"]), page_view(world.spec).scale
    (big,) = (each for each in world.spec.characters if each.name == "big")
    fastest = max(c.fastest for c in world.spec.characters)
    ways = (([2, 7], 12 * fastest), ([4, 6], 12 * fastest + 0.25 * big.radius))
    cell = 0.3  # units, more than the picture's fineness
    corners = np.array([world.spec.width, world.spec.height])
    told = {True: 0, False: 0}
    for point in np.random.default_rng(0).uniform(0, corners, size=(2000, 2)):
        x, y = point[0] * scale, (world.spec.height - point[1]) * scale
        across = (boxes[:, 0] <= x) & (x <= boxes[:, 0] + boxes[:, 2])
        is_open = bool((across & (boxes[:, 1] <= y) & (y <= boxes[:, 1] + boxes[:, 3])).any())
        left = min(far - np.hypot(*(point - at)) for at, far in ways)
        if abs(left) > cell:
            told[is_open] += 1
            assert is_open == (left > 0)
    assert all(told.values())
    assert not any(spot["possible"] for spot in found["spots"])


def test_what_is_said_of_who_is_put_somewhere(walk: Made, pull: Made) -> None:
    plane = drawing_for(walk.script.world.spec)
    (here,) = (seen.at[5] for seen in plane.seen(walk.script) if seen.name == "little")
    assert here is not None
    told = re.fullmatch(
        r"at\(little, \(([\d.]+), ([\d.]+)\)\)", plane.said_of(walk.script, 5, "little", here)
    )
    assert told is not None
    assert np.allclose(
        [float(told[1]), float(told[2])], walk.script.trajectory.states[5][:2], atol=0.02
    )
    hill = drawing_for(pull.script.world.spec)
    (box,) = (seen.at[20] for seen in hill.seen(pull.script) if seen.name == "box")
    assert box is not None
    now = float(pull.script.query("[climbed(box) @ script[20]]"))
    said = hill.said_of(pull.script, 20, "box", (box[0] + 30, box[1]))
    low, high = (float(x) for x in re.findall(r"-?[\d.]+", said))
    assert high - low == 1
    assert low <= now + 30 * np.cos(0.1) / 10 <= high
    grid = drawing_for(find_spec("kitchen"))
    with pytest.raises(StoryError, match="only places can be chosen"):
        grid.said_of(pull.script, 1, "robot", (0, 0))


def test_offers_for_a_stretch(pull: Made, walk: Made) -> None:
    found = {each["text"]: each["now"] for each in offers(pull, 10, 20)}
    effort = pull.script.query("mean_{t in 10..20} [effort(hopper) @ script[t]]")
    assert found["taut(hopper)"] + found["not taut(hopper)"] == pytest.approx(1)
    (less,) = (text for text in found if text.startswith("effort(hopper) <= "))
    assert float(less.split()[-1]) == pytest.approx(0.5 * effort, rel=0.05)
    text = hands.during(StoryText(PULL), 10, 20, less).text
    assert text.endswith(f"pin script[10..20]: {less}\n")
    making.read(text, "pull.story", Path())
    assert "at(big, inside)" in {each["text"] for each in offers(walk, 3, 9)}
    for wrong in (
        (0, 3, less),
        (3, 31, less),
        (5, 4, less),
        (1, 2, "1\nworld hill"),
        (1, 2, "(1 >\n0)"),
    ):
        with pytest.raises(Refusal):
            hands.during(StoryText(PULL), *wrong)


def test_who_was_put_up_the_hill_is_put_elsewhere() -> None:
    once = hands.say(StoryText(PULL), 9, "box", "1 <= climbed(box) <= 2")
    other = hands.say(once, 9, "box", "2 <= climbed(box) <= 3")
    assert other.text == once.text.replace("1 <= climbed(box) <= 2", "2 <= climbed(box) <= 3")
    assert hands.unpin(other, 9, "box").text.rstrip() == PULL.rstrip()


@pytest.fixture
def moving(desk: Any, served: Served) -> Iterator[Any]:
    """Opens a story of bodies."""
    (served.folder / "walk.story").write_text(WALK, encoding="utf-8")
    (served.folder / "pull.story").write_text(PULL, encoding="utf-8")
    yield desk
    for name in ("walk.story", "pull.story"):
        (served.folder / name).unlink()


@pytest.mark.browser
def test_somebody_is_dragged_to_a_point(moving: Any) -> None:
    shown: Desk = moving("walk.story")
    page = shown.page
    shown.seek(20)
    x, y = shown.place("little")
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x - 40, y - 25, steps=4)
    page.locator("#stage .spot.room").wait_for(state="attached")
    page.mouse.up()
    shown.says(r"pin script\[20\]: at\(little, \(\d+\.?\d*, \d+\.?\d*\)\)")
    shown.seek(0)
    x, y = shown.place("little")
    shown.drag((x, y), (x + 30, y - 20))
    shown.says(r"start at\(big, \(2, 7\)\) and at\(little, \(\d")
    shown.solved()
    assert shown.place("little") == pytest.approx((x + 30, y - 20), abs=4)


@pytest.mark.browser
def test_the_box_is_moved_and_a_stretch_marked(moving: Any) -> None:
    shown: Desk = moving("pull.story")
    page = shown.page
    shown.seek(15)
    page.get_by_role("button", name="box", exact=True).press("Enter")
    page.locator("#stage .spot.way").wait_for(state="attached")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("Enter")
    shown.says(r"pin script\[15\]: [\d.]+ <= climbed\(box\) <= [\d.]+")
    shown.solved()
    lane = page.get_by_role("group", name="Pins")
    box = lane.bounding_box()
    at = lambda share: (box["x"] + share * box["width"], box["y"] + box["height"] - 4)
    shown.drag(at(0.7), at(0.9))
    page.get_by_label("What shall hold").select_option("taut(hopper)")
    page.get_by_role("button", name="Pin", exact=True).click()
    shown.says(r"pin script\[21\.\.27\]: taut\(hopper\)")
    shown.solved()
    pin = page.get_by_role("button", name=re.compile("Pin in frames 21 to 27"))
    pin.press("Shift+ArrowRight")
    shown.says(r"pin script\[21\.\.28\]: taut\(hopper\)")
    page.get_by_role("button", name=re.compile("Pin in frames 21 to 28")).press("ArrowLeft")
    shown.says(r"pin script\[20\.\.27\]: taut\(hopper\)")
    page.get_by_role("button", name=re.compile("Pin in frames 20 to 27")).press("Delete")
    shown.says("^(?![^]*taut)")
    page.locator("#undo").click()
    shown.solved()
    shown.seek(12)
    page.get_by_role("button", name="Hold to here").click()
    shown.says(r'pin script\[1\.\.12\] = "pull\.kept\.json"')
    shown.solved()
    page.get_by_role("button", name=re.compile("Pin in frames 1 to 12: as in pull")).wait_for()
    page.get_by_role("button", name="Pin a stretch").click()
    page.get_by_label("First frame").fill("28")
    page.get_by_label("Last frame").fill("29")
    page.get_by_label("What shall hold").select_option("all as it is now")
    page.get_by_role("button", name="Pin", exact=True).click()
    shown.says(r'pin script\[28\.\.29\] = "pull\.kept(-2)?\.json"')


def test_what_is_offered_in_each_world(walk: Made, pull: Made, tmp_path: Path) -> None:
    from i2pdsl.studio.folder import Folder

    plane, hill = (outline(each.story, Folder(tmp_path))["can"] for each in (walk, pull))
    assert (plane["drag"], plane["start"], plane["hold"]) == (["little", "big"], True, True)
    assert (hill["drag"], hill["start"], hill["hold"]) == (["hopper", "box"], False, True)
    with pytest.raises(Refusal, match="begin like this"):
        spots(pull.story, making.world_of(pull.story, Watch()), 0, "box")


def test_a_first_picture_is_said_in_words(walk: Made, pull: Made) -> None:
    """Everybody at a point, and nobody anywhere else; the hill has no words for it."""
    text = hands.start(StoryText(WALK), first_picture(walk)).text
    story = making.read(text, "moving.story", Path())
    starts = allowed_starts(making.world_of(story, Watch()), story.typed.start)
    assert np.unique(starts, axis=0).tolist() == [walk.script.trajectory.states[0].tolist()]
    assert starts[0, 2:4].tolist() == [2, 7]
    with pytest.raises(Refusal, match="no words for the first picture"):
        first_picture(pull)


def test_every_first_picture_on_a_map_is_said_in_words() -> None:
    """Also where something is absent: each is told from all others."""
    source = Source("tiny.world", TINY)
    spec = parse_world(source, "tiny")
    kind = kind_of(spec)
    world = kind.rules(spec)
    told = set()
    for state in world.starts():
        record = Record({}, {}, None, kind.start_as_json(world, state), ())
        condition = kind.begun(record)
        story = f"world tiny\nlength 1\nstart {condition}\nsearch naive\n"
        typed = check_source(Source("s.story", story), lambda *_: kind.vocabulary(spec))
        assert allowed_starts(world, typed.start).tolist() == [state]
        told |= set(re.findall(r"(\w+)\(", condition))
    assert told == {"at", "absent"}
