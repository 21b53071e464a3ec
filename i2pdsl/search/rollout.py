"""The centre of a search: one node, and all its children with their scores."""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from i2pdsl.audience.filter import update
from i2pdsl.objective.fold import Objective
from i2pdsl.objective.frame import Frame, observe
from i2pdsl.worlds.grid.world import GridWorld
from i2pdsl.worlds.world import World

Array = Any


class Node(NamedTuple):
    """A prefix of a script: its last state, the belief after it, and the fold's carry."""

    number: Array
    state: Array
    belief: Array
    carry: Any
    score: Array


def root(world: World, objective: Objective, tables: Any, params: Any, state: Array) -> Node:
    """The node of an empty script."""
    belief = world.log_prior(tables)
    zero = jnp.zeros((), belief.dtype)
    carry = objective.init(tables, params, state)
    return Node(jnp.zeros((), jnp.int32), state, belief, carry, zero)


def children(
    world: GridWorld, tables: Any, node: Node, events: tuple[int, ...]
) -> tuple[Frame, Array]:
    """The frames that can follow a node, [K, ...], and which of them are real.

    K = all joint turns, then every cell for each allowed event (a number of `world.moves.events`).
    """
    turns = world.turns(tables, node.state)
    observers = node.belief.shape
    full = (*jnp.broadcast_shapes(*(r.shape for r in turns.log_rows)),)
    flat = (turns.state.shape[-1], *observers)
    belief = node.belief[None, None]
    expecting, rows = [], []
    for row in turns.log_rows:
        expecting.append(jnp.broadcast_to(belief, full).reshape(flat))
        rows.append(jnp.broadcast_to(row, full).reshape(flat))
        belief = update(belief, row, world.forgetting(tables))
    count = flat[0]
    frame = Frame(
        jnp.full((count,), node.number + 1),
        jnp.full((count,), node.state),
        jnp.arange(count, dtype=jnp.int32),
        turns.state,
        jnp.broadcast_to(node.belief, flat),
        jnp.broadcast_to(belief, full).reshape(flat),
        jnp.stack(expecting, axis=1),
        jnp.stack(rows, axis=1),
    )
    if not events:
        return frame, turns.valid
    fallen, possible = world.drops(tables, node.state)
    cells = world.moves.cell_count
    number = jnp.concatenate([jnp.arange(e * cells, (e + 1) * cells) for e in events])
    still = jnp.broadcast_to(node.belief, (len(number), *observers))
    rows_ = jnp.zeros((len(number), len(rows), *observers), node.belief.dtype)
    dropped = Frame(
        jnp.full((len(number),), node.number + 1),
        jnp.full((len(number),), node.state),
        (world.moves.turn_count + number).astype(jnp.int32),
        fallen[number],
        still,
        still,
        jnp.broadcast_to(node.belief, rows_.shape),
        rows_,
    )
    joined = jax.tree.map(lambda a, b: jnp.concatenate([a, b]), frame, dropped)
    return joined, jnp.concatenate([turns.valid, possible[number]])


def scores(
    objective: Objective, tables: Any, params: Any, node: Node, frames: Frame, real: Array
) -> Array:
    """The objective of each child's prefix, [K]; -inf for what is not real or not a number."""

    def score(frame: Frame) -> Array:
        return objective.score(
            tables, params, objective.step(tables, params, node.carry, frame), frame
        )

    value = jax.vmap(score)(frames)
    alive = real & jnp.isfinite(value) & (node.score > -jnp.inf)
    return jnp.where(alive, value, -jnp.inf)


def advance(
    world: World,
    objective: Objective,
    tables: Any,
    params: Any,
    node: Node,
    action: Array,
    score: Array,
) -> Node:
    """The node that an action leads to; `score` is what its prefix is worth."""
    node, _ = follow(world, objective, tables, params, node, action)
    return node._replace(score=score)


def follow(
    world: World, objective: Objective, tables: Any, params: Any, node: Node, action: Array
) -> tuple[Node, Frame]:
    """One frame further: the audience sees it, the objective's fold takes it in."""
    frame = observe(world, tables, node.number + 1, node.state, action, node.belief)
    carry = objective.step(tables, params, node.carry, frame)
    return Node(frame.number, frame.state, frame.belief, carry, node.score), frame
