"""Beam search over scripts, from many initial states at once (paper, section 3).

Starts are independent: each has its own beam. They are searched in blocks that bound the memory;
between blocks the search can be interrupted, and keeps what it has.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from i2pdsl.objective.compile import Params
from i2pdsl.objective.fold import Objective
from i2pdsl.objective.frame import Frame
from i2pdsl.programs import Program, compiled_program
from i2pdsl.search.rollout import Node, advance, children, root, scores
from i2pdsl.worlds.grid.world import GridWorld
from i2pdsl.worlds.world import World

Array = Any

BLOCK_BYTES = 192 * 2**20  # of working memory for one block of starts


@dataclass(frozen=True)
class Found:
    """The best script from each start, best first.

    Attributes:
        starts: [N] initial states.
        actions: [N, T].
        scores: [N], in single precision.
        finished: whether all starts were searched.
        compile_seconds: time spent on tracing and compiling.
    """

    starts: np.ndarray
    actions: np.ndarray
    scores: np.ndarray
    finished: bool
    compile_seconds: float


def draw_starts(allowed: np.ndarray, count: int, seed: int) -> np.ndarray:
    """`count` different initial states, uniformly from the allowed ones; all if there are fewer."""
    generator = np.random.default_rng(seed)
    if count >= len(allowed):
        return generator.permutation(allowed)
    return generator.choice(allowed, size=count, replace=False)


def beam_search(
    world: GridWorld,
    objective: Objective,
    length: int,
    starts: np.ndarray,
    width: int,
    events: tuple[int, ...],
    report: Callable[[int, int], None] | None = None,
    say: Callable[[str], None] | None = None,
) -> Found:
    """Searches from every start. Ctrl-C ends it early with what was found.

    Args:
        starts: [N] initial states.
        width: scripts kept for each start.
        events: the allowed events, as numbers of `world.moves.events`.
        report: called with (starts done, all starts).
        say: is told of damaged caches.

    Raises KeyboardInterrupt if it is interrupted before anything was found.
    """
    ready = prepare_beam(world, objective, length, len(starts), width, events, say)
    block, run = ready.block, ready.program.run
    found: list[tuple[np.ndarray, np.ndarray]] = []
    done = 0
    try:
        while done < len(starts):
            chunk = starts[done : done + block]
            padded = np.resize(chunk, block).astype(np.int32)
            best, actions = jax.device_get(run(ready.tables, ready.params, padded))
            found.append((best[: len(chunk)], actions[: len(chunk)]))
            done += len(chunk)
            if report is not None:
                report(done, len(starts))
    except KeyboardInterrupt:
        if not found:
            raise
    best = np.concatenate([b for b, _ in found])
    actions = np.concatenate([a for _, a in found])
    order = np.argsort(-best, kind="stable")
    return Found(
        starts[:done][order], actions[order], best[order], done == len(starts), ready.seconds
    )


@dataclass(frozen=True)
class Beam:
    """A beam search that is ready to run: `program` of the tables, parameters and `block` starts.

    `seconds` is the time spent on tracing and compiling.
    """

    program: Program
    tables: Any
    params: Params
    block: int
    seconds: float


def prepare_beam(
    world: GridWorld,
    objective: Objective,
    length: int,
    count: int,
    width: int,
    events: tuple[int, ...],
    say: Callable[[str], None] | None = None,
) -> Beam:
    """Compiles a beam search from `count` starts, or finds it in the cache."""
    block = min(count, block_size(world, objective, length, width, events))
    tables = single_precision(world)
    began = time.perf_counter()
    params = prepared(world, objective, tables)
    # The cells of appended turns are numbers inside the program.
    cells = tuple(world.cell_number) if objective.has_suffix else ()
    key = ("beam", objective.shape, world.moves, cells, length, width, events)
    search = partial(_search_block, world, objective, length, width, events)
    arguments = (tables, params, np.zeros(block, np.int32))
    program = compiled_program(key, search, arguments, (0, 0), say)
    return Beam(program, tables, params, block, time.perf_counter() - began)


def block_size(
    world: GridWorld, objective: Objective, length: int, width: int, events: tuple[int, ...]
) -> int:
    """How many starts fit into BLOCK_BYTES."""
    branching = world.moves.turn_count + len(events) * world.moves.cell_count
    belief = world.tables.log_prior.size
    per_child = 4 * belief * 8
    if objective.keeps_history:
        per_child += 4 * belief * 8 * (length + 1)
    return max(1, int(BLOCK_BYTES // (per_child * branching * width)))


def single_precision(world: World) -> Any:
    """A world's tables as JAX arrays in single precision."""
    return jax.tree.map(_single, world.tables)


def _single(array: np.ndarray) -> Array:
    array = np.asarray(array)
    if array.dtype == np.float64:
        return jnp.asarray(array, dtype=jnp.float32)
    if array.dtype == np.int64:
        return jnp.asarray(array, dtype=jnp.int32)
    return jnp.asarray(array)


def prepared(world: World, objective: Objective, tables: Any) -> Params:
    """An objective's parameters in single precision, with the tables that are worth their time."""
    params = jax.tree.map(_single, objective.params)
    if not objective.has_suffix:
        return params
    return jax.jit(objective.prepare)(tables, params)


def _search_block(
    world: GridWorld,
    objective: Objective,
    length: int,
    width: int,
    events: tuple[int, ...],
    tables: Any,
    params: Params,
    starts: Array,
) -> tuple[Array, Array]:
    """The best score [B] and its actions [B, T] for a block of starts."""

    def first(state: Array) -> Node:
        node = root(world, objective, tables, params, state)
        return jax.tree.map(lambda x: jnp.asarray(x)[None], node)

    choose = chooser(world, objective, width, events, tables, params)

    def turn(beams: Node, _: None) -> tuple[Node, tuple[Array, Array]]:
        return jax.vmap(choose)(beams)

    beams = jax.vmap(first)(starts)
    if width == 1:
        beams, (parents, actions) = jax.lax.scan(turn, beams, None, length=length)
    else:
        # The first turn has one script to go on from, not `width`.
        beams, opening = turn(beams, None)
        beams, later = jax.lax.scan(turn, beams, None, length=length - 1)
        parents, actions = jax.tree.map(lambda a, b: jnp.concatenate([a[None], b]), opening, later)
    best = jnp.argmax(beams.score, axis=1)

    def back(place: Array, step: tuple[Array, Array]) -> tuple[Array, Array]:
        parent, action = step
        rows = jnp.arange(place.shape[0])
        return parent[rows, place], action[rows, place]

    _, path = jax.lax.scan(back, best, (parents, actions), reverse=True)
    return beams.score[jnp.arange(len(starts)), best], path.T


def chooser(
    world: GridWorld,
    objective: Objective,
    width: int,
    events: tuple[int, ...],
    tables: Any,
    params: Params,
) -> Callable[[Node], tuple[Node, tuple[Array, Array]]]:
    """One turn of a beam: the `width` best children of its nodes, each with the number of its
    parent and its action."""

    def expand(node: Node) -> tuple[Frame, Array]:
        frames, real = children(world, tables, node, events)
        return frames, scores(objective, tables, params, node, frames, real)

    def choose(beam: Node) -> tuple[Node, tuple[Array, Array]]:
        frames, values = jax.vmap(expand)(beam)  # [W, K, ...], [W, K]
        count = values.shape[1]
        if width == 1:
            picked = jnp.argmax(values, axis=1)
        else:
            picked = _best_different(width, objective.keeps_history, frames, values, beam)
        # The first turn can have fewer children than the beam has places.
        spare = width - len(picked)
        picked = jnp.pad(picked, (0, spare))
        worth = values.reshape(-1)[picked]
        worth = jnp.where(jnp.arange(width) < width - spare, worth, -jnp.inf)
        parent, child = picked // count, picked % count
        action = frames.action[parent, child]
        parents = jax.tree.map(lambda x: x[parent], beam)
        # Observed anew: gathering the chosen frames would keep those of all children in memory.
        step = partial(advance, world, objective, tables, params)
        return jax.vmap(step)(parents, action, worth), (parent, action)

    return choose


def _best_different(
    width: int, keeps_history: bool, frames: Frame, values: Array, beam: Node
) -> Array:
    """The best children [W] as flat indices, leaving out those that others repeat.

    Two prefixes repeat each other if they have the same state, belief, score and sums: all that
    could follow one can follow the other. Where the history counts, nothing repeats.
    """
    flat = values.reshape(-1)
    if keeps_history:
        return jax.lax.top_k(flat, min(width, flat.size))[1]
    top, index = jax.lax.top_k(flat, min(2 * width, flat.size))
    count = values.shape[1]
    parent, child = index // count, index % count
    state = frames.state[parent, child]
    belief = jnp.exp(frames.belief[parent, child]).reshape(len(index), -1)
    # One number for a belief: weights without structure tell different ones apart.
    weights = jnp.sin(jnp.arange(1, belief.shape[1] + 1) * 12.9898) * 4.0
    sums, tried = beam.carry.sums[parent], beam.carry.tried[parent]
    marks = jnp.concatenate([top[:, None], (belief @ weights)[:, None], sums, tried], axis=1)
    near = jnp.abs(marks[:, None] - marks[None]) <= 1e-6 * (1 + jnp.abs(marks[None]))
    same = near.all(-1) & (state[:, None] == state[None])
    repeated = (same & (jnp.arange(len(index))[None] < jnp.arange(len(index))[:, None])).any(1)
    kept = jax.lax.top_k(jnp.where(repeated, -jnp.inf, top), min(width, len(index)))[1]
    return index[kept]
