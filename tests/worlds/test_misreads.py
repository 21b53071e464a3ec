"""What one takes another to want: hypotheses, plans and beliefs, against worlds without."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from i2pdsl.errors import Source, StoryError
from i2pdsl.objective.replay import replay
from i2pdsl.worlds.grid.hypotheses import grid_hypotheses
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.grid.policy import log_policy
from i2pdsl.worlds.grid.spec import GridSpec
from i2pdsl.worlds.grid.world import build_world

TEXT = """
map
    A..
    ..B
tile a
    symbol = A
tile b
    symbol = B
character ann
    success = 0.7
    goals = {a, b}
character bob
    pushes = ann
    toward = ann
    attitude = {-1, 2}
    misreads = ann
"""


def spec_of(text: str = TEXT) -> GridSpec:
    return parse_world(Source("cell.world", text), "cell")


def test_the_hypotheses() -> None:
    rows = grid_hypotheses(spec_of())
    both = [row for row in rows if row["R_ann"] and row["R_bob"]]
    found = {(row["G_ann"], row["rho"], row["B_bob_ann"]) for row in both}
    assert found == set(product("ab", (-1.0, 2.0), "ab"))
    assert len(both) == 8
    assert all("B_bob_ann" not in row for row in rows if row not in both)
    assert len(rows) == 8 + 1 + 2 + 1
    literal = grid_hypotheses(spec_of(TEXT + "audience\n    hypotheses = literal\n"))
    # Ann's goal, bob's attitude and what he takes ann to want, of both rational or irrational.
    assert len(literal) == 2 * (2 * 2 * 2) + 2 * (2 * 1 * 2)


def test_who_is_mistaken_acts_as_if_he_were_right() -> None:
    """Bob as one who sees a through the eyes of B; ann as she is."""
    mistaken, plain = (
        build_world(spec_of()),
        build_world(spec_of(TEXT.replace("    misreads = ann\n", ""))),
    )
    rows, known = grid_hypotheses(mistaken.spec), grid_hypotheses(plain.spec)
    states = np.arange(mistaken.dynamics.state_count)
    ann, bob = (log_policy(mistaken.tables, who, states)[..., 0, :] for who in (0, 1))
    ann_, bob_ = (log_policy(plain.tables, who, states)[..., 0, :] for who in (0, 1))
    for number, row in enumerate(rows):
        truth = {k: v for k, v in row.items() if k != "B_bob_ann"}
        seen = truth | {"G_ann": row["B_bob_ann"]} if "B_bob_ann" in row else truth
        np.testing.assert_allclose(ann[..., number], ann_[..., known.index(truth)], atol=1e-9)
        np.testing.assert_allclose(bob[..., number], bob_[..., known.index(seen)], atol=1e-9)


def test_beliefs_of_mistakes_by_bayes() -> None:
    """Along a random script, by plain sums over the hypotheses."""
    world = build_world(spec_of())
    rows, random = grid_hypotheses(world.spec), np.random.default_rng(3)
    states, actions = [7], []
    belief = np.full(len(rows), 1 / len(rows))
    for _ in range(6):
        state = np.asarray(states[-1])
        turns = world.turns(world.tables, state)
        action = int(random.choice(np.flatnonzero(turns.valid)))
        for row in world.log_rows(world.tables, state, np.asarray(action), state):
            belief = belief * np.exp(row[0])
            belief /= belief.sum()
            eps = world.spec.settings.forgetting
            belief = belief * (1 - eps) + (1 - belief) / (len(rows) - 1) * eps
        actions.append(action)
        states.append(int(world.transition(world.tables, state, np.asarray(action))))
    frames = replay(world, np.array(states), np.array(actions))
    np.testing.assert_allclose(np.exp(frames.log_belief[-1, 0]), belief, atol=1e-9)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("misreads = ann", "misreads = bob", "no other character `bob`"),
        ("    toward = ann\n    attitude = {-1, 2}\n", "", "cannot be wrong about it"),
    ],
)
def test_what_cannot_be_is_said(old: str, new: str, message: str) -> None:
    with pytest.raises(StoryError, match=message):
        spec_of(TEXT.replace(old, new))
