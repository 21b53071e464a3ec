"""What viewers believe of a finished script, frame by frame, in NumPy and doubles."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from i2pdsl.language import typed as ty
from i2pdsl.objective.appended import append_turns, with_suffix
from i2pdsl.objective.belief import Belief, first_belief
from i2pdsl.objective.frame import Frame
from i2pdsl.worlds.record import Trajectory
from i2pdsl.worlds.world import World

History = tuple[Frame, Any]

TOGETHER = 2_000  # frames of several scripts that are computed side by side


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
    known = None if rows is None else tuple(row[None] for row in rows)
    return replay_all(world, states[None], actions[None], known).at(0)


def replay_many(
    world: World,
    paths: Sequence[Trajectory],
    rows: Sequence[tuple[np.ndarray, ...]] | None = None,
) -> list[Frame]:
    """What `replay` says of each of several scripts of one length, computed side by side.

    Args:
        rows: of each script the world's `log_rows`, if they are known already.
    """
    found: list[Frame] = []
    many = max(1, TOGETHER // len(paths[0].states)) if paths else 1
    for first in range(0, len(paths), many):
        some = paths[first : first + many]
        parts = None if rows is None else zip(*rows[first : first + many], strict=True)
        known = None if parts is None else tuple(map(np.stack, parts))
        states = np.stack([path.states for path in some])
        actions = np.stack([path.actions for path in some])
        frames = replay_all(world, states, actions, known)
        found += [frames.at(number) for number in range(len(some))]
    return found


def replay_all(
    world: World,
    states: np.ndarray,
    actions: np.ndarray,
    rows: tuple[np.ndarray, ...] | None = None,
    regret: bool = True,
) -> Frame:
    """All frames of N scripts of one length, [N, T + 1, ...]; see `replay`.

    Args:
        states: [N, T + 1, ...], actions: [N, T, ...].
        rows: [N, T, O, H] each.
        regret: whether anybody asks for it.
    """
    tables = world.tables
    count, length = actions.shape[:2]
    before, later = states[:, :-1], states[:, 1:]
    best: tuple[np.ndarray, ...] = ()
    if length:
        flat = (_side_by_side(part) for part in (before, actions, later))
        seen_there = (tables, *flat)
        apart = lambda row: row.reshape(count, length, *row.shape[1:])
        if rows is None and regret:
            best = tuple(map(apart, world.best_rows(*seen_there)))
        rows = rows or tuple(map(apart, world.log_rows(*seen_there)))
    elif rows is None:  # nothing has happened yet, but what is observed has its shape
        first = states[:, 0]
        still = world.log_rows(tables, first, world.no_action(first), first)
        rows = tuple(row[:, None][:, :0] for row in still)
    seen = world.is_observed(actions)
    given, prior = world.holdings(tables), world.log_prior(tables)
    many = lambda part: np.broadcast_to(part, (count, *np.shape(part)))
    start = first_belief(world, tables)
    belief = start.map(many)._replace(holdings=tuple(s.each(many) for s in start.holdings))
    found, expecting = [belief], [np.stack([np.zeros_like(belief.log)] * len(rows), axis=1)]
    odd = np.zeros((count, length + 1, *prior.shape[:-1]))
    shown: list[list[np.ndarray]] = [[] for _ in rows]
    for t in range(length):
        earlier, happens = [], seen[:, t]
        belief = belief.shown(given)
        for u, row in enumerate(rows):
            earlier.append(belief.log)
            if not world.lists_hypotheses:
                shown[u].append(belief.likely(world, tables, u, row[:, t]))
            if happens.any():
                after = belief.seeing(world, tables, u, row[:, t])
                belief = after if happens.all() else after.where(happens, belief)
            if best and not world.lists_hypotheses:
                odd[:, t + 1] += belief.regret(world, tables, u, best[u][:, t] - row[:, t])
        if belief.holdings:
            belief = belief.over(given).where(happens, belief)
        found.append(belief)
        expecting.append(np.stack(earlier, axis=1))
    beliefs = [each.log for each in found]
    if not world.lists_hypotheses:
        none = np.zeros((count, 0, *prior.shape))
        rows = tuple(np.stack(each, axis=1) if length else none for each in shown)
    likelihoods = np.stack(rows, axis=2)
    nothing = np.zeros((count, 1, *likelihoods.shape[2:]))
    frames = Frame(
        number=np.broadcast_to(np.arange(length + 1), (count, length + 1)),
        before=np.concatenate([states[:, :1], before], axis=1),
        action=np.concatenate([world.no_action(states[:, :1]), actions], axis=1),
        state=states,
        log_previous=np.stack([beliefs[0], *beliefs[:-1]], axis=1),
        log_belief=np.stack(beliefs, axis=1),
        log_expecting=np.stack(expecting, axis=1),
        log_rows=np.concatenate([nothing, likelihoods], axis=1),
        regret=odd,
        holdings=tuple(
            parts[0].each(lambda *part: np.stack(part, axis=1), *parts[1:])
            for parts in zip(*(each.holdings for each in found), strict=True)
        ),
    )
    if best and world.lists_hypotheses:
        seen_by = Belief(frames.log_afterwards[:, 1:])
        with np.errstate(invalid="ignore"):  # of who thinks that nobody is rational: nan
            regret = np.stack(best, axis=2) - likelihoods
            odd[:, 1:] = seen_by.regret(world, tables, 0, regret).sum(2)
    return frames


def _side_by_side(part: np.ndarray) -> np.ndarray:
    """[N, T, ...] as [N T, ...]: the worlds take one leading axis fastest."""
    return part.reshape(-1, *part.shape[2:])


def histories(
    world: World, tables: Any, frames: Frame, expression: ty.Typed
) -> dict[tuple[ty.Turn, ...], History]:
    """The script's history, and those of all scripts that an expression appends turns to."""
    xp = frames.log_belief.__array_namespace__()
    found: dict[tuple[ty.Turn, ...], History] = {(): (frames, xp.ones(len(frames.state), bool))}
    last = frames.at(-1)
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
