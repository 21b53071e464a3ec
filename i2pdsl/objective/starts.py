"""The first pictures that fulfil the `start` of a story."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from i2pdsl.language import typed as ty
from i2pdsl.objective.compile import Compiler, Params
from i2pdsl.worlds.world import World


@dataclass(frozen=True)
class PictureScope:
    """First pictures: predicates are asked of `state` [S]; there are no frames and no beliefs."""

    world: World
    tables: Any
    params: Params
    state: np.ndarray
    xp = np
    t = None


def allowed_starts(world: World, condition: ty.Typed | None) -> np.ndarray:
    """The initial states that fulfil a checked condition, in order; all of them without one."""
    if condition is None:
        return world.starts()
    features = [node for node in ty.walk(condition) if isinstance(node, ty.Feature)]
    points = [a for node in features for a in node.arguments if isinstance(a, ty.Point)]
    states = world.starts(tuple(dict.fromkeys(points))) if points else world.starts()
    compiler = Compiler(world, 0)
    closure = compiler.build(condition)
    with np.errstate(all="ignore"):  # 1/0 is infinite, as in a query
        holds = closure(PictureScope(world, world.tables, compiler.params(), states))
    return states[np.broadcast_to(holds, len(states)) != 0]
