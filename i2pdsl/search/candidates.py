"""Several good scripts that a viewer can tell apart, because the best score is not always the
best story."""

from __future__ import annotations

import numpy as np

from i2pdsl.worlds.kinds import kind_of
from i2pdsl.worlds.world import World

SHORTLIST = 16  # of the best scripts, of which the panel chooses
TOLERANCE = 0.05  # of the best score: what lies further below it is much worse
QUIET = 0.5  # a script that is still in more than this share of its frames is no film


def select_different(world: World, paths: list[np.ndarray], count: int) -> list[int]:
    """The first `count` scripts (best first, as states [T + 1, ...]) that differ visibly from all
    better ones. Mirror images do not."""
    chosen: list[int] = []
    apart = kind_of(world.spec).distance
    for i, path in enumerate(paths):
        if all(apart(world, path, paths[j]) >= 1 for j in chosen):
            chosen.append(i)
            if len(chosen) == count:
                break
    return chosen


def faults(world: World, states: np.ndarray) -> int:
    """How much a script lacks of a film, whatever is believed of it: one that stands still for
    most of its frames, and one in which the characters never meet."""
    still = world.is_still(world.tables, states[:-1], states[1:])
    return int(still.mean() > QUIET) + int(not kind_of(world.spec).meet(world, states))
