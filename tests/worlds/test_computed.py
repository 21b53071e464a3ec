"""Computed states against listed ones: all that a world can be asked, in all of its states.

What actions lead to is held against the rules where these are tested (as_computed)."""

from __future__ import annotations

import re
from functools import cache
from itertools import product

import jax
import numpy as np
import pytest

from i2pdsl.errors import Source, StoryError
from i2pdsl.language.check import TypedStory, check_source
from i2pdsl.objective.compile import asked_of, is_of_states, late_from
from i2pdsl.objective.reach import frames_until
from i2pdsl.objective.relaxed import least, relaxed
from i2pdsl.objective.starts import allowed_starts
from i2pdsl.stories import Story
from i2pdsl.studio.spots import spots
from i2pdsl.worlds.grid import model, packed, parts
from i2pdsl.worlds.grid.kind import KIND
from i2pdsl.worlds.grid.method import additive_bytes, is_computed
from i2pdsl.worlds.grid.packed import Computed
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.grid.parts import part_of, with_movers
from i2pdsl.worlds.grid.spec import GridSpec
from i2pdsl.worlds.grid.world import GridWorld, build_world
from i2pdsl.worlds.kind import Watch
from i2pdsl.worlds.world import Viewer, on_device
from worlds_for_tests import CROWD

COUPLE = re.sub("(object .*)", r"\1\n    may_be_absent = yes", CROWD).replace(
    "planning", "event deus\n    drops = {table, chair}\nplanning"
)
LOCKED = """
map
    k .|D
    . . G
tile goal
    symbol = G
character ann
    success = 0.7
    goals = goal
    carries = key
    diagonals = yes
character bob
    goals = {goal, none}
    carries = key
    puts_down = key
    pulls = box
    toward = ann
    attitude = {-1, 1}
object key
    symbol = k
object door
    symbol = D
    opened_by = key
object box
    count = 2
planning
    gamma = 0.8
    method = additive
    at_once = 4
"""


def spec_of(text: str) -> GridSpec:
    return parse_world(Source("crowd.world", text), "crowd")


@cache
def world(text: str, states: str) -> GridWorld:
    spec = spec_of(text).with_settings({"states": states})
    return build_world(spec)


def numbers(text: str) -> np.ndarray:
    """The computed number of each listed state."""
    return world(text, "computed").dynamics.state_of(world(text, "listed").dynamics.cells)


def same(ours, theirs) -> None:
    for a, b in zip(jax.tree.leaves(ours), jax.tree.leaves(theirs), strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("text", [COUPLE, LOCKED], ids=["couple", "locked"])
def test_all_that_is_asked_is_answered_alike(text: str) -> None:
    listed, computed = world(text, "listed"), world(text, "computed")
    assert isinstance(computed.dynamics, Computed)
    number, every = numbers(text), np.arange(listed.dynamics.state_count)
    assert (number >= 0).all()
    assert len(set(number)) == computed.dynamics.state_count == len(every)
    assert (np.sort(number[listed.starts()]) == computed.starts()).all()
    ours, theirs = (w.turns(w.tables, s) for w, s in ((computed, number), (listed, every)))
    same(ours._replace(state=number[theirs.state]), theirs._replace(state=ours.state))
    random = np.random.default_rng(0)
    some = random.choice(every, 400)
    action = random.integers(
        listed.turn_count + len(listed.moves.events) * listed.moves.slots, size=400
    )
    pairs = (computed, number[some]), (listed, some)
    if listed.moves.events:
        (fell, can), (falls, could) = (w.drops(w.tables, s) for w, s in pairs)
        assert (can == could).all()
        assert (fell == number[falls]).all()
        assert could.any()
    after, afterwards = (w.transition(w.tables, s, action) for w, s in pairs)
    assert (after == number[afterwards]).all()
    same(*(w.log_rows(w.tables, s, action, s) for w, s in pairs))
    same(*(w.best_rows(w.tables, s, action, s) for w, s in pairs))
    same(*(w.attempts(w.tables, s, action) for w, s in pairs))
    same(*([w.value(w.tables, who, s) for who in (0, 1)] for w, s in pairs))
    things = range(len(listed.spec.entities))
    asked = [("at", (e, (0, 3))) for e in things] + [("absent", (e,)) for e in things]
    asked += [("adjacent", pair) for pair in product(things, things)]
    asked += [("moved", (0,)), ("tried", (1,)), ("faces", (0, 1)), ("fell", (2,))]
    asked += [("pushes", (1, 2)), ("pushes", (1, 3)), ("holds", (1, 2)), ("takes", (1, 2))]
    asked += [("puts", (1, 2)), ("gives", (1, 2)), ("opens", (0, 3)), ("opens", (1, 3))]
    ends = (after, afterwards)
    for name, arguments in asked:
        told = [
            w.feature(w.tables, name, arguments, end, s, action)
            for (w, s), end in zip(pairs, ends, strict=True)
        ]
        assert (told[0] == told[1]).all(), (name, arguments)


def test_compiled_programs_compute_the_same() -> None:
    computed, number = world(LOCKED, "computed"), numbers(LOCKED)[::7].astype(np.int32)
    tables = computed.search_tables
    found = jax.jit(lambda s: model.turns(tables, computed.moves, s))(number)
    told = computed.turns(computed.tables, number)
    assert (np.asarray(found.state) == told.state).all()
    assert (np.asarray(found.valid) == told.valid).all()
    for a, b in zip(found.log_rows, told.log_rows, strict=True):
        np.testing.assert_allclose(a, b, atol=2e-3)
    assert on_device(tables).packed is not None


STARTS = [
    None,
    "adjacent(cheese, table)",
    "at(robot, pink) and not absent(chair)",
    "absent(table) or absent(chair)",
    "distance(robot, cheese) = 3 and adjacent(table, chair) and at(cheese, green)",
    "adjacent(robot, cheese) and distance(robot, cheese) = 3",
]


def told(world: GridWorld, start: str | None) -> TypedStory:
    line = "" if start is None else f"start {start}\n"
    text = f"world crowd\nlength 4\n{line}maximize depict(rho > 0)\n"
    checked = check_source(Source("test.story", text), lambda *_: world.vocabulary)
    assert isinstance(checked, TypedStory)
    return checked


@pytest.mark.parametrize("start", STARTS)
def test_first_pictures_are_those_of_the_list(
    start: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    listed, computed = world(COUPLE, "listed"), world(COUPLE, "computed")
    condition = told(listed, start).start
    right = numbers(COUPLE)[allowed_starts(listed, condition)]
    assert (allowed_starts(computed, condition) == np.sort(right)).all()
    monkeypatch.setattr(packed, "DRAWN", 30)
    monkeypatch.setattr(packed, "_AT_ONCE", 300)
    drawn = allowed_starts(computed, condition)
    assert len(set(drawn)) == min(30, len(right))
    assert set(drawn) <= set(right)


SOON = [
    (COUPLE, "at(robot, pink) and at(cheese, green)"),
    (COUPLE, "adjacent(table, chair) or at(table, green)"),
    (COUPLE, "not absent(table) and distance(robot, chair) = 1"),
    (COUPLE, "pushes(robot, table) and at(cheese, pink)"),
    (LOCKED, "holds(ann, key) and at(bob, goal)"),
    (LOCKED, "absent(door)"),
    (LOCKED, "at(box_2, goal)"),
]


@pytest.mark.parametrize(("text", "condition"), SOON)
def test_nothing_can_be_seen_sooner_than_is_said(text: str, condition: str) -> None:
    listed, computed = world(text, "listed"), world(text, "computed")
    allow = "allow deus(table)\n" if text == COUPLE else ""
    told = f"world crowd\nlength 9\n{allow}maximize depict(rho > 0)\n"
    told += f"require eventually [{condition}]\n"
    story = check_source(Source("test.story", told), lambda *_: listed.vocabulary)
    assert isinstance(story, TypedStory)
    (requirement,) = story.requirements
    body, events = requirement.condition.body, listed.events(story.allow)
    of_states = is_of_states(listed, body)
    count = listed.dynamics.state_count
    right = frames_until(listed, events, asked_of(listed, body), of_states)[:count]
    known = relaxed(computed, body, computed.events(story.allow), asked_of)
    said = least(computed, computed.tables, known, numbers(text))
    assert (said <= right).all()
    assert (said == right).mean() > (0.25 if of_states else 0.0)
    assert len(set(said)) > 1
    late = late_from(computed, [(2, body)], computed.events(story.allow), numbers(text))
    assert ((late == 1) == (said > 2)).all()


def test_a_large_part_says_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    computed = world(COUPLE, "computed")
    assert with_movers(computed.spec, frozenset({0})) == {0, 1}
    assert with_movers(spec_of(LOCKED), frozenset({3})) == {0, 1, 2, 3}
    assert with_movers(spec_of(LOCKED), frozenset({5})) == {1, 4, 5}
    monkeypatch.setattr(parts, "MOST", 100)
    part_of.cache_clear()
    assert computed.small(frozenset({2})) is None
    part_of.cache_clear()


def test_too_many_states_are_computed_and_take_little() -> None:
    rows = "\n".join("    " + "." * 10 for _ in range(4))
    text = COUPLE.replace("    P..\n    ..G\n", f"    P.........\n{rows}\n    .........G\n")
    text = text.replace("object chair", "object crate\nobject chair")
    spec = spec_of(text)
    assert spec.state_count > 5 * 10**8
    assert is_computed(spec)
    assert additive_bytes(spec, 3) < 2 * 2**30
    listed = spec.with_settings({"states": "listed"})
    assert additive_bytes(listed, 3) > 100 * 2**30
    crowded = spec_of(text.replace("object crate", "object crate\nobject chest"))
    with pytest.raises(StoryError, match="numbers, more than can be computed with"):
        build_world(crowded.with_settings({"states": "computed"}))


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (("method = additive", "method = exact"), "only where planning is additive"),
        (("gamma = 0.8", "gamma = 0.8\n    horizon = 5"), "and states not computed"),
        (("method = additive", "order = together"), "and states not computed"),
    ],
)
def test_what_needs_a_list_is_refused_before_any_work(change: tuple[str, str], says: str) -> None:
    spec = spec_of(COUPLE.replace(*change) + "    states = computed\n")
    with pytest.raises(StoryError, match=says):
        KIND.build(spec, (Viewer(spec),), Watch())


def test_a_story_is_searched_alike_told_and_read(tmp_path) -> None:
    """The same starts, the same beams: the same script, whatever states are called."""
    scripts = []
    for states in ("listed", "computed"):
        text = f"{COUPLE}    states = {states}\n"
        (tmp_path / "crowd.world").write_text(text, encoding="utf-8")
        story = "world crowd\nlength 4\nstart at(cheese, pink) and at(robot, green)\n"
        story += "allow deus(table)\nmaximize depict(rho > 0)\nrequire eventually [fell(table)]\n"
        story += "search beam(starts = 1000, width = 2, polish = 0)\n"
        result = Story.from_text(story, tmp_path).solve(choose="score")
        scripts.append(result.script)
        path = tmp_path / f"{states}.json"
        result.script.save(path)
        again = type(result.script).load(path)
        assert (again.trajectory.states == result.script.trajectory.states).all()
    first, second = scripts
    assert second.score == pytest.approx(first.score, abs=1e-3)
    told = Story.from_text(story, tmp_path)
    offered = spots(told, told.world(), 1, "robot")["spots"]
    assert {spot["possible"] for spot in offered} == {None}
