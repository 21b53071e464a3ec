"""The first pictures that fulfil the `start` of a story."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from i2pdsl.language import typed as ty
from i2pdsl.objective.compile import Compiler, Params
from i2pdsl.worlds.world import Part, World


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
    parts = () if world.lists_states else _parts(world, condition)
    states = world.starts(tuple(dict.fromkeys(points)), parts)
    return states[_holds(world, condition, states)]


def _parts(world: World, condition: ty.Typed) -> tuple[Part, ...]:
    """What a condition asks, each with whom it asks about."""
    asked, left = list[ty.Typed](), [condition]
    while left:
        node = left.pop()
        if isinstance(node, ty.Apply) and node.operation == "and":
            left += node.arguments
        else:
            asked.append(node)
    return tuple((_about(node), partial(_holds, world, node)) for node in asked)


def _about(condition: ty.Typed) -> frozenset[int]:
    """The characters and things that a condition asks about."""
    features = (node for node in ty.walk(condition) if isinstance(node, ty.Feature))
    return frozenset(a for node in features for a in node.arguments if isinstance(a, int))


def _holds(world: World, condition: ty.Typed, states: np.ndarray) -> np.ndarray:
    compiler = Compiler(world, 0)
    closure = compiler.build(condition)
    with np.errstate(all="ignore"):  # 1/0 is infinite, as in a query
        holds = closure(PictureScope(world, world.tables, compiler.params(), states))
    found: np.ndarray = np.broadcast_to(holds, len(states)) != 0
    return found
