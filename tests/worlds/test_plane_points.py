"""Points of a plane in stories: what they say, what is wrong with them, and where stories begin."""

from __future__ import annotations

import math

import numpy as np
import pytest

from i2pdsl.errors import Source, StoryError
from i2pdsl.language import typed as ty
from i2pdsl.language.check import check_source
from i2pdsl.language.story import TypedStory
from i2pdsl.objective.replay import evaluate, replay
from i2pdsl.objective.requirements import SHORTFALL, violations
from i2pdsl.objective.starts import allowed_starts
from i2pdsl.worlds.plane.kind import KIND
from i2pdsl.worlds.record import Trajectory
from plane_for_tests import DESK, PAIR, WALLED, build_plane, wandered

LENGTH = 12


def story(text: str, spec=PAIR) -> TypedStory:
    source = Source("points.story", f"world {spec.name}\nlength {LENGTH}\nmaximize 0\n{text}\n")
    return check_source(source, lambda *_: KIND.vocabulary(spec))


@pytest.fixture(scope="module")
def walked():
    """A world, and frames of two who wander in it."""
    world = build_plane(PAIR)
    states, actions = wandered(world, LENGTH)
    return world, replay(world, states, actions), states


def test_what_points_say_in_plain_python(walked):
    world, frames, states = walked
    (x, y), r = states[5][2:4], PAIR.characters[1].radius
    for dx in (0.0, 0.24 * r, 0.26 * r, 1.5):
        point = f"({x + dx:.9f}, {y:.9f})"
        (at,) = story(f"require [at(cat, {point}) @ script[5]]").requirements
        assert bool(evaluate(world, frames, at.condition, None)) == (dx <= 0.25 * r)
        asked = story(f"require [distance(cat, {point}) @ script[5]] < {dx + 1e-6}")
        assert evaluate(world, frames, asked.requirements[0].condition, None) == 1.0
    apart = math.dist(states[5][:2], PAIR.places[0].at)
    place = story(f"require [distance(mouse, left) @ script[5]] <= {apart - 1e-6}")
    assert evaluate(world, frames, place.requirements[0].condition, None) == 0.0


def test_whither_somebody_heads_is_what_it_tries():
    """In plain Python, from the actions: whatever was in the way."""
    world = build_plane(PAIR)
    _, actions = wandered(world, LENGTH)
    actions += np.array([-0.4, -0.2, 0.4, 0.2])  # at each other, faster than they can
    states = [world.starts()[0]]
    for action in actions:
        states.append(world.transition(world.tables, states[-1], action))
    frames = replay(world, np.array(states), actions)
    stopped = 0
    for t in range(1, LENGTH + 1):
        for who, (name, other) in enumerate((("mouse", "cat"), ("cat", "mouse"))):
            x, y, *_ = states[t - 1][2 * who : 2 * who + 2]
            u, v = actions[t - 1][2 * who : 2 * who + 2]
            tried = math.hypot(u, v)
            most = PAIR.characters[who].fastest
            u, v = (u * min(1, most / tried), v * min(1, most / tried))
            moved = states[t][2 * who : 2 * who + 2] - states[t - 1][2 * who : 2 * who + 2]
            stopped += math.dist(moved, (u, v)) > 1e-3
            there = {
                "left": PAIR.places[0].at,
                "(3.5, 6.25)": (3.5, 6.25),
                other: states[t - 1][2 - 2 * who : 4 - 2 * who],
            }
            for spot, (to_x, to_y) in there.items():
                way = math.hypot(to_x - x, to_y - y)
                expected = (u * (to_x - x) + v * (to_y - y)) / way / PAIR.characters[who].speed
                wish = f"require [heads({name}, {spot}) @ script[{t}]] > {{}}"
                for less, holds in ((1e-5, 1.0), (-1e-5, 0.0)):
                    (asked,) = story(wish.format(f"{expected - less:.9f}")).requirements
                    assert evaluate(world, frames, asked.condition, None) == holds
    assert stopped > 2


@pytest.mark.parametrize("place", ["(3.5, 6.25)", "left"])
def test_a_pin_costs_what_is_missing_from_anywhere(walked, place):
    world, frames, states = walked
    ((price, missed),) = violations(story(f"pin script[7]: at(mouse, {place})"), world)
    at, near = ((4.0, 7.0), 0.5) if place == "left" else ((3.5, 6.25), 0.25 * 0.4)
    away = math.dist(states[7][:2], at)
    assert away > 1  # a step of a predicate is flat so far away
    assert price == -SHORTFALL
    assert float(evaluate(world, frames, missed, None)) == pytest.approx(away - near)


def test_stories_begin_at_points_with_room_for_who_begins_there():
    world = build_plane(WALLED)
    start = story("start at(mouse, (9.5, 3)) and at(cat, left)", WALLED).start
    ((x, y, u, v, *_),) = allowed_starts(world, start)
    assert (x, y, u, v) == (9.5, 3.0, 4.0, 7.0)
    beside = allowed_starts(world, story("start at(mouse, (2.2, 2))", WALLED).start)
    assert (beside[:, 2:4] != (2, 2)).any(axis=-1).all()  # where the cat would be
    for blocked in ("(0.2, 3)", "(4.1, 4)"):  # the edge, a wall
        assert not len(allowed_starts(world, story(f"start at(mouse, {blocked})", WALLED).start))
    assert len(allowed_starts(build_plane(DESK), story("", DESK).start)) == 4


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("pin script[3]: at(cat, (12.5, 3))", "(12.5, 3) is outside 12 x 8 units"),
        ("pin script[3]: at(cat, 3)", "expected a place"),
        ("pin script[3]: progress(cat, (2, 3)) > 0", "expected a place"),
        ("pin script[3]: at(cat, nowhere)", "there is no place `nowhere`"),
    ],
)
def test_mistakes_are_told(text, message):
    with pytest.raises(StoryError, match=message.replace("(", r"\(").replace(")", r"\)")) as found:
        story(text)
    assert found.value.diagnostics[0].span.start > 0


def test_points_and_numbers_of_places_are_not_taken_for_each_other():
    words = KIND.vocabulary(PAIR)
    point = ty.Feature("at", (0, ty.Point(1.0, 0.0)), None)
    place = ty.Feature("at", (0, words.places["right"]), None)
    assert words.places["right"] == ((1, 0),)
    assert point != place


def test_frames_are_kept_by_few_pins(walked):
    world, _, states = walked
    path = Trajectory(np.zeros((LENGTH, 4)), states)
    lines = KIND.kept(world, path, 2, 9)
    told = story("\n".join(lines))
    frames = sorted({pin.frame for pin in told.pins})
    assert frames[0] == 2
    assert frames[-1] == 9
    straight = {"mouse": [], "cat": []}
    for pin in told.pins:
        for node in ty.walk(pin.condition):
            if isinstance(node, ty.Feature):
                place = node.arguments[1]
                straight[PAIR.characters[node.arguments[0]].name].append(
                    (pin.frame, place.x, place.y)
                )
    for number, c in enumerate(PAIR.characters):
        at, x, y = np.array(straight[c.name]).T
        for frame in range(2, 10):
            seen = states[frame][2 * number : 2 * number + 2]
            way = (np.interp(frame, at, x), np.interp(frame, at, y))
            assert math.dist(seen, way) <= 0.25 * c.radius + 1e-3
