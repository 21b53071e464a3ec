"""The fast code against tests/reference.py, an independent transcription of the equations."""

from __future__ import annotations

from itertools import product
from random import Random

import numpy as np
import pytest

import reference
from i2pdsl.errors import Source
from i2pdsl.language.check import check_query
from i2pdsl.language.scope import Module
from i2pdsl.objective.belief import first_belief
from i2pdsl.objective.frame import Frame, observe
from i2pdsl.objective.replay import evaluate, replay
from i2pdsl.objective.terms import score_script, story_objective
from stories_for_tests import BARE
from worlds_for_tests import STORIES, Pair, small_kitchen

NAMES = sorted(reference.STORIES)


@pytest.fixture(scope="module")
def pair() -> Pair:
    return small_kitchen()


def test_states_and_moves_agree(pair: Pair) -> None:
    dynamics = pair.world.dynamics
    places = [*map(tuple, dynamics.coordinates.tolist()), None]
    states = [tuple(places[c] for c in row) for row in dynamics.cells.tolist()]
    assert len(states) == pair.reference.count_states() == pair.spec.state_count
    for who, character in enumerate(pair.spec.characters):
        for act, action in enumerate(("north", "south", "east", "west", "stay")):
            for number, state in enumerate(states):
                expected = pair.reference.effect(state, character.name, action)
                assert states[dynamics.successor[who][act, number]] == tuple(expected)


@pytest.mark.parametrize("level0", ["uniform", "costs"])
def test_values_agree(level0: str) -> None:
    pair = small_kitchen(("P.", ".G", ".."), level0=level0)
    dynamics = pair.world.dynamics
    places = [*map(tuple, dynamics.coordinates.tolist()), None]
    order = pair.order()
    every = np.arange(dynamics.state_count)
    for who, character in enumerate(pair.spec.characters):
        values = pair.world.value(pair.world.tables, who, every)[:, 0]
        for h, hypothesis in enumerate(pair.vocabulary.hypotheses):
            if not hypothesis[f"R_{character.name}"]:
                continue
            row = pair.reference.hypotheses[order[h]]
            for number in range(0, dynamics.state_count, 7):
                state = tuple(places[c] for c in dynamics.cells[number])
                expected = pair.reference.value(character.name, row, state)
                assert values[number, h] == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("hypotheses", ["merged", "literal"])
def test_beliefs_agree(hypotheses: str) -> None:
    pair = small_kitchen(hypotheses=hypotheses)
    order, random = pair.order(), Random(1)
    for _ in range(6):
        path = pair.random_script(random, 6)
        frames = replay(pair.world, path.states, path.actions)
        expected = pair.reference.beliefs(pair.document(path))
        for t, belief in enumerate(expected):
            row = [belief[i] for i in order]
            np.testing.assert_allclose(np.exp(frames.log_belief[t, 0]), row, atol=1e-9)


def fold_score(pair: Pair, text: str, frames: Frame) -> float:
    """The objective by init, step and score, in NumPy and doubles."""
    world, story = pair.world, pair.story(text)
    objective = story_objective(story, world)
    assert not objective.keeps_history
    tables, params = world.tables, objective.params
    carry = objective.init(tables, params, frames.state[0])
    belief, frame = first_belief(world, tables), None
    for t in range(1, len(frames.state)):
        frame = observe(
            world, tables, np.asarray(t), frames.before[t], np.asarray(frames.action[t]), belief
        )
        belief = frame.belief
        carry = objective.step(tables, params, carry, frame)
    return float(objective.score(tables, params, carry, frame))


@pytest.mark.parametrize("name", NAMES)
def test_scores_of_stories_agree(pair: Pair, name: str) -> None:
    text = (STORIES / "kitchen" / f"{name}.story").read_text(encoding="utf-8")
    story = pair.story(text)
    expected = reference.objective(name, story.length)
    random = Random(name)
    for _ in range(4):
        path = pair.random_script(random, story.length)
        frames = replay(pair.world, path.states, path.actions)
        score = score_script(story, pair.world, frames)
        assert score == pytest.approx(expected(pair.reference, pair.document(path)), abs=1e-6)
        assert fold_score(pair, text, frames) == pytest.approx(score, abs=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_scores_of_prefixes_agree(pair: Pair, name: str) -> None:
    text = (STORIES / "kitchen" / f"{name}.story").read_text(encoding="utf-8")
    story = pair.story(text)
    expected = reference.objective(name, story.length)
    path = pair.random_script(Random(name), story.length)
    frames = replay(pair.world, path.states, path.actions)
    document = pair.document(path)
    for n in range(1, story.length + 1):
        part = frames.at(slice(n + 1))
        shorter = {**document, "frames": document["frames"][:n]}
        score = fold_score(pair, text, part)
        assert score == pytest.approx(expected(pair.reference, shorter), abs=1e-6)


def helps(h: dict) -> bool:
    return h.get("rho", 0) > 0


def rational(h: dict) -> bool:
    return h["R_cheese"] and h["R_robot"]


def wants_pink(h: dict) -> bool:
    return h.get("G_cheese") == "pink"


R = reference
QUERIES = {
    "P(rho > 0 | script[:t])": lambda w, s, t: R.P(w, s, t, helps),
    "P(rho > 0 | script[:t], G_cheese = pink)": lambda w, s, t: R.P(w, s, t, helps, (wants_pink,)),
    "P(not rho > 0 or G_robot = G_cheese | script[:t])": lambda w, s, t: R.P(
        w, s, t, lambda h: not helps(h) or h["G_robot"] == h["G_cheese"]
    ),
    "P(rho in {-3, 3} | script[:t])": lambda w, s, t: R.P(w, s, t, lambda h: h["rho"] in (-3, 3)),
    "P(-1 <= rho < 3 | script[:t])": lambda w, s, t: R.P(w, s, t, lambda h: -1 <= h["rho"] < 3),
    "E[rho | script[:t]]": lambda w, s, t: R.E(w, s, t, lambda h: h.get("rho")),
    "E[V(robot) | script[:t]]": lambda w, s, t: R.EV(w, s, t, "robot"),
    "E[V(cheese) | script[:t], G_cheese = pink]": lambda w, s, t: R.EV(
        w, s, t, "cheese", (wants_pink,)
    ),
    "entropy(rho | script[:t])": lambda w, s, t: R.entropy(w, s, t, "rho"),
    "entropy(script[:t])": lambda w, s, t: R.entropy(w, s, t),
    "suspense(rho | script[:t])": lambda w, s, t: R.suspense(w, s, t, "rho"),
    "suspense(G_cheese | script[:t])": lambda w, s, t: R.suspense(w, s, t, "G_cheese"),
}
FRAME_QUERIES = {
    "KL(script[:t-1] || script[:t])": lambda w, s, t: R.KL(w, s, t - 1, t),
    "KL(rho; script[:t-1] || script[:t])": lambda w, s, t: R.KL(w, s, t - 1, t, "rho"),
    "surprise(script[t])": lambda w, s, t: R.surprise(w, s, t),
    "[pushes(robot, cheese) @ script[t]]": lambda w, s, t: R.pushes(w, s, t, "robot", "cheese"),
    "[pushes(robot, table) @ script[t]]": lambda w, s, t: R.pushes(w, s, t, "robot", "table"),
    "[moved(cheese) @ script[t]]": lambda w, s, t: R.moved(w, s, t, "cheese"),
    "[tried(cheese) @ script[t]]": lambda w, s, t: R.tried(w, s, t, "cheese"),
    "[fell(table) @ script[t]]": lambda w, s, t: R.fell(w, s, t, "table"),
    "[at(robot, pink) @ script[t]]": lambda w, s, t: R.at(w, w.state_at(s, t), "robot", "pink"),
    "[adjacent(robot, cheese) @ script[t]]": lambda w, s, t: R.adjacent(
        w, w.state_at(s, t), "robot", "cheese"
    ),
    "[idle(cheese) @ script[t]]": lambda w, s, t: R.idle(w, s, t, "cheese"),
    "[faces(robot, cheese) @ script[t]]": lambda w, s, t: R.faces(w, s, t, "robot", "cheese"),
    "[faces(cheese, green) @ script[t]]": lambda w, s, t: R.faces(w, s, t, "cheese", "green"),
    "[faces(cheese, table) @ script[t]]": lambda w, s, t: R.faces(w, s, t, "cheese", "table"),
    "[sees(robot, table) @ script[t]]": lambda w, s, t: R.sees(
        w, w.state_at(s, t), "robot", "table"
    ),
    "[sees(cheese, pink) @ script[t]]": lambda w, s, t: R.sees(
        w, w.state_at(s, t), "cheese", "pink"
    ),
    "[distance(robot, table) @ script[t]]": lambda w, s, t: R.distance(
        w, w.state_at(s, t), "robot", "table"
    ),
    "[distance(cheese, green) @ script[t]]": lambda w, s, t: R.distance(
        w, w.state_at(s, t), "cheese", "green"
    ),
    "[touching(robot, cheese) @ script[t]]": lambda w, s, t: R.adjacent(
        w, w.state_at(s, t), "robot", "cheese"
    ),
    "[absent(table) @ script[t]]": lambda w, s, t: R.absent(w, w.state_at(s, t), "table"),
}


@pytest.mark.parametrize("expression", [*QUERIES, *FRAME_QUERIES])
def test_queries_agree(pair: Pair, expression: str) -> None:
    expected = {**QUERIES, **FRAME_QUERIES}[expression]
    random = Random(expression)
    seen = set()
    for _ in range(16 if expression[0] == "[" else 4):
        path = pair.random_script(random, 5, events=0.3)
        frames = replay(pair.world, path.states, path.actions)
        document = pair.document(path)
        module = Module(Source("query", ""))
        query = check_query(Source("query", expression), pair.vocabulary, module, 5)
        assert query.times is not None
        first = 1 if expression in FRAME_QUERIES else 0
        assert list(query.times) == list(range(first, 6))
        values = evaluate(pair.world, frames, query.value, query.times)
        for t, value in zip(query.times, values, strict=True):
            assert value == pytest.approx(float(expected(pair.reference, document, t)), abs=1e-6)
        seen |= set(np.round(values, 9).tolist())
    assert len(seen) > 1, "a query that never changes tests nothing"


@pytest.mark.parametrize("latent", ["rho", "G_robot", "G_cheese"])
def test_distributions_and_assume_nothing_agree(pair: Pair, latent: str) -> None:
    path = pair.random_script(Random(latent), 5)
    frames = replay(pair.world, path.states, path.actions)
    document = pair.document(path)
    for assume in (None, "nothing"):
        query = check_query(
            Source("query", f"P({latent} | script[:t])"),
            pair.vocabulary,
            Module(Source("query", "")),
            5,
            assume=None if assume is None else Source("assume", assume),
        )
        values = evaluate(pair.world, frames, query.value, query.times)
        labels = pair.vocabulary.latents[latent].values
        for t in range(6):
            for v, label in enumerate(labels):
                expected = reference.P(
                    pair.reference,
                    document,
                    t,
                    lambda h, label=label: h.get(latent) == label,
                    assume=None if assume else rational,
                )
                assert values[t, v] == pytest.approx(expected, abs=1e-6)
            assert values[t].sum() == pytest.approx(1.0)


def asked(pair: Pair, frames: Frame, expression: str, assume: str | None = None) -> np.ndarray:
    """A query's values over its frames."""
    query = check_query(
        Source("query", expression),
        pair.vocabulary,
        Module(Source("query", "")),
        len(frames.state) - 1,
        assume=None if assume is None else Source("assume", assume),
    )
    return np.asarray(evaluate(pair.world, frames, query.value, query.times))


@pytest.mark.parametrize("assume", [None, "nothing"])
def test_joint_beliefs_agree(pair: Pair, assume: str | None) -> None:
    latents = ("G_cheese", "rho", "R_robot")
    path = pair.random_script(Random(7), 5)
    frames = replay(pair.world, path.states, path.actions)
    names = [(*pair.vocabulary.latents[name].values, "unknown") for name in latents]
    values = asked(pair, frames, f"P({', '.join(latents)} | script[:t])", assume)
    values = values.reshape(6, *map(len, names))
    for t in range(6):
        belief = R.posterior(
            pair.reference, pair.document(path), t, (), None if assume else rational
        )
        expected = R.joint(pair.reference, belief, latents)
        for place, key in zip(np.ndindex(*map(len, names)), product(*names), strict=True):
            assert values[(t, *place)] == pytest.approx(expected.get(key, 0.0), abs=1e-6)
    single = asked(pair, frames, "P(rho | script[:t])", assume)
    assert values.sum((1, 3)) == pytest.approx(single)


def test_beliefs_within_a_frame_agree(pair: Pair) -> None:
    random = Random(8)
    changed = 0.0
    for _ in range(4):
        path = pair.random_script(random, 5, events=0.2)
        frames = replay(pair.world, path.states, path.actions)
        document = pair.document(path)
        values = asked(pair, frames, "P(rho > 0 | script[:t, cheese])")
        ends = asked(pair, frames, "P(rho > 0 | script[:t])")
        assert asked(pair, frames, "P(rho > 0 | script[:t, robot])") == pytest.approx(ends[1:])
        for t in range(1, 6):
            belief = R.posterior_within(pair.reference, document, t, 1)
            expected = sum(p for i, p in belief.items() if helps(pair.reference.hypotheses[i]))
            assert values[t - 1] == pytest.approx(expected, abs=1e-6)
        changed = max(changed, float(abs(values - ends[1:]).max()))
    assert changed > 0.01, "the robot's action never told anything"


@pytest.mark.parametrize("who", ["cheese", "robot"])
def test_predictions_of_the_next_action_agree(pair: Pair, who: str) -> None:
    random = Random(who)
    for _ in range(2):
        path = pair.random_script(random, 3, events=0.2)
        frames = replay(pair.world, path.states, path.actions)
        document = pair.document(path)
        for assume in (None, "nothing"):
            values = asked(pair, frames, f"next({who} | script[:t])", assume)
            assert values.sum(-1) == pytest.approx(1.0)
            for t in range(4):
                expected = R.next_action(
                    pair.reference, document, t, who, None if assume else rational
                )
                for action, value in zip(pair.vocabulary.actions, values[t], strict=True):
                    assert value == pytest.approx(expected.get(action, 0.0), abs=1e-6)


def test_an_objective_may_ask_within_a_frame(pair: Pair) -> None:
    """Of the frame at hand a fold knows it; of an earlier one it keeps the history."""
    within = "sum_t (P(rho > 0 | script[:t, cheese]) + KL(script[:t-1] || script[:t, cheese]))"
    path = pair.random_script(Random(9), 5, events=0.2)
    frames = replay(pair.world, path.states, path.actions)
    text = f"world w\nlength 5\n{BARE}maximize "
    score = fold_score(pair, text + within, frames)
    assert score == pytest.approx(float(asked(pair, frames, within)), abs=1e-9)
    earlier = "sum_{t in 2..T} P(rho > 0 | script[:t-1, cheese])"
    assert story_objective(pair.story(text + earlier), pair.world).keeps_history
