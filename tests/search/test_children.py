"""All children of a prefix at once, as a search scores them, against each of them followed alone:
in doubles, one action after the other, with the likelihood of every hypothesis."""

from __future__ import annotations

from functools import cache
from typing import Any

import jax
import numpy as np
import pytest

from i2pdsl.audience.product import Product
from i2pdsl.objective.belief import first_belief
from i2pdsl.objective.frame import observe
from i2pdsl.objective.terms import story_objective
from i2pdsl.programs import BRIEF, compiled
from i2pdsl.search import rollout
from i2pdsl.worlds.grid.looked_up import by_problem
from i2pdsl.worlds.grid.planning import solve
from i2pdsl.worlds.grid.world import GridWorld, assemble
from i2pdsl.worlds.ready import viewers_of
from i2pdsl.worlds.world import single_precision
from worlds_for_tests import small_kitchen

ROWS, LENGTH, BEFORE = ("P.", ".G", ".."), 4, 2
ONE = (
    "maximize sum_t (P(rho > 0 | script[:t]) - 0.2 * E[rho | script[:t]]"
    " + 0.3 * entropy(G_cheese | script[:t]) - 0.1 * surprise(script[t])"
    " + 0.2 * entropy(script[:t]) - P(R_robot | script[:t-1]))"
)
SEVERAL = """
audience bayesian(forgetting = 0.02)
audience child = bayesian(beta = 0.5)
audience careful = average(bayesian(given = rho > 0, forgetting = 0.1), bayesian)
maximize sum_t (P[child](rho > 0 | script[:t]) - 0.3 * P[careful](G_robot = green | script[:t])
    + 0.2 * entropy(rho | script[:t]) - 0.1 * E[careful][rho | script[:t]])
"""
DOUBTING = """
assume nothing
audience bayesian(given = not R_robot)
maximize sum_t P(G_cheese = pink | script[:t])
"""


@cache
def watched(text: str) -> tuple[GridWorld, Any]:
    pair = small_kitchen(ROWS)
    story = pair.story(f"world kitchen\nlength {LENGTH}\nallow deus(table)\n{text}")
    viewers = viewers_of(pair.spec, story.observers)
    plans = [solve(v.spec, pair.world.dynamics, tolerance=1e-10) for v in viewers]
    world = assemble(pair.spec, pair.world.dynamics, viewers, plans)
    return world, story_objective(story, world)


@pytest.mark.parametrize("text", [ONE, SEVERAL, DOUBTING], ids=["one", "several", "doubting"])
def test_each_child_is_worth_what_it_is_worth_alone(text: str) -> None:
    world, objective = watched(text)
    tables = world.tables._replace(by_problem=by_problem(world.tables, 10**6))
    tables = jax.tree.map(single_precision, tables)
    params = jax.tree.map(single_precision, objective.params)
    random = np.random.default_rng(5)
    state, belief = np.int64(23), first_belief(world, world.tables)
    carry = objective.init(world.tables, objective.params, state)
    for number in range(1, BEFORE + 1):
        action = random.choice(np.flatnonzero(world.turns(world.tables, state).valid))
        frame = observe(world, world.tables, np.int64(number), state, action, belief)
        carry = objective.step(world.tables, objective.params, carry, frame)
        state, belief = frame.state, frame.belief

    assert world.keeps_doubt  # so that a search holds beliefs as probabilities
    held = belief._replace(share=np.exp(belief.log))
    node = rollout.Node(np.int32(BEFORE), np.int32(state), held, carry, np.zeros(()))
    node = jax.tree.map(single_precision, node)

    def found(tables: Any, params: Any, node: Any, ahead: Any) -> rollout.Children:
        assert isinstance(rollout._turns(world, tables, node)[0].share, Product)
        return rollout.children(world, objective, (0,), tables, params, ahead, node)

    program = compiled(jax.jit(found).lower(tables, params, node, np.bool_(False)), BRIEF)
    children, hopeful = (program(tables, params, node, np.bool_(ahead)) for ahead in (False, True))
    real = np.isfinite(children.worth)
    turns = world.turns(world.tables, state)
    fallen, possible = world.drops(world.tables, state)
    slots = world.event_slots
    np.testing.assert_array_equal(real, np.concatenate([turns.valid, possible[:slots]]))
    np.testing.assert_array_equal(
        children.state[real], np.concatenate([turns.state, fallen[:slots]])[real]
    )
    assert real.sum() > 20
    marks: dict[bytes, list[float]] = {}
    for k in np.flatnonzero(real):
        action = np.int64(children.action[k])
        frame = observe(world, world.tables, np.int64(BEFORE + 1), state, action, belief)
        after = objective.step(world.tables, objective.params, carry, frame)
        for value, each in ((objective.score, children), (objective.promise, hopeful)):
            alone = float(value(world.tables, objective.params, after, frame))
            assert each.worth[k] == pytest.approx(alone, abs=2e-4)
        marks.setdefault(frame.log_belief.round(9).tobytes(), []).append(float(children.mark[k]))
    # The same belief has the same mark, others have others.
    means = np.sort([np.mean(each) for each in marks.values()])
    assert max(np.ptp(each) for each in marks.values()) < 1e-5
    assert len(means) > 3
    assert np.diff(means).min() > 1e-5
