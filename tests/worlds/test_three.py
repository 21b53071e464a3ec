"""Three and four characters on a grid, against tests/reference.py: an independent transcription of
docs/worlds.md, "Three and more"."""

from __future__ import annotations

import math
import re
from collections import Counter
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
from i2pdsl.stories import Script, Story
from i2pdsl.worlds.grid.kind import KIND
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.grid.policy import log_policy
from i2pdsl.worlds.grid.vocabulary import grid_vocabulary
from i2pdsl.worlds.record import Record
from reference import Character, Object
from searches_for_tests import compiling_briefly
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
    toward = {queen: {0, 2}}
character bear
    success = 0.9
    pushes = {queen, fox}
    toward = {queen: {-1, 1}, fox: {0, 2}}
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
    gamma = 0.5
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
    # A chain; the last one cares about both, and the fox may be wrong about the queen. All
    # rational: 2 goals of the queen, 2 + 1 of the fox's (goal, rho) by 2 that it may take hers to
    # be, 2 x 2 of the bear's. The queen irrational: 2 of the fox's, 1 of the bear's. The fox
    # irrational: 2 x 2; both: 1. The bear irrational: 2 x 3 x 2, 2, 2 and 1.
    "court": Case(
        COURT.replace("character bear\n", "    misreads = queen\ncharacter bear\n"),
        ("...", "..."),
        {"tower": (0, 0), "pond": (2, 1)},
        (
            Character("queen", 0.6, (), ("tower", "pond")),
            Character(
                "fox",
                1,
                ("queen", "bear"),
                ("pond", "none"),
                {"queen": (0, 2)},
                misreads=("queen",),
            ),
            Character("bear", 0.9, ("queen", "fox"), toward={"queen": (-1, 1), "fox": (0, 2)}),
        ),
        {"gamma": 0.8},
        {
            "rho_fox_queen": {0, 2},
            "rho_bear_queen": {-1, 0, 1},  # 0 beside an irrational queen
            "rho_bear_fox": {0, 2},
        },
        48 + 2 + 4 + 1 + 12 + 2 + 2 + 1,
    ),
    # Two care about one and do not model each other. Beside a rational ewe of 2 goals rex has 2,
    # and 1 if irrational, tom 3 and 1; beside an irrational one rex 1 and 1, tom 2 and 1.
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
        {"gamma": 0.5, "forgetting": 0.05},
        {"rho": {-2, 0, 3}},
        3 * 2 * 5,
    ),
}


def reference_of(name: str) -> dict:
    """The arguments of reference.World."""
    case = CASES[name]
    told = {"rows": case.rows, "tiles": case.tiles, "characters": case.characters}
    return told | case.settings


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
    truth = R.World(**reference_of(request.param))
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
            values = setup.asked(seen, f"P({latent} > 0 | script[:t, {character.name}])")
            for t, value in enumerate(values, start=1):
                belief = R.posterior_within(truth, seen.document, t, number)
                helps = (p for i, p in belief.items() if truth.hypotheses[i][latent] > 0)
                assert value == pytest.approx(sum(helps), abs=1e-6)


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


# ---- A time limit --------------------------------------------------------------------------------

TIMED = """
map
    A..
    .B#
tile a
    symbol = A
tile b
    symbol = B
character one
    goals = {{a, b}}
    success = 0.6
character two
    pushes = {{one, three}}
    toward = {{one: {{-1, 2}}}}
character three
    success = 0.8
    goals = {{b, none}}
    toward = {{two: {{0, 1}}}}
    models = one
rewards
    end = 4
planning
    horizon = {horizon}
    gamma = 0.9
"""


class Timed(R.World):
    """With so many frames: backward induction by recursion."""

    def __init__(self, horizon: int):
        super().__init__(
            ["...", "..#"],
            {"a": (0, 0), "b": (1, 1)},
            [
                Character("one", 0.6, (), ("a", "b")),
                Character("two", 1, ("one", "three"), toward={"one": (-1, 2)}),
                Character("three", 0.8, (), ("b", "none"), {"two": (0, 1)}, models="one"),
            ],
            gamma=0.9,
        )
        self.horizon = horizon
        self.q, self.v, self.w, self.seen = map(cache, (self.q, self.v, self.w, self.seen))

    def end(self, problem: tuple, state: tuple) -> float:
        """What the last picture is worth."""
        stands = lambda who, goal: 4.0 * (self.cell(state, who) == self.tiles.get(goal))
        cared = [(rho, other, view[1]) for other, rho, view in problem[2] if rho]
        return stands(*problem[:2]) + sum(rho * stands(*other) for rho, *other in cared)

    def q(self, problem: tuple, frame: int, state: tuple, action: str) -> float:
        who, goal, _ = problem
        then = sum(p * self.w(problem, frame, s) for p, s in self.outcomes(state, who, action))
        return self.reward(who, goal, state, action) + self.gamma * then

    def v(self, problem: tuple, frame: int, state: tuple) -> float:
        return max(self.q(problem, frame, state, action) for action in R.ACTIONS)

    def seen(self, other: str, view: tuple | str, frame: int, state: tuple) -> dict[str, float]:
        """How another is expected to act."""
        if isinstance(view, str):
            return self.pi_0()
        return R.softmax({a: self.beta * self.q(view, frame, state, a) for a in R.ACTIONS})

    def w(self, problem: tuple, frame: int, state: tuple) -> float:
        """What comes after an action in a frame: the others' until the own next one, or the end."""
        order, (who, _, others) = list(self.characters), problem
        found, reached, now = 0.0, {state: 1.0}, frame
        for other, rho, view in others:
            now = frame if order.index(other) > order.index(who) else frame + 1
            if now == self.horizon:
                break
            before, reached = reached, {}
            for s, p in before.items():
                for action, q in self.seen(other, view, now, s).items():
                    if rho:
                        found += rho * p * q * self.reward(other, view[1], s, action)
                    for chance, result in self.outcomes(s, other, action):
                        reached[result] = reached.get(result, 0.0) + p * q * chance
        if frame + 1 == self.horizon:
            return found + sum(p * self.end(problem, s) for s, p in reached.items())
        return found + sum(p * self.v(problem, frame + 1, s) for s, p in reached.items())


def test_with_a_time_limit_plans_are_those_of_plain_recursion() -> None:
    truth = Timed(2)
    pair = Pair(planned(TIMED.format(horizon=2)), truth)
    world, dynamics, order = pair.world, pair.world.dynamics, pair.order()
    places, count = list(map(tuple, dynamics.coordinates.tolist())), dynamics.state_count
    assert count == truth.count_states() == 60
    for who, character in enumerate(truth.characters):
        for frame, number in product(range(2), range(0, count, 7)):
            at = np.asarray(number + frame * count)
            logs, values = (f(world.tables, who, at) for f in (log_policy, world.value))
            state = tuple(places[c] for c in dynamics.cells[number])
            for h, i in enumerate(order):
                row = truth.hypotheses[i]
                if not row[f"R_{character}"]:
                    np.testing.assert_allclose(logs[:, 0, h], math.log(1 / 5), atol=1e-6)
                    continue
                problem = truth.problem(character, row)
                assert values[0, h] == pytest.approx(truth.v(problem, frame, state), abs=1e-5)
                expected = truth.seen(character, problem, frame, state)
                np.testing.assert_allclose(np.exp(logs[:, 0, h]), [*expected.values()], atol=1e-5)


# ---- Invariance ----------------------------------------------------------------------------------


def test_neither_names_nor_mirrors_change_what_is_believed() -> None:
    """The fold, seen in a mirror, with other names; with those sorted the other way, too."""
    names = {"rex": "ab", "ewe": "zo", "tom": "k_1", "hay": "m", "box": "a"}
    flip = {"east": "west", "west": "east"}
    rename = lambda text: re.sub(r"[a-z]+", lambda m: names.get(m[0], m[0]), text)
    mirrored = FOLD.replace("A.#", "#.A").replace("..B", "B..").replace(".##", "##.")
    first, second = (planned(text) for text in (FOLD, rename(mirrored)))
    truth = Pair(first, R.World(**reference_of("fold")))
    there = lambda cells: {names.get(k, k): v and [2 - v[0], v[1]] for k, v in cells.items()}
    for seed in range(3):
        path = truth.random_script(Random(seed), 4, events=0.0)
        document = truth.document(path)
        frames = []
        for frame in document["frames"]:
            told: dict = {"event": None, "state": there(frame["state"])}
            for who in ("rex", "ewe", "tom"):
                action = frame[who]["action"]
                told[names[who]] = {**frame[who], "action": flip.get(action, action)}
            frames.append(told)
        record = Record({}, {"name": "w"}, None, there(document["start"]), tuple(frames))
        turned = KIND.read(second, record)
        ours = replay(first, path.states, path.actions)
        theirs = replay(second, turned.states, turned.actions)
        np.testing.assert_allclose(np.exp(ours.log_belief), np.exp(theirs.log_belief), atol=1e-8)
    for one, other in zip(first.vocabulary.latents, second.vocabulary.latents, strict=True):
        assert other == "_".join(names.get(part, part) for part in one.split("_"))


# ---- The whole way -------------------------------------------------------------------------------

ROW = """
map
    A..B
tile a
    symbol = A
tile b
    symbol = B
character one
    goals = {a, b}
character two
    pushes = one
    toward = {one: {-1, 1}}
character three
    success = 0.7
    pushes = {one, two}
    models = two
planning
    gamma = 0.7
"""


def test_a_search_finds_the_best_of_all_scripts(tmp_path: Path) -> None:
    (tmp_path / "row.world").write_text(ROW, encoding="utf-8")
    text = f"""world row
length 2
start at(one, (1, 0)) and at(two, (2, 0)) and at(three, (3, 0))
maximize P(rho > 0 | script[:1]) + P(rho < 0 and G_one = a | script[:2])
{BARE}search beam(starts = 1, width = 1000, polish = 0)
"""
    with compiling_briefly():
        result = Story.from_text(text, tmp_path).solve()
    truth = R.World(
        ["...."],
        {"a": (0, 0), "b": (3, 0)},
        [
            Character("one", goals=("a", "b")),
            Character("two", 1, ("one",), toward={"one": (-1, 1)}),
            Character("three", 0.7, ("one", "two"), models="two"),
        ],
        gamma=0.7,
    )
    rational = [h["R_one"] and h["R_two"] and h["R_three"] for h in truth.hypotheses]
    helps = lambda h: h.get("rho", 0) > 0
    harms = lambda h: h.get("rho", 0) < 0 and h.get("G_one") == "a"

    @cache
    def likelihood(who: str, state: tuple, action: str) -> list[float]:
        return [truth.policy(who, h, state)[action] for h in truth.hypotheses]

    def share(belief: list[float], event: Callable) -> float:
        rows = zip(belief, rational, truth.hypotheses, strict=True)
        found = [(p, event(h)) for p, counts, h in rows if counts]
        return sum(p for p, holds in found if holds) / sum(p for p, _ in found)

    def turns(state: tuple, belief: list[float]) -> list[tuple]:
        reached = [(state, belief)]
        for who in truth.characters:
            reached = [
                (after, told)
                for s, b in reached
                for action in R.ACTIONS
                for told in [updated(b, likelihood(who, s, action))]
                for _, after in truth.outcomes(s, who, action)
            ]
        return reached

    def updated(belief: list[float], likely: list[float]) -> list[float]:
        weights = [p * q for p, q in zip(belief, likely, strict=True)]
        total, n, eps = sum(weights), len(weights), 1e-5
        shares = [w / total for w in weights]
        return [p * (1 - eps) + (1 - p) / (n - 1) * eps for p in shares]

    start, n = ((1, 0), (2, 0), (3, 0)), len(truth.hypotheses)
    best = max(
        share(first, helps) + max(share(b, harms) for _, b in turns(state, first))
        for state, first in turns(start, [1 / n] * n)
    )
    assert result.score == pytest.approx(best, abs=1e-3)
    told = result.script.record.as_json()
    assert R.P(truth, told, 1, helps) + R.P(truth, told, 2, harms) == pytest.approx(best, abs=1e-3)


def test_other_viewers_of_positions_believe_what_the_text_says(tmp_path: Path) -> None:
    """Through the public door: a table of positions, a prior, goals that change, pins, a file."""
    (tmp_path / "fold.world").write_text(FOLD, encoding="utf-8")
    text = f"""world fold
length 4
maximize depict(rho_rex_ewe > 0)
audience bayesian(switching = 0.3, forgetting = 0.01, prior(rho_rex_ewe) = {{-3: 0.2, others: 0.8}})
{BARE}search beam(starts = 2, polish = 0)
"""
    truth = R.World(**reference_of("fold"))
    frames, state = [], truth.state(((0, 0), (1, 1), (0, 1), None))
    for acts in (("stay", "north", "east"), ("south", "east", "west"), ("east", "west", "south")):
        told = dict(zip(truth.characters, acts, strict=True))
        frames.append(R.turn(truth, state, told))
        state = truth.state(frames[-1]["state"])
    document = {"start": truth.mapping(((0, 0), (1, 1), (0, 1), None)), "frames": frames}
    table = [
        {"who": who, "frame": t, "x": at and at[0], "y": at and at[1], "action": action}
        for t, frame in enumerate([{"state": document["start"]}, *frames])
        for who, at in frame["state"].items()
        for action in [frame[who]["action"] if who in frame else None]
    ]
    story = Story.from_text(text, tmp_path)
    script = story.script_from_positions(table)
    assert script.record.as_json()["frames"] == frames

    rows = truth.hypotheses
    alike = lambda i, latents: [
        j for j, h in enumerate(rows) if without(h, latents) == without(rows[i], latents)
    ]
    without = lambda h, latents: {k: v for k, v in h.items() if k not in latents}
    prior = [1 / len(rows)] * len(rows)
    for i, h in enumerate(rows):  # among those of which the same are rational
        among = [x for x in rows if all(x[k] == h[k] for k in h if k[0] == "R")]
        if h["R_rex"] and h["R_ewe"]:
            same = [x for x in among if x["rho_rex_ewe"] == h["rho_rex_ewe"]]
            share = 0.2 if h["rho_rex_ewe"] == -3 else 0.8
            prior[i] = share * len(among) / len(same) / len(rows)
    belief, expected, state = prior, [], truth.state(document["start"])
    for frame in [None, *frames]:
        for who, action, acted_from, after in truth.actions(state, frame) if frame else ():
            logs = [truth.log_likelihood(who, h, acted_from, action) for h in rows]
            weights = [p * math.exp(x) for p, x in zip(belief, logs, strict=True)]
            shares = [w / sum(weights) for w in weights]
            kept = [p * 0.99 + (1 - p) / (len(rows) - 1) * 0.01 for p in shares]
            belief = []
            for i in range(len(rows)):  # its goal may change, drawn from the prior given the rest
                group = alike(i, {f"G_{who}"})
                drawn = prior[i] / sum(prior[j] for j in group) * sum(kept[j] for j in group)
                belief.append(0.7 * kept[i] + 0.3 * drawn)
            state = after
        chosen = [(p, h) for p, h in zip(belief, rows, strict=True) if R.rational(h)]
        helps = sum(p for p, h in chosen if h["rho_rex_ewe"] > 0)
        expected.append(helps / sum(p for p, _ in chosen))
    values = script.query("P(rho_rex_ewe > 0 | script[:t])")
    np.testing.assert_allclose(values, expected, atol=2e-4)

    again = Script.load(script.save(tmp_path / "script.json"))
    assert again.query("P(rho_rex_ewe > 0 | script[:t])") == pytest.approx(values)
    kept_story = story.keeping(script, [2])
    assert "pin script[2] = [tom: south, rex: east, ewe: west]" in kept_story.typed.source.text


# ---- Mistakes ------------------------------------------------------------------------------------

TOWARD = "toward = {queen: {0, 2}}"
MANY = "{" + ", ".join(map(str, range(1, 17))) + "}"
CAST = """
map
    ....
character x
    toward = {y_z: {1, 2}}
character x_y
    toward = {z: {1, 2}}
character z
character y_z
"""
MISTAKES = {
    "five characters": (
        COURT.replace("planning", "character cat\ncharacter dog\nplanning"),
        "my.world:21:11: error[world-cast]: a world has at most 4 characters, this is another",
        "",
    ),
    "a circle of three": (
        COURT.replace("character queen\n", "character queen\n    models = bear\n"),
        "my.world:20:5: error[world-cast]: `queen`, `fox` and `bear` model each other in a circle",
        "whoever has an attitude toward another models it; leave out one of them",
    ),
    "somebody beside a circle": (
        COURT.replace("character queen\n", "character queen\n    models = fox\n"),
        "my.world:16:5: error[world-cast]: `queen` and `fox` model each other in a circle",
        "leave out one of them",
    ),
    "too many hypotheses": (
        COURT.replace("{-1, 1}", MANY).replace("fox: {0, 2}", f"fox: {MANY}")
        + "audience\n    hypotheses = literal\n",
        "my.world:16:11: error[too-large]: viewers would hold up to 16,384 hypotheses",
        "fewer goals or values of attitudes: at most 4,096",
    ),
    "three at the same time": (
        COURT + "    order = together\n",
        "my.world:22:13: error[world-value]: there are more characters than two",
        "two can act at the same time; or give their order",
    ),
    "an order of two": (
        COURT + "    order = [queen, fox]\n",
        "my.world:22:13: error[world-value]: the order must name every character once",
        "add `bear`",
    ),
    "latents of one name": (
        CAST,
        "my.world:6:11: error[world-cast]: `x_y` and `x` both have a `rho_x_y_z`",
        "give one of them a name without `_`",
    ),
    "a tile with a latent's name": (
        COURT.replace("tower", "rho_fox_queen"),
        "my.world:5:6: error[reserved]: `rho_fox_queen` is the latent of `fox`'s attitude",
        "choose another name",
    ),
    "attitudes in two places": (
        COURT.replace(TOWARD, f"{TOWARD}\n    attitude = 1"),
        "my.world:16:5: error[world-cast]: the values of each attitude stand in `toward`",
        "remove the line, or write `toward = NAME`",
    ),
    "an unknown character": (
        COURT.replace(TOWARD, TOWARD.replace("queen", "quen")),
        "my.world:15:15: error[world-name]: there is no other character `quen`",
        "did you mean `queen`?",
    ),
    "a value that is no number": (
        COURT.replace(TOWARD, TOWARD.replace("2}", "big}")),
        "my.world:15:26: error[world-value]: an attitude is a number, not `big`",
        "attitude = {-1, 0, 1}",
    ),
    "a value that is too large": (
        COURT.replace(TOWARD, TOWARD.replace("2}", "2e7}")),
        "my.world:15:26: error[world-range]: an attitude must be between -1e6 and 1e6",
        "",
    ),
    "a name twice": (
        COURT.replace(TOWARD, "toward = {queen: 1, queen: {1, 2}}"),
        "my.world:15:25: error[duplicate]: `queen` is given twice",
        "",
    ),
    "no values": (
        COURT.replace(TOWARD, "toward = {queen, bear}"),
        "my.world:15:5: error[world-cast]: `fox` has no attitude toward anyone",
        "give the values of each: toward = {queen: {-1, 0, 1}, bear: {-1, 0, 1}}",
    ),
    "values of those who are only modelled": (
        COURT.replace(TOWARD, "models = {queen: {1, 2}}"),
        "my.world:15:14: error[world-value]: `models` must name another character",
        "",
    ),
    "a prior of no latent": (
        COURT + "audience\n    prior(rho) = {0: 1, others: 2}\n",
        "my.world:23:11: error[world-name]: there is no latent `rho`",
        "did you mean `rho_bear_fox` or `rho_bear_queen` or `rho_fox_queen`?",
    ),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_said_where_it_is_with_what_to_do(name: str) -> None:
    text, message, hint = MISTAKES[name]
    with pytest.raises(StoryError) as caught:
        parse_world(Source("my.world", text), "my")
    assert message in str(caught.value)
    assert hint in str(caught.value)


def test_taken_literally_every_combination_counts() -> None:
    for name in CASES:
        text = f"{CASES[name].text}audience\n    hypotheses = literal\n"
        if name == "four":
            text = CASES[name].text.replace("audience\n", "audience\n    hypotheses = literal\n")
        found = grid_vocabulary(parse_world(Source("my.world", text), "my")).hypotheses
        expected = R.World(**reference_of(name), hypotheses="literal").hypotheses
        counted = [Counter(frozenset(h.items()) for h in rows) for rows in (found, expected)]
        assert counted[0] == counted[1]


def test_several_may_be_met_with_the_same_attitudes() -> None:
    """And no weight is asked of an indifference that is only forced."""
    text = COURT.replace("toward = {queen: {-1, 1}, fox: {0, 2}}", "toward = {queen, fox}")
    text = text.replace("planning", "    attitude = {-1, 2}\nplanning")
    priors = "audience\n    prior(rho_bear_fox) = {-1: 3, 2: 1}\n"
    spec = parse_world(Source("my.world", text + priors), "my")
    assert dict(spec.character("bear").attitudes) == {"queen": (-1, 2), "fox": (-1, 2)}
    assert spec.shares == (("rho_bear_fox", ((-1, 3), (2, 1))),)
