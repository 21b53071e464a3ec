"""The centre of a search: one node, and all its children with their scores."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from i2pdsl.audience.product import Product
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


class Children(NamedTuple):
    """What can follow a node, [K].

    Attributes:
        action, state: what happens, and the state that it leads to.
        worth: of the prefix that ends with it; -inf for what is not real or not a number.
        mark: a number for the belief after it; None where beliefs are not compared.
    """

    action: Array
    state: Array
    worth: Array
    mark: Array | None


def children(
    world: World,
    objective: Objective,
    events: tuple[int, ...],
    tables: Any,
    params: Any,
    ahead: Array,
    node: Node,
) -> Children:
    """All joint turns that can follow a node, then every cell for each allowed event (a number of
    `world.events`).

    Args:
        ahead: whether a prefix is worth what it promises (fold.py) rather than its own objective.
    """
    kinds = [_turns(world, tables, node)]
    if events:
        observed = kinds[0][0].log_rows.shape[2]
        kinds.append(_drops(world, tables, node, events, observed))
    found = []
    for frames, real in kinds:
        worth, mark = _of_all(partial(_worth, objective, tables, params, ahead, node), frames)
        alive = real & jnp.isfinite(worth) & (node.score > -jnp.inf)
        worth = jnp.where(alive, worth, -jnp.inf)
        found.append(Children(frames.action, frames.state, worth, mark))
    return jax.tree.map(lambda *parts: jnp.concatenate([p.reshape(-1) for p in parts]), *found)


def _worth(
    objective: Objective, tables: Any, params: Any, ahead: Array, node: Node, frame: Frame
) -> tuple[Array, Array | None]:
    """What the prefix that ends with a frame is worth, and the mark of its belief."""
    carry = objective.step(tables, params, node.carry, frame)
    worth = lambda value: lambda: value(tables, params, carry, frame)
    value = jax.lax.cond(ahead, worth(objective.promise), worth(objective.score))
    return value, None if objective.keeps_history else _mark(frame)


def _mark(frame: Frame) -> Array:
    """One number for the belief after a frame: weights without structure tell different ones
    apart."""
    each = np.arange(1, frame.log_belief.size + 1).reshape(frame.log_belief.shape)
    weights = np.sin(each * 12.9898).astype(frame.log_belief.dtype)  # known to the compiler
    if isinstance(frame.share, Product):
        return frame.share.summed(weights).sum()
    belief = jnp.maximum(frame.log_belief, -40.0) if frame.share is None else frame.share
    return belief.reshape(-1) @ weights.reshape(-1)


def _of_all(function: Callable[[Frame], Any], frames: Frame) -> Any:
    """A function of one frame, of children [J, A] of one node. What it finds of what they have in
    common it finds once: of what was before, and of a product's factor that all A share."""
    every = jax.tree.map(lambda _: 0, frames)
    every = every._replace(number=None, before=None, log_previous=None)
    if frames.shares is None:
        return jax.vmap(jax.vmap(function, (every,)), (every,))(frames)
    product = frames.shares.product
    of = lambda before: product and Product(before, 0, None, None)
    inner, outer = (
        every._replace(shares=every.shares._replace(previous=None, product=of(before)))
        for before in (None, 0)
    )
    return jax.vmap(jax.vmap(function, (inner,)), (outer,))(frames)


def _turns(world: World, tables: Any, node: Node) -> tuple[Frame, Array]:
    """The frames of all joint turns, [J, A], and which of them are real: A outcomes of who acts
    last for each of J of those before. What was before them they have in common."""
    turns = world.turns(tables, node.state)
    observers = node.belief.log.shape
    full = (*jnp.broadcast_shapes(*(r.shape[:-2] for r in turns.log_rows)), *observers)
    shape = (-1, full[-3])
    whole = lambda part: jnp.broadcast_to(part, full).reshape(*shape, *observers)
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
    after = belief.map(whole)
    holdings = tuple(
        held.each(lambda part, own: _of_turns(part, own, full[:-2]), first)
        for held, first in zip(belief.holdings, node.belief.holdings, strict=True)
    )
    holdings = after._replace(holdings=holdings).over(given).holdings
    state = turns.state.reshape(shape)
    frame = Frame(
        node.number + 1,
        node.state,
        jnp.arange(state.size, dtype=jnp.int32).reshape(shape),
        state,
        node.belief.log,
        after.log,
        jnp.stack([each.log for each in expecting], axis=2),
        jnp.stack(rows, axis=2),
        regret.reshape(*shape, regret.shape[-1]),
        shares_of(node.belief, after, expecting),
        tuple(held.each(lambda part: part.reshape(*shape, *part.shape[1:])) for held in holdings),
    )
    if belief.product is not None:
        assert frame.shares is not None
        before, likely = belief.product.before, belief.product.likely
        likely = jnp.broadcast_to(likely, (*full[:-1], likely.shape[-1]))
        product = belief.product._replace(
            before=jnp.broadcast_to(before, (*full[:-3], 1, *observers)).reshape(-1, *observers),
            likely=likely.reshape(*shape, *likely.shape[-2:]),
        )
        frame = frame._replace(shares=frame.shares._replace(product=product))
    return frame, turns.valid.reshape(shape)


def _drops(
    world: World, tables: Any, node: Node, events: tuple[int, ...], observed: int
) -> tuple[Frame, Array]:
    """The same of some events, [1, A]; `observed` is U."""
    fallen, possible = world.drops(tables, node.state)
    slots = world.event_slots
    number = jnp.concatenate([jnp.arange(e * slots, (e + 1) * slots) for e in events])
    each = lambda part: jnp.broadcast_to(part, (1, len(number), *part.shape))
    still = node.belief.map(each)
    rows = jnp.zeros((1, len(number), observed, *node.belief.log.shape), still.log.dtype)
    state = fallen[number][None]
    frame = Frame(
        node.number + 1,
        node.state,
        (world.turn_count + number)[None].astype(jnp.int32),
        state,
        node.belief.log,
        still.log,
        rows + node.belief.log,
        rows,
        rows[:, :, 0, :, 0],
        shares_of(node.belief, still, [still] * observed),
        tuple(held.each(each) for held in node.belief.holdings),
    )
    return frame, possible[number][None]


def _below_best(log_rows: Array, axis: int) -> Array:
    """How much likelier the likeliest action is than each: all are among the branches."""
    return log_rows.max(axis=axis, keepdims=True) - log_rows


def _of_turns(part: Array, first: Array, turns: tuple[int, ...]) -> Array:
    """What is held after each turn, [K, ...], of what is held before any."""
    own = first.shape
    lead = part.shape[: part.ndim - len(own)]
    part = part.reshape(*(1,) * (len(turns) - len(lead)), *part.shape)
    return jnp.broadcast_to(part, (*turns, *own)).reshape(-1, *own)


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
