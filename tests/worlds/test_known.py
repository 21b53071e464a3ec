"""What viewers expect where scripts passed is kept, and never another number."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from i2pdsl.worlds.grid import known
from i2pdsl.worlds.grid.known import Known
from i2pdsl.worlds.grid.policy import log_softmax
from worlds_for_tests import SMALL_MAP, kitchen_text, planned


def test_what_is_kept_is_what_is_computed(monkeypatch: pytest.MonkeyPatch) -> None:
    world = planned(kitchen_text(SMALL_MAP, gamma="0.8"))
    tables, generator = world.tables, np.random.default_rng(0)
    for who in (0, 1):
        kept, every = Known(tables, who), np.arange(world.tables.cells.shape[0])
        logs = log_softmax(tables, who, every)
        for shape in ((3,), (40, 5), (), (2000,), (3,)):
            state, act = (
                generator.integers(len(every), size=shape),
                generator.integers(5, size=shape),
            )
            np.testing.assert_array_equal(kept.taken(state, act), logs[state, act])
        again = pickle.loads(pickle.dumps(kept))
        assert (again.count, kept.count > 0) == (0, True)
        np.testing.assert_array_equal(again.taken(state, act), logs[state, act])
        monkeypatch.setattr(known, "MOST_BYTES", 8 * logs[0].size * 100)
        few = Known(tables, who)
        assert few.taken(every[:101], every[:101] % 5) is None
        np.testing.assert_array_equal(
            few.taken(every[:9], every[:9] % 5), logs[every[:9], every[:9] % 5]
        )
        monkeypatch.undo()


def test_a_world_before_other_viewers_keeps_its_own() -> None:
    world = planned(kitchen_text(SMALL_MAP, gamma="0.8"))
    state = np.arange(50)
    action = np.random.default_rng(1).integers(world.turn_count, size=50)
    rows = world.log_rows(world.tables, state, action, state)
    prior, forgetting = world.tables.log_prior, world.tables.forgetting
    sharper = world.with_audience(3.0, forgetting, prior)
    others = sharper.log_rows(sharper.tables, state, action, state)
    assert max(np.abs(a - b).max() for a, b in zip(rows, others, strict=True)) > 0.1
    again = world.log_rows(world.tables, state, action, state)
    for one, other in zip(rows, again, strict=True):
        np.testing.assert_array_equal(one, other)
