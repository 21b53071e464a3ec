"""What became of each wish of a story, what could have become of it, and what is doubtful."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from i2pdsl.errors import Source
from i2pdsl.objective.replay import evaluate
from i2pdsl.objective.wishes import Wish, doubts, shares, wish
from i2pdsl.search import wishes as wishes_module
from i2pdsl.search.beam import processor_seconds
from i2pdsl.search.searches import search_of
from i2pdsl.search.wishes import wishes_of
from i2pdsl.stories import Result, Story, story_from
from stories_for_tests import BARE
from worlds_for_tests import with_small_world

TEXT = """\
world small
length 5
maximize sum_t P(rho > 0 | script[:t])  # a friend
maximize 3 * sum_{t in 3..5}
    P(rho < 0 | script[:t])
minimize [at(robot, pink) @ script[T]]
search beam(starts = 60, polish = 1)
"""
ONE = (
    "world small\nlength 5\nmaximize sum_t P(rho > 0 | script[:t])\n"
    "search beam(starts = 60, polish = 1)\n"
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return with_small_world(tmp_path_factory.mktemp("wishes"))


@pytest.fixture(scope="module")
def torn(folder: Path) -> Story:
    return story_from(Source("torn.story", TEXT), folder)


@pytest.fixture(scope="module")
def found(torn: Story) -> Result:
    return torn.solve(seed=0)


@pytest.fixture(scope="module")
def wishes(torn: Story, found: Result) -> tuple[Wish, ...]:
    told, finished = torn.wishes(found.script)
    assert finished
    return told


def test_each_statement_is_a_wish(wishes: tuple[Wish, ...], found: Result) -> None:
    assert [w.source for w in wishes] == [
        "maximize sum_t P(rho > 0 | script[:t])",
        "maximize 3 * sum_{t in 3..5} P(rho < 0 | script[:t])",
        "minimize [at(robot, pink) @ script[T]]",
    ]
    asked = [w.source.split(None, 1)[1] for w in wishes]
    assert [w.reached for w in wishes] == pytest.approx(
        [float(found.script.query(expression)) for expression in asked]
    )


def test_what_is_possible_alone_is_at_least_what_was_reached(wishes: tuple[Wish, ...]) -> None:
    friend, foe, away = wishes
    assert friend.possible is not None
    assert friend.possible > 4.5 > friend.reached  # of 5: the two exclude each other
    assert foe.possible is not None
    assert foe.possible >= foe.reached
    assert away.possible == away.reached == 0
    assert away.frames == ()
    assert set(friend.frames) <= {3, 4, 5}
    assert friend.frames


def test_one_wish_alone_is_searched_for_without_the_rest(torn: Story, found: Result) -> None:
    """The compiled program is the same; what it scores is that wish."""
    task = torn.task()
    script, shape = found.script, task.objective.shape
    frames = script.frames
    for number, (sign, value) in enumerate(torn.typed.objective):
        alone = replace(task, only=number).objective
        assert alone.shape == shape
        tables, state = task.world.tables, frames.state[0]
        carry = alone.init(tables, alone.params, state)
        for t in range(1, script.length + 1):
            frame = frames.at(t).each(np.asarray)
            carry = alone.step(tables, alone.params, carry, frame)
        scored = float(alone.score(tables, alone.params, carry, frame))
        assert scored == pytest.approx(sign * float(evaluate(task.world, frames, value, None)))


@pytest.mark.parametrize(
    "expression",
    [
        "sum_t P(rho > 0 | script[:t])",
        "2 * mean_t P(rho > 0 | script[:t]) - min_t P(rho > 0 | script[:t]) / 4",
        "max_t (t * P(rho > 0 | script[:t])) + 1",
        "-(sum_{t in 2..3} P(rho > 0 | script[:t]) * 3)",
        "4 * (P(rho > 0 | script[:T]) - P(rho > 0 | script[:1]))^2",
        "(sum_t P(rho > 0 | script[:t]))^2",
        "P(rho > 0 | script[:2])",
        "arc(robot)",
    ],
)
def test_shares_of_frames_sum_to_the_value(expression: str, found: Result) -> None:
    script = found.script
    value = script.check(expression).value
    told = shares(script.world, script.frames, value)
    assert told.shape == (script.length + 1,)
    assert told.sum() == pytest.approx(float(script.query(expression)))


def test_shares_stand_where_they_arise(found: Result) -> None:
    script = found.script
    told = lambda text: shares(script.world, script.frames, script.check(text).value)
    belief = script.query("P(rho > 0 | script[:t])")
    assert told("2 * sum_{t in 2..3} P(rho > 0 | script[:t])") == pytest.approx(
        [0, 0, 2 * belief[2], 2 * belief[3], 0, 0]
    )
    least = int(belief[1:].argmin()) + 1
    assert np.flatnonzero(told("min_t P(rho > 0 | script[:t])")).tolist() == [least]
    assert np.flatnonzero(told("P(rho > 0 | script[:2])")).tolist() == [2]
    assert np.flatnonzero(told("exp(sum_{t in 1..4} P(rho > 0 | script[:t]))")).tolist() == [4]


@pytest.mark.parametrize(
    ("reached", "frames"),
    [
        ((0.5, 0.9, 0.9, 0.2, 0.9), (4,)),  # .7 of 1.1
        ((0.5, 0.9, 0.5, 0.4, 0.9), (1, 4)),  # .4, .4 and .5
        ((0.9, 0.95, 0.9, 0.9, 0.9), ()),  # better than that
        ((0.5, 0.95, 0.9, 0.9, 0.9), (1,)),  # in one frame better, on the whole worse
    ],
)
def test_frames_that_hurt_are_the_fewest_that_make_half(
    reached: tuple[float, ...], frames: tuple[int, ...], torn: Story, found: Result
) -> None:
    helps = np.array([row.get("rho", 0.0) > 0 for row in torn.world().vocabulary.hypotheses])
    others = np.array(torn.typed.everyone_rational) & ~helps

    def believing(probabilities: tuple[float, ...]) -> Any:
        p = np.array((0.5, *probabilities))[:, None, None]
        belief = helps * p / helps.sum() + others * (1 - p) / others.sum()
        with np.errstate(divide="ignore"):
            return found.script.frames._replace(log_belief=np.log(belief))

    value = found.script.check("sum_t P(rho > 0 | script[:t])").value
    told = wish("maximize", 1, value, torn.world(), believing(reached), believing((0.9,) * 5))
    assert told.reached == pytest.approx(sum(reached))
    assert told.possible == pytest.approx(max(4.5, sum(reached)))
    assert told.frames == frames
    least = wish("minimize", -1, value, torn.world(), believing((0.9,) * 5), believing(reached))
    assert least.possible == pytest.approx(min(4.5, sum(reached)))


class Refuses:
    """A search that must not be used, or that is interrupted."""

    takes_effort = True

    def __init__(self, problem: BaseException):
        self.problem = problem

    def solve(self, *_: Any) -> Any:
        raise self.problem


def test_a_wish_that_nothing_competes_with_needs_no_search(folder: Path) -> None:
    alone = story_from(Source("a.story", ONE + BARE), folder)
    script = alone.solve(seed=0).script
    search: Any = Refuses(AssertionError("it was used"))
    ((told,), finished) = wishes_of(alone.task(), search, script.frames, 0)
    assert finished
    assert told.possible == told.reached


def test_an_interrupt_leaves_the_rest_unknown(torn: Story, found: Result) -> None:
    search: Any = Refuses(KeyboardInterrupt())
    told, finished = wishes_of(torn.task(), search, found.script.frames, 0)
    assert not finished
    assert [w.possible for w in told] == [None] * 3
    naive, finished = torn.wishes(found.script, naive=True)
    assert finished
    assert [w.possible for w in naive] == [None] * 3


def test_all_searches_together_are_one(torn: Story, found: Result) -> None:
    starts = []

    class Counts:
        takes_effort = True

        def solve(self, task: Any, *rest: Any) -> Any:
            starts.append((task.story.search.starts, task.only))
            return search_of(task.story).solve(task, *rest)

    search: Any = Counts()
    wishes_of(torn.task(), search, found.script.frames, 0)
    assert starts == [(20, 0), (20, 1), (20, 2)]


def test_doubts_are_about_characters_who_seem_to_act_at_random(torn: Story, found: Result) -> None:
    typed, script = torn.typed, found.script
    assert torn.doubts(script) == ()
    rational = np.array(typed.everyone_rational)
    belief = np.where(rational, 1e-3, 1.0)[None, None]
    belief = np.log(belief / belief.sum(-1, keepdims=True))
    random = np.repeat(belief, script.length + 1, axis=0)
    (swamped,) = doubts(typed, script.world, script.frames._replace(log_belief=random))
    assert swamped.code == "swamped"
    assert swamped.severity == "warning"
    assert swamped.span.text.startswith("maximize sum_t P(rho > 0")
    once = script.frames.log_belief.copy()
    once[3] = belief[0]
    (refuted,) = doubts(typed, script.world, script.frames._replace(log_belief=once))
    assert refuted.code == "refuted"
    assert "frame 3" in refuted.message


def test_an_assumption_of_the_story_is_doubted_at_its_place(folder: Path) -> None:
    text = ONE + "assume G_robot = green\n"
    story = story_from(Source("assumed.story", text), folder)
    world = story.world()
    frames = story.solve(seed=0).script.frames
    green = np.array([row.get("G_robot") == "green" for row in world.vocabulary.hypotheses])
    belief = np.where(green[None, None], frames.log_belief - 9, frames.log_belief)
    belief = belief - np.log(np.exp(belief).sum(-1, keepdims=True))
    (refuted,) = doubts(story.typed, world, frames._replace(log_belief=belief))
    assert refuted.span.text == "assume G_robot = green"


def test_what_is_possible_is_looked_for_no_longer_than_a_minute(
    torn: Story, monkeypatch: pytest.MonkeyPatch
) -> None:
    task = torn.task()
    more = replace(task.story.search, polish=11)
    task = replace(task, story=replace(task.story, search=more))
    assert wishes_module._affordable(task) == (60, 11)
    given = task.world, task.objective, 5, 60 * 12, task.events
    long = processor_seconds(*given)
    for share, afforded in ((3.0, (60, 3)), (11.9, (60, 0)), (24.1, (29, 0)), (1e9, (1, 0))):
        monkeypatch.setattr(wishes_module, "PATIENCE", long / share)
        assert wishes_module._affordable(task) == afforded
    monkeypatch.setattr(wishes_module, "PATIENCE", long / 24.1)
    alone = wishes_module._alone(task, 1, search_of(task.story)).story.search
    assert (alone.starts, alone.polish) == (9, 0)  # a third of the 29
