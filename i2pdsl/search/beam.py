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

from i2pdsl.errors import error, whole_file
from i2pdsl.objective.appended import tabulate_turns, worth_a_table
from i2pdsl.objective.compile import Params
from i2pdsl.objective.fold import Objective
from i2pdsl.objective.frame import Frame
from i2pdsl.programs import Program, Say, compiled_program
from i2pdsl.search.rollout import Node, children, root, scores
from i2pdsl.sizes import memory_limit, padded_size
from i2pdsl.worlds.world import World, single_precision

Array = Any

BLOCK_BYTES = 192 * 2**20  # of working memory for one block of starts

# What a search takes for each child and hypothesis, and for each pair of places of a beam that are
# compared (measured: the kitchen, 2 cores). Another machine is not ten times as fast.
CHILD_SECONDS, PAIR_SECONDS = 8e-9, 2e-9
BRIEF_SECONDS = 0.05  # below, it takes longer to compile well than it saves
LONG, TOO_LONG = 600.0, 24 * 3600.0  # seconds that are said, and that are refused


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


def beam_search(
    world: World,
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
        events: the allowed events, as numbers of `world.events`.
        report: called with (starts done, all starts).
        say: is told of damaged caches.

    Raises KeyboardInterrupt if it is interrupted before anything was found, StoryError where it
    would need too much memory, or more than a day.
    """
    check_size(world, objective, length, len(starts), width, events, say)
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
    world: World,
    objective: Objective,
    length: int,
    count: int,
    width: int,
    events: tuple[int, ...],
    say: Callable[[str], None] | None = None,
) -> Beam:
    """Compiles a beam search from `count` starts, or finds it in the cache."""
    most = block_size(world, objective, length, width, events)
    block = min(padded_size(count, 64), most)
    tables = world.search_tables
    began = time.perf_counter()
    params = prepared(world, objective, say)
    layout = world.program_key(objective.suffix_turns)
    key = ("beam", objective.shape, layout, length, width, events)
    search = partial(_search_block, world, objective, length, width, events)
    arguments = (tables, params, np.zeros(block, np.int32))
    brief = expected_seconds(world, objective, length, count, width, events) < BRIEF_SECONDS
    program = compiled_program(key, search, arguments, (0, 0), say, brief)
    return Beam(program, tables, params, block, time.perf_counter() - began)


def branching(world: World, events: tuple[int, ...]) -> int:
    """How many children a script has, those that are not possible included."""
    return world.turn_count + len(events) * world.event_slots


def start_bytes(
    world: World, objective: Objective, length: int, width: int, events: tuple[int, ...]
) -> int:
    """Working memory for one start."""
    belief = world.tables.log_prior.size
    per_child = 4 * belief * 8
    if objective.keeps_history:
        per_child += 4 * belief * 8 * (length + 1)
    return width * (per_child * branching(world, events) + 8 * length)


def block_size(
    world: World, objective: Objective, length: int, width: int, events: tuple[int, ...]
) -> int:
    """How many starts fit into BLOCK_BYTES."""
    return max(1, BLOCK_BYTES // start_bytes(world, objective, length, width, events))


def check_size(
    world: World,
    objective: Objective,
    length: int,
    starts: int,
    width: int,
    events: tuple[int, ...],
    say: Say | None = None,
) -> None:
    """Refuses a search that does not fit or takes more than a day, and says when it takes long.

    Raises StoryError.
    """
    hint = "fewer `starts`, a smaller `width` or a shorter story"
    size = f"{starts:,} starts x {width:,} scripts x {length:,} frames"
    needed, there = start_bytes(world, objective, length, width, events), memory_limit() // 2
    if needed > there:
        message = (
            f"the search ({size}) needs {needed / 2**30:.1f} GiB of memory for one start, "
            f"{there / 2**30:.1f} GiB are there"
        )
        raise error("too-large", message, whole_file("search"), hint)
    seconds = expected_seconds(world, objective, length, starts, width, events)
    if seconds > TOO_LONG:
        message = f"the search ({size}) would take about {_duration(seconds)}"
        raise error("too-large", message, whole_file("search"), hint)
    if seconds > LONG and say is not None:
        say(f"the search ({size}) takes about {_duration(seconds)}; Ctrl-C keeps what was found")


def expected_seconds(
    world: World,
    objective: Objective,
    length: int,
    starts: int,
    width: int,
    events: tuple[int, ...],
) -> float:
    """How long a search takes, roughly."""
    looks = 1 + len(objective.suffix_turns) + (length if objective.keeps_history else 0)
    child = branching(world, events) * world.tables.log_prior.size * looks * CHILD_SECONDS
    return starts * length * width * (child + 4 * (width > 1) * width * PAIR_SECONDS)


def _duration(seconds: float) -> str:
    """A length of time in the largest unit of which there are two."""
    for unit, size in (("days", 86_400), ("hours", 3600)):
        if seconds >= 2 * size:
            return f"{seconds / size:,.0f} {unit}"
    return f"{seconds / 60:.0f} minutes"


def prepared(world: World, objective: Objective, say: Say | None = None) -> Params:
    """An objective's parameters in single precision, with the tables that are worth their time."""
    params = jax.tree.map(single_precision, objective.params)
    turns, tables = objective.suffix_turns, world.search_tables
    if not worth_a_table(world, tables, turns):
        return params
    key = ("turns", turns, world.program_key(turns))
    tabulate = lambda tables: tabulate_turns(world, tables, turns)
    program = compiled_program(key, tabulate, (tables,), (0,) * len(turns), say)
    return params._replace(suffix_rows=program.run(tables))


def _search_block(
    world: World,
    objective: Objective,
    length: int,
    width: int,
    events: tuple[int, ...],
    tables: Any,
    params: Params,
    starts: Array,
) -> tuple[Array, Array]:
    """The best score [B] and its actions [B, T] for a block of starts."""

    choose = chooser(world, objective, width, events, tables, params)

    def search(start: Array) -> tuple[Array, Array]:
        node = root(world, objective, tables, params, start)
        found, steps = grown(choose, node, width, length)
        best = jnp.argmax(found)
        return found[best], traced(steps, best)

    return jax.vmap(search)(starts)


Steps = tuple[Array, Array]
"""For each frame the parents and the actions of a beam's scripts, [frames, W] each."""


def grown(
    choose: Callable[[Node], tuple[Node, Steps]], node: Node, width: int, frames: int
) -> tuple[Array, Steps]:
    """The scores [W] of a beam that grows from one node, and its steps."""
    copies = jax.tree.map(lambda x: jnp.broadcast_to(x, (width, *jnp.shape(x))), node)
    # One script to go on from: what follows the copies counts for nothing. (A first turn of its
    # own would do less, and make the program twice as long to compile.)
    beam = copies._replace(score=jnp.where(jnp.arange(width) > 0, -jnp.inf, copies.score))
    beam, steps = jax.lax.scan(lambda beam, _: choose(beam), beam, None, length=frames)
    return beam.score, steps


def traced(steps: Steps, place: Array) -> Array:
    """The actions [frames] of the script that has a place in the end."""

    def back(place: Array, step: Steps) -> Steps:
        parent, action = step
        return parent[place], action[place]

    return jax.lax.scan(back, place, steps, reverse=True)[1]


def chooser(
    world: World,
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
        worth = values.reshape(-1)[picked]
        parent, child = picked // count, picked % count
        action = frames.action[parent, child]
        chosen = jax.tree.map(lambda x: x[parent, child], frames)
        carry = jax.tree.map(lambda x: x[parent], beam.carry)
        carry = jax.vmap(partial(objective.step, tables, params))(carry, chosen)
        return Node(chosen.number, chosen.state, chosen.belief, carry, worth), (parent, action)

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
        return jax.lax.top_k(flat, width)[1]
    top, index = jax.lax.top_k(flat, 2 * width)
    count = values.shape[1]
    parent, child = index // count, index % count
    state = frames.state[parent, child]
    belief = jnp.exp(frames.belief[parent, child]).reshape(len(index), -1)
    # One number for a belief: weights without structure tell different ones apart.
    weights = jnp.sin(jnp.arange(1, belief.shape[1] + 1) * 12.9898) * 4.0
    carried = [part[parent].reshape(len(index), -1) for part in jax.tree.leaves(beam.carry[:2])]
    marks = jnp.concatenate([top[:, None], (belief @ weights)[:, None], *carried], axis=1)
    near = jnp.abs(marks[:, None] - marks[None]) <= 1e-6 * (1 + jnp.abs(marks[None]))
    same = near.all(-1) & (state[:, None] == state[None])
    repeated = (same & (jnp.arange(len(index))[None] < jnp.arange(len(index))[:, None])).any(1)
    kept = jax.lax.top_k(jnp.where(repeated, -jnp.inf, top), width)[1]
    return index[kept]
