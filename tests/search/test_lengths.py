"""Stories whose length the search chooses: each length is a story of its own, and all of them have
one program."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from i2pdsl.errors import Source, StoryError
from i2pdsl.language.check import Library, TypedStory, check_source
from i2pdsl.language.vocabulary import Weights
from i2pdsl.objective.belief import Belief, first_belief
from i2pdsl.objective.fold import Objective
from i2pdsl.objective.frame import Frame, observe
from i2pdsl.objective.replay import replay
from i2pdsl.objective.terms import score_script, story_objective
from i2pdsl.programs import BRIEF
from i2pdsl.stories import Story
from i2pdsl.worlds.grid.world import GridWorld
from worlds_for_tests import CORRIDOR, planned, trajectory

SEARCH = "search beam(starts = 5, polish = 1)"


@cache
def world() -> GridWorld:
    return planned(CORRIDOR, "corridor")


def story(*lines: str, lengths: str = "2..5") -> TypedStory:
    text = "\n".join((f"world corridor\nlength {lengths}", *lines))
    checked = check_source(Source("s.story", text), lambda *_: world().vocabulary)
    assert not isinstance(checked, Library)
    return checked


def scores(objective: Objective, before: int, actions: np.ndarray) -> np.ndarray:
    """Of each prefix what the fold says of it, and what it promises; it begins `before` late."""

    def further(
        number: np.ndarray, state: np.ndarray, belief: Belief, carry: Any, action: np.ndarray
    ) -> tuple[Frame, Any, list[np.ndarray]]:
        frame = observe(world(), tables, number, state, action, belief)
        carry = objective.step(tables, params, carry, frame)
        pair = (objective.score, objective.promise)
        return frame, carry, [value(tables, params, carry, frame) for value in pair]

    tables, params = world().tables, objective.params
    if objective.keeps_history:  # which NumPy cannot
        tables, params = jax.tree.map(jnp.asarray, (tables, params))
        further = jax.jit(further, compiler_options=BRIEF)
    state, belief = np.asarray(2), first_belief(world(), tables)
    carry = objective.init(tables, params, state)
    found = []
    for number, action in enumerate(actions, before + 1):
        frame, carry, values = further(np.asarray(number), state, belief, carry, action)
        state, belief = frame.state, frame.belief
        found.append([float(value) for value in values])
    return np.array(found)


SLOW = ("maximize sum_t P(G_one = left | script[:2]) * P(G_one = left | script[:t])",)
ASKED = (
    "maximize depict(G_one = left)",
    "maximize twist(G_one = left, G_one = right)",
    "maximize arc(one)",
    "maximize mean_t P(G_one = left | script[:t]) + min_t P(G_one = left | script[:t-1])",
    "maximize entropy(G_one | script[:T]) - max_t surprise(script[t])",
    "maximize sum_t KL(script[:0] || script[:t]) + sum_{t in 2..T} t * P(R_one | script[:t])",
    "maximize sum_t (if t <= when [moved(one)] then t else 0)",
    "maximize sum_{t in 0..T} t * P(G_one = left | script[:t])",
    SLOW[0],
    "let more = script ++ [one: west]\nmaximize depict(G_one = left, over = more)",
    "maximize beats(depict(G_one = left), depict(G_one = right))",
    "maximize beats(depict(G_one = left), sum_t P(G_one = right | script[:T]))",
    "maximize 0\nrequire eventually [at(one, left)]\nrequire [moved(one) @ script[2]]",
    "maximize 0\nrequire when [at(one, left)] > 1\nrequire [moved(one)] before [at(one, left)]",
    "maximize 0\nrequire (sum_t [moved(one) @ script[t]]) >= 2\npin script[T]: at(one, left)",
    "maximize 0\npin script[1] = [one: west]\nrequire P(G_one = left | script[:T-1]) > 0.7",
)


@pytest.mark.parametrize(
    "asked", [pytest.param(a, marks=pytest.mark.slow) if a in SLOW else a for a in ASKED]
)
def test_a_story_that_begins_late_is_the_same_story(asked: str) -> None:
    typed = story("assume nothing", asked)
    generator = np.random.default_rng(0)
    shapes = set()
    for each in typed.lengths:
        late = story_objective(each, world())
        shapes.add(late.shape)
        if late.keeps_history and each.length != 3:
            continue  # each has a program of its own
        on_time = story_objective(replace(each, longest=0), world())
        for _ in range(1 if late.keeps_history else 4):
            actions = generator.integers(5, size=each.length)
            found = scores(late, typed.length - each.length, actions)
            assert found == pytest.approx(scores(on_time, 0, actions), rel=1e-5, abs=1e-5)
    assert asked not in ASKED[:5] or len(shapes) == 1


def test_frames_weigh_as_much_in_all_as_those_of_the_longest() -> None:
    asked = (
        "maximize sum_t P(G_one = left | script[:t]) + sum_{t in 1..2} 3 * t",
        "maximize sum_{t in 2..T} 1 + mean_t 2",
    )
    typed = story(*asked, "naturalness 0.3")
    for each in typed.lengths:
        alone = story(*asked, "naturalness 0.3", lengths=str(each.length))
        frames = replay(world(), *_walk(each.length))
        weight = typed.length / each.length
        belief = np.exp(frames.log_belief[1:, 0])
        rational = np.array([h["R_one"] for h in world().vocabulary.hypotheses])
        left = np.array([h.get("G_one") == "left" for h in world().vocabulary.hypotheses])
        expected = (belief[:, left & rational].sum(1) / belief[:, rational].sum(1)).sum() * weight
        expected += 9 + (each.length - 1) * weight + 2
        bare = Weights(0, 0, 0, 0, 0)
        found = score_script(replace(each, weights=bare), world(), frames)
        assert found == pytest.approx(expected)
        summed = ("rationality", "naturalness", "liveliness")
        for term, value in each.weights._asdict().items():
            times = weight if term in summed else 1
            assert value == pytest.approx(times * getattr(alone.weights, term)), term


def _walk(length: int) -> tuple[np.ndarray, np.ndarray]:
    path = trajectory(world(), 2, np.arange(length) % 3)
    return path.states, path.actions


def test_the_search_chooses_the_length() -> None:
    asked = ("start at(one, (3, 0))", "maximize depict(G_one = left)", SEARCH)
    end = "require [at(one, left) @ script[T]]"
    found = Story(story(*asked, end), known=world().spec).solve(candidates=4, choose="score")
    assert not found.unmet
    assert found.script.length == 3  # it is there after three frames, and no frame is wasted
    assert len({script.length for script in found.candidates}) > 1
    best = [script.score for script in found.candidates if not script.unmet]
    assert best == sorted(best, reverse=True)
    assert found.script.record.text.startswith("world corridor\nlength 2..5")


def test_what_is_wrong_with_one_length_is_said_with_it() -> None:
    with pytest.raises(StoryError) as caught:
        story("maximize P(G_one = left | script[:4])")
    told = str(caught.value)
    assert "the script has 3 frames, this is 4" in told
    assert "in a story of 3 frames" in told
