"""Scripts of the hill: written, read back, and held against the simulator."""

from __future__ import annotations

import copy
import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from i2pdsl import Script, StoryError
from i2pdsl.errors import Source
from i2pdsl.scripts import script_from
from i2pdsl.stories import story_from
from i2pdsl.worlds.record import parse_record

TEXT = """world hill(weight = 0.5, sigma = 0.8)
length 6
let heavy = weight = 0.5
audience bayesian(controller = 1)
search naive(noise = 0.7)
"""


@cache
def made() -> Script:
    return story_from(Source("small.story", TEXT)).solve(seed=3).script


def document() -> dict[str, Any]:
    return copy.deepcopy(made().record.as_json())


def read(content: dict[str, Any]) -> Script:
    return script_from(parse_record(Source("script.json", json.dumps(content))), None)


def test_a_script_comes_back_as_it_was(tmp_path: Path) -> None:
    path = made().save(tmp_path / "script.json")
    again = Script.load(path)
    assert again.warnings == ()
    assert again.record.as_json() == made().record.as_json()
    np.testing.assert_allclose(again.trajectory.states, made().trajectory.states, atol=1e-5)
    for question in (
        "P(heavy | script[:t])",
        "[effort(hopper) @ script[t]]",
        "E[V(hopper) | script]",
    ):
        if question.startswith("E"):
            question = "E[V(hopper) | script[:t]]"
        np.testing.assert_allclose(again.query(question), made().query(question), rtol=1e-4)
    assert again.world.spec.settings.weight == 0.5
    assert again.save(tmp_path / "again.json").read_text() == path.read_text()


def test_beliefs_come_from_the_stored_states_not_from_a_rollout() -> None:
    """A state within the tolerance of the rules is believed as it is."""
    content = document()
    content["frames"][2]["state"]["velocities"][9][0] += 0.002
    moved = read(content)
    assert moved.trajectory.states[3][38 + 9] == pytest.approx(
        made().trajectory.states[3][38 + 9] + 0.002, abs=1e-5
    )


def test_a_script_of_the_default_hill_needs_no_settings() -> None:
    story = story_from(Source("s.story", "world hill\nlength 3\nsearch naive(noise = 0)\n"))
    content = json.loads(json.dumps(story.solve().script.record.as_json()))
    del content["world"]["settings"], content["world"]["source"], content["story"]
    assert read(content).length == 3


def change(*path: Any, to: Any) -> dict[str, Any]:
    content: Any = document()
    place = content
    for key in path[:-1]:
        place = place[key]
    if to is KeyError:
        del place[path[-1]]
    else:
        place[path[-1]] = to
    return content


@pytest.mark.parametrize(
    ("path", "to", "words"),
    [
        (("frames", 3, "state", "positions", 4), [0.0, 0.0], "frame 4: by the world's rules"),
        (("frames", 0, "residual"), [5, 0, 0, 0, 0, 0], "frame 1: by the world's rules"),
        (("frames", 1, "residual"), [0, 0, 0], '"residual" must be 6 numbers'),
        (("frames", 1, "residual"), KeyError, '"residual" must be 6 numbers'),
        (("frames", 1, "residual"), ["a"] * 6, '"residual" must be 6 numbers'),
        (("frames", 1, "residual", 0), None, '"residual" must be 6 numbers'),
        (("frames", 1, "residual", 0), True, '"residual" must be 6 numbers'),
        (("frames", 1, "residual", 0), float("nan"), '"residual" must be 6 numbers'),
        (("frames", 1, "residual", 0), 1e300, '"residual" must be 6 numbers'),
        (("frames", 5, "state"), KeyError, "frame 6: a state gives the positions"),
        (("frames", 5, "state", "velocities"), [[0, 0]], '"velocities" must be 19 x 2 numbers'),
        (("frames", 5, "state", "velocities", 3), [0], '"velocities" must be 19 x 2 numbers'),
        (("frames", 5, "state", "speed"), 3, "a state of the hill has no `speed`"),
        (("frames", 5, "event"), {"deus": "box"}, "there are no events on the hill"),
        (("frames", 5, "hopper"), {"action": "east"}, "a frame of the hill has no `hopper`"),
        (("start", "positions"), KeyError, "start: "),
        (("start", "cheese"), [1, 2], "a state of the hill has no `cheese`"),
        (("world", "settings", "weight"), 0.1, "frame 1: by the world's rules"),
        (("world", "settings", "weight"), 50, "the setting `weight` cannot be 50"),
        (("world", "settings", "weights"), [0.1], "the setting `weights` cannot be [0.1]"),
        (("world", "settings", "weights"), [0.1, "x"], "the setting `weights` cannot be"),
        (("world", "settings", "beta"), 2, "world hill has no setting `beta`"),
        (("world", "name"), "kitchen", "world kitchen has no setting `sigma`"),
        (("world", "name"), "mountain", "there is no world `mountain`"),
    ],
)
def test_what_the_world_does_not_allow_is_said(path: tuple[Any, ...], to: Any, words: str) -> None:
    with pytest.raises(StoryError) as caught:
        read(change(*path, to=to))
    assert words in caught.value.diagnostics[0].render()


def test_a_script_of_another_world_is_an_error_both_ways() -> None:
    content = document()
    content["world"] = {"name": "kitchen"}
    with pytest.raises(StoryError, match="start"):
        read(content)
    content["world"] = {"name": "hill"}
    content["start"] = {"cheese": [3, 1], "robot": [5, 1], "table": None}
    with pytest.raises(StoryError, match="a state of the hill has no `cheese`"):
        read(content)


def test_a_kitchen_story_on_the_hill_names_what_is_missing() -> None:
    text = "world hill\nlength 5\nmaximize depict(rho > 0)\nmaximize arc(robot)\n"
    with pytest.raises(StoryError) as caught:
        story_from(Source("moved.story", text))
    shown = "\n".join(d.render() for d in caught.value.diagnostics)
    assert "`rho`" in shown
    assert "`robot`" in shown


@pytest.mark.parametrize(
    "value",
    [
        ["x" * 10**6, *[""] * 18], [["1", "2"]] * 19, [[1, True]] * 19, [[10**400, 1]] * 19,
        [[float("nan"), 1]] * 19, [[1e308, 1]] * 19, [{"a": 1}] * 19, [[[1, 2]]] * 19,
        [[1, 2]] * 10**5, [[1, 2], *[[1]] * 18], {"0": [1, 2]}, "x" * 38,
    ],
)  # fmt: skip
def test_what_are_no_numbers(value: Any) -> None:
    """NumPy is not asked: of a long text among others it makes as much of each of them."""
    with pytest.raises(StoryError, match='"positions" must be 19 x 2 numbers'):
        read(change("frames", 0, "state", "positions", to=value))
