"""The centre of a search: one node, and all its children with their scores."""

from __future__ import annotations

from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from i2pdsl.objective.belief import Belief, first_belief
from i2pdsl.objective.fold import Objective
from i2pdsl.objective.frame import Frame, observe, shares_of
from i2pdsl.programs import compiled_program
from i2pdsl.worlds.record import Trajectory
from i2pdsl.worlds.world import World, single_precision

Array = Any


class Node(NamedTuple):
    """A prefix of a script: its last state, the belief after it, and the fold's carry."""

    number: Array
    state: Array
    belief: Belief
    carry: Any
    score: Array


def root(world: World, objective: Objective, tables: Any, params: Any, state: Array) -> Node:
    """The node of an empty script."""
    prior = world.log_prior(tables)
    # A history of frames would double with them.
    share = jnp.exp(prior) if world.keeps_doubt and not objective.keeps_history else None
    belief = first_belief(world, tables, share)
    zero = jnp.zeros((), prior.dtype)
    carry = objective.init(tables, params, state)
    none = jnp.zeros((), jnp.int32) if params.before is None else params.before
    return Node(none, state, belief, carry, zero)


def children(world: World, tables: Any, node: Node, events: tuple[int, ...]) -> tuple[Frame, Array]:
    """The frames that can follow a node, [K, ...], and which of them are real.

    K = all joint turns, then every cell for each allowed event (a number of `world.events`).
    """
    turns = world.turns(tables, node.state)
    observers = node.belief.log.shape
    full = (*jnp.broadcast_shapes(*(r.shape[:-2] for r in turns.log_rows)), *observers)
    flat = (turns.state.shape[-1], *observers)
    whole = lambda part: jnp.broadcast_to(part, full).reshape(flat)
    lifted = lambda part: part[(None,) * (len(full) - 2)]
    given = world.holdings(tables)
    belief = node.belief.map(lifted)._replace(holdings=node.belief.holdings).shown(given)
    expecting, rows = [], []
    regret = jnp.zeros(full[:-1], belief.log.dtype)
    for who, row in enumerate(turns.log_rows):
        known = turns.problems[who] if turns.problems else None
        expecting.append(belief.map(whole))
        rows.append(whole(belief.likely(world, tables, who, row)))
        belief = belief.seeing(world, tables, who, row, known)
        below = _below_best(row, who - len(full))
        lacking = known and known._replace(log_rows=_below_best(known.log_rows, who - len(full)))
        regret += belief.regret(world, tables, who, below, lacking)
    count = flat[0]
    previous, after = node.belief.map(lifted).map(whole), belief.map(whole)
    holdings = tuple(
        held.each(lambda part, own: _of_turns(part, own, full[:-2]), first)
        for held, first in zip(belief.holdings, node.belief.holdings, strict=True)
    )
    frame = Frame(
        jnp.full((count,), node.number + 1),
        jnp.full((count,), node.state),
        jnp.arange(count, dtype=jnp.int32),
        turns.state,
        previous.log,
        after.log,
        jnp.stack([each.log for each in expecting], axis=1),
        jnp.stack(rows, axis=1),
        regret.reshape(flat[:-1]),
        shares_of(previous, after, expecting),
        after._replace(holdings=holdings).over(given).holdings,
    )
    if not events:
        return frame, turns.valid
    fallen, possible = world.drops(tables, node.state)
    slots = world.event_slots
    number = jnp.concatenate([jnp.arange(e * slots, (e + 1) * slots) for e in events])
    still = node.belief.map(lambda part: jnp.broadcast_to(part, (len(number), *observers)))
    rows_ = jnp.zeros((len(number), len(rows), *observers), still.log.dtype)
    dropped = Frame(
        jnp.full((len(number),), node.number + 1),
        jnp.full((len(number),), node.state),
        (world.turn_count + number).astype(jnp.int32),
        fallen[number],
        still.log,
        still.log,
        jnp.broadcast_to(node.belief.log, rows_.shape),
        rows_,
        jnp.zeros(rows_.shape[::2], rows_.dtype),
        shares_of(still, still, [still] * len(rows)),
        tuple(
            held.each(lambda part: jnp.broadcast_to(part, (len(number), *part.shape)))
            for held in node.belief.holdings
        ),
    )
    joined = frame.each(lambda a, b: jnp.concatenate([a, b]), dropped)
    return joined, jnp.concatenate([turns.valid, possible[number]])


def _below_best(log_rows: Array, axis: int) -> Array:
    """How much likelier the likeliest action is than each: all are among the branches."""
    return log_rows.max(axis=axis, keepdims=True) - log_rows


def _of_turns(part: Array, first: Array, turns: tuple[int, ...]) -> Array:
    """What is held after each turn, [K, ...], of what is held before any."""
    own = first.shape
    lead = part.shape[: part.ndim - len(own)]
    part = part.reshape(*(1,) * (len(turns) - len(lead)), *part.shape)
    return jnp.broadcast_to(part, (*turns, *own)).reshape(-1, *own)


def scores(
    objective: Objective,
    tables: Any,
    params: Any,
    node: Node,
    frames: Frame,
    real: Array,
    ahead: Array,
) -> Array:
    """What each child's prefix is worth, [K]; -inf for what is not real or not a number.

    Args:
        ahead: whether a prefix is worth what it promises (fold.py) rather than its own objective.
    """

    carry = jax.vmap(partial(objective.step, tables, params, node.carry))(frames)
    worth = lambda value: lambda: jax.vmap(partial(value, tables, params))(carry, frames)
    value = jax.lax.cond(ahead, worth(objective.promise), worth(objective.score))
    alive = real & jnp.isfinite(value) & (node.score > -jnp.inf)
    return jnp.where(alive, value, -jnp.inf)


def follow(
    world: World, objective: Objective, tables: Any, params: Any, node: Node, action: Array
) -> tuple[Node, Frame]:
    """One frame further: the audience sees it, the objective's fold takes it in."""
    frame = observe(world, tables, node.number + 1, node.state, action, node.belief)
    carry = objective.step(tables, params, node.carry, frame)
    return Node(frame.number, frame.state, frame.belief, carry, node.score), frame


def retraced(
    world: World,
    objective: Objective,
    tables: Any,
    params: Any,
    actions: Array,
    states: Array,
    number: Array,
) -> Node:
    """The node that a script leads to after its first `number` frames.

    Args:
        actions, states: [T, ...] and [T + 1, ...], of which only the first count. The states are
            followed as they are: rollouts of bodies are chaotic.
    """

    def frame(node: Node, step: tuple[Array, Array, Array]) -> tuple[Node, None]:
        t, action, state = step
        here = node._replace(state=state)
        after, _ = follow(world, objective, tables, params, here, action)
        return jax.tree.map(lambda a, b: jnp.where(t < number, a, b), after, node), None

    node = root(world, objective, tables, params, states[0])
    times = jnp.arange(actions.shape[0])
    node, _ = jax.lax.scan(frame, node, (times, actions, states[:-1]))
    return node._replace(state=states[number])


def prefix_scores(
    world: World, objective: Objective, length: int, tables: Any, params: Any, paths: Trajectory
) -> np.ndarray:
    """What scripts side by side are worth as prefixes of a story of `length` frames, [S].

    Args:
        paths: actions [S, n, ...] and states [S, n + 1, ...], n at least 1.
    """

    def scores(tables: Any, params: Any, actions: Array, states: Array, last: Array) -> Array:
        def score(actions: Array, states: Array) -> Array:
            node = retraced(world, objective, tables, params, actions, states, last)
            end, frame = follow(world, objective, tables, params, node, actions[last])
            return objective.score(tables, params, end.carry, frame)

        return jax.vmap(score)(actions, states)

    given = (tables, params, *_padded(length, paths), np.int32(paths.actions.shape[1] - 1))
    key = ("prefixes", objective.shape, world.program_key(objective.suffix_turns))
    return np.asarray(compiled_program(key, scores, given, 0, brief=True).run(*given), dtype=float)


def resume(
    world: World, objective: Objective, length: int, tables: Any, params: Any, path: Trajectory
) -> Node:
    """The node that a script leads to, of a story of `length` frames, in single precision."""
    actions, states = _padded(length, Trajectory(path.actions[None], path.states[None]))
    given = (tables, params, actions[0], states[0], np.int32(len(path.actions)))
    run = partial(retraced, world, objective)
    key = ("resume", objective.shape, world.program_key(objective.suffix_turns))
    return compiled_program(key, run, given, jax.eval_shape(run, *given), brief=True).run(*given)


def _padded(length: int, paths: Trajectory) -> tuple[np.ndarray, np.ndarray]:
    """Actions and states of scripts side by side, up to `length` frames."""
    missing = length - paths.actions.shape[1]
    pad = lambda a: single_precision(
        np.pad(a, ((0, 0), (0, missing), *((0, 0) for _ in a.shape[2:])))
    )
    return pad(paths.actions), pad(paths.states)
