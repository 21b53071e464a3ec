"""All pictures of a script: what they show is what the audience believes."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from functools import cache
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest
from PIL import Image

from i2pdsl.errors import Source
from i2pdsl.render.files import UNSURE, FilmLook
from i2pdsl.render.grid.pictures import GridPictures, stage_of
from i2pdsl.stories import Script, script_from
from i2pdsl.worlds.record import parse_record
from worlds_for_tests import SMALL_MAP, kitchen_text, small_kitchen

WORLD = kitchen_text(SMALL_MAP, gamma="0.9")
LONER = """map
    A..B
tile left
    symbol = A
tile right
    symbol = B
character fox
    goals = {left, right}
planning
    gamma = 0.9
"""


def loaded(content: dict[str, Any]) -> Script:
    return script_from(parse_record(Source("script.json", json.dumps(content))), None)


@cache
def small_script(seed: int = 1, length: int = 6, events: float = 0.3) -> Script:
    """A script of random turns and, perhaps, an event."""
    content = small_kitchen().document(small_kitchen().random_script(Random(seed), length, events))
    content["world"] = {"name": "small", "source": WORLD}
    content["story"] = {"name": "small <story> & more"}
    return loaded(content)


@cache
def with_event() -> Script:
    scripts = (small_script(seed) for seed in range(30))
    return next(s for s in scripts if any(f["event"] for f in s.record.frames))


@cache
def loner() -> Script:
    """A world with one character and nothing else."""
    act = {"action": "east", "moved": True}
    frames = [{"fox": act, "event": None, "state": {"fox": [c, 0]}} for c in (1, 2, 3)]
    content = {
        "format": "i2p-script",
        "version": 1,
        "world": {"name": "lane", "source": LONER},
        "start": {"fox": [0, 0]},
        "frames": frames,
    }
    return loaded(content)


def test_the_panels_are_the_audience_s_beliefs() -> None:
    script = small_script()
    panels = {p.title: p for p in GridPictures(script).panels}
    assert list(panels) == [
        "cheese's goal", "robot's goal", "robot's alignment", "rationality", "expected value",
    ]  # fmt: skip
    alignment = {s.label: s.values for s in panels["robot's alignment"].series}
    np.testing.assert_array_equal(alignment["helping"], script.query("P(rho > 0 | script[:t])"))
    np.testing.assert_allclose(sum(alignment.values()), 1)
    goals = {s.label: s.values for s in panels["robot's goal"].series}
    np.testing.assert_allclose(goals["none"], script.query("P(G_robot = none | script[:t])"))
    rational = {s.label: s.values for s in panels["rationality"].series}
    expected = script.query("P(R_cheese | script[:t])", assume="nothing")
    np.testing.assert_array_equal(rational["cheese"], expected)
    assert panels["expected value"].kind == "value"
    colors = [s.color for s in panels["robot's goal"].series]
    assert len(set(colors)) == len(colors)


def test_one_character_alone_has_pictures_too(tmp_path: Path) -> None:
    pictures = GridPictures(loner())
    assert [p.title for p in pictures.panels] == ["fox's goal", "rationality", "expected value"]
    assert pictures.meters()[0][0] == "left"
    assert "that fox wants right (" in pictures.captions([3])[0]
    assert pictures.title == "lane"
    files = pictures.save(tmp_path, ("svg", "html", "gif"))
    assert set(files) == {"comic.svg", "mind.svg", "html", "gif"}


@pytest.mark.parametrize(
    ("assumption", "characters"),
    [
        ("not R_robot", ["cheese"]),
        ("not R_cheese", ["robot"]),
        ("not R_robot and not R_cheese", []),
        ("nothing", ["cheese", "robot"]),
        ("rho < 0 and G_robot = none", ["cheese", "robot"]),
    ],
)
def test_any_assumption_can_be_drawn(
    assumption: str, characters: list[str], tmp_path: Path
) -> None:
    """An irrational character has no value to draw."""
    content = small_script().record.as_json()
    content["story"] = {"source": f"world small\nlength 6\nassume {assumption}\nsearch naive\n"}
    script = loaded(content)
    assert script.warnings == ()
    pictures = GridPictures(script)
    values = [p for p in pictures.panels if p.kind == "value"]
    assert [s.label for p in values for s in p.series] == characters
    pictures.save(tmp_path, ("svg",))


def test_captions_say_what_is_believed_most() -> None:
    """Of a script without a story: what one means to the other."""
    pictures = GridPictures(small_script())
    script = pictures.script
    signs = {"means to hinder": "<", "does not care about": "=", "means to help": ">"}
    for t, line in enumerate(pictures.captions(list(range(script.length + 1)))):
        beliefs = {k: float(script.query(f"P(rho {o} 0 | script[:{t}])")) for k, o in signs.items()}
        second, first = sorted(beliefs.values())[-2:]
        told = line.rpartition(": ")[2]
        if first - second < UNSURE:
            assert told == "viewers cannot tell what robot means to cheese"
            continue
        verb = "are sure" if first >= 0.95 else "think" if first >= 0.7 else "rather think"
        best = max(beliefs, key=lambda k: beliefs[k])
        assert told.startswith(f"viewers {verb} that robot {best} cheese (")
        shown = told.partition("(")[2].partition(" %")[0]
        if shown.startswith("> "):
            assert beliefs[best] >= 0.99
        else:
            assert abs(float(shown) - 100 * beliefs[best]) <= 0.5


def asked(source: str, seed: int = 1) -> GridPictures:
    """The pictures of a random script, as if it had been made of a story."""
    content = small_script(seed).record.as_json()
    content["story"] = {"source": f"world small\nlength 6\n{source}\n"}
    script = loaded(content)
    assert script.warnings == ()
    return GridPictures(script)


def test_pictures_speak_of_what_the_story_asks() -> None:
    help_, herring, arc = (
        asked(f"maximize {wish}")
        for wish in ("depict(rho > 0)", "red_herring(G_robot = pink)", "arc(robot)")
    )
    assert [m[0] for m in help_.meters()] == ["hindering", "indifferent", "helping"]
    assert herring.meters()[0][0] == "robot's goal: pink"
    assert (
        "robot wants" in herring.captions([6])[0] or "what robot wants" in herring.captions([6])[0]
    )
    ((label, _, values),) = arc.meters()
    assert label == "robot"
    np.testing.assert_allclose(values, arc.script.query("E[V(robot) | script[:t]]"))
    assert "things look" in arc.captions([6])[0]
    assert arc.panels[0].title == "robot's fortune"
    best = int(np.argmax(values))
    assert "things look good for robot (value " in arc.captions([best])[0]


def test_irony_is_told_by_what_the_deed_looks_like() -> None:
    pictures = asked("maximize irony(G_cheese = green, G_cheese = pink, rho > 0, rho < 0)")
    meters = {label: np.asarray(values) for label, _, values in pictures.meters()}
    assert list(meters) == ["cheese: green", "keeping from green", "helping to pink"]
    ask = pictures.script.query
    for label, question in (
        ("cheese: green", "P(G_cheese = green | script[:t])"),
        ("keeping from green", "P(rho < 0 | script[:t], G_cheese = green)"),
        ("helping to pink", "P(rho > 0 | script[:t], G_cheese = pink)"),
    ):
        np.testing.assert_allclose(meters[label], ask(question))
    for line in (pictures.captions([t])[0] for t in range(7)):
        assert "cheese wants green" in line
        assert "robot acts as if helping cheese to pink" in line
        assert "keeping" not in line


def test_comics_show_events_and_never_two_alike() -> None:
    pictures = GridPictures(with_event())
    times = [t for t, f in enumerate(with_event().record.frames, 1) if f["event"]]
    frames = pictures.key_frames(4)
    assert set(times[:2]) <= set(frames)
    still = GridPictures(walk(TWINS, {"ann": [1, 0], "bob": [2, 0]}, [stayed()] * 9))
    assert still.key_frames(8) == [0, 9]


def test_events_are_marked() -> None:
    pictures = GridPictures(with_event())
    times = [t for t, f in enumerate(with_event().record.frames, 1) if f["event"]]
    assert [(m.frame, m.label) for m in pictures.marks] == [(t, "the table falls") for t in times]


def test_the_stage_has_the_whole_cast() -> None:
    stage = stage_of(small_script().world.spec)
    assert [a.name for a in stage.cast] == ["cheese", "robot", "table"]
    assert {t.name for t in stage.tiles} == {"pink", "green"}
    assert stage.rows == SMALL_MAP


@pytest.mark.parametrize("make", [with_event, loner, lambda: small_script(3, 1, 0.0)])
def test_every_format_is_written_whole(make: Any, tmp_path: Path) -> None:
    pictures = GridPictures(make())
    pictures.look = FilmLook(pace=6)  # its films have fewer pictures
    steps: list[tuple[str, int, int]] = []
    kinds = ("mp4", "gif", "png", "svg", "html")
    found = pictures.save(
        tmp_path / "a" / "b", kinds, lambda name, done, total: steps.append((name, done, total))
    )
    names = {"comic.png", "mind.png", "comic.svg", "mind.svg", "page.html", "film.gif", "film.mp4"}
    assert {p.name for p in found.values()} == names
    assert {p.name for p in (tmp_path / "a" / "b").iterdir()} == names
    assert list(found)[-2:] == ["gif", "mp4"]  # those that take longest come last
    for kind in ("comic.png", "mind.png", "gif"):
        with Image.open(found[kind]) as image:
            image.load()
            assert image.width > 100
    for kind in ("comic.svg", "mind.svg"):
        assert ET.parse(found[kind]).getroot().tag.endswith("svg")
    assert found["mp4"].read_bytes()[4:8] == b"ftyp"
    assert {name for name, _, _ in steps} == {"film.gif", "film.mp4"}
    for name in ("film.gif", "film.mp4"):
        done = [d for n, d, _ in steps if n == name]
        assert done == sorted(done)
        assert done[-1] == next(t for n, _, t in steps if n == name)


def test_the_same_script_gives_the_same_bytes(tmp_path: Path) -> None:
    kinds = ("png", "svg", "html")
    first = GridPictures(small_script()).save(tmp_path / "1", kinds)
    second = GridPictures(small_script()).save(tmp_path / "2", kinds)
    for name, path in first.items():
        assert path.read_bytes() == second[name].read_bytes(), name


@pytest.mark.parametrize(
    "title", ["", "<b>&amp;</b>", "ein Märchen 🧀", "a\x00b\x1f", "x" * 3000, "$x_1$", "</script>"]
)
def test_any_title(title: str, tmp_path: Path) -> None:
    kinds = ("svg", "html", "png") if "\x00" in title else ("svg", "html")
    found = GridPictures(small_script(2, 2), title).save(tmp_path, kinds)
    for kind in ("comic.svg", "mind.svg"):
        ET.parse(found[kind])
    page = found["html"].read_text(encoding="utf-8")
    assert page.count("</script>") == page.count("<script")


def test_nothing_is_drawn_where_nothing_is_asked(tmp_path: Path) -> None:
    assert GridPictures(small_script()).save(tmp_path / "none", ()) == {}


def test_pictures_come_one_by_one(tmp_path: Path) -> None:
    """What is done is there, whatever becomes of the rest."""
    drawing = GridPictures(small_script()).drawn(tmp_path, ("svg", "gif"))
    name, path = next(drawing)
    assert name == "comic.svg"
    assert path.is_file()
    assert [p.name for p in tmp_path.iterdir()] == ["comic.svg"]
    drawing.close()
    assert [p.name for p in tmp_path.iterdir()] == ["comic.svg"]


def test_an_interrupted_film_leaves_nothing(tmp_path: Path) -> None:
    def stop(name: str, done: int, total: int) -> None:
        if done > 2:
            raise KeyboardInterrupt

    for kind in ("gif", "mp4"):
        with pytest.raises(KeyboardInterrupt):
            GridPictures(small_script()).save(tmp_path, (kind,), stop)
    assert list(tmp_path.iterdir()) == []


TWINS = """map
    A..B
tile left
    symbol = A
tile right
    symbol = B
character ann
    goals = {left, right}
character bob
    goals = {left, right}
planning
    gamma = 0.9
"""


def walk(world: str, start: dict[str, Any], frames: list[dict[str, Any]]) -> Script:
    content = {"format": "i2p-script", "version": 1, "world": {"name": "w", "source": world}}
    return loaded({**content, "start": start, "frames": frames})


def stayed() -> dict[str, Any]:
    stay = {"action": "stay", "moved": False}
    return {"ann": stay, "bob": stay, "event": None, "state": {"ann": [1, 0], "bob": [2, 0]}}


def test_a_cast_without_colours_is_told_apart() -> None:
    pictures = GridPictures(walk(TWINS, stayed()["state"], [stayed()]))
    ann, bob = pictures.stage.cast
    assert ann.color != bob.color
    assert [label for label, _, _ in pictures.meters()] == ["ann's goal: left", "ann's goal: right"]
    kitchen = GridPictures(small_script())
    spec = kitchen.script.world.spec
    assert [a.color for a in kitchen.stage.cast] == [
        one.color for one in (*spec.characters, *spec.things)
    ]


def test_very_many_goals_are_taken_together(tmp_path: Path) -> None:
    names = [f"goal{i}" for i in range(40)]
    tiles = "".join(f"tile {n}\n    cell = ({i}, 0)\n" for i, n in enumerate(names))
    world = f"map\n    {'.' * 40}\n{tiles}character fox\n    goals = {{{', '.join(names)}}}\n"
    acts = {"fox": {"action": "east", "moved": True}, "event": None}
    frames = [{**acts, "state": {"fox": [c, 0]}} for c in (31, 32, 33)]
    script = walk(world, {"fox": [30, 0]}, frames)
    pictures = GridPictures(script)
    series = pictures.panels[0].series
    assert len(series) == 24
    assert series[-1].label == "17 others"
    np.testing.assert_allclose(sum(s.values for s in series), 1)
    beliefs = script.query("P(G_fox | script[:t])")
    kept = {s.label: s.values for s in series[:-1]}
    for name, values in zip(names, beliefs.T, strict=True):
        if name in kept:
            np.testing.assert_array_equal(kept[name], values)
        else:
            assert values.max() <= min(v.max() for v in kept.values()) + 1e-12
    assert "others" not in "".join(pictures.captions([0, 1, 2, 3]))
    pictures.save_mind(tmp_path / "mind.png", "many")
    with Image.open(tmp_path / "mind.png") as image:
        assert image.height > 700
