"""A pool of scripts that grow side by side: many beams in one program, of any width.

M places are divided into groups of `width` neighbouring places; each group is a beam of its own.
How wide they are and by what they are judged are arguments of the program, so that one program
serves a whole search. K children a node, T frames.
"""

from __future__ import annotations

from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from i2pdsl.objective.compile import Params
from i2pdsl.objective.fold import Objective
from i2pdsl.search.rollout import Children, Node, children, follow
from i2pdsl.worlds.world import World

Array = Any

# Of a script's children at most so many go on: those of one soon look alike, and to sort more takes
# time. In a short story they may still decide, and there is time.
OFFSPRING, IN_ALL_FRAMES = 8, 120


class Rule(NamedTuple):
    """How a pool goes on: numbers of the program.

    Attributes:
        width: places of each group.
        alike: so many scripts of a group may stand in one state; at least `width` for no limit.
        ahead: whether prefixes are judged by what they promise (objective/fold.py).
    """

    width: Array
    alike: Array
    ahead: Array


def grown(
    world: World,
    objective: Objective,
    frames: int,
    events: tuple[int, ...],
    tables: Any,
    params: Params,
    pool: Node,
    rule: Rule,
    before: Array | None = None,
) -> tuple[Array, Array]:
    """The scores [M] and further actions [M, frames] of scripts; -inf in places not taken.

    Args:
        pool: what each group goes on from, in all of its places.
        before: so many of the frames are none, at first.
    """
    places = jnp.arange(pool.state.shape[0])
    offspring = max(OFFSPRING, IN_ALL_FRAMES // frames)
    expand = jax.vmap(partial(children, world, objective, events, tables, params, rule.ahead))
    # A frame seen anew costs less than to keep what was seen in all children.
    step = jax.vmap(lambda node, action: follow(world, objective, tables, params, node, action)[0])

    def turn(pool: Node, t: Array) -> tuple[Node, tuple[Array, Array]]:
        found = expand(pool)  # [M, K]
        # At first a group's places are the same: each offers its share of the children.
        share = jnp.arange(found.worth.shape[1]) % rule.width == (places % rule.width)[:, None]
        first = 0 if before is None else before
        worth = jnp.where((t > first) | share, found.worth, -jnp.inf)
        parent, child = jax.lax.cond(
            rule.width == 1,
            lambda: (places, jnp.argmax(worth, axis=1).astype(places.dtype)),
            lambda: _chosen(offspring, pool, found._replace(worth=worth), rule),
        )
        action = found.action[parent, child]
        pool = step(jax.tree.map(lambda x: x[parent], pool), action)
        score = jnp.where(parent < 0, -jnp.inf, worth[parent, child])
        return pool._replace(score=score), (parent, action)

    def turn_or_none(pool: Node, t: Array) -> tuple[Node, tuple[Array, Array]]:
        none = (pool, (places, jnp.zeros(places.shape, jnp.int32)))
        return jax.lax.cond(t < before, lambda: none, lambda: turn(pool, t))

    step_on = turn if before is None else turn_or_none
    pool, steps = jax.lax.scan(step_on, pool, jnp.arange(frames))
    return pool.score, _traced(places, steps)


def _traced(places: Array, steps: tuple[Array, Array]) -> Array:
    """The actions [M, frames] of the script in each place."""

    def back(place: Array, step: tuple[Array, Array]) -> tuple[Array, Array]:
        parent, action = step
        return parent[place], action[place]

    return jax.lax.scan(back, places, steps, reverse=True)[1].T


def _chosen(offspring: int, pool: Node, found: Children, rule: Rule) -> tuple[Array, Array]:
    """The parents and children [M] that take the places; parent -1 where none is left.

    In each group the best go on, without those that repeat others, and without more than
    `rule.alike` in one state.
    """
    places, count = found.worth.shape
    kept = min(offspring, count)
    best, child = jax.lax.top_k(found.worth, kept)  # [M, kept]
    parent = jnp.broadcast_to(jnp.arange(places)[:, None], best.shape)
    group = (parent // rule.width).reshape(-1)
    keys = (group, -best.reshape(-1), jnp.arange(best.size))
    _, worth, order = jax.lax.sort(keys, num_keys=2)  # the groups stay where they are
    worth = -worth
    parent, child = parent.reshape(-1)[order], child.reshape(-1)[order]
    state = found.state[parent, child]
    alive = worth > -jnp.inf
    if found.mark is not None:
        alive &= ~_repeated(pool, parent, state, worth, found.mark[parent, child])
    alive = jax.lax.cond(
        rule.alike < rule.width,
        lambda: alive & (_rank(group, jnp.where(alive, state, -1)) < rule.alike),
        lambda: alive,
    )
    so_far = jnp.cumsum(alive)
    begin = group * rule.width * kept
    before = jnp.where(begin > 0, so_far[begin - 1], 0)
    place = so_far - 1 - before
    taken = alive & (place < rule.width)
    target = jnp.where(taken, group * rule.width + place, places)
    fill = lambda x: jnp.full((places,), -1, x.dtype).at[target].set(x, mode="drop")
    return fill(parent), fill(child.astype(parent.dtype))


def _repeated(pool: Node, parent: Array, state: Array, worth: Array, mark: Array) -> Array:
    """Which of a sorted row of prefixes repeat one just before them, [n].

    Two prefixes repeat each other if they have the same state, belief, score and sums: all that
    could follow one can follow the other. Equal scores stand side by side.
    """
    carried = [part[parent].reshape(len(parent), -1) for part in jax.tree.leaves(pool.carry[:3])]
    marks = jnp.concatenate([worth[:, None], mark[:, None], *carried], axis=1)
    repeated = jnp.zeros(len(parent), bool)
    for back in (1, 2, 3):
        other = jnp.roll(marks, back, axis=0)
        near = (jnp.abs(marks - other) <= 1e-6 * (1 + jnp.abs(other))).all(-1)
        repeated |= near & (state == jnp.roll(state, back)) & (jnp.arange(len(parent)) >= back)
    return repeated


def _rank(group: Array, state: Array) -> Array:
    """How many that stand in the same state come before each in its group, [n]."""
    positions = jnp.arange(len(group))
    first, second, order = jax.lax.sort((group, state, positions), num_keys=3)
    begins = (first != jnp.roll(first, 1)) | (second != jnp.roll(second, 1)) | (positions == 0)
    begin = jax.lax.cummax(jnp.where(begins, positions, 0))
    return jnp.zeros_like(order).at[order].set(positions - begin)
