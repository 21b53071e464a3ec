"""Walls between cells, pulls, things that are alike, moves at the same time and a horizon, against
a transcription with dictionaries, loops and plain recursion."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from itertools import product

import numpy as np
import pytest

from i2pdsl.errors import Source, StoryError
from i2pdsl.objective.replay import replay
from i2pdsl.scripts import make_record
from i2pdsl.worlds.grid.dynamics import Dynamics, build_dynamics
from i2pdsl.worlds.grid.kind import KIND
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.grid.planning import solve
from i2pdsl.worlds.grid.policy import action_values
from i2pdsl.worlds.grid.spec import GridSpec
from i2pdsl.worlds.grid.world import GridWorld, assemble
from i2pdsl.worlds.inferred import inferred_turns
from i2pdsl.worlds.positions import read_positions
from i2pdsl.worlds.record import empty, extended
from i2pdsl.worlds.world import Viewer
from worlds_for_tests import as_computed

WORLD = """
map
    . .|.
    -
    . . S
tile star
    symbol = S
character {first}
character {second}
object box
    count = {boxes}
rewards
    goal = 1.5
    end = 4
planning
    order = {order}
    horizon = {horizon}
    gamma = {gamma}
    beta = 1.3
    level0 = {level0}
"""
RED = "red\n    goals = {star}"
BLUE = """blue
    success = 0.7
    pushes = box
    pulls = box
    toward = red
    attitude = {-1, 2}"""
MOVES = {"north": (0, -1), "south": (0, 1), "east": (1, 0), "west": (-1, 0), "stay": (0, 0)}
ACTIONS = {
    "red": tuple(MOVES),
    "blue": (*MOVES, *(f"pull_{way}" for way in MOVES if way != "stay")),
}
COST = {action: -0.1 if action == "stay" else -1.0 for action in ACTIONS["blue"]}
CELLS = tuple(product(range(3), range(2)))
WALLS = {((1, 0), (2, 0)), ((0, 0), (0, 1))}  # as WORLD is drawn
STAR = (2, 1)
GAMMA, BETA, GOAL, END = 0.9, 1.3, 1.5, 4.0
CHANCE = {"red": 1.0, "blue": 0.7}
State = tuple[tuple[int, int], tuple[int, int], frozenset[tuple[int, int]]]  # red, blue, boxes


def neighbour(cell: tuple[int, int], way: tuple[int, int]) -> tuple[int, int] | None:
    """The next cell, or None where a wall is between."""
    there = cell[0] + way[0], cell[1] + way[1]
    closed = (cell, there) in WALLS or (there, cell) in WALLS
    return there if there in CELLS and not closed else None


def effect(state: State, who: str, action: str) -> State:
    red, blue, boxes = state
    pull, way = action.startswith("pull_"), MOVES[action.removeprefix("pull_")]
    own, other = (red, blue) if who == "red" else (blue, red)
    to = neighbour(own, way)
    if action == "stay" or to is None or to == other:
        return state
    if pull:
        behind = neighbour(own, (-way[0], -way[1]))
        if behind not in boxes or to in boxes:
            return state
        boxes = boxes - {behind} | {own}
    elif to in boxes:
        beyond = neighbour(to, way)
        if who == "red" or beyond is None or beyond == other or beyond in boxes:
            return state
        boxes = boxes - {to} | {beyond}
    return (to, blue, boxes) if who == "red" else (red, to, boxes)


def at_once(state: State, order: tuple[str, str], acts: dict[str, str]) -> State:
    """The first moves, then the second; but the first waits for who is in its way."""
    first, second = order
    moved = effect(state, first, acts[first])
    if moved == state:
        return effect(effect(state, second, acts[second]), first, acts[first])
    return effect(moved, second, acts[second])


class Plain:
    """Backward induction by recursion."""

    def __init__(self, order: tuple[str, str], together: bool, horizon: int, level0: str):
        self.order, self.together, self.horizon = order, together, horizon
        self.q, self.v, self.w, self.red = map(cache, (self.q, self.v, self.w, self.red))
        weight = {a: math.exp(BETA * COST[a]) if level0 == "costs" else 1 for a in ACTIONS["blue"]}
        self.imagined = {a: w / sum(weight.values()) for a, w in weight.items()}

    def red(self, frame: int, state: State, is_rational: bool) -> dict[str, float]:
        """How blue expects red to act."""
        if not is_rational:
            return dict.fromkeys(ACTIONS["red"], 1 / 5)
        weights = {a: math.exp(BETA * self.q("red", None, frame, state, a)) for a in ACTIONS["red"]}
        return {a: w / sum(weights.values()) for a, w in weights.items()}

    def other(self, who: str, rho: float | None, frame: int, state: State) -> dict[str, float]:
        return self.imagined if who == "red" else self.red(frame, state, rho is not None)

    def social(self, who: str, rho: float | None, frame: int, state: State) -> float:
        if who == "red" or rho is None:
            return 0.0
        policy = self.red(frame, state, True)
        return rho * sum(p * (GOAL * (state[0] == STAR) + COST[a]) for a, p in policy.items())

    def end(self, who: str, rho: float | None, state: State) -> float:
        return END * (state[0] == STAR) * (1.0 if who == "red" else rho or 0.0)

    def q(self, who: str, rho: float | None, frame: int, state: State, action: str) -> float:
        """The value of an action; rho is None of red, and of blue beside an irrational red."""
        now = COST[action] + (GOAL * (state[0] == STAR) if who == "red" else 0.0)
        if not self.together:
            p, after = CHANCE[who], effect(state, who, action)
            return now + GAMMA * (
                p * self.w(who, rho, frame, after) + (1 - p) * self.w(who, rho, frame, state)
            )
        then, other = 0.0, next(n for n in self.order if n != who)
        for act, p in self.other(who, rho, frame, state).items():
            for ok, ok2 in product((True, False), repeat=2):
                q = (CHANCE[who] if ok else 1 - CHANCE[who]) * p
                q *= CHANCE[other] if ok2 else 1 - CHANCE[other]
                acts = {who: action if ok else "stay", other: act if ok2 else "stay"}
                then += q * self.v(who, rho, frame + 1, at_once(state, self.order, acts))
        return now + self.social(who, rho, frame, state) + GAMMA * then

    def v(self, who: str, rho: float | None, frame: int, state: State) -> float:
        if frame == self.horizon:
            return self.end(who, rho, state)
        return max(self.q(who, rho, frame, state, a) for a in ACTIONS[who])

    def w(self, who: str, rho: float | None, frame: int, state: State) -> float:
        """One after the other: what comes after an action of `who`."""
        if who == self.order[1]:
            frame += 1  # the other acts in the next frame only
        if frame == self.horizon:
            return self.end(who, rho, state)
        other = next(n for n in self.order if n != who)
        found = self.social(who, rho, frame, state)
        later = frame + 1 if who == self.order[0] else frame
        for act, p in self.other(who, rho, frame, state).items():
            q, after = CHANCE[other], effect(state, other, act)
            found += p * (
                q * self.v(who, rho, later, after) + (1 - q) * self.v(who, rho, later, state)
            )
        return found


def world_of(
    order: tuple[str, str],
    together: bool,
    boxes: int,
    horizon: int,
    level0: str = "uniform",
    gamma: float = GAMMA,
) -> GridWorld:
    blocks = {"red": RED, "blue": BLUE}
    text = WORLD.format(
        first=blocks[order[0]],
        second=blocks[order[1]],
        boxes=boxes,
        order="together" if together else f"[{', '.join(order)}]",
        horizon=horizon,
        level0=level0,
        gamma=gamma,
    )
    spec = parse_world(Source("rules.world", text), "rules")
    dynamics = build_dynamics(spec)
    return assemble(spec, dynamics, (Viewer(spec),), [solve(spec, dynamics)])


def states_of(world: GridWorld) -> list[State]:
    order = [c.name for c in world.spec.characters]
    found = []
    for cells in world.dynamics.cells.tolist():
        places = [(int(c), int(r)) for c, r in world.dynamics.coordinates[cells]]
        red, blue = (places[order.index(name)] for name in ("red", "blue"))
        found.append((red, blue, frozenset(places[2:])))
    return found


@pytest.mark.parametrize("listed_by", [build_dynamics, as_computed])
@pytest.mark.parametrize("boxes", [1, 2])
def test_walls_pulls_and_like_boxes_are_as_they_are_told(
    boxes: int, listed_by: Callable[[GridSpec], Dynamics]
) -> None:
    spec = world_of(("blue", "red"), False, boxes, 1).spec
    assert set(spec.walls) == WALLS
    dynamics = listed_by(spec)
    world = assemble(spec, dynamics, (Viewer(spec),), [solve(spec, dynamics)])
    states = states_of(world)
    assert len(states) == len(set(states)) == spec.state_count == 6 * 5 * math.comb(4, boxes)
    for who, name in enumerate(("blue", "red")):
        for act, action in enumerate(ACTIONS[name]):
            for number, state in enumerate(states):
                after = states[dynamics.successor[who][act, number]]
                assert after == effect(state, name, action), (state, name, action)


def test_who_act_at_once_follow_each_other_and_never_meet() -> None:
    world = world_of(("red", "blue"), True, 1, 2)
    states, count = states_of(world), world.dynamics.state_count
    number = {state: i for i, state in enumerate(states)}
    turns = world.turns(world.tables, np.arange(count))
    np.testing.assert_allclose(np.where(turns.valid, turns.chance, 0).sum(1), 45)  # of 45 choices
    np.testing.assert_array_equal(world.endings(world.tables, np.arange(count)), turns.state)
    for state in states[::17]:
        here = np.asarray(number[state])
        for a, b in product(range(5), range(9)):
            for ok in (True, False):
                if b == 4 and not ok:
                    continue
                acts = {"red": ACTIONS["red"][a], "blue": ACTIONS["blue"][b] if ok else "stay"}
                action = world.turn_number([(a, True), (b, ok)])
                after = int(world.transition(world.tables, here, action))
                assert after // count == 1
                assert states[after % count] == at_once(state, ("red", "blue"), acts)
                k = int(action)
                # A failure that is nothing but a second copy: blue would not have moved anyway.
                done = at_once(state, ("red", "blue"), acts | {"blue": ACTIONS["blue"][b]})
                undone = at_once(state, ("red", "blue"), acts | {"blue": "stay"})
                if not ok:
                    assert bool(turns.valid[number[state], k]) == (done != undone)
                _, would = world.attempts(world.tables, here, action)
                assert bool(would[0]) == (ok and b != 4 and done != undone)


@pytest.mark.parametrize("together", [True, False])
@pytest.mark.parametrize("order", [("red", "blue"), ("blue", "red")])
def test_plans_with_a_horizon_are_those_of_plain_recursion(
    order: tuple[str, str], together: bool
) -> None:
    level0 = "costs" if order[0] == "red" else "uniform"
    world, plain = world_of(order, together, 1, 3, level0), Plain(order, together, 3, level0)
    states, tables = states_of(world), world.tables
    count = len(states)
    for who, name in enumerate(order):
        for frame in range(3):
            values = action_values(tables, who, np.arange(0, count, 5) + frame * count)
            rhos = (None,) if name == "red" else (-1.0, 2.0, None)  # in the order of the keys
            for column, rho in enumerate(rhos):
                for i, number in enumerate(range(0, count, 5)):
                    for act, action in enumerate(ACTIONS[name]):
                        expected = plain.q(name, rho, frame, states[number], action)
                        assert values[i, act, column] == pytest.approx(expected, abs=1e-5)


def test_beliefs_are_of_the_frame_that_is_left() -> None:
    """Both are seen to choose by the state before; once the time is up, each frame is the last."""
    order = ("blue", "red")
    world, plain = world_of(order, True, 1, 3), Plain(order, True, 3, "uniform")
    states = states_of(world)
    start = states.index(((0, 1), (1, 0), frozenset({(1, 1)})))
    chosen = [((7, True), (2, True)), ((2, False), (2, True)), ((4, True), (0, True))] * 2
    actions = [int(world.turn_number(turn)) for turn in chosen]
    path = extended(world, empty(world, np.int64(start)), np.array(actions))
    assert (path.states // len(states)).tolist() == [0, 1, 2, 2, 2, 2, 2]
    frames = replay(world, path.states, path.actions)
    rows = world.vocabulary.hypotheses
    belief = np.full(len(rows), 1 / len(rows))
    for t, ((blue, _), (red, _)) in enumerate(chosen):
        frame, state = min(t, 2), states[path.states[t] % len(states)]
        for name, act in (("blue", blue), ("red", red)):
            for h, row in enumerate(rows):
                rational = row["R_blue"] if name == "blue" else row["R_red"]
                rho = float(row["rho"]) if row["R_red"] and "rho" in row else None
                weights = [
                    math.exp(BETA * plain.q(name, rho if name == "blue" else None, frame, state, a))
                    if rational
                    else 1.0
                    for a in ACTIONS[name]
                ]
                belief[h] *= weights[act] / sum(weights)
            belief /= belief.sum()
            belief = belief * (1 - 1e-5) + 1e-5 / len(rows)
        np.testing.assert_allclose(np.exp(frames.log_belief[t + 1, 0]), belief, rtol=1e-4)


def test_without_a_horizon_who_act_at_once_plan_without_end() -> None:
    """Far from its end a plan with a horizon is one without."""
    world, far = (world_of(("blue", "red"), True, 1, frames, gamma=0.5) for frames in (0, 25))
    every = np.arange(world.dynamics.state_count)
    for who in (0, 1):
        found = action_values(world.tables, who, every)
        expected = action_values(far.tables, who, every)
        np.testing.assert_allclose(found, expected, atol=1e-5)


def test_cached_plans_with_a_horizon_are_looked_at() -> None:
    from i2pdsl.planning import store
    from i2pdsl.worlds.grid.planning import load_or_plan

    spec = world_of(("blue", "red"), True, 1, 3).spec
    plan = load_or_plan(spec, lambda: build_dynamics(spec))
    again = load_or_plan(spec, lambda: build_dynamics(spec))
    assert again.seconds == 0
    np.testing.assert_array_equal(plan.continuation[0], again.continuation[0])
    said: list[str] = []
    wrong = [array + 0.1 for array in plan.continuation]
    (name,) = {
        path.name.rsplit("-v", 1)[0]
        for path in store.cache_folder("plans").iterdir()
        if path.name.startswith(spec.planning_key)
    }
    store.save(name, {f"continuation_{i}": array for i, array in enumerate(wrong)})
    made = load_or_plan(spec, lambda: build_dynamics(spec), say=said.append)
    assert "does not fit" in said[0]
    np.testing.assert_array_equal(made.continuation[1], plan.continuation[1])


def mistakes(text: str) -> list[str]:
    with pytest.raises(StoryError) as caught:
        parse_world(Source("a.world", text), "a")
    found = []
    for d in caught.value.diagnostics:
        line, column = d.span.source.position(d.span.start)
        found.append(f"{line}:{column}: {d.message}")
    return found


@pytest.mark.parametrize(
    ("drawn", "told"),
    [
        ("    . . .\n    ..  .\n    . . .", "3:6: between two cells stands a space or `|`"),
        ("    . . .\n     -\n    . . .", "3:6: this wall is below no cell"),
        ("    . . .\n    . . .\n    -", "4:5: a wall between cells has a row on each side"),
        ("    . . .\n    . . .\n      . . .", "4:7: this row does not begin below the others"),
        ("    . . .\n    . X .", "3:7: unknown symbol `X` on 1 cell of the map"),
        ("    . . .\n    . .", "3:5: this row has 2 cells, the others have 3"),
    ],
)
def test_mistakes_of_maps_with_walls_between_cells(drawn: str, told: str) -> None:
    assert mistakes(f"map\n{drawn}\ncharacter a\n") == [told]


@pytest.mark.parametrize(
    ("lines", "told"),
    [
        ("object b\n    count = 0", "6:13: `count` must be a whole number from 1 to 8, not 0"),
        ("object b\n    count = 2\n    may_be_absent = yes", "7:5: `b` cannot be absent"),
        ("planning\n    order = together", "6:13: there is only one character"),
        ("planning\n    horizon = 1.5", "6:15: `horizon` must be a whole number from 0 to 100000, "
         "not 1.5"),
        ("character c\n    pulls = d", "6:13: there is no character or object `d`"),
    ],
)  # fmt: skip
def test_mistakes_of_the_new_keys(lines: str, told: str) -> None:
    assert mistakes(f"map\n    ...\n    ...\ncharacter a\n{lines}\n") == [told]


@pytest.mark.parametrize("together", [True, False])
def test_scripts_come_again_from_positions_and_actions(together: bool) -> None:
    """Whatever the rules are: who pulls, who waits for whom, and in which frame it is."""
    world, generator = world_of(("red", "blue"), together, 1, 3), np.random.default_rng(0)
    for start in generator.choice(world.starts(), size=8):
        path = empty(world, start)
        for _ in range(3):
            valid = np.flatnonzero(world.turns(world.tables, path.states[-1]).valid)
            path = extended(world, path, [int(generator.choice(valid))])
        record = make_record(world, path, {}, {}, None)
        frames = [{"state": record.start}, *record.frames]
        rows = [
            {"who": who, "frame": number, "x": x, "y": y}
            | {"action": frame.get(who, {}).get("action")}
            for number, frame in enumerate(frames)
            for who, (x, y) in frame["state"].items()
        ]
        found = inferred_turns(KIND, world, read_positions(rows, world.vocabulary))
        assert found.frames == record.frames


def test_a_name_of_one_of_several_is_taken() -> None:
    text = "map\n    ...\n    ...\ncharacter a\nobject b\n    count = 2\nobject b_2\n"
    assert mistakes(text) == ["7:8: `b_2` is one of those called `b` and cannot be a name"]


@pytest.mark.parametrize(
    ("lines", "told"),
    [
        ("character a\n    symbol = A\nobject b\n    symbol = A",
         "6:8: `b` stands on a cell of `a`"),
        ("character a\n    symbol = B", "5:14: `a` stands on 2 cells of the map"),
        ("character a\nobject b\n    symbol = B\n    count = 3",
         "7:13: `b` stands on 2 cells of the map, not 3"),
        ("character a\n    cell = (7, 0)", "5:12: the character `a` lies outside the map"),
    ],
)  # fmt: skip
def test_mistakes_of_places_at_first(lines: str, told: str) -> None:
    drawn = "    A.." if "symbol = A" in lines else "    B.B" if "= B" in lines else "    ..."
    assert mistakes(f"map\n{drawn}\n    ...\n{lines}\n")[0] == told


PLACED = """
map
    b .|.
    -
    x r S
tile star
    symbol = S
character blue
    symbol = b
    pushes = box
    pulls = box
    toward = red
    attitude = {-1, 1}
character red
    symbol = r
    goals = star
object box
    symbol = x
rewards
    end = 3
planning
    order = together
    horizon = 3
    beta = 0.7
"""


@cache
def placed(text: str = PLACED) -> GridWorld:
    spec = parse_world(Source("placed.world", text), "placed")
    dynamics = build_dynamics(spec)
    return assemble(spec, dynamics, (Viewer(spec),), [solve(spec, dynamics)])


def test_what_can_be_reached_in_time_is_planned_like_all_states() -> None:
    """A map without symbols has all states; their values are those of the few."""
    few, text = placed(), PLACED.replace("b .|.", ". .|.").replace("x r S", ". . S")
    for symbol in "brx":
        text = text.replace(f"    symbol = {symbol}\n", "")
    every = placed(text)
    assert few.spec.is_limited
    assert not every.spec.is_limited
    assert few.dynamics.state_count < every.dynamics.state_count == every.spec.state_count
    (start,) = few.starts()
    number = every.dynamics.lookup[few.dynamics.cells @ few.dynamics.strides]
    states = np.array([start])
    for _ in range(3):
        count, whole = few.dynamics.state_count, every.dynamics.state_count
        same = states // count * whole + number[states % count]
        for who in (0, 1):
            np.testing.assert_allclose(
                action_values(few.tables, who, states),
                action_values(every.tables, who, same),
                atol=1e-5,
            )
        after, expected = few.turns(few.tables, states), every.turns(every.tables, same)
        np.testing.assert_array_equal(after.valid, expected.valid)
        states = np.unique(after.state)


def test_no_script_in_time_is_better_than_what_the_search_finds() -> None:
    from i2pdsl.language.check import TypedStory, check_source
    from i2pdsl.objective.terms import score_script, story_objective
    from i2pdsl.search.beam import beam_search

    world = placed()
    text = "world placed\nlength 2\nmaximize sum_t P(rho > 0 | script[:t])"
    story = check_source(Source("asked.story", text), lambda *_: world.vocabulary)
    assert isinstance(story, TypedStory)
    start = world.starts()
    found = beam_search(world, story_objective(story, world), 2, start, 64, ())

    def score(turns: np.ndarray) -> float:
        path = extended(world, empty(world, start[0]), turns)
        return score_script(story, world, replay(world, path.states, path.actions))

    assert found.scores[0] == pytest.approx(score(found.actions[0]), abs=1e-4)
    some = np.random.default_rng(0).integers(world.turn_count, size=(60, 2))
    assert max(map(score, some)) <= found.scores[0] + 1e-4


def test_the_time_of_a_story_is_that_of_its_world() -> None:
    from i2pdsl.language.check import check_source

    world = placed()

    def vocabulary(name: str, folder: object, settings: tuple = ()) -> object:
        from i2pdsl.worlds.grid.vocabulary import grid_vocabulary

        return grid_vocabulary(world.spec.with_settings(dict(settings)))

    check = lambda head: check_source(
        Source("a.story", f"world placed{head}\nlength 4\nmaximize depict(rho > 0)"), vocabulary
    )
    with pytest.raises(StoryError, match="after 3 frames the time in placed is up"):
        check("")
    assert check("(horizon = 4)").length == 4
