"""Script files: what is written is read again, and whatever is wrong is said with its frame."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from fuzz_for_tests import examples
from i2pdsl.errors import Source, StoryError
from i2pdsl.scripts import make_record
from i2pdsl.stories import script_from
from i2pdsl.worlds.grid.kind import KIND
from i2pdsl.worlds.record import parse_record, read_record
from worlds_for_tests import SMALL_MAP, STORIES, kitchen_text, small_kitchen

WORLD = kitchen_text(SMALL_MAP, gamma="0.9")  # P.. / #.G / ...


def turn(cheese: str, robot: str, state: dict[str, Any]) -> dict[str, Any]:
    """A frame; `west+` is a move that moved."""
    acts = {"cheese": cheese, "robot": robot}
    moves = {n: {"action": a.rstrip("+"), "moved": a.endswith("+")} for n, a in acts.items()}
    return {**moves, "event": None, "state": state}


def at(cheese: list[int], robot: list[int], table: list[int] | None) -> dict[str, Any]:
    return {"cheese": cheese, "robot": robot, "table": table}


def document() -> dict[str, Any]:
    """A script written by hand: moves, a wall, an event, a failure, a push, a push in vain."""
    return {
        "format": "i2p-script",
        "version": 1,
        "world": {"name": "small", "source": WORLD},
        "start": at([1, 0], [2, 2], None),
        "frames": [
            turn("west+", "north+", at([0, 0], [2, 1], None)),
            turn("south", "west+", at([0, 0], [1, 1], None)),
            {"event": {"deus": "table", "to": [1, 0]}, "state": at([0, 0], [1, 1], [1, 0])},
            turn("stay", "north", at([0, 0], [1, 1], [1, 0])),
            turn("east", "east+", at([0, 0], [2, 1], [1, 0])),
            turn("stay", "north+", at([0, 0], [2, 0], [1, 0])),
            turn("stay", "west", at([0, 0], [2, 0], [1, 0])),
        ],
    }


def read(content: Any) -> Any:
    record = parse_record(Source("script.json", json.dumps(content)))
    return KIND.read(small_kitchen().world, record)


def mistake(content: Any) -> str:
    with pytest.raises(StoryError) as caught:
        read(content)
    assert len(caught.value.diagnostics) == 1
    assert caught.value.diagnostics[0].span.source.name == "script.json"
    return caught.value.diagnostics[0].render()


def changed(*path: Any, to: Any = None, drop: bool = False) -> dict[str, Any]:
    """The script with one value replaced or left out."""
    content: Any = copy.deepcopy(document())
    place = content
    for key in path[:-1]:
        place = place[key]
    if drop:
        del place[path[-1]]
    else:
        place[path[-1]] = to
    return content


def test_a_script_written_by_hand_is_read() -> None:
    path = read(document())
    world = small_kitchen().world
    cells = world.dynamics.coordinates[world.dynamics.cells[path.states][:, :2]]
    assert cells[-1].tolist() == [[0, 0], [2, 0]]
    assert len(path.actions) == 7
    again = make_record(world, path, {}, {}, None)
    assert list(again.frames) == document()["frames"]
    assert again.start == document()["start"]


@pytest.mark.parametrize("seed", range(12))
def test_round_trip(seed: int, tmp_path: Path) -> None:
    pair = small_kitchen()
    path = pair.random_script(Random(seed), 12, events=0.3)
    about = {"name": "é…", "file": "x.story", "source": "", "seed": seed}
    record = make_record(pair.world, path, about, {}, 1.25)
    again = read_record(record.save(tmp_path / "deep" / "script.json"))
    assert again == record
    back = KIND.read(pair.world, again)
    assert back.start == path.start
    np.testing.assert_array_equal(back.actions, path.actions)
    np.testing.assert_array_equal(back.states, path.states)


# Every mistake, and what is said about it.

MOVED = ("frames", 0, "cheese", "moved")
WRONG = [
    (changed("frames", 0, "cheese", "action", to="wets"), "frame 1: there is no action `wets`"),
    (changed("frames", 0, "cheese", "action", to="wets"), "did you mean `west`?"),
    (changed("frames", 0, "cheese", "action", to=3), "frame 1: there is no action `3`"),
    (changed("frames", 0, "cheese", "action", to=["west"]), "frame 1: there is no action"),
    (changed("frames", 0, "cheese", "action", to="x" * 10**5), "…`"),
    (changed("frames", 0, "cheese", "action", drop=True), "frame 1: what does `cheese` do?"),
    (changed("frames", 0, "cheese", to="west"), "frame 1: what does `cheese` do?"),
    (changed("frames", 0, "cheese", drop=True), "frame 1: what does `cheese` do?"),
    (changed("frames", 0, "robot", drop=True), "frame 1: what does `robot` do?"),
    (changed(*MOVED, drop=True), "frame 1: did `cheese` move?"),
    (changed(*MOVED, to=1), "frame 1: did `cheese` move?"),
    (changed(*MOVED, to=False), "frame 1: by the world's rules `cheese` is at [1, 0], not at [0"),
    (changed("frames", 0, "robot", "moved", to=False), "`robot` goes north and must move"),
    (changed("frames", 1, "cheese", "moved", to=True), "`cheese` cannot move south: the way is"),
    (changed("frames", 6, "robot", "moved", to=True), "frame 7: `robot` cannot move west: the way"),
    (changed("frames", 3, "cheese", "moved", to=True), "frame 4: `cheese` cannot move stay: stay"),
    (changed("frames", 4, "state", "cheese", to=[1, 0]), "frame 5: two of them stand on one cell"),
    (changed("frames", 4, "state", "robot", to=[2, 2]), "frame 5: by the world's rules `robot` is"),
    (changed("frames", 4, "state", "table", to=None), "`table` is at [1, 0], not absent"),
    (changed("frames", 1, "state", "table", to=[2, 2]), "`table` is absent, not at [2, 2]"),
    (changed("frames", 4, "state", "table", drop=True), "frame 5: where is `table`?"),
    (changed("frames", 4, "state", "chese", to=[1, 1]), "frame 5: there is no `chese` in small"),
    (changed("frames", 4, "state", to=[]), "frame 5: a state gives the cell of everyone"),
    (changed("frames", 4, "state", drop=True), "frame 5: a state gives the cell of everyone"),
    (changed("frames", 4, "state", "robot", to=None), "frame 5: `robot` cannot be absent"),
    (changed("frames", 4, "state", "robot", to=[0, 1]), "`robot` cannot stand at [0, 1]"),
    (changed("frames", 4, "state", "robot", to=[3, 0]), "`robot` cannot stand at [3, 0]"),
    (changed("frames", 4, "state", "robot", to=[-1, 0]), "`robot` cannot stand at [-1, 0]"),
    (
        changed("frames", 4, "state", "robot", to=[2]),
        "the place of `robot` is written [column, row]",
    ),
    (changed("frames", 4, "state", "robot", to="2,1"), "the place of `robot` is written"),
    (changed("frames", 4, "state", "robot", to=[2.0, 1]), "the place of `robot` is written"),
    (changed("frames", 4, "state", "robot", to=[True, 1]), "the place of `robot` is written"),
    (changed("frames", 4, "state", "robot", to={"x": 2}), "the place of `robot` is written"),
    (changed("frames", 4, "state", "robot", to=[10**40, 1]), "`robot` cannot stand at [1000"),
    (changed("frames", 0, "chese", to={}), "frame 1: there is no character `chese`"),
    (changed("frames", 2, "robot", to={}), "frame 3: an event fills a whole frame, but `robot`"),
    (changed("frames", 2, "robt", to={}), "frame 3: there is no character `robt`"),
    (changed("frames", 2, "event", "to", drop=True), "frame 3: where does `table` fall?"),
    (
        changed("frames", 2, "event", "to", to=[1, 1]),
        "`table` cannot fall there: the cell is taken",
    ),
    (changed("frames", 2, "event", "to", to=[0, 1]), "`table` cannot stand at [0, 1]"),
    (changed("frames", 2, "event", "to", to=[2, 2]), "`table` is at [2, 2], not at [1, 0]"),
    (
        changed("frames", 2, "event", to={"dues": "table", "to": [1, 0]}),
        "frame 3: there is no event",
    ),
    (
        changed("frames", 2, "event", to={"deus": "robot", "to": [1, 0]}),
        "frame 3: there is no event",
    ),
    (changed("frames", 2, "event", to={"deus": ["table"], "to": [1, 0]}), "there is no event"),
    (changed("frames", 2, "event", to="deus"), 'events: {"deus": "table", "to": [column, row]}'),
    (changed("frames", 2, "event", to={}), "frame 3: there is no event {}"),
    (changed("frames", 2, "event", drop=True), "frame 3: what does `cheese` do?"),
    (changed("frames", 5, to=document()["frames"][2]), "`table` cannot fall there: it is there"),
    (changed("start", "robot", to=[1, 0]), "start: two of them stand on one cell"),
    (changed("start", "robot", drop=True), "start: where is `robot`?"),
    (changed("start", "table", to=[1, 1]), "frame 1: by the world's rules `table` is at [1, 1]"),
    (changed("frames", 3, to=None), "frame 4: a frame is an object, not null"),
    (changed("frames", to=[]), "the script has no frames"),
    (changed("frames", to={}), '"frames" must be a list'),
    (changed("frames", drop=True), '"frames" must be a list'),
    (changed("start", drop=True), 'the script has no "start"'),
    (changed("start", to=[]), 'the script has no "start"'),
    (changed("format", to="x"), "this is no i2p script"),
    (changed("format", drop=True), "this is no i2p script"),
    (changed("version", to=2), "scripts of version 2 cannot be read; version 1 can"),
    (changed("version", to="1"), 'scripts of version "1" cannot be read'),
    (changed("version", drop=True), "scripts of version null cannot be read"),
    (changed("world", drop=True), "the script names no world"),
    (changed("world", "name", to=1), "the script names no world"),
    (changed("world", "source", to=1), '"source" of the world must be the text'),
    (changed("world", "settings", to=[]), '"settings" of the world must be an object'),
    ([], "this is no i2p script"),
    (None, "this is no i2p script"),
]


@pytest.mark.parametrize("number", range(len(WRONG)))
def test_a_mistake_is_said_with_its_frame(number: int) -> None:
    content, words = WRONG[number]
    message = mistake(content)
    assert words in message
    assert len(message) < 2000


BROKEN = [
    ("", "this is no JSON"),
    ("world kitchen\n", "this is no JSON"),
    ("[" * 200_000, "nested too deeply"),
    ('{"format": ' * 100_000, "nested too deeply"),
    ('{"format": "i2p-script", "version": ' + "1" * 5000 + "}", "a number that is too long"),
    ('{"format": "i2p-script", "version": 1', "this is no JSON"),
    ("\ufeff{}", "this is no"),
    ("NaN", "this is no i2p script"),
    ('{"format": "i2p-script", "version": 1, "version": 2}', "has `version` twice"),
    ('{"x": "' + '\\"' * 10**6, "this is no JSON"),
    ("[" + "{}," * 5_000_000 + "{}]", "of more than 5,000,000 parts"),
    ('{"format": "i2p-script", "story": ' + "[" * 60 + "]" * 60 + "}", "nested too deeply"),
    (json.dumps(changed("frames", to=[{}] * 100_001)), "has 100,001 frames; at most 100,000"),
]


@pytest.mark.parametrize("number", range(len(BROKEN)))
def test_what_is_no_json(number: int) -> None:
    text, words = BROKEN[number]
    with pytest.raises(StoryError, match=words):
        parse_record(Source("script.json", text))


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"betta": 1}, "no setting `betta`"),
        ({"betta": 1}, "did you mean `beta`?"),
        ({"beta": "high"}, 'the setting `beta` cannot be "high"'),
        ({"beta": True}, "the setting `beta` cannot be true"),
        ({"beta": None}, "the setting `beta` cannot be null"),
        ({"beta": -1}, "the setting `beta` cannot be -1"),
        ({"beta": float("nan")}, "the setting `beta` cannot be NaN"),
        ({"gamma": 1.0}, "the setting `gamma` cannot be 1.0"),
        ({"forgetting": 2}, "the setting `forgetting` cannot be 2"),
        ({"level0": "clever"}, 'the setting `level0` cannot be "clever"'),
        ({"level0": 1}, "it can be: uniform, costs"),
        ({"level0": ["uniform"]}, "the setting `level0` cannot be"),
    ],
)
def test_settings_are_held_against_the_world(settings: dict[str, Any], words: str) -> None:
    record = parse_record(
        Source("script.json", json.dumps(changed("world", "settings", to=settings)))
    )
    with pytest.raises(StoryError) as caught:
        script_from(record, None)
    assert words in caught.value.diagnostics[0].render()


@pytest.mark.parametrize(
    ("world", "words"),
    [
        ({"name": "nowhere"}, "there is no world `nowhere`"),
        ({"name": ""}, "there is no world ``"),
        ({"name": "n" * 5000}, "there is no world `nnn"),
        ({"name": "a\0b"}, "there is no world"),
        ({"name": "../worlds/kitchen"}, "there is no world `../worlds/kitchen`"),
        ({"name": str(STORIES / "worlds" / "kitchen")}, "there is no world `"),
        ({"name": str(STORIES / "worlds" / "kitchen.world")}, "there is no world `"),
        ({"name": "\x1b[31mred"}, "there is no world `�[31mred`"),
        ({"name": "small", "source": "nonsense\n"}, "small.world:1:1"),
        ({"name": "../../small", "source": "nonsense\n"}, "small-"),
        ({"name": "small", "source": WORLD.replace("goals", "gaols")}, "did you mean `goals`"),
    ],
)
def test_worlds_that_are_none(world: dict[str, Any], words: str) -> None:
    record = parse_record(Source("script.json", json.dumps(changed("world", to=world))))
    with pytest.raises(StoryError) as caught:
        script_from(record, None)
    assert words in "\n".join(d.render() for d in caught.value.diagnostics)


@pytest.mark.parametrize(
    "extra",
    [
        {"story": {"name": 3, "source": 7, "file": [1]}},
        {"story": "none of your business", "score": "high"},
        {"story": None, "score": None, "remark": "keys that nobody knows are left alone"},
        {"score": float("inf")},
        {"score": 10**400},
    ],
)
def test_what_informs_is_never_checked(extra: dict[str, Any]) -> None:
    content = {**document(), **extra}
    record = parse_record(Source("script.json", json.dumps(content)))
    assert record.score is None
    assert len(KIND.read(small_kitchen().world, record).actions) == 7
    json.loads(json.dumps(record.as_json(), allow_nan=False))


def test_a_file_name_that_is_not_utf_8_is_kept(tmp_path: Path) -> None:
    pair = small_kitchen()
    path = pair.random_script(Random(1), 3)
    record = make_record(pair.world, path, {"file": "caf\udce9.story"}, {}, float("-inf"))
    again = read_record(record.save(tmp_path / "script.json"))
    assert again.story == record.story
    assert again.score is None


def places(content: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """All places of a JSON document."""
    found = [path] if path else []
    items = content.items() if isinstance(content, dict) else enumerate(content)
    for key, value in items:
        if isinstance(value, dict | list):
            found += places(value, (*path, key))
        else:
            found.append((*path, key))
    return found


PLACES = places(document())
JUNK = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5)
    | st.sampled_from(["cheese", "robot", "table", "deus", "west", "stay", "kitchen"]),
    lambda inner: st.lists(inner, max_size=3)
    | st.dictionaries(st.sampled_from(["to", "deus", "action", "moved", "robot", "x"]), inner),
    max_leaves=5,
)  # fmt: skip


@hypothesis_settings(max_examples=examples(300), deadline=None)
@given(st.sampled_from(PLACES), JUNK)
def test_junk_anywhere_is_a_story_error_or_fine(path: tuple[Any, ...], junk: Any) -> None:
    content = changed(*path, to=junk)
    message = ""
    try:
        record = parse_record(Source("script.json", json.dumps(content)))
        KIND.read(small_kitchen().world, record)
    except StoryError as problem:
        message = problem.diagnostics[0].render()
    assert not message or message.startswith("script.json:1:1: error[script]: ")


def test_any_characters_changed() -> None:
    """A text that was damaged, or made up of pieces of a right one."""
    random, good = Random(7), json.dumps(document())
    pieces = [
        "{",
        "}",
        "[",
        "]",
        '"',
        ",",
        ":",
        "null",
        "NaN",
        "-Infinity",
        "1e999",
        "\\ud800",
        "\\",
    ]
    for _ in range(examples(150)):
        text = good
        for _ in range(random.randint(1, 3)):
            at, end = sorted(random.choices(range(len(text)), k=2))
            end = min(end, at + random.choice([0, 1, 3, 50]))
            text = text[:at] + random.choice([*pieces, text[end : end + 30]]) + text[end:]
        try:
            record = parse_record(Source("script.json", text))
            KIND.read(small_kitchen().world, record)
        except StoryError as problem:
            assert problem.diagnostics[0].span.source.name == "script.json"  # noqa: PT017


@pytest.mark.parametrize(
    "name", ["x" * 3_000_000, "\x1b\x00\x01", "\ud800", '"><script>alert(1)</script>', 10**4000]
)
def test_any_title_is_drawn(name: Any, tmp_path: Path) -> None:
    """And no text of a script gets into a picture as anything but text."""
    from i2pdsl.render.pictures import pictures_of

    source = "</code><script>alert(1)</script>\u2028\ud800"
    content = {**document(), "story": {"name": name, "source": source, "seed": 10**4000}}
    content["world"]["name"] = "../" + str(name)
    script = script_from(parse_record(Source("script.json", json.dumps(content))), tmp_path)
    files = pictures_of([script]).save(tmp_path, ("svg", "html"))
    for path in files.values():
        text = path.read_text(encoding="utf-8")
        assert "<script>alert" not in text
        assert "\u2028" not in text.partition('id="film-data"')[2]
        assert len(text) < 2_000_000
    assert len(script.world.name) < 200
    assert len(repr(script)) < 500
