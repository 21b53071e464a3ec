"""Gradient descent over what is added to a controller's actuation (paper, section 3.3).

The gradient of a long rollout grows without bound, so a script is improved window by window: each
is optimised for the objective of the prefix that it completes, and the next goes on from where it
ends, with its state, belief and fold. Several seeds are improved side by side.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from i2pdsl.errors import error, whole_file
from i2pdsl.language.story import SearchPlan
from i2pdsl.objective.fold import Objective
from i2pdsl.objective.frame import Frame
from i2pdsl.search.beam import prepared, single_precision
from i2pdsl.search.minimise import minimise
from i2pdsl.search.programs import compiled_program
from i2pdsl.search.rollout import Node, follow, root
from i2pdsl.worlds.hill.hopper import MUSCLE_COUNT
from i2pdsl.worlds.hill.world import HillWorld

Array = Any

# A frame and seed of a window takes 40 KB while its gradient is computed; 10 KB if what its frames
# compute is computed again on the way back, which takes a third longer.
REMEMBERED_FRAMES = 20_000
MOST_FRAMES = 500_000


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
    world: HillWorld,
    objective: Objective,
    length: int,
    plan: SearchPlan,
    seed: int,
    report: Callable[[int, int], None] | None = None,
    say: Callable[[str], None] | None = None,
) -> Descended:
    """Searches from the controller's own motion and `plan.noise`. Ctrl-C ends it early with what
    was found: the rest of the script is then the controller's own motion.

    Args:
        report: called with (windows done, all windows).
        say: is told of damaged caches, and of gradients that were not finite.

    Raises KeyboardInterrupt if it is interrupted before anything was found, StoryError where the
    plan needs too much memory.
    """
    window = min(plan.window, length)
    at_once = plan.seeds * window * len(world.tables.sigma)
    if at_once > MOST_FRAMES:
        message = f"{plan.seeds} seeds of {window} frames are too many to improve at once"
        raise error("search", message, whole_file("search"), "take fewer seeds or a shorter window")
    stride = max(1, round(window * (1 - plan.overlap)))
    windows = max(0, math.ceil((length - window) / stride)) + 1
    tables = single_precision(world)
    knobs = jnp.asarray([plan.rate, plan.damping], jnp.float32)
    began = time.perf_counter()
    params = prepared(world, objective, tables)
    nodes = _roots(world, objective, tables, params, plan.seeds)
    noise = np.random.default_rng(seed).normal(size=(plan.seeds, length + window, MUSCLE_COUNT))
    changes = (plan.noise * noise).astype(np.float32)
    guess = changes[:, :window]
    arguments = (tables, params, knobs, nodes, guess)
    improve = _compiled(world, objective, length, window, stride, plan, arguments, say)
    compile_seconds = time.perf_counter() - began
    actions = np.zeros((plan.seeds, 0, MUSCLE_COUNT), np.float32)
    states = np.asarray(nodes.state)[:, None]
    spoilt, finished = 0, True
    try:
        for number in range(windows):
            # All of it comes back at once, so an interrupt loses a window, never half of one.
            nodes, better, more, bad = jax.device_get(improve(tables, params, knobs, nodes, guess))
            first = number * stride
            kept = min(length - first, window) if number == windows - 1 else stride
            longer = np.concatenate([actions, better[:, :kept]], axis=1)
            actions, states = longer, np.concatenate([states, more[:, :kept]], axis=1)
            fresh = changes[:, first + window : first + window + stride]
            guess = np.concatenate([better[:, stride:], fresh], axis=1)
            spoilt += int(bad.sum())
            if report is not None:
                report(number + 1, windows)
    except KeyboardInterrupt:
        if actions.shape[1] == 0:
            raise
        finished = False
        ahead = guess[:, : min(window - stride, length - actions.shape[1])]
        actions, states = _coast(world, length, actions, states, ahead)
    if spoilt and say is not None:
        say(f"{spoilt} gradients were not finite; those steps were left out")
    return Descended(actions, states, finished, compile_seconds)


def _coast(
    world: HillWorld, length: int, actions: np.ndarray, states: np.ndarray, ahead: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The rest of a script: what is improved already `ahead`, then the controller alone."""
    missing = length - actions.shape[1] - ahead.shape[1]
    rest = np.pad(ahead, ((0, 0), (0, missing), (0, 0)))
    found = [states]
    for t in range(rest.shape[1]):
        after = world.transition(world.tables, found[-1][:, -1].astype(float), rest[:, t])
        found.append(after[:, None].astype(states.dtype))
    return np.concatenate([actions, rest], axis=1), np.concatenate(found, axis=1)


def _roots(world: HillWorld, objective: Objective, tables: Any, params: Any, count: int) -> Node:
    """The empty scripts of all seeds."""
    start = jnp.asarray(np.repeat(world.starts(None), count, axis=0), jnp.float32)
    return jax.jit(jax.vmap(lambda state: root(world, objective, tables, params, state)))(start)


_programs: dict[tuple[Any, ...], Any] = {}


def _compiled(
    world: HillWorld,
    objective: Objective,
    length: int,
    window: int,
    stride: int,
    plan: SearchPlan,
    arguments: tuple[Any, ...],
    say: Callable[[str], None] | None,
) -> Callable[..., Any]:
    """The compiled improvement of one window: one for each shape of story, world and plan."""
    leaves, structure = jax.tree.flatten(arguments)
    shapes = tuple((a.shape, str(a.dtype)) for a in leaves)
    bound = None if math.isinf(plan.bound) else plan.bound
    key = (objective.shape, length, window, stride, plan.steps, plan.optimiser, bound, shapes)
    if key not in _programs:

        def improve(*flat: Array) -> list[Array]:
            tables, params, knobs, nodes, guess = jax.tree.unflatten(structure, flat)

            def one(node: Node, changes: Array) -> Any:
                steps = (plan.optimiser, plan.steps, bound)
                return _improve(
                    world,
                    objective,
                    length,
                    stride,
                    steps,
                    plan.seeds,
                    tables,
                    params,
                    knobs,
                    node,
                    changes,
                )

            return jax.tree.leaves(jax.vmap(one)(nodes, guess))

        _programs[key] = compiled_program(f"descent {key!r}", improve, leaves, say)
    program = _programs[key]
    result = jax.tree.structure((arguments[3], 0, 0, 0))
    return lambda *given: jax.tree.unflatten(result, program(*jax.tree.leaves(given)))


def _improve(
    world: HillWorld,
    objective: Objective,
    length: int,
    stride: int,
    how: tuple[str, int, float | None],
    seeds: int,
    tables: Any,
    params: Any,
    knobs: Array,
    node: Node,
    changes: Array,
) -> tuple[Node, Array, Array, Array]:
    """One window of one seed.

    Args:
        node: where the window begins.
        changes: [W, 6], what its optimisation begins with.

    Returns: the node after `stride` frames, the changes, the states after each frame [W, 76], and
        the number of gradients that were not finite.
    """
    rate, damping = knobs
    optimiser, steps, bound = how

    def frame(carry: tuple[Node, Frame], change: Array) -> tuple[tuple[Node, Frame], Array]:
        node, _ = carry
        damped = damping * node.state + jax.lax.stop_gradient((1 - damping) * node.state)
        seen = node._replace(state=damped)
        after, now = follow(world, objective, tables, params, seen, change)
        # The last window can reach beyond the story's end.
        live = node.number < length
        after, now = jax.tree.map(lambda a, b: jnp.where(live, a, b), (after, now), carry)
        return (after, now), after.state

    if changes.shape[0] * seeds > REMEMBERED_FRAMES:
        frame = jax.checkpoint(frame)
    shapes = jax.eval_shape(lambda: follow(world, objective, tables, params, node, changes[0]))
    nothing = jax.tree.map(lambda s: jnp.zeros(s.shape, s.dtype), shapes[1])

    def loss(changes: Array) -> Array:
        (end, last), _ = jax.lax.scan(frame, (node, nothing), changes)
        return -objective.score(tables, params, end.carry, last)

    best, spoilt = minimise(loss, changes, optimiser, steps, rate, bound)
    middle, first = jax.lax.scan(frame, (node, nothing), best[:stride])
    _, rest = jax.lax.scan(frame, middle, best[stride:])
    return middle[0], best, jnp.concatenate([first, rest]), spoilt
