"""What plans promise: beliefs right to 1e-4, values to 1e-2, against solutions that are tight."""

from __future__ import annotations

from random import Random

import numpy as np
import pytest

from i2pdsl.errors import Source
from i2pdsl.objective.replay import replay
from i2pdsl.worlds.grid.dynamics import build_dynamics
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.grid.planning import Plan, solve
from i2pdsl.worlds.grid.world import GridWorld, assemble
from i2pdsl.worlds.world import Viewer
from worlds_for_tests import STORIES, Pair, kitchen_text

ROOM = ("P...", ".#..", "...G")


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("kitchen", {}),
        ("kitchen", {"gamma": "0.9"}),
        pytest.param("kitchen", {"gamma": "0.999"}, marks=pytest.mark.slow),
        ("kitchen", {"beta": "10"}),
        ("kitchen", {"level0": "costs", "stay": "-0.5"}),
        ("maze", {}),
        ("fork", {}),
    ],
)
def test_beliefs_and_values_are_right(name: str, changes: dict[str, str]) -> None:
    text = (STORIES / "worlds" / f"{name}.world").read_text(encoding="utf-8")
    if name == "kitchen":
        text = kitchen_text(ROOM, **changes)
    spec = parse_world(Source(f"{name}.world", text), name)
    dynamics = build_dynamics(spec)
    put = lambda plan: assemble(spec, dynamics, (Viewer(spec),), [plan])
    plan = solve(spec, dynamics)
    ours, truth = put(plan), put(solve(spec, dynamics, tolerance=1e-14 / (1 - spec.settings.gamma)))
    assert plan.bound <= 2e-2  # a bound for the worst case: what is reached is below
    _compare_values(ours, truth, plan)
    random = Random(0)
    pair = Pair(truth, None)  # type: ignore[arg-type]
    for _ in range(30):
        path = pair.random_script(random, 15)
        one = replay(ours, path.states, path.actions)
        other = replay(truth, path.states, path.actions)
        belief, right = np.exp(one.log_belief), np.exp(other.log_belief)
        assert np.abs(belief - right).max() <= 1e-4
        for who in range(len(spec.characters)):
            values = [
                (b[..., 0, :] * w.value(w.tables, who, path.states)[..., 0, :]).sum(-1)
                for w, b in ((ours, belief), (truth, right))
            ]
            assert np.abs(values[0] - values[1]).max() <= 1e-2


def _compare_values(ours: GridWorld, truth: GridWorld, plan: Plan) -> None:
    for found, right in zip(ours.tables.continuation, truth.tables.continuation, strict=True):
        assert np.abs(found - right).max() <= plan.bound
