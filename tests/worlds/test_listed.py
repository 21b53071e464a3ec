"""Listed worlds: what is derived from their tables is what a grid of the same tables does, and a
kind of two who act one after the other is held against loops."""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import cache
from itertools import pairwise, product

import numpy as np
import pytest

from alley_for_tests import ACTIONS, ALLEY, CELLS, Alley, AlleySpec
from i2pdsl.errors import Source, StoryError
from i2pdsl.language.scope import Module
from i2pdsl.language.typed import Act
from i2pdsl.language.vocabulary import STAY
from i2pdsl.worlds.grid.policy import log_policy
from i2pdsl.worlds.grid.world import GridWorld
from i2pdsl.worlds.kind import Watch
from i2pdsl.worlds.listed import build
from i2pdsl.worlds.listed.kind import Picture
from i2pdsl.worlds.listed.script import frames_as_json, kept_in_words
from i2pdsl.worlds.listed.world import ListedTables, ListedWorld
from i2pdsl.worlds.record import Record, Trajectory, empty, extended
from i2pdsl.worlds.turns import columns
from i2pdsl.worlds.world import Viewer
from worlds_for_tests import planned

YARD = """
map
    A..
    ..B
tile pink
    symbol = A
tile green
    symbol = B
character cat
    goals = {pink, green}
character mouse
    goals = {pink, green}
    toward = cat
    attitude = {-1, 1}
planning
    gamma = 0.8
"""


@cache
def both() -> tuple[GridWorld, ListedWorld]:
    """A grid, and a listed world of the same tables."""
    grid = planned(YARD, "yard")
    every, tables = np.arange(grid.dynamics.state_count), grid.tables
    listed = ListedTables(
        coordinates=grid.dynamics.coordinates,
        cells=grid.dynamics.cells_of(every),
        after=tuple(np.asarray(each).T for each in tables.successor),
        log_policy=tuple(log_policy(tables, who, every) for who in (0, 1)),
        value=tuple(grid.value(tables, who, every) for who in (0, 1)),
        log_prior=tables.log_prior,
        forgetting=tables.forgetting,
        switching=(),
    )
    begins = np.ones(len(every), dtype=bool)
    return grid, ListedWorld(grid.spec, grid.vocabulary, listed, begins)


def pairs() -> tuple[np.ndarray, np.ndarray]:
    """Every state with every turn from it."""
    grid, listed = both()
    states = np.arange(grid.dynamics.state_count)
    return np.repeat(states, listed.turn_count), np.tile(np.arange(listed.turn_count), len(states))


def same(one: object, other: object) -> bool:
    return np.allclose(np.asarray(one), np.asarray(other), rtol=1e-9, atol=1e-12)


def test_turns_are_a_grids() -> None:
    grid, listed = both()
    assert listed.turn_count == grid.turn_count
    for state in (np.int64(0), np.arange(grid.dynamics.state_count)):
        state = np.asarray(state)
        a, b = grid.turns(grid.tables, state), listed.turns(listed.tables, state)
        assert same(a.state, b.state)
        assert same(a.chance * a.valid, b.chance * b.valid)
        assert same(grid.endings(grid.tables, state), listed.endings(listed.tables, state))
        for one, other in zip(a.log_rows, b.log_rows, strict=True):
            assert one.shape == other.shape
            assert same(one, other)
    for who in (0, 1):
        assert grid.branch_actions(who) == listed.branch_actions(who)


def test_frames_are_a_grids() -> None:
    grid, listed = both()
    seen = pairs()
    ends = grid.transition(grid.tables, *seen)
    assert same(ends, listed.transition(listed.tables, *seen))
    asks = [
        lambda w: w.log_rows(w.tables, *seen, ends),
        lambda w: w.best_rows(w.tables, *seen, ends),
    ]
    asks += [lambda w: w.outcome(w.tables, *seen)[1]]
    asks += [lambda w: [part for pair in w.alternatives(w.tables, *seen, ends) for part in pair]]
    for ask in asks:
        for one, other in zip(ask(grid), ask(listed), strict=True):
            assert same(one, other)
    for turn in product((None, Act(0, False), Act(4, False)), repeat=2):
        one, other = (w.is_turn(w.tables, *seen, turn) for w in (grid, listed))
        assert same(one, other)
        if None not in turn:
            one, other = (w.act(w.tables, seen[0], turn)[0] for w in (grid, listed))
            assert same(one, other)


@pytest.mark.parametrize(
    ("name", "arguments"),
    [("at", (1, ((2, 1), (0, 0)))), ("moved", (0,)), ("moved", (1,)), ("idle", (1,)),
     ("touching", (0, 1))],
)  # fmt: skip
def test_what_can_be_asked_is_a_grids(name: str, arguments: tuple[object, ...]) -> None:
    before, actions = pairs()
    found = []
    for world in both():
        ends = world.transition(world.tables, before, actions)
        given = world.feature_arguments(name, arguments)
        found.append(world.feature(world.tables, name, given, ends, before, actions))
    assert same(*found)
    assert 0 < found[0].mean() < 1


def test_sharper_viewers_are_a_grids() -> None:
    grid, _ = both()
    seen = pairs()
    told = 1.7, np.array([0.2]), grid.tables.log_prior[:, ::-1]
    rows = []
    for world in both():
        other = world.with_audience(*told)
        assert same(other.log_prior(other.tables), told[2])
        assert same(other.forgetting(other.tables), told[1])
        rows.append(other.log_rows(other.tables, *seen, seen[0]))
    for one, two in zip(*rows, strict=True):
        assert same(one, two)


# -------------------------------------------------------------------------------- a kind of two


MODULE = Module(Source("none", ""))


def alley(*viewers: Viewer, **changes: bool) -> ListedWorld:
    spec = AlleySpec("alley", **changes)
    return ALLEY.build(spec, viewers or (Viewer(spec),), Watch())


def test_likelihoods_are_the_softmax_of_what_is_liked() -> None:
    """In loops, of each viewer; who acts second answers what the first has done."""
    spec = AlleySpec("alley")
    viewers = Viewer(spec), Viewer(spec.with_settings({"beta": 0.5}), sharpness=3.0)
    world = alley(*viewers)
    states = list(ALLEY.states(spec))
    for state, (number, action) in product(
        range(len(states)), enumerate(product(*ACTIONS.values()))
    ):
        rows = world.log_rows(world.tables, np.asarray(state), np.asarray(number), np.asarray(0))
        picture = states[state]
        for who, (name, own) in enumerate(ACTIONS.items()):
            for o, beta in enumerate((2.0, 1.5)):
                for h, row in enumerate(world.vocabulary.hypotheses):
                    ends = {a: ALLEY.step(spec, picture, name, a) for a in own}
                    worth = {a: math.exp(beta * ALLEY.worth(spec, row, ends[a], name)) for a in own}
                    expected = worth[action[who]] / sum(worth.values())
                    assert math.exp(rows[who][o, h]) == pytest.approx(expected, rel=1e-12)
            picture = ALLEY.step(spec, picture, name, action[who])
        end = world.transition(world.tables, np.asarray(state), np.asarray(number))
        assert states[int(end)] == picture


def test_its_words() -> None:
    words = ALLEY.vocabulary(AlleySpec("alley"))
    assert words.automatic == {"rationality", "naturalness", "liveliness"}
    assert words.limited_to == {"bob": ACTIONS["bob"]}
    assert len(words.hypotheses) == 4
    assert (words.columns, words.rows) == (3, 1)
    assert ALLEY.play(words).signature == "play WHO ACTION, ..."
    assert dict(ALLEY.options(words, ["bob"])) == dict.fromkeys(ACTIONS["bob"], "action")
    assert ALLEY.has_same_rules(*(AlleySpec("a").with_settings({"beta": b}) for b in (1, 2)))
    assert not ALLEY.has_same_rules(AlleySpec("a"), AlleySpec("a", narrow=False))


def random_script(world: ListedWorld, seed: int) -> Trajectory:
    generator = np.random.default_rng(seed)
    start = generator.choice(world.starts())
    return extended(world, empty(world, start), generator.integers(world.turn_count, size=6))


@pytest.mark.parametrize("seed", range(5))
def test_scripts_are_read_again(seed: int) -> None:
    world = alley()
    path = random_script(world, seed)
    start = ALLEY.start_as_json(world, path.start)
    frames = ALLEY.frames_as_json(world, path)
    record = Record({}, {}, None, start, frames)
    again = ALLEY.read(world, record)
    assert np.array_equal(again.states, path.states)
    assert np.array_equal(again.actions, path.actions)
    told = columns(world.vocabulary, record)
    assert told["ann_column"][0] == [s["ann"][0] for s in [start, *(f["state"] for f in frames)]]
    assert told["bob_moved"][0][1:] == [
        one["bob"] != two["bob"] for one, two in pairwise([start, *(f["state"] for f in frames)])
    ]
    first, *_ = kept_in_words(world, path, 2, 3)
    assert first.startswith(
        f"pin script[2]: at(ann, ({frames[1]['state']['ann'][0]}, 0)) and at(bob"
    )
    wrong = dict(frames[0], state={**frames[0]["state"], "box": [0, 0]})
    with pytest.raises(StoryError, match="frame 1: by the world's rules `box` is at"):
        ALLEY.read(world, Record({}, {}, None, start, (wrong,)))


def test_a_script_begins_as_the_kind_says() -> None:
    together = {"ann": [0, 0], "bob": [0, 0], "box": [1, 0]}
    with pytest.raises(StoryError, match="begins in another way"):
        ALLEY.read(alley(), Record({}, {}, None, together, ()))
    assert len(alley().starts()) == 6


def test_how_different_scripts_are() -> None:
    world = alley()
    path = random_script(world, 0)
    assert ALLEY.distance(world, path.states, path.states) == 0
    # Ann, of three, is two cells away in the second half of the frames.
    spec = AlleySpec("alley")
    numbers = {picture: n for n, picture in enumerate(ALLEY.states(spec))}
    near, far = numbers[CELLS[0], CELLS[0], CELLS[1]], numbers[CELLS[2], CELLS[0], CELLS[1]]
    one, two = np.array([near] * 4), np.array([near, near, far, far])
    assert ALLEY.distance(world, one, two) == pytest.approx(2 / 2 / 3 / 2)
    assert ALLEY.meet(world, one)
    assert not ALLEY.meet(world, np.array([far]))


def test_what_is_typed_is_an_action() -> None:
    world = alley()
    path = empty(world, world.starts()[0])
    longer, told = ALLEY.played(world, MODULE, path, "ann west")
    assert told == "[ann: west, bob: stay]"
    assert frames_as_json(world, longer)[0]["bob"] == {"action": STAY, "moved": False}
    with pytest.raises(StoryError, match="`bob` cannot do this: west"):
        ALLEY.played(world, MODULE, path, "bob west")


class Wrong(Alley):
    def __init__(self, fault: str):
        self.fault = fault

    def states(self, spec: AlleySpec) -> Iterable[Picture]:
        every = list(super().states(spec))
        return {"twice": [*every, every[0]], "few": every[:-1]}.get(self.fault, every)

    def step(self, spec: AlleySpec, state: Picture, who: str, action: str) -> Picture:
        return super().step(spec, state, who, "east" if self.fault == "stay" else action)


@pytest.mark.parametrize(
    ("fault", "message"),
    [("twice", "two states look alike"), ("few", "which is no state"), ("stay", "must have")],
)
def test_who_writes_a_kind_is_told_what_is_wrong(fault: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Wrong(fault).rules(AlleySpec("alley", narrow=False))


def test_too_many_states_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """Before anything is asked of them. The alley has 9 states, 5 actions and 2 values, and 4
    hypotheses: 252 numbers."""
    monkeypatch.setattr(build, "MOST", 252)
    assert len(alley().begins) == 9
    monkeypatch.setattr(build, "MOST", 251)
    with pytest.raises(StoryError, match="more than 8 states; with 7 actions and values") as wrong:
        alley()
    assert wrong.value.diagnostics[0].code == "too-large"


def test_files_may_say_what_viewers_are_like() -> None:
    text = "# An alley.\nkind = alley\naudience\n    beta = 3\n    switching = 0.25\n"
    spec = ALLEY.parse(Source("alley.world", text), "alley")
    assert (spec.settings.beta, spec.settings.forgetting, spec.settings.switching) == (3, 0, 0.25)
    assert spec.documentation == "An alley."
    world = ALLEY.rules(spec)
    (ann, bob) = world.switching(world.tables)
    assert ann is not None
    assert bob is not None
    assert len(np.unique(ann.group)) == 2  # ann may want something else, whatever bob is like
    with pytest.raises(StoryError, match="`forgetting` must be between"):
        ALLEY.parse(Source("alley.world", "kind = alley\naudience\n    forgetting = 1\n"), "alley")


def test_files_may_say_more() -> None:
    text = "kind = alley\nplanning\n    width = wide\n"
    spec = ALLEY.parse(Source("alley.world", text), "alley")
    assert spec == AlleySpec("alley", text, narrow=False)
    assert ALLEY.parse(Source("alley.world", "kind = alley\n"), "alley").narrow
    wrong = "kind = alley\nplanning\n    width = broad\n    hight = 2\naudience\n    beta = x\n"
    with pytest.raises(StoryError) as found:
        ALLEY.parse(Source("alley.world", wrong), "alley")
    assert [d.span.text for d in found.value.diagnostics] == ["broad", "hight", "x"]
