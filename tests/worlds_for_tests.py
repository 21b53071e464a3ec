"""Small worlds for tests: the fast code's and the reference's versions of the same thing."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from random import Random

import numpy as np

import reference
from i2pdsl.errors import Source
from i2pdsl.language.check import Library, TypedStory, check_source
from i2pdsl.language.vocabulary import Vocabulary
from i2pdsl.scripts import make_record
from i2pdsl.worlds.grid.arrays import state_of
from i2pdsl.worlds.grid.dynamics import Dynamics, build_dynamics
from i2pdsl.worlds.grid.following import moved
from i2pdsl.worlds.grid.packed import computed
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.grid.planning import solve
from i2pdsl.worlds.grid.spec import GridSpec
from i2pdsl.worlds.grid.world import GridWorld, assemble
from i2pdsl.worlds.record import Trajectory, empty, extended
from i2pdsl.worlds.world import Viewer

STORIES = Path(__file__).parent.parent / "stories"
SMALL_MAP = ("P..", "#.G", "...")
CROWD = """
map
    P..
    ..G
tile pink
    symbol = P
tile green
    symbol = G
character cheese
    success = 0.6
    goals = {pink, green}
character robot
    goals = {pink, none}
    pushes = {cheese, table, chair}
    toward = cheese
    attitude = {-1, 1}
object table
object chair
planning
    gamma = 0.8
    method = additive
"""
"""Two characters and two objects on six cells, planned for three at once."""

CORRIDOR = """
map
    A...B
tile left
    symbol = A
tile right
    symbol = B
character one
    goals = {left, right}
planning
    gamma = 0.9
    beta = 1
"""


def trajectory(world: GridWorld, start: int, actions: np.ndarray) -> Trajectory:
    """A script from its start and its actions."""
    return extended(world, empty(world, np.int64(start)), actions)


def kitchen_text(rows: tuple[str, ...], **changes: str) -> str:
    """kitchen.world with another map and other values: `kitchen_text(rows, gamma="0.9")`."""
    text = (STORIES / "worlds" / "kitchen.world").read_text(encoding="utf-8")
    drawn = "map\n" + "".join(f"    {row}\n" for row in rows)
    text = re.sub(r"map\n(    .*\n)+", drawn, text)
    for key, value in changes.items():
        text, count = re.subn(rf"\b{key} = .*", f"{key} = {value}", text)
        assert count, key
    return text


def with_small_world(folder: Path) -> Path:
    """A folder with a world `small`: the kitchen on a small map."""
    text = kitchen_text(SMALL_MAP, gamma="0.9")
    (folder / "small.world").write_text(text, encoding="utf-8")
    return folder


@dataclass(frozen=True)
class Pair:
    """A planned world and the reference's version of it."""

    world: GridWorld
    reference: reference.World

    @property
    def spec(self) -> GridSpec:
        return self.world.spec

    @property
    def vocabulary(self) -> Vocabulary:
        return self.world.vocabulary

    def order(self) -> list[int]:
        """The reference's index of each of our hypotheses."""
        rows = [frozenset(h.items()) for h in self.reference.hypotheses]
        taken: list[int] = []
        for hypothesis in self.vocabulary.hypotheses:
            index = next(
                i
                for i, row in enumerate(rows)
                if row == frozenset(hypothesis.items()) and i not in taken
            )
            taken.append(index)
        assert len(taken) == len(rows)
        return taken

    def story(self, text: str, name: str = "test.story") -> TypedStory:
        """Checks a story whose world is this one, whatever it is called."""
        checked = check_source(Source(name, text), lambda *_: self.vocabulary)
        assert not isinstance(checked, Library)
        return checked

    def random_script(self, random: Random, length: int, events: float = 0.1) -> Trajectory:
        """A script of random turns and events; every third starts without the last thing."""
        state = random.randrange(self.spec.state_count)
        if self.spec.things and random.random() < 1 / 3:
            last = self.world.dynamics.cells[:, -1] == self.world.dynamics.absent
            state = random.choice(np.flatnonzero(last).tolist())
        start, actions = state, []
        for _ in range(length):
            turns = self.world.turns(self.world.tables, np.asarray(state))
            action = random.choice(np.flatnonzero(turns.valid).tolist())
            if self.world.moves.events and random.random() < events:
                _, possible = self.world.drops(self.world.tables, np.asarray(state))
                if possible.any():
                    number = random.choice(np.flatnonzero(possible).tolist())
                    action = self.world.moves.turn_count + number
            actions.append(action)
            state = int(
                self.world.transition(self.world.tables, np.asarray(state), np.asarray(action))
            )
        return trajectory(self.world, start, np.array(actions))

    def document(self, path: Trajectory) -> dict:
        """The script as the dict of script.json."""
        return make_record(self.world, path, {}, {}, None).as_json()


def as_computed(spec: GridSpec) -> Dynamics:
    """A world's states, listed, with successors that are computed (worlds/grid/packed.py)."""
    listed, states = build_dynamics(spec), computed(spec)
    numbers = states.state_of(listed.cells)
    assert (numbers >= 0).all()
    assert len(np.unique(numbers)) == len(numbers) == states.state_count
    assert (states.cells_of(numbers) == listed.cells).all()
    successor = []
    for who in range(len(spec.characters)):
        cells = moved(states.packed, who, listed.cells.astype(int))
        assert (states.cells_of(state_of(states.packed, cells)) == cells).all()
        successor.append(listed.state_of(cells).T)
    return replace(listed, successor=tuple(successor))


@cache
def planned(text: str, name: str = "small", tolerance: float = 1e-10) -> GridWorld:
    """A world planned tightly, without the cache."""
    spec = parse_world(Source(f"{name}.world", text), name)
    dynamics = build_dynamics(spec)
    plan = solve(spec, dynamics, tolerance=tolerance)
    return assemble(spec, dynamics, (Viewer(spec),), [plan])


@cache
def small_kitchen(
    rows: tuple[str, ...] = SMALL_MAP, level0: str = "uniform", hypotheses: str = "merged"
) -> Pair:
    """The kitchen on a small map, with gamma = 0.8 so that the reference is quick."""
    text = kitchen_text(rows, gamma="0.8", level0=level0, hypotheses=hypotheses)
    ours = reference.kitchen(rows=list(rows), gamma=0.8, level0=level0, hypotheses=hypotheses)
    ours._values = reference_plans(rows, level0)
    return Pair(planned(text), ours)


@cache
def reference_plans(rows: tuple[str, ...], level0: str) -> dict:
    """What the reference has planned so far: the same whatever the hypotheses' weights."""
    return {}
