"""Pulls and pushes among three characters, against the rules in docs/worlds.md."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from i2pdsl.errors import Source
from i2pdsl.worlds.grid.dynamics import Dynamics, build_dynamics
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.grid.spec import GridSpec
from worlds_for_tests import as_computed

TEXT = """
map
    ....
    .#..
character ann
    goals = none
character bob
    pulls = {ann, cid}
    pushes = cid
character cid
    pulls = bob
"""
WAYS = {"north": (0, -1), "south": (0, 1), "east": (1, 0), "west": (-1, 0)}
FREE = {(c, r) for c in range(4) for r in range(2)} - {(1, 1)}
PULLS = {"ann": (), "bob": ("ann", "cid"), "cid": ("bob",)}
PUSHES = {"ann": (), "bob": ("cid",), "cid": ()}
State = dict[str, tuple[int, int]]


def effect(state: State, who: str, action: str) -> State:
    """What a successful action makes of a state."""
    if action == "stay":
        return state
    (dx, dy), (x, y) = WAYS[action.removeprefix("pull_")], state[who]
    to, behind, beyond = (x + dx, y + dy), (x - dx, y - dy), (x + 2 * dx, y + 2 * dy)
    met = next((name for name, cell in state.items() if cell == to), None)
    if to not in FREE:
        return state
    if action.startswith("pull_"):
        held = next((name for name in PULLS[who] if state[name] == behind), None)
        return state | {who: to, held: (x, y)} if held and not met else state
    if met is None:
        return state | {who: to}
    is_pushed = met in PUSHES[who] and beyond in FREE and beyond not in state.values()
    return state | {who: to, met: beyond} if is_pushed else state


@pytest.mark.parametrize("listed_by", [build_dynamics, as_computed])
def test_all_moves_of_three_are_those_of_the_rules(
    listed_by: Callable[[GridSpec], Dynamics],
) -> None:
    spec = parse_world(Source("cell.world", TEXT), "cell")
    dynamics = listed_by(spec)
    names = [c.name for c in spec.characters]
    states = [
        dict(zip(names, map(tuple, dynamics.coordinates[cells].tolist()), strict=True))
        for cells in dynamics.cells
    ]
    assert len(states) == 7 * 6 * 5
    changed = set()
    for who, character in enumerate(spec.characters):
        for a, action in enumerate(character.actions):
            for number, state in enumerate(states):
                after = states[dynamics.successor[who][a, number]]
                assert after == effect(state, character.name, action), (state, action)
                moved = [name for name in names if after[name] != state[name]]
                changed.add((character.name, action.partition("_")[0], len(moved)))
    assert {("bob", "pull", 2), ("cid", "pull", 2), ("bob", "east", 2)} <= changed
    assert ("ann", "pull", 2) not in changed
