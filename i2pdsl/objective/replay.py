"""What viewers believe of a finished script, frame by frame, in NumPy and doubles."""

from __future__ import annotations

from typing import Any

import numpy as np

from i2pdsl.audience.filter import update
from i2pdsl.language import typed as ty
from i2pdsl.objective.appended import append_turns, with_suffix
from i2pdsl.objective.frame import Frame
from i2pdsl.worlds.world import World

History = tuple[Frame, Any]


def replay(
    world: World,
    states: np.ndarray,
    actions: np.ndarray,
    rows: tuple[np.ndarray, ...] | None = None,
) -> Frame:
    """All frames of a script along the first axis, frame 0 being the start.

    Args:
        states: [T + 1, ...], actions: [T, ...], as the world has them; T may be 0.
        rows: the world's `log_rows` of them, if they are known already.
    """
    tables = world.tables
    if len(actions):
        seen_there = (tables, states[:-1], actions, states[1:])
        best = world.best_rows(*seen_there) if rows is None else ()
        rows = rows or world.log_rows(*seen_there)
    elif rows is None:  # nothing has happened yet, but what is observed has its shape
        still = world.log_rows(tables, states, world.no_action(states), states)
        rows, best = tuple(row[:0] for row in still), ()
    seen = world.is_observed(actions)
    forgetting = world.forgetting(tables)
    belief = world.log_prior(tables)
    beliefs, expecting = [belief], [np.stack([np.zeros_like(belief)] * len(rows))]
    for t in range(len(actions)):
        before = []
        for row in rows:
            before.append(belief)
            if seen[t]:
                belief = update(belief, row[t], forgetting)
        beliefs.append(belief)
        expecting.append(np.stack(before))
    likelihoods = np.stack(rows, axis=1)
    regrets = np.stack(best or rows, axis=1) - likelihoods
    first = np.zeros((1, *likelihoods.shape[1:]))
    return Frame(
        number=np.arange(len(states)),
        before=np.concatenate([states[:1], states[:-1]]),
        action=np.concatenate([world.no_action(states[:1]), actions]),
        state=states,
        previous=np.stack([beliefs[0], *beliefs[:-1]]),
        belief=np.stack(beliefs),
        expecting=np.stack(expecting),
        log_rows=np.concatenate([first, likelihoods]),
        regrets=np.concatenate([first, regrets]),
    )


def histories(
    world: World, tables: Any, frames: Frame, expression: ty.Typed
) -> dict[tuple[ty.Turn, ...], History]:
    """The script's history, and those of all scripts that an expression appends turns to."""
    xp = frames.belief.__array_namespace__()
    found: dict[tuple[ty.Turn, ...], History] = {(): (frames, xp.ones(len(frames.state), bool))}
    last = Frame(*(part[-1] for part in frames))
    for node in ty.walk(expression):
        if isinstance(node, ty.Moment) and node.turns not in found:
            suffix = append_turns(world, tables, node.turns, last)
            found[node.turns] = with_suffix(xp, frames, suffix)
    return found


def evaluate(world: World, frames: Frame, expression: ty.Typed, times: range | None) -> Any:
    """The value of a checked expression over a finished script.

    A number, an array [n_t] over `times`, or with a last axis of values for a distribution.
    """
    from i2pdsl.objective.compile import Compiler, evaluate_all, reduce_over_history

    length = len(frames.state) - 1
    compiler = Compiler(world, length)
    compiler.on_reduction = reduce_over_history(compiler)
    closure = compiler.build(expression)
    turns = histories(world, world.tables, frames, expression)
    value = evaluate_all(compiler, closure, world.tables, turns, times)
    return (
        np.broadcast_to(value, (len(times), *np.shape(value)[1:])) if times is not None else value
    )
