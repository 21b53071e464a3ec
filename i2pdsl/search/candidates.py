"""Several good scripts that a viewer can tell apart, because the best score is not always the
best story."""

from __future__ import annotations

import numpy as np

from i2pdsl.worlds.kinds import kind_of
from i2pdsl.worlds.world import World


def select_different(world: World, paths: list[np.ndarray], count: int) -> list[int]:
    """The first `count` scripts (best first, as states [T + 1, ...]) that differ visibly from all
    better ones."""
    chosen: list[int] = []
    apart = kind_of(world.spec).distance
    for i, path in enumerate(paths):
        if all(apart(world, path, paths[j]) >= 1 for j in chosen):
            chosen.append(i)
            if len(chosen) == count:
                break
    return chosen
