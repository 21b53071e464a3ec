"""Gradient descent over what is added to a controller's actuation (paper, section 3.3).

The gradient of a long rollout grows without bound, so a script is improved window by window: each
is optimised for the objective of the prefix that it completes, and the next goes on from where it
ends, with its state, belief and fold. Several seeds are improved side by side.

A fall takes about as long as a window. So that no window is improved into a fall which the next
can no longer prevent, its prefix reaches further than its changes do: for some frames more the
controller acts alone (`lookahead`), and these frames count too.

Frames of another script can be kept. Those from the first on are simply what a search goes on from.
Of later ones what is done is fixed: it has no gradient. The states that they begin from
cannot be, since they follow from what is done before; how far bodies are from where they were costs
`APART` a unit, so a descent leads there as well as it can.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from i2pdsl.errors import error, whole_file
from i2pdsl.language.story import SearchPlan
from i2pdsl.objective.compile import Params
from i2pdsl.objective.fold import Objective
from i2pdsl.objective.frame import Frame
from i2pdsl.programs import Program, compiled_program, on_devices
from i2pdsl.search.beam import prepared
from i2pdsl.search.minimise import minimise
from i2pdsl.search.rollout import Node, follow, resume, root
from i2pdsl.worlds.record import Kept, Trajectory, empty
from i2pdsl.worlds.world import World

Array = Any

# A frame and seed of a window takes 40 KB while its gradient is computed; 10 KB if what its frames
# compute is computed again on the way back, which takes a third longer.
REMEMBERED_FRAMES = 20_000
MOST_FRAMES = 500_000
# Frames of all seeds, windows and steps below which it takes longer to compile well than it saves.
BRIEF_FRAMES = 10_000


APART = 100.0  # what a unit's distance from where a kept frame was costs, of the score


class _Kept(NamedTuple):
    """Frames that are kept, of N frames and one more (the start), padded.

    Attributes:
        fixed: [N] whether what is done in the frame after each is kept, and `actions` [N, m] it.
        wanted: [N] whether the positions after each are.
        positions: [N, n] the positions.
    """

    fixed: Array
    actions: Array
    wanted: Array
    positions: Array


@dataclass(frozen=True)
class _Window:
    """How many frames a window has, how many of them stay, and how many follow that count too."""

    length: int
    stride: int
    lookahead: int


@dataclass(frozen=True)
class Descended:
    """What was found, S seeds side by side.

    Attributes:
        actions: [S, T, 6].
        states: [S, T + 1, 76]: rollouts are chaotic, these are the ones that were improved.
        finished: whether all windows were improved; the rest is the controller's own.
        compile_seconds: time spent on tracing and compiling.
    """

    actions: np.ndarray
    states: np.ndarray
    finished: bool
    compile_seconds: float


def descend(
    world: World,
    objective: Objective,
    length: int,
    plan: SearchPlan,
    seed: int,
    report: Callable[[int, int], None] | None = None,
    say: Callable[[str], None] | None = None,
    so_far: Trajectory | None = None,
    frames: int | None = None,
    start: np.ndarray | None = None,
    kept: Kept | None = None,
) -> Descended:
    """Searches from the controller's own motion and `plan.noise`. Ctrl-C ends it early with what
    was found: the rest of the script is then the controller's own motion.

    Args:
        report: called with (windows done, all windows).
        say: is told of damaged caches, and of gradients that were not finite.
        so_far: a script to go on from, instead of the first state; it is part of what is returned.
        frames: how many to add to it; without it, all that are missing.
        start: the first state, unless there is a script; usually the first that there is.
        kept: frames of a script to keep; instead of `so_far`.

    Raises KeyboardInterrupt if it is interrupted before anything was found, StoryError where the
    plan needs too much memory.
    """
    so_far = so_far or (None if kept is None else _prefix(kept))
    ready = prepare_descent(world, objective, length, plan, say, so_far, start, kept)
    window, stride = ready.window.length, ready.window.stride
    done = 0 if so_far is None else len(so_far.actions)
    end = length if frames is None else min(length, done + frames)
    windows = max(0, math.ceil((end - done - window) / stride)) + 1
    begun = so_far or empty(world, _first(world, start))
    guesses = world.guesses(length + window, plan.seeds, plan.noise, seed, begun.states[-1])
    changes = guesses.astype(np.float32)
    nodes, guess = ready.nodes, changes[:, :window]
    actions = [np.repeat(begun.actions[None].astype(np.float32), plan.seeds, axis=0)]
    states = [np.repeat(begun.states[None].astype(np.float32), plan.seeds, axis=0)]
    spoilt, finished = 0, True
    try:
        for number in range(windows):
            # All of it comes back at once, so an interrupt loses a window, never half of one.
            nodes, better, more, bad = ready.improve(nodes, guess)
            first = number * stride
            stays = min(end - done - first, window) if number == windows - 1 else stride
            # Both at once: an interrupt finds as many actions as states.
            actions, states = [*actions, better[:, :stays]], [*states, more[:, :stays]]
            fresh = changes[:, first + window : first + window + stride]
            guess = np.concatenate([better[:, stride:], fresh], axis=1)
            spoilt += int(bad.sum())
            if report is not None:
                report(number + 1, windows)
    except KeyboardInterrupt:
        if len(actions) == 1:
            raise
        finished = False
        made = sum(part.shape[1] for part in actions)
        ahead = guess[:, : min(window - stride, end - made)]
        coasted = _coast(world, end, _joined(actions), _joined(states), ahead)
        actions, states = [coasted[0]], [coasted[1]]
    if spoilt and say is not None:
        say(f"{spoilt} gradients were not finite; those steps were left out")
    return Descended(_joined(actions), _joined(states), finished, ready.seconds)


def _joined(parts: list[np.ndarray]) -> np.ndarray:
    return np.concatenate(parts, axis=1)


@dataclass(frozen=True)
class Descent:
    """A descent that is ready to run: `program` of the tables, parameters, knobs, what is kept (or
    None), and on each device its share of the nodes (where all seeds are) and of the changes that a
    window begins with.

    `seconds` is the time spent on tracing and compiling.
    """

    program: Program
    tables: Any
    params: Params
    knobs: Array
    kept: _Kept | None
    nodes: Node
    window: _Window
    devices: int
    seconds: float

    def improve(self, nodes: Node, guess: np.ndarray) -> tuple[Node, np.ndarray, Any, Any]:
        """The nodes after a window, its changes and states, and how many gradients were not
        finite: of each seed."""
        shares = _shared_out((nodes, guess), self.devices)
        fixed = (self.tables, self.params, self.knobs, self.kept)
        found = jax.device_get(self.program.run(*fixed, *shares))
        joined: tuple[Node, np.ndarray, Any, Any] = jax.tree.map(
            lambda part: part.reshape(part.shape[0] * part.shape[1], *part.shape[2:]), found
        )
        return joined


def _shared_out(arrays: Any, devices: int) -> Any:
    """Arrays of all seeds [S, ...], as each device has its own: [D, S / D, ...]."""
    # An array of no numbers (a fold without sums) has no -1 to be told from them.
    apart = lambda part: part.reshape(devices, len(part) // devices, *part.shape[1:])
    return jax.tree.map(apart, arrays)


def prepare_descent(
    world: World,
    objective: Objective,
    length: int,
    plan: SearchPlan,
    say: Callable[[str], None] | None = None,
    so_far: Trajectory | None = None,
    start: np.ndarray | None = None,
    kept: Kept | None = None,
) -> Descent:
    """Compiles the improvement of one window, or finds it in the cache.

    Raises StoryError where the plan needs too much memory.
    """
    window = min(plan.window, length)
    lookahead = min(plan.lookahead, length - window)
    stride = max(1, round(window * (1 - plan.overlap)))
    shape = _Window(window, stride, lookahead)
    seen = window + lookahead
    if plan.seeds * seen * len(world.log_prior(world.tables)) > MOST_FRAMES:
        message = f"{plan.seeds} seeds of {seen} frames are too many to improve at once"
        hint = "take fewer seeds, or a shorter window or lookahead"
        raise error("search", message, whole_file("search"), hint)
    tables = world.search_tables
    knobs = np.array([plan.rate, plan.damping], np.float32)
    devices = max(n for n in range(1, len(jax.devices()) + 1) if plan.seeds % n == 0)
    each = plan.seeds // devices
    began = time.perf_counter()
    params = prepared(world, objective, say)
    nodes = _roots(world, objective, length, tables, params, so_far, start, plan.seeds)
    bound = None if math.isinf(plan.bound) else plan.bound
    how = (plan.optimiser, plan.steps, bound)

    def improve(*given: Any) -> Any:
        tables, params, knobs, kept, nodes, guess = given
        one = partial(
            _improve, world, objective, length, shape, how, each, tables, params, knobs, kept
        )
        return jax.vmap(one)(nodes, guess)

    rules = world.program_key(())
    key = ("descent", objective.shape, rules, length, shape, plan.steps, plan.optimiser, bound)
    guess = np.zeros((plan.seeds, window, *world.action_shape), np.float32)
    to_keep = None if kept is None else _to_keep(kept, length + seen)
    arguments = (tables, params, knobs, to_keep, *_shared_out((nodes, guess), devices))
    work = plan.seeds * seen * plan.steps * (1 + max(0, length - window) // stride)
    brief = work < BRIEF_FRAMES
    result = (nodes, 0, 0, 0)
    program = compiled_program(key, improve, arguments, result, say, brief, apart=(4, 5))
    tables, params, knobs, to_keep = on_devices((tables, params, knobs, to_keep), devices)
    spent = time.perf_counter() - began
    return Descent(program, tables, params, knobs, to_keep, nodes, shape, devices, spent)


def _prefix(kept: Kept) -> Trajectory | None:
    """The frames that are kept from the first on."""
    first, last = kept.runs[0]
    if first > 1:
        return None
    return Trajectory(kept.path.actions[:last], kept.path.states[: last + 1])


def _to_keep(kept: Kept, size: int) -> _Kept:
    states = kept.path.states
    fixed, wanted = np.zeros(size, bool), np.zeros(size, bool)
    actions = np.zeros((size, kept.path.actions.shape[1]), np.float32)
    positions = np.zeros((size, states.shape[1] // 2), np.float32)
    for frame in kept.frames:
        actions[frame - 1] = kept.path.actions[frame - 1]
        fixed[frame - 1] = wanted[frame - 1] = wanted[frame] = True
        for number in (frame - 1, frame):
            positions[number] = _positions(states[number])
    return _Kept(fixed, actions, wanted, positions)


def _positions(state: Array) -> Array:
    """Of bodies; their velocities are the other half of a state."""
    return state[..., : state.shape[-1] // 2]


def apart(kept: Kept, states: np.ndarray) -> np.ndarray:
    """How far bodies are at most from where kept frames have them, of scripts [S, T + 1, n]: the
    mean over coordinates."""
    numbers = sorted({number for frame in kept.frames for number in (frame - 1, frame)})
    away = _positions(states)[:, numbers] - _positions(kept.path.states)[numbers]
    found: np.ndarray = np.abs(away).mean(-1).max(-1)
    return found


def _coast(
    world: World, length: int, actions: np.ndarray, states: np.ndarray, ahead: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The rest of a script: what is improved already `ahead`, then the controller alone."""
    missing = length - actions.shape[1] - ahead.shape[1]
    rest = np.pad(ahead, ((0, 0), (0, missing), (0, 0)))
    found = [states]
    for t in range(rest.shape[1]):
        after = world.transition(world.tables, found[-1][:, -1].astype(float), rest[:, t])
        found.append(after[:, None].astype(states.dtype))
    return np.concatenate([actions, rest], axis=1), np.concatenate(found, axis=1)


def _roots(
    world: World,
    objective: Objective,
    length: int,
    tables: Any,
    params: Any,
    so_far: Trajectory | None,
    start: np.ndarray | None,
    count: int,
) -> Node:
    """Where all seeds begin: the empty script, or the one that is there already."""
    if so_far is None:
        first = _first(world, start).astype(np.float32)
        node = jax.jit(lambda state: root(world, objective, tables, params, state))(first)
    else:
        node = resume(world, objective, length, tables, params, so_far)
    return jax.tree.map(lambda part: np.repeat(np.asarray(part)[None], count, axis=0), node)


def _first(world: World, start: np.ndarray | None) -> np.ndarray:
    state: np.ndarray = world.starts()[0] if start is None else start
    return state


def _improve(
    world: World,
    objective: Objective,
    length: int,
    window: _Window,
    how: tuple[str, int, float | None],
    seeds: int,
    tables: Any,
    params: Any,
    knobs: Array,
    kept: _Kept | None,
    node: Node,
    changes: Array,
) -> tuple[Node, Array, Array, Array]:
    """One window of one seed.

    Args:
        kept: what is kept, of all frames.
        node: where the window begins.
        changes: [W, 6], what its optimisation begins with.

    Returns: the node after the frames that stay, the changes, the states after each frame [W, 76],
        and the number of gradients that were not finite.
    """
    rate, damping = knobs
    optimiser, steps, bound = how

    # The last windows can reach beyond the story's end.
    staying = jnp.minimum(node.number + window.stride, length)

    Carry = tuple[Node, Frame, Node]

    def frame(carry: Carry, change: Array) -> tuple[Carry, Array]:
        node, last, middle = carry
        damped = damping * node.state + jax.lax.stop_gradient((1 - damping) * node.state)
        seen = node._replace(state=damped)
        after, now = follow(world, objective, tables, params, seen, change)
        live = node.number < length
        after, now = jax.tree.map(lambda a, b: jnp.where(live, a, b), (after, now), (node, last))
        stays = after.number == staying
        middle = jax.tree.map(lambda a, b: jnp.where(stays, a, b), after, middle)
        return (after, now, jax.lax.stop_gradient(middle)), after.state

    if (window.length + window.lookahead) * seeds > REMEMBERED_FRAMES:
        frame = jax.checkpoint(frame)
    shapes = jax.eval_shape(lambda: follow(world, objective, tables, params, node, changes[0]))
    nothing = jax.tree.map(lambda s: jnp.zeros(s.shape, s.dtype), shapes[1])

    def missed(begin: Array, states: Array) -> Array:
        """What it costs to be elsewhere than kept frames are, from frame `begin` + 1 on."""
        if kept is None:
            return jnp.zeros(())
        numbers = begin + 1 + jnp.arange(states.shape[0])
        near = jnp.minimum(numbers, length)
        away = jnp.abs(_positions(states) - kept.positions[near]).mean(-1)
        return APART * jnp.where(kept.wanted[near] & (numbers <= length), away, 0.0).sum()

    def with_kept(first: Array, changes: Array) -> Array:
        """What is done from a frame on, where some of it is kept."""
        if kept is None:
            return changes
        at = first + jnp.arange(changes.shape[0])
        return jnp.where(kept.fixed[at][:, None], kept.actions[at], changes)

    alone = jnp.zeros((window.lookahead, *world.action_shape), changes.dtype)
    alone = with_kept(node.number + window.length, alone)
    changes = with_kept(node.number, changes)

    def loss(changes: Array) -> tuple[Array, tuple[Node, Array]]:
        both = jnp.concatenate([with_kept(node.number, changes), alone])
        (end, last, middle), states = jax.lax.scan(frame, (node, nothing, node), both)
        total = missed(node.number, states) - objective.score(tables, params, end.carry, last)
        return total, (middle, states)

    best, (middle, states), spoilt = minimise(loss, changes, optimiser, steps, rate, bound)
    return middle, best, states[: window.length], spoilt
