"""Additive planning against tests/reference.py: differences between small worlds, summed."""

from __future__ import annotations

import math
import re
from functools import cache
from itertools import combinations
from random import Random

import numpy as np
import pytest

import reference as R
from i2pdsl.errors import Source, StoryError
from i2pdsl.worlds.grid import cost, method
from i2pdsl.worlds.grid.additive import coefficients, core
from i2pdsl.worlds.grid.kind import KIND
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.grid.policy import action_values, log_policy
from i2pdsl.worlds.grid.spec import GridSpec
from i2pdsl.worlds.grid.world import GridWorld, build_world
from worlds_for_tests import CROWD, Pair, planned

COUPLE = re.sub("(object .*)", r"\1\n    may_be_absent = yes", CROWD)
TRIO = """
map
    P..
    ..G
tile pink
    symbol = P
tile green
    symbol = G
character mouse
    success = 0.6
    goals = {pink, green}
character cat
    goals = {green, none}
    pushes = {mouse, box}
    toward = mouse
    attitude = {-1, 1}
character dog
    success = 0.8
    goals = pink
    pushes = {cat, box}
    models = mouse
object box
planning
    gamma = 0.8
    method = additive
"""
TILES = {"pink": (0, 0), "green": (2, 1)}
CASTS = {
    COUPLE: (
        R.Character("cheese", 0.6, (), ("pink", "green")),
        R.Character(
            "robot", 1.0, ("cheese", "table", "chair"), ("pink", "none"), "cheese", (-1, 1)
        ),
        R.Object("table", True),
        R.Object("chair", True),
    ),
    TRIO: (
        R.Character("mouse", 0.6, (), ("pink", "green")),
        R.Character("cat", 1.0, ("mouse", "box"), ("green", "none"), "mouse", (-1, 1)),
        R.Character("dog", 0.8, ("cat", "box"), ("pink",), models="mouse"),
        R.Object("box"),
    ),
}
CORES = {"cheese": 1, "robot": 2, "mouse": 1, "cat": 2, "dog": 2}


def spec_of(text: str, name: str = "crowd") -> GridSpec:
    return parse_world(Source(f"{name}.world", text), name)


@cache
def additive(text: str, at_once: int) -> GridWorld:
    return build_world(spec_of(f"{text}    at_once = {at_once}\n"))


@cache
def reference_world(text: str, names: frozenset[str] | None = None) -> R.World:
    """The world, or one with some of its entities alone, in the reference's version."""
    cast = [e for e in CASTS[text] if names is None or e.name in names]
    characters = [c for c in cast if isinstance(c, R.Character)]
    known = {c.name for c in characters}
    for i, c in enumerate(characters):
        if not c.modelled <= known:
            characters[i] = R.Character(c.name, c.success, c.pushes, c.goals)
    objects = [o for o in cast if isinstance(o, R.Object)]
    return R.World(["P..", "..G"], TILES, characters, objects, gamma=0.8)


def after_action(text: str, names: frozenset[str], who: str, row: dict, state: dict) -> float:
    """W of a sub-world: what is to be expected once a character has acted."""
    small, whole = reference_world(text, names), reference_world(text)
    cells = tuple(state[name] for name in small.entities)
    known = {pair: row[name] for pair, name in whole.rho.items() if name in row}
    rhos = {name: known[pair] for pair, name in small.rho.items() if pair in known}
    problem = small.problem(who, row | rhos)
    social, reached = small.answer(problem, cells)
    values = small._planned(problem, cells)
    return social + sum(p * values[s] for s, p in reached.items())


def summed(text: str, at_once: int, who: str, row: dict, state: dict) -> float:
    """What the core can reach, and what each few of the others change beyond what fewer do."""
    whole = reference_world(text)
    own = {who, *whole.characters[who].modelled}
    others = [name for name in whole.entities if name not in own]
    total = 0.0
    for size in range(max(0, at_once - len(own)) + 1):
        for some in combinations(others, size):
            for k in range(size + 1):
                for fewer in combinations(some, k):
                    w = after_action(text, frozenset({*own, *fewer}), who, row, state)
                    total += (-1) ** (size - k) * w
    return total


def test_plans_without_problems_are_read_again() -> None:
    """Where the dog models nobody, nobody plans for the cat that it meets."""
    world = additive(TRIO.replace("    models = mouse\n", ""), 2)
    again = build_world(world.spec)
    for ours, theirs in zip(world.tables.continuation, again.tables.continuation, strict=True):
        np.testing.assert_array_equal(ours, theirs)


@pytest.mark.parametrize("text", [COUPLE, TRIO], ids=["couple", "trio"])
@pytest.mark.parametrize("at_once", [2, 3])
def test_values_are_sums_over_sub_worlds(text: str, at_once: int) -> None:
    world, whole = additive(text, at_once), reference_world(text)
    pair = Pair(world, whole)
    places = [*map(tuple, world.dynamics.coordinates.tolist()), None]
    count, order = world.dynamics.state_count, pair.order()
    assert count == whole.count_states()
    some = Random(at_once).sample(range(count), 6)
    for who, name in enumerate(whole.characters):
        for number in some:
            cells = tuple(places[c] for c in world.dynamics.cells[number])
            logs = log_policy(world.tables, who, np.asarray(number))[:, 0]
            values = world.value(world.tables, who, np.asarray(number))[0]
            for h in Random(number).sample(range(len(order)), 4):
                row = whole.hypotheses[order[h]]
                if not row[f"R_{name}"]:
                    np.testing.assert_allclose(logs[:, h], math.log(1 / 5), atol=1e-9)
                    continue
                q = {}
                for a in R.ACTIONS:
                    q[a] = whole.reward(name, row[f"G_{name}"], cells, a)
                    for p, after in whole.outcomes(cells, name, a):
                        there = dict(zip(whole.entities, after, strict=True))
                        q[a] += 0.8 * p * summed(text, at_once, name, row, there)
                assert values[h] == pytest.approx(max(q.values()), abs=1e-4)
                policy = R.log_softmax({a: 2.0 * v for a, v in q.items()})
                np.testing.assert_allclose(logs[:, h], [*policy.values()], atol=1e-3)


def test_a_core_are_those_who_are_modelled_and_all_that_is_carried() -> None:
    spec = spec_of(TRIO)
    assert [sorted(core(spec, who)) for who in range(3)] == [[0], [0, 1], [0, 2]]
    chain = TRIO.replace("models = mouse", "models = cat")
    assert sorted(core(spec_of(chain), 2)) == [0, 1, 2]
    carried = TRIO.replace("object box", "object box\n    cell = (1, 1)")
    carried = carried.replace("pushes = {mouse, box}", "carries = box\n    pushes = mouse")
    carried = carried.replace("pushes = {cat, box}", "pushes = cat")
    assert sorted(core(spec_of(carried), 2)) == [0, 1, 2, 3]  # the cat carries the box
    assert sorted(core(spec_of(carried), 0)) == [0, 1, 3]


@pytest.mark.parametrize("at_once", [1, 2, 3, 4, 5, 9])
def test_what_all_sub_worlds_say_alike_is_said_once(at_once: int) -> None:
    """Over all sub-worlds, and over those with an entity that counts, coefficients add up to 1."""
    text = TRIO.replace("object box", "object box\nobject crate\nobject chest")
    for who in range(3):
        own = len(core(spec_of(text), who))
        found = coefficients(spec_of(text), who, at_once)
        assert sum(found.values()) == 1
        assert max(map(len, found)) == max(own, min(at_once, 6))
        held = sum(count for kept, count in found.items() if 5 in kept)
        assert held == (1 if at_once > own else 0)


def test_with_all_entities_at_once_plans_are_exact() -> None:
    whole, exact = additive(COUPLE, 4), planned(COUPLE.replace("additive", "exact"))
    assert whole.tables.terms is None
    for ours, theirs in zip(whole.tables.continuation, exact.tables.continuation, strict=True):
        np.testing.assert_allclose(ours, theirs, atol=1e-4)


def errors(text: str, at_once: int) -> tuple[GridWorld, np.ndarray]:
    """How far the additive values after an action are from the exact ones: the worst of all
    problems in each state."""
    from i2pdsl.worlds.grid.arrays import continued

    world, exact = additive(text, at_once), planned(text.replace("additive", "exact"))
    every = np.arange(world.dynamics.state_count)
    apart = [
        np.abs(continued(world.tables, who, every) - exact.tables.continuation[who]).max(-1)
        for who in range(len(world.spec.characters))
    ]
    return world, np.max(apart, axis=0)


def test_where_few_are_there_plans_are_exact() -> None:
    """What is absent changes nothing, so with one of the two tables values are right."""
    world, apart = errors(COUPLE, 3)
    few = (world.dynamics.cells[:, 2:] == world.dynamics.absent).any(1)
    assert apart[few].max() < 1e-4
    assert apart[~few].max() > 0.01


def test_what_never_meets_anybody_adds_no_error() -> None:
    """A box in a closet of its own: nobody can get there."""
    text = COUPLE.replace("    ..G\n", "    ..G\n    ###\n    ...\n", 1)
    world, apart = errors(text, 3)
    rows = world.dynamics.coordinates[:, 1]
    cells = world.dynamics.cells
    people, things = (rows[cells[:, :2]] < 2).all(1), (cells[:, 2:] < world.dynamics.absent).all(1)
    there = rows[np.minimum(cells[:, 2:], len(rows) - 1)]
    alone = people & things & (there > 2).any(1)
    assert alone.sum() > 100
    assert apart[alone].max() < 1e-4
    assert apart[people & things & (there < 2).all(1)].max() > 0.01


def test_things_that_are_alike_are_summed_like_two_of_a_kind() -> None:
    two = "object table\nobject chair\nplanning"
    text = re.sub(r"object table(.|\n)*planning", two, COUPLE)
    like = text.replace("object table\nobject chair", "object box\n    count = 2")
    like = like.replace("{cheese, table, chair}", "{cheese, box}")
    one, other = additive(text, 3), additive(like, 3)
    cells = one.dynamics.cells
    order = cells.copy()
    order[:, 2:] = np.sort(order[:, 2:], axis=1)
    same = other.dynamics.lookup[order.astype(int) @ other.dynamics.strides]
    for who in range(2):
        ours = action_values(one.tables, who, np.arange(len(cells)))
        np.testing.assert_allclose(ours, action_values(other.tables, who, same), atol=1e-4)


def test_keys_and_doors_stay_with_those_who_carry_them() -> None:
    """While the crates are absent values are exact, whoever has the key."""
    text = """
map
    k.D.
    .#.S
tile sun
    symbol = S
object key
    symbol = k
object door
    symbol = D
    opened_by = key
object crate
    may_be_absent = yes
object chest
    may_be_absent = yes
character child
    success = 0.6
    goals = {sun, none}
character dog
    carries = key
    pushes = crate
    toward = child
    attitude = {-1, 1}
planning
    gamma = 0.8
    method = additive
"""
    world, apart = errors(text, 5)
    few = (world.dynamics.cells[:, 4:] == world.dynamics.absent).any(1)
    assert apart[few].max() < 1e-4
    assert len({int(c) for c in world.dynamics.cells[few, 2]}) == 2  # on its cell, or carried


def test_searches_see_the_same_values() -> None:
    import jax

    world, every = additive(COUPLE, 3), np.arange(0, 300, 7)
    tables = world.search_tables._replace(policies=None)
    for who in range(2):
        theirs = jax.jit(lambda t, s, who=who: log_policy(t, who, s))(tables, every)
        np.testing.assert_allclose(theirs, log_policy(world.tables, who, every), atol=1e-3)
        tabulated = log_policy(world.search_tables, who, every)
        np.testing.assert_allclose(tabulated, theirs, atol=1e-4)


# ---- Which method it is --------------------------------------------------------------------------


def test_auto_is_exact_where_that_fits(monkeypatch: pytest.MonkeyPatch) -> None:
    spec = spec_of(COUPLE.replace("    method = additive\n", ""))
    assert spec.settings.method == "auto"
    assert method.at_once(spec) is None
    needed = method.estimated_bytes(spec)
    for module in (cost, method):
        monkeypatch.setattr(module, "memory_limit", lambda: needed - 1)
    assert method.at_once(spec) == 3
    for module in (cost, method):
        monkeypatch.setattr(module, "memory_limit", lambda: needed)
    assert method.at_once(spec) is None
    monkeypatch.setattr(cost, "PATIENCE", method.estimated_seconds(spec) / 2)
    assert method.at_once(spec) == 3


def test_who_did_not_ask_for_it_is_warned(monkeypatch: pytest.MonkeyPatch) -> None:
    auto = spec_of(COUPLE.replace("additive", "auto"))
    told = lambda spec: [d for d in KIND.warnings(spec, "w.world") if d.code == "approximate"]
    assert told(auto) == []
    monkeypatch.setattr(method, "FEW", 0)
    assert told(auto) == []
    monkeypatch.setattr(cost, "PATIENCE", method.estimated_seconds(auto) / 2)
    (warning,) = told(auto)
    assert warning.severity == "warning"
    assert f"{auto.state_count:,} states" in warning.message
    assert "3 at once" in warning.message
    assert told(spec_of(COUPLE)) == []


def test_the_method_is_what_a_story_or_the_world_says() -> None:
    spec = spec_of(COUPLE)
    assert method.at_once(spec) == 3
    assert method.at_once(spec.with_settings({"at_once": 2.0})) == 2
    assert method.at_once(spec.with_settings({"method": "exact"})) is None
    assert spec.with_settings({"method": "exact"}).planning_key == spec.planning_key


@pytest.mark.parametrize("change", ["    horizon = 4\n", "    order = together\n"])
def test_with_an_end_or_together_plans_are_exact(change: str) -> None:
    """Whoever asks for something else is told."""
    with pytest.raises(StoryError, match="planning cannot be additive where"):
        method.check_size(spec_of(COUPLE + change))
    assert method.at_once(spec_of(COUPLE.replace("additive", "auto") + change)) is None


def test_with_a_way_round_plans_are_exact() -> None:
    text = COUPLE.replace("goals = {pink, none}", "goals = {pink, none}\n    via = green")
    with pytest.raises(StoryError, match="planning cannot be additive where somebody wants to go"):
        method.check_size(spec_of(text))
    assert method.at_once(spec_of(text.replace("additive", "auto"))) is None


def test_what_does_not_fit_is_refused_with_what_would(monkeypatch: pytest.MonkeyPatch) -> None:
    from i2pdsl.worlds.grid import planning

    row = "    " + "." * 16
    text = "map\n" + "\n".join([row] * 8) + "\ncharacter a\ncharacter b\n    models = a\n"
    text += "object c\nobject d\nplanning\n    method = exact\n"
    spec = spec_of(text)
    for module in (method, planning):
        monkeypatch.setattr(module, "memory_limit", lambda: 100 * 2**30)
    with pytest.raises(StoryError, match=f"{spec.state_count:,} states") as caught:
        method.check_size(spec)
    hint = caught.value.diagnostics[0].hint
    assert re.fullmatch(
        r"`method = additive` with `at_once = 3` would take [\d.]+ GiB, and be approximate", hint
    )
    method.check_size(spec.with_settings({"method": "additive"}))
    for module in (method, planning):
        monkeypatch.setattr(module, "memory_limit", lambda: 2**30)
    with pytest.raises(StoryError, match="3 at once would take") as caught:
        method.check_size(spec.with_settings({"method": "additive"}))
