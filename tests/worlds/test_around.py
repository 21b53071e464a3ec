"""Exact planning around scripts, against plain loops and against exact plans of everything."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from random import Random

import numpy as np
import pytest

from i2pdsl.errors import Source
from i2pdsl.planning import value_iteration
from i2pdsl.worlds.grid import around as subject
from i2pdsl.worlds.grid.arrays import continued
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.grid.policy import action_values
from i2pdsl.worlds.grid.world import GridWorld, build_world
from i2pdsl.worlds.kind import Watch
from i2pdsl.worlds.record import Trajectory
from i2pdsl.worlds.world import Viewer
from worlds_for_tests import CROWD, trajectory


@cache
def world(method: str) -> GridWorld:
    told = "goals = {pink, green}\n"
    text = CROWD.replace(told, f"{told}    pushes = table\n").replace("additive", method)
    return build_world(parse_world(Source("crowd.world", text), "crowd"))


def scripts(count: int, length: int) -> list[Trajectory]:
    """Scripts of random turns."""
    found, random, crowd = [], Random(3), world("additive")
    for _ in range(count):
        state = start = random.randrange(crowd.dynamics.state_count)
        actions = []
        for _ in range(length):
            turns = crowd.turns(crowd.tables, np.asarray(state))
            actions.append(random.choice(np.flatnonzero(turns.valid).tolist()))
            state = int(turns.state[actions[-1]])
        found.append(trajectory(crowd, start, np.array(actions)))
    return found


def part_of(
    paths: list[Trajectory], watch: Watch | None = None
) -> tuple[GridWorld, list[Trajectory]]:
    crowd = world("additive")
    found = subject.around(crowd, (Viewer(crowd.spec),), paths, watch)
    assert found is not None
    return found


def test_what_is_around_everything_is_planned_exactly(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(subject, "MOST_MOVES", 12)
    (part, (path,)), exact = part_of(scripts(1, 2)), world("exact")
    assert part.dynamics.state_count == exact.dynamics.state_count
    assert (part.dynamics.cells == exact.dynamics.cells).all()
    assert (path.states == scripts(1, 2)[0].states).all()
    for who in range(2):
        ours, theirs = part.tables.continuation[who], exact.tables.continuation[who]
        np.testing.assert_allclose(ours, theirs, atol=3e-3)


def test_beyond_the_end_values_are_additive(monkeypatch: pytest.MonkeyPatch) -> None:
    """What the cheese, who models nobody, expects: by plain loops over the states inside."""
    monkeypatch.setattr(subject, "MOST_MOVES", 0)
    crowd = world("additive")
    part, _ = part_of(scripts(1, 3))
    cells = [tuple(row) for row in part.dynamics.cells.tolist()]
    whole = {tuple(row): i for i, row in enumerate(crowd.dynamics.cells.tolist())}
    number = np.array([whole[row] for row in cells])
    ends = [
        i
        for i in range(len(cells))
        if any((crowd.dynamics.successor[w][:, number[i]] != number[i]).any() for w in (0, 1))
        and all((part.dynamics.successor[w][:, i] == i).all() for w in (0, 1))
    ]
    assert 0 < len(ends) < len(cells)
    moves = [part.dynamics.successor[w].T.tolist() for w in (0, 1)]
    after_own = {j for i in range(len(cells)) if i not in ends for j in moves[0][i]}
    known = {
        i: continued(crowd.tables, 0, number[i])
        if i in after_own
        else action_values(crowd.tables, 0, number[i]).max(0)
        for i in ends
    }
    assert len({i in after_own for i in ends}) == 2
    for problem in range(2):
        goal = int(np.flatnonzero(crowd.tables.goals[0][problem])[0])
        w = {i: known[i][problem] if i in known else 0.0 for i in range(len(cells))}
        for _ in range(120):
            v = {}
            for i, row in enumerate(cells):
                paid = 1.0 if row[0] == goal else 0.0
                after = [0.6 * w[moves[0][i][a]] + 0.4 * w[i] for a in range(5)]
                v[i] = paid + max((-0.1 if a == 4 else -1.0) + 0.8 * after[a] for a in range(5))
            for i in range(len(cells)):
                if i not in known:
                    w[i] = sum(v[j] if j not in known else w[j] for j in moves[1][i]) / 5
        np.testing.assert_allclose(
            part.tables.continuation[0][:, problem], [*w.values()], atol=3e-3
        )


def test_scripts_stay_where_they_are(monkeypatch: pytest.MonkeyPatch) -> None:
    paths = scripts(4, 5)
    crowd = world("additive")
    part, renumbered = part_of(paths)
    for path, found in zip(paths, renumbered, strict=True):
        ours = part.dynamics.cells[found.states]
        assert (ours == crowd.dynamics.cells[path.states]).all()
        again = trajectory(part, found.states[0], found.actions)
        assert (again.states == found.states).all()
    for name, value in (("PATIENCE", 0.0), ("SHARE", 1e-12)):
        with monkeypatch.context() as patched:
            patched.setattr(subject, name, value)
            assert subject.around(crowd, (Viewer(crowd.spec),), paths) is None


def test_it_is_nearer_to_exact_plans_than_sums_are() -> None:
    paths, exact, sums = scripts(12, 4), world("exact"), world("additive")
    part, renumbered = part_of(paths)
    errors = []
    for path, own in zip(paths, renumbered, strict=True):
        told = [
            world_.value(world_.tables, 1, states)
            for world_, states in ((exact, path.states), (sums, path.states), (part, own.states))
        ]
        errors.append([np.abs(told[0] - other).mean() for other in told[1:]])
    additive, around = np.mean(errors, axis=0)
    assert around < additive / 2


def test_what_was_planned_last_is_begun_with_whatever_the_cache_holds(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("I2PDSL_CACHE", str(tmp_path))
    sweeps: list[int] = []

    def counted(*given: object, **named: object) -> value_iteration.Solution:
        found = usual(*given, **named)  # type: ignore[arg-type]
        sweeps.append(found.sweeps)
        return found

    usual = value_iteration.solve
    monkeypatch.setattr(value_iteration, "solve", counted)

    def planned() -> tuple[list[np.ndarray], int]:
        sweeps.clear()
        part, _ = part_of(scripts(1, 3))
        return list(part.tables.continuation), sum(sweeps)

    first, many = planned()
    again, few = planned()
    assert few < many / 2
    file, arrays = entry(tmp_path)
    forged = {key: array if key == "mark" else array * 0 + 7 for key, array in arrays.items()}
    np.savez(file, **forged)
    other, _ = planned()
    for found in (again, other):
        for ours, theirs in zip(found, first, strict=True):
            np.testing.assert_allclose(ours, theirs, atol=2e-3)
    part_of(scripts(2, 2))
    assert (entry(tmp_path)[1]["mark"] != arrays["mark"]).any()  # of one place at a time


def entry(cache: Path) -> tuple[Path, dict[str, np.ndarray]]:
    """The one file of plans around scripts, and what it holds."""
    (file,) = cache.rglob("around-*.npz")
    with np.load(file) as held:
        return file, dict(held)


FORGERIES = {
    "larger than any": lambda array: array * 0 + 1e4,
    "far larger": lambda array: array * 0 + 1e300,
    "no number": lambda array: array * np.nan,
    "text": lambda array: np.full(array.shape, "seven"),
    "complex": lambda array: array.astype(complex),
    "in half precision": lambda array: array.astype(np.float16),
    "of another shape": lambda array: array[1:],
}


Values = tuple[np.ndarray, ...]


@pytest.fixture
def first(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Values:
    """Of a small part that is planned and kept in an empty cache."""
    monkeypatch.setenv("I2PDSL_CACHE", str(tmp_path))
    monkeypatch.setattr(subject, "MOST_MOVES", 0)
    found: Values = part_of(scripts(1, 3))[0].tables.continuation
    return found


def test_an_entry_that_holds_no_values_of_a_part_is_said_and_made_again(
    first: Values, tmp_path: Path
) -> None:
    file, arrays = entry(tmp_path)
    for name, change in FORGERIES.items():
        np.savez(file, **{key: a if key == "mark" else change(a) for key, a in arrays.items()})
        said: list[str] = []
        part, _ = part_of(scripts(1, 3), Watch(say=said.append))
        (message,) = (line for line in said if "around-" in line)
        assert message.endswith("does not fit the world; it is made again"), name
        for ours, theirs in zip(part.tables.continuation, first, strict=True):
            assert (ours == theirs).all()
        kept = entry(tmp_path)[1]
        assert all((kept[key] == array).all() for key, array in arrays.items())


def test_an_entry_from_which_nothing_settles_is_said_and_made_again(
    first: Values, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever is kept: also values of the right size."""
    usual, starts = value_iteration.solve, []

    def refusing(*given: object, start: np.ndarray, **named: object) -> value_iteration.Solution:
        starts.append(start)
        if len(starts) == 1:
            raise value_iteration.NotConverged("never")
        return usual(*given, start=start, **named)  # type: ignore[arg-type]

    monkeypatch.setattr(value_iteration, "solve", refusing)
    said: list[str] = []
    part, _ = part_of(scripts(1, 3), Watch(say=said.append))
    assert any("is no plan of this part" in line for line in said)
    for ours, theirs in zip(part.tables.continuation, first, strict=True):
        assert (ours == theirs).all()
    monkeypatch.setattr(value_iteration, "solve", usual)
    again, _ = part_of(scripts(1, 3))
    np.testing.assert_allclose(again.tables.continuation[1], first[1], atol=2e-3)


def test_around_computed_states_all_is_as_around_listed_ones() -> None:
    """The same scripts, the same part, in another order of its ends at most."""
    crowd, paths = world("additive"), scripts(2, 3)
    spec = crowd.spec.with_settings({"states": "computed"})
    computed = build_world(spec)
    number = computed.dynamics.state_of(crowd.dynamics.cells)
    renamed = [replace(path, states=number[path.states]) for path in paths]
    found = subject.around(computed, (Viewer(spec),), renamed)
    assert found is not None
    (part, told), (other, others) = found, part_of(paths)
    cells, theirs = part.dynamics.cells, other.dynamics.cells
    order, back = np.lexsort(cells.T), np.lexsort(theirs.T)
    assert (cells[order] == theirs[back]).all()
    for who in range(2):
        ours = part.tables.continuation[who][order]
        np.testing.assert_allclose(ours, other.tables.continuation[who][back], atol=3e-3)
    for path, twin in zip(told, others, strict=True):
        assert (cells[path.states] == theirs[twin.states]).all()
