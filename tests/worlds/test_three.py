"""Three and four characters on a grid, against tests/reference.py: an independent transcription of
docs/worlds.md, "Three and more"."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from itertools import product
from pathlib import Path
from random import Random

import numpy as np
import pytest

import reference as R
from i2pdsl.errors import Source, StoryError
from i2pdsl.language.check import check_query
from i2pdsl.language.scope import Module
from i2pdsl.objective.frame import Frame
from i2pdsl.objective.replay import evaluate, replay
from i2pdsl.pipeline import Story
from i2pdsl.worlds.grid.kind import KIND
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.grid.vocabulary import grid_vocabulary
from i2pdsl.worlds.record import Record
from reference import Character, Object
from stories_for_tests import BARE
from worlds_for_tests import Pair, planned

COURT = """
map
    T..
    ..P
tile tower
    symbol = T
tile pond
    symbol = P
character queen
    success = 0.6
    goals = {tower, pond}
character fox
    goals = {pond, none}
    pushes = {queen, bear}
    toward = {queen: {-2, 0, 2}}
character bear
    success = 0.9
    pushes = {queen, fox}
    toward = {queen: {-1, 1}, fox: {-1, 0, 2}}
planning
    gamma = 0.8
"""
FOLD = """
map
    A.#
    ..B
    .##
tile hay
    symbol = A
tile pond
    symbol = B
character rex
    goals = hay
    pushes = {ewe, box}
    toward = ewe
    attitude = {-3, 1}
character ewe
    success = 0.7
    goals = {hay, pond}
character tom
    success = 0.8
    goals = {pond, none}
    pushes = {rex, ewe}
    toward = {ewe: {0, 2}}
object box
    may_be_absent = yes
event deus
    drops = box
rewards
    goal = 1.5
    move = -0.7
planning
    order = [tom, rex, ewe]
    gamma = 0.7
    beta = 1.5
    level0 = costs
"""
FOUR = """
map
    A.B
    ...
tile a
    symbol = A
tile b
    symbol = B
character one
    goals = {a, b}
    models = four
character two
    success = 0.5
    goals = b
    pushes = one
    models = {four, one}
character three
    pushes = {one, two, four}
    toward = {two: {-2, 3}}
character four
    success = 0.8
    goals = a
    pushes = three
audience
    forgetting = 0.05
planning
    order = [four, two, three, one]
    gamma = 0.7
"""


@dataclass(frozen=True)
class Case:
    """A world, and what tests/reference.py has instead."""

    text: str
    rows: tuple[str, ...]
    tiles: dict[str, tuple[int, int]]
    characters: tuple[Character, ...]  # in acting order
    settings: dict
    latents: dict[str, set]  # the attitudes, and their values
    hypotheses: int  # counted by hand


CASES = {
    # A chain; the last one cares about both. All rational: 2 goals of the queen, 3 + 2 of the fox's
    # (goal, rho), 2 x 3 of the bear's: 60. The queen irrational: 2 of the fox's, 2 of the bear's: 4.
    # The fox irrational: 2 x 2; both: 1. The same without the bear, who is irrational: 10 + 2 + 2 + 1.
    "court": Case(
        COURT,
        ("...", "..."),
        {"tower": (0, 0), "pond": (2, 1)},
        (
            Character("queen", 0.6, (), ("tower", "pond")),
            Character("fox", 1, ("queen", "bear"), ("pond", "none"), {"queen": (-2, 0, 2)}),
            Character("bear", 0.9, ("queen", "fox"), toward={"queen": (-1, 1), "fox": (-1, 0, 2)}),
        ),
        {"gamma": 0.8},
        {
            "rho_fox_queen": {-2, 0, 2},
            "rho_bear_queen": {-1, 0, 1},  # 0 beside an irrational queen
            "rho_bear_fox": {-1, 0, 2},
        },
        60 + 4 + 4 + 1 + 10 + 2 + 2 + 1,
    ),
    # Two care about one and do not model each other. Beside a rational ewe of 2 goals rex has 2, and
    # 1 if irrational, tom 3 and 1; beside an irrational one rex 1 and 1, tom 2 and 1.
    "fold": Case(
        FOLD,
        ("..#", "...", ".##"),
        {"hay": (0, 0), "pond": (2, 1)},
        (
            Character("tom", 0.8, ("rex", "ewe"), ("pond", "none"), {"ewe": (0, 2)}),
            Character("rex", 1, ("ewe", "box"), ("hay",), "ewe", (-3, 1)),
            Character("ewe", 0.7, (), ("hay", "pond")),
        ),
        {
            "objects": (Object("box", may_be_absent=True),),
            "rewards": {"goal": 1.5, "move": -0.7},
            "gamma": 0.7,
            "beta": 1.5,
            "level0": "costs",
        },
        {"rho_tom_ewe": {0, 2}, "rho_rex_ewe": {-3, 0, 1}},
        2 * 3 * 4 + 2 * 3,
    ),
    # Four, of whom one models two others without an attitude. One has 2 + 1, four 1 + 1, two and
    # three together 2 + 1 + 1 + 1.
    "four": Case(
        FOUR,
        ("...", "..."),
        {"a": (0, 0), "b": (2, 0)},
        (
            Character("four", 0.8, ("three",), ("a",)),
            Character("two", 0.5, ("one",), ("b",), models=("four", "one")),
            Character("three", 1, ("one", "two", "four"), toward={"two": (-2, 3)}),
            Character("one", 1, (), ("a", "b"), models="four"),
        ),
        {"gamma": 0.7, "forgetting": 0.05},
        {"rho": {-2, 0, 3}},
        3 * 2 * 5,
    ),
}


@dataclass(frozen=True)
class Seen:
    """A script as the fast code has it, and as script.json does."""

    frames: Frame
    document: dict


@dataclass(frozen=True)
class Setup:
    case: Case
    pair: Pair
    scripts: tuple[Seen, ...]

    def asked(self, seen: Seen, expression: str) -> np.ndarray:
        """A query's values over the frames of a script."""
        length, module = len(seen.document["frames"]), Module(Source("query", ""))
        query = check_query(Source("query", expression), self.pair.vocabulary, module, length)
        return np.asarray(evaluate(self.pair.world, seen.frames, query.value, query.times))


@pytest.fixture(scope="module", params=CASES)
def setup(request: pytest.FixtureRequest) -> Setup:
    case, random = CASES[request.param], Random(request.param)
    truth = R.World(case.rows, case.tiles, case.characters, **case.settings)
    pair = Pair(planned(case.text), truth)
    paths = [pair.random_script(random, 4, events=0.2) for _ in range(3)]
    scripts = [Seen(replay(pair.world, p.states, p.actions), pair.document(p)) for p in paths]
    return Setup(case, pair, tuple(scripts))


def test_hypotheses_are_those_of_the_text(setup: Setup) -> None:
    words, case = setup.pair.vocabulary, setup.case
    assert len(words.hypotheses) == case.hypotheses
    setup.pair.order()  # raises where one is missing
    assert setup.pair.spec.state_count == setup.pair.reference.count_states()
    found = {n: set(latent.values) for n, latent in words.latents.items() if n.startswith("rho")}
    assert found == case.latents
    for character in case.characters:
        assert words.latents[f"G_{character.name}"].values == character.goals


def test_values_agree(setup: Setup) -> None:
    pair, truth = setup.pair, setup.pair.reference
    dynamics, order = pair.world.dynamics, pair.order()
    places = [*map(tuple, dynamics.coordinates.tolist()), None]
    numbers = np.arange(0, dynamics.state_count, 37)
    for who, character in enumerate(setup.case.characters):
        values = pair.world.value(pair.world.tables, who, numbers)[:, 0]
        for h, hypothesis in enumerate(pair.vocabulary.hypotheses):
            if hypothesis[f"R_{character.name}"]:
                for row, number in enumerate(numbers):
                    state = tuple(places[c] for c in dynamics.cells[number])
                    expected = truth.value(character.name, truth.hypotheses[order[h]], state)
                    assert values[row, h] == pytest.approx(expected, abs=1e-6)


def test_beliefs_agree(setup: Setup) -> None:
    order = setup.pair.order()
    for seen in setup.scripts:
        for t, belief in enumerate(setup.pair.reference.beliefs(seen.document)):
            row = [belief[i] for i in order]
            np.testing.assert_allclose(np.exp(seen.frames.log_belief[t, 0]), row, atol=1e-8)


def test_the_belief_changes_with_each_action(setup: Setup) -> None:
    truth = setup.pair.reference
    latent = next(iter(setup.case.latents))
    for number, character in enumerate(setup.case.characters, start=1):
        for seen in setup.scripts[:2]:
            values = setup.asked(seen, f"P({latent} < 0 | script[:t, {character.name}])")
            for t, value in enumerate(values, start=1):
                belief = R.posterior_within(truth, seen.document, t, number)
                less = (p for i, p in belief.items() if truth.hypotheses[i][latent] < 0)
                assert value == pytest.approx(sum(less), abs=1e-6)


def test_questions_agree(setup: Setup) -> None:
    truth = setup.pair.reference
    names = [character.name for character in setup.case.characters]
    questions: dict[str, Callable] = {
        "entropy(script[:t])": lambda s, t: R.entropy(truth, s, t),
        "surprise(script[t])": lambda s, t: R.surprise(truth, s, t),
        "KL(script[:t-1] || script[:t])": lambda s, t: R.KL(truth, s, t - 1, t),
    }
    for who in names:
        questions[f"E[V({who}) | script[:t]]"] = lambda s, t, who=who: R.EV(truth, s, t, who)
        for other in names:
            if other != who:
                questions[f"[pushes({who}, {other}) @ script[t]]"] = (
                    lambda s, t, who=who, other=other: R.pushes(truth, s, t, who, other)
                )
    for latent in setup.case.latents:
        questions[f"E[{latent} | script[:t]]"] = lambda s, t, latent=latent: R.E(
            truth, s, t, lambda h: h.get(latent)
        )
    for expression, expected in questions.items():
        for seen in setup.scripts:
            values = setup.asked(seen, expression)
            for t, value in enumerate(values, start=5 - len(values)):
                assert value == pytest.approx(float(expected(seen.document, t)), abs=1e-6)


def test_the_evidence_is_that_of_all_actions(setup: Setup) -> None:
    truth = setup.pair.reference
    for seen in setup.scripts:
        (value,) = np.atleast_1d(setup.asked(seen, "-sum_t surprise(script[t])"))
        assert value == pytest.approx(
            -sum(R.surprise(truth, seen.document, t) for t in range(1, 5))
        )


@pytest.mark.parametrize("setup", ["fold"], indirect=True)  # a sum over hundreds of frames
def test_what_comes_next_agrees(setup: Setup) -> None:
    """What viewers expect everybody to do, and how much they expect it to tell them."""
    truth, seen = setup.pair.reference, setup.scripts[0]
    shorter = {**seen.document, "frames": seen.document["frames"][:1]}
    latent = next(iter(setup.case.latents))
    value = setup.asked(seen, f"suspense({latent} | script[:1])")
    assert float(np.ravel(value)[0]) == pytest.approx(R.suspense(truth, shorter, 1, latent))
    for character in setup.case.characters:
        values = np.ravel(setup.asked(seen, f"next({character.name} | script[:1])"))
        expected = R.next_action(truth, shorter, 1, character.name)
        found = dict(zip(setup.pair.vocabulary.actions, values, strict=False))
        assert found == pytest.approx({a: expected.get(a, 0.0) for a in found}, abs=1e-6)
