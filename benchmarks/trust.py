"""How well what is said of an additive world's error predicts it, of three characters and a table
on maps small enough to be planned exactly (docs/approximate.md has the table).

    python benchmarks/trust.py [MAP ...]
"""

from __future__ import annotations

import sys
import time
from dataclasses import replace

import numpy as np

from i2pdsl.errors import Source
from i2pdsl.language.story import default_assumption
from i2pdsl.objective.nearer import error_in_copy, rational_scripts
from i2pdsl.objective.replay import replay_all
from i2pdsl.objective.trust import DOUBTFUL, apart
from i2pdsl.worlds.grid import around, method
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.grid.reduced import reduced
from i2pdsl.worlds.grid.world import build_world
from i2pdsl.worlds.record import Trajectory
from i2pdsl.worlds.world import Viewer

WORLD = """
map
{rows}
tile pink
    symbol = P
tile green
    symbol = G
character cheese
    success = 0.6
    goals = {{pink, green}}
character robot
    goals = {{pink, green, none}}
    toward = cheese
    attitude = {{-3, 0, 3}}
    pushes = {{cheese, table}}
character dog
    goals = {{pink, green}}
    pushes = table
object table
planning
    method = additive
    at_once = 3
"""
MAPS = {
    "open, 12 cells": ("P...", "....", "...G"),
    "open, 16 cells": ("P...", "....", "....", "...G"),
    "rooms, 16 cells": ("P..#..", "......", "...#.G"),
}
SCRIPTS, FRAMES, TOGETHER = 32, 12, 16
FIELDS = ("actions", "states")


def measured(rows: tuple[str, ...]) -> None:
    drawn = "\n".join(f"    {row}" for row in rows)
    spec = parse_world(Source("three.world", WORLD.format(rows=drawn)), "three")
    exact, sums = (build_world(s) for s in (spec.with_settings({"method": "exact"}), spec))
    fewer = build_world(spec.with_settings({"at_once": 2}))
    path = rational_scripts(exact, SCRIPTS, FRAMES, 1)
    words, rational = exact.vocabulary, default_assumption(exact.vocabulary)
    see = lambda world, p: replay_all(world, p.states, p.actions, regret=False)
    own, truth, other = (see(world, path) for world in (sums, exact, fewer))
    far = lambda one, two: apart(words, rational, one, two)[:, 1:]
    wrong = far(own, truth)
    worst = wrong.max(1)
    print(f"  beliefs off by {wrong.mean():.3f} on average, {told(worst)} are doubtful")
    small = reduced(spec, lambda each: method.estimated_seconds(each) <= method.BRIEF)
    if small is not None:
        named = replace(small, name="a copy")
        copy = error_in_copy(named, named.with_settings({"method": "exact"}))
        print(f"  a copy with {len(small.free_cells)} cells: {copy[0]:.3f} on average")
    step = far(own, other).max(1)
    print(f"  2 at once against 3: correlation {np.corrcoef(step, worst)[0, 1]:.2f}")
    around.PATIENCE = 1e9
    for around.MOST_MOVES in (0, 1):
        began, found = time.process_time(), []
        for first in range(0, SCRIPTS, TOGETHER):
            some = slice(first, first + TOGETHER)
            paths = list(map(Trajectory, path.actions[some], path.states[some]))
            part = around.around(sums, (Viewer(spec),), paths)
            assert part is not None
            actions, states = (np.stack([getattr(p, n) for p in part[1]]) for n in FIELDS)
            found += far(own.at(some), see(part[0], Trajectory(actions, states))).max(1).tolist()
        figures = np.array(found)
        print(
            f"  around, {around.MOST_MOVES} moves: {told(figures)} are said to be doubtful, "
            f"of which {(worst[figures > DOUBTFUL] > DOUBTFUL).sum()} are; "
            f"off by {np.abs(figures - worst).mean():.3f}; "
            f"{(time.process_time() - began) / SCRIPTS:.1f} s of processors a script",
            flush=True,
        )


def told(figures: np.ndarray) -> str:
    return f"{(figures > DOUBTFUL).sum()} of {len(figures)}"


if __name__ == "__main__":
    for name in sys.argv[1:] or MAPS:
        print(name)
        measured(MAPS[name])
