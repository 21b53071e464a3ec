"""What a prefix promises: the score of the whole script if nothing more happened, by hand."""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from i2pdsl.objective.belief import Belief, first_belief
from i2pdsl.objective.frame import observe
from i2pdsl.objective.terms import story_objective
from i2pdsl.programs import BRIEF
from worlds_for_tests import Pair, small_kitchen

LENGTH = 5


@pytest.fixture(scope="module")
def pair() -> Pair:
    return small_kitchen()


def believed(pair: Pair, text: str) -> tuple[list[float], list[float], list[float]]:
    """The scores and promises after each frame of a script, and P(rho > 0) from the prior on."""
    world = pair.world
    fold = story_objective(pair.story(f"world w\nlength {LENGTH}\nrationality 0\n{text}"), world)
    helps = np.array([h.get("rho", 0) > 0 for h in world.vocabulary.hypotheses])
    sane = np.array(
        [h["R_cheese"] and h["R_robot"] for h in world.vocabulary.hypotheses], dtype=bool
    )
    tables: Any = world.tables
    state: Any = np.int64(17)
    if fold.keeps_history:  # which only JAX's arrays can
        tables, state = world.search_tables, jnp.int32(17)

    def further(number: Any, state: Any, belief: Belief, carry: Any, action: Any) -> Any:
        frame = observe(world, tables, number, state, action, belief)
        carry = fold.step(tables, fold.params, carry, frame)
        of_both = [f(tables, fold.params, carry, frame) for f in (fold.score, fold.promise)]
        return frame, carry, of_both

    if fold.keeps_history:
        further = jax.jit(further, compiler_options=BRIEF)
    belief = first_belief(world, tables)
    carry = fold.init(tables, fold.params, state)
    scores, promises, beliefs = [], [], [_share(belief.log, helps, sane)]
    generator = np.random.default_rng(3)
    for number in range(1, LENGTH + 1):
        valid = np.flatnonzero(world.turns(world.tables, np.int64(state)).valid)
        action = state * 0 + generator.choice(valid)
        frame, carry, of_both = further(state * 0 + number, state, belief, carry, action)
        state, belief = frame.state, frame.belief
        for found, value in zip((scores, promises), of_both, strict=True):
            found.append(float(value))
        beliefs.append(_share(belief.log, helps, sane))
    return scores, promises, beliefs


def _share(belief: np.ndarray, event: np.ndarray, given: np.ndarray) -> float:
    p = np.exp(np.asarray(belief[0], dtype=float))
    return float(p[event & given].sum() / p[given].sum())


PLAIN = "plausibility 0\nnaturalness 0\nluck 0\nliveliness 0\n"


def test_a_sum_goes_on_as_it_is(pair: Pair) -> None:
    text = PLAIN + "maximize sum_t t * P(rho > 0 | script[:t])"
    scores, promises, p = believed(pair, text)
    for n in range(1, LENGTH + 1):
        so_far = sum(t * p[t] for t in range(1, n + 1))
        assert scores[n - 1] == pytest.approx(so_far)
        rest = sum(t * p[n] for t in range(n + 1, LENGTH + 1))
        assert promises[n - 1] == pytest.approx(so_far + rest)


def test_the_end_is_what_is_now(pair: Pair) -> None:
    text = PLAIN + "maximize P(rho > 0 | script[:T]) - P(rho > 0 | script[:0])"
    scores, promises, p = believed(pair, text)
    assert scores[:-1] == pytest.approx([-p[0]] * (LENGTH - 1))
    assert promises == pytest.approx([p[n] - p[0] for n in range(1, LENGTH + 1)])


@pytest.mark.parametrize(("kind", "of"), [("min", min), ("max", max)])
def test_an_extreme_of_some_frames_reaches_ahead(pair: Pair, kind: str, of: object) -> None:
    text = PLAIN + f"maximize {kind}_{{t in 3..4}} P(rho > 0 | script[:t])"
    _, promises, p = believed(pair, text)
    assert callable(of)
    expected = [p[1], p[2], p[3], of(p[3], p[4]), of(p[3], p[4])]
    assert promises == pytest.approx(expected, abs=1e-4)


def test_a_script_that_is_kept_is_held_the_same_way(pair: Pair) -> None:
    text = PLAIN + "maximize (P(rho > 0 | script[:T]) - P(rho > 0 | script[:2]))^2"
    _, promises, p = believed(pair, text)
    expected = [0.0, 0.0, *((p[n] - p[2]) ** 2 for n in range(3, LENGTH + 1))]
    assert promises == pytest.approx(expected, abs=1e-4)


@pytest.mark.parametrize(
    "text",
    [
        "maximize sum_t surprise(script[t])",
        "maximize sum_t KL(script[:t-1] || script[:t])",
        "maximize sum_t [pushes(robot, cheese) @ script[t]]",
        "maximize sum_t [moved(cheese) @ script[t]] * P(rho > 0 | script[:2])",
    ],
)
def test_what_only_happens_does_not_go_on(pair: Pair, text: str) -> None:
    scores, promises, _ = believed(pair, PLAIN + text)
    assert promises[1:] == pytest.approx(scores[1:], abs=1e-4)


def test_what_is_seen_goes_on(pair: Pair) -> None:
    text = PLAIN + "maximize sum_t [not absent(table) or absent(table) @ script[t]]"
    scores, promises, _ = believed(pair, text)
    assert scores == pytest.approx([1, 2, 3, 4, 5])
    assert promises == pytest.approx([LENGTH] * LENGTH)
