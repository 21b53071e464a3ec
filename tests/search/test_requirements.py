"""Requirements and `when`, against plain Python on every script of a corridor."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from i2pdsl.errors import Source
from i2pdsl.language.check import Library, TypedStory, check_source
from i2pdsl.objective.belief import first_belief
from i2pdsl.objective.fold import Objective
from i2pdsl.objective.frame import Frame, observe
from i2pdsl.objective.replay import evaluate, replay
from i2pdsl.objective.requirements import VIOLATION, unmet, violations
from i2pdsl.objective.terms import story_objective
from i2pdsl.stories import Story
from i2pdsl.worlds.grid.world import GridWorld
from plane_for_tests import DESK, build_plane, wandered
from stories_for_tests import BARE
from worlds_for_tests import CORRIDOR, planned, small_kitchen, trajectory

FRAMES = 3
STARTS = (0, 2)
Walk = tuple[int, ...]
"""The cells from left to right, 0 to 4, at the start and after each frame."""


def world() -> GridWorld:
    return planned(CORRIDOR, "corridor")


def story(*lines: str, length: int = FRAMES, weights: str = BARE) -> TypedStory:
    head = (f"world corridor\nlength {length}\n{weights}", *lines)
    checked = check_source(Source("s.story", "\n".join(head)), lambda *_: world().vocabulary)
    assert not isinstance(checked, Library)
    return checked


def moved(walk: Walk) -> list[bool]:
    """Of each frame."""
    return [a != b for a, b in itertools.pairwise(walk)]


def first(holds: list[bool]) -> int:
    """The number of the first frame that holds, or one more than there are."""
    return holds.index(True) + 1 if True in holds else len(holds) + 1


def at(walk: Walk, cell: int) -> list[bool]:
    return [x == cell for x in walk[1:]]


# What is required, what it means, and whether a prefix is known at once to have broken it.
REQUIRED: list[tuple[str, Callable[[Walk], bool], bool]] = [
    ("[at(one, left) @ script[T]]", lambda w: w[3] == 0, True),
    ("[at(one, (3, 0)) @ script[2]]", lambda w: w[2] == 3, True),
    ("not [moved(one) @ script[1]]", lambda w: w[0] == w[1], True),
    ("[moved(one) and at(one, (1, 0)) @ script[3]]", lambda w: w[2] != w[3] == 1, True),
    ("never [moved(one)]", lambda w: not any(moved(w)), True),
    ("eventually [at(one, right)]", lambda w: 4 in w[1:], True),
    (
        "eventually [at(one, right)] or not never [at(one, left)]",
        lambda w: 4 in w[1:] or 0 in w[1:],
        True,
    ),
    (
        "[at(one, (1, 0))] before [at(one, (3, 0))]",
        lambda w: first(at(w, 1)) < first(at(w, 3)) <= FRAMES,
        False,
    ),
    ("when [at(one, (4, 0))] <= 2", lambda w: 4 in w[1:3], True),
    ("when [moved(one)] > 1", lambda w: w[0] == w[1], True),
    ("1 < when [moved(one)] <= 2", lambda w: w[0] == w[1] != w[2], False),
    (
        "when [moved(one)] < when [at(one, left)]",
        lambda w: first(moved(w)) < first(at(w, 0)),
        False,
    ),
    ("(sum_t [moved(one) @ script[t]]) >= 2", lambda w: sum(moved(w)) >= 2, False),
    (
        "[moved(one) @ script[1]] = [moved(one) @ script[2]]",
        lambda w: moved(w)[0] == moved(w)[1],
        False,
    ),
]


@cache
def walks() -> dict[Walk, tuple[int, ...]]:
    """The scripts of FRAMES frames that look different, with their actions, by brute force."""
    found: dict[Walk, tuple[int, ...]] = {}
    for start in STARTS:
        for actions in itertools.product(range(5), repeat=FRAMES):
            states = trajectory(world(), start, np.array(actions)).states
            found.setdefault(tuple(int(s) for s in states), actions)
    return found


def prefix_score(objective: Objective, walk: Walk, count: int) -> float:
    """What the fold says of a script's first frames, in NumPy."""
    tables, params = world().tables, objective.params
    carry = objective.init(tables, params, np.asarray(walk[0]))
    frame: Frame | None = None
    belief = first_belief(world(), tables)
    for number, action in enumerate(walks()[walk][:count], 1):
        state = np.asarray(walk[number - 1])
        frame = observe(world(), tables, np.asarray(number), state, np.asarray(action), belief)
        belief = frame.belief
        carry = objective.step(tables, params, carry, frame)
    return float(objective.score(tables, params, carry, frame))


def frames_of(walk: Walk) -> Frame:
    path = trajectory(world(), walk[0], np.array(walks()[walk]))
    return replay(world(), path.states, path.actions)


@pytest.mark.parametrize(
    ("text", "met", "at_once"), REQUIRED, ids=lambda x: x if isinstance(x, str) else ""
)
def test_a_prefix_has_broken_what_no_ending_can_meet(
    text: str, met: Callable[[Walk], bool], at_once: bool
) -> None:
    typed = story("maximize 0", f"require {text}")
    objective = story_objective(typed, world())
    assert not objective.keeps_history
    for walk in walks():
        missed = [r.text for r in unmet(typed, world(), frames_of(walk))]
        assert missed == ([] if met(walk) else [f"require {text}"])
        assert prefix_score(objective, walk, FRAMES) == (0 if met(walk) else -VIOLATION)
    for count in range(1, FRAMES):
        for walk in {w[: count + 1]: w for w in walks()}.values():
            possible = any(met(w) for w in walks() if w[: count + 1] == walk[: count + 1])
            broken = prefix_score(objective, walk, count) == -VIOLATION
            assert not (broken and possible), (walk, count)
            assert broken or possible or not at_once, (walk, count)


def test_beliefs_of_single_frames_are_kept_without_all_frames() -> None:
    text = "P(G_one = left | script[:1]) > 0.5 and KL(script[:1] || script[:2]) < 0.01"
    typed = story("maximize 0", f"require {text}")
    objective = story_objective(typed, world())
    assert not objective.keeps_history
    for walk in walks():
        frames = frames_of(walk)
        belief = np.exp(frames.log_belief[:, 0])
        seen = world().vocabulary.hypotheses.index({"G_one": "left", "R_one": True})
        rational = np.array([h["R_one"] for h in world().vocabulary.hypotheses])
        after = [b * rational / b[rational].sum() for b in belief]
        apart = sum(p * np.log(p / q) for p, q in zip(after[1], after[2], strict=True) if p > 0)
        first_holds, both = after[1][seen] > 0.5, after[1][seen] > 0.5 and apart < 0.01
        assert (prefix_score(objective, walk, 1) == 0) == first_holds
        assert (prefix_score(objective, walk, 2) == 0) == both


TURNS = [
    ("if t <= when [moved(one)] then 1 else 10", lambda t, w: 1 if t <= w else 10, False),
    ("if when [moved(one)] = t then t else 0", lambda t, w: t if t == w else 0, False),
    ("if t - 1 < when [moved(one)] then 1 else 10", lambda t, w: 1 if t - 1 < w else 10, False),
    ("if t + 1 < when [moved(one)] then 1 else 10", lambda t, w: 1 if t + 1 < w else 10, True),
    ("when [moved(one)] - t", lambda t, w: w - t, True),
    ("if eventually [moved(one)] then t else 0", lambda t, w: t if w <= FRAMES else 0, True),
]


@pytest.mark.parametrize(
    ("term", "value", "history"), TURNS, ids=lambda x: x if isinstance(x, str) else ""
)
def test_a_turn_comes_with_its_event(
    term: str, value: Callable[[int, int], int], history: bool
) -> None:
    typed = story(f"maximize sum_t ({term})", "maximize [at(one, left) @ script[T]]")
    objective = story_objective(typed, world())
    assert objective.keeps_history == history
    for walk in walks():
        turn = first(moved(walk))
        expected = sum(value(t, turn) for t in range(1, FRAMES + 1))
        found = evaluate(world(), frames_of(walk), typed.objective[0][1], None)
        assert found == expected, walk
        if not history:
            assert prefix_score(objective, walk, FRAMES) == expected + (walk[-1] == 0)


def test_events_that_a_story_allows_count_as_ways() -> None:
    pair = small_kitchen()
    text = "world w\nlength 2\nmaximize 0\nrequire [at(table, (0, 2)) @ script[1]]\n"
    kitchen = pair.world
    absent = kitchen.dynamics.cells[:, 2] == kitchen.dynamics.absent
    (closed,) = story_objective(pair.story(text), kitchen).params.reach
    (open_,) = story_objective(pair.story(text + "allow deus(table)"), kitchen).params.reach
    states = kitchen.dynamics.state_count
    assert (closed[:states][absent] > 1000).all()
    there = kitchen.dynamics.coordinates.tolist().index([0, 2])
    taken = (kitchen.dynamics.cells[:, :2] == there).any(1)
    assert (open_[:states][absent & ~taken] == 1).all()
    # Whoever stands there has to go first; the cheese may have to wait for the robot.
    assert set(open_[:states][absent & taken].tolist()) == {2, 3}


DESK_REQUIRED = (
    "[at(hand, left) @ script[T]]",
    "not [moved(hand) @ script[3]]",
    "[moved(hand) @ script[2]] and never [at(hand, right)]",
    "eventually [distance_gone > 0.02]",
    "when [idle(hand)] > 3 or P(G_hand = left | script[:4]) > 0.4",
    "(mean_t [speed(hand) @ script[t]]) < 0.03",
    "not (P(G_hand = low | script[:T]) <= 0.3 and eventually [sees(hand, low)])",
)


@pytest.mark.parametrize("text", DESK_REQUIRED)
def test_where_bodies_move_something_is_lost_where_a_requirement_is_missed(text: str) -> None:
    desk = build_plane(DESK)
    lines = ("world desk", "length 6", "let distance_gone = speed(hand)", "maximize 0")
    source = Source("s.story", "\n".join((*lines, f"require {text}")))
    typed = check_source(source, lambda *_: desk.vocabulary)
    assert not isinstance(typed, Library)
    ((weight, missed),) = violations(typed, desk)
    assert weight < 0
    for seed in range(12):
        frames = replay(desk, *wandered(desk, 6, seed, spread=0.3 * (seed % 4)))
        value = evaluate(desk, frames, missed, None)
        assert value >= 0
        assert (value > 0) == bool(unmet(typed, desk, frames)), seed


def test_the_search_meets_what_it_can_and_says_what_it_cannot() -> None:
    typed = story(
        "maximize sum_t P(G_one = left | script[:t])",
        "require [at(one, right) @ script[T]]",
        "require when [at(one, right)] <= 0",
        length=5,
        weights="",
    )
    result = Story(typed, known=world().spec).solve(candidates=3)
    for script in result.candidates:
        assert script.record.frames[-1]["state"]["one"] == [4, 0]
    assert [r.text for r in result.unmet] == [typed.requirements[1].text]
    told = result.unmet[0].missed().render()
    assert told.startswith("s.story:6:1: warning[unmet]: no script was found that meets")
    assert result.score > 0  # the score is told without what broken requirements cost
