"""What viewers believe of a finished script, frame by frame, in NumPy and doubles."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from i2pdsl.audience.filter import share_after, spread_of
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
    within: bool = True,
) -> Frame:
    """All frames of N scripts of one length, [N, T + 1, ...]; see `replay`.

    Args:
        states: [N, T + 1, ...], actions: [N, T, ...].
        rows: [N, T, O, H] each.
        regret: whether anybody asks for it.
        within: whether anybody asks for what is believed and expected within frames (looks.py);
            else there may be none of it.
    """
    tables = world.tables
    count, length = actions.shape[:2]
    before, later = states[:, :-1], states[:, 1:]
    best: tuple[np.ndarray, ...] = ()
    if length:
        seen_there = (tables, *map(_side_by_side, (before, actions, later)))
        apart = lambda row: row.reshape(length, count, *row.shape[1:])
        if rows is None and regret:
            best = tuple(map(apart, world.best_rows(*seen_there)))
        if rows is None:
            rows = tuple(map(apart, world.log_rows(*seen_there)))
        else:
            rows = tuple(np.moveaxis(row, 1, 0) for row in rows)
    else:  # nothing has happened yet, but what is observed has its shape
        first = states[:, 0]
        still = world.log_rows(tables, first, world.no_action(first), first)
        rows = tuple(row[None][:0] for row in still)
    seen = np.moveaxis(world.is_observed(actions), 1, 0)
    if world.keeps_doubt and world.lists_hypotheses:
        followed = _as_shares(world, seen, rows, within or regret)
    else:
        followed = _as_logs(world, seen, rows, best)
    beliefs, expecting, likelihoods, odd, holdings = followed
    frames = Frame(
        number=np.broadcast_to(np.arange(length + 1), (count, length + 1)),
        before=np.concatenate([states[:, :1], before], axis=1),
        action=np.concatenate([world.no_action(states[:, :1]), actions], axis=1),
        state=states,
        log_previous=beliefs[:, :-1],
        log_belief=beliefs[:, 1:],
        log_expecting=expecting,
        log_rows=likelihoods,
        regret=odd,
        holdings=holdings,
    )
    if best and world.lists_hypotheses:
        seen_by = Belief(frames.log_afterwards[:, 1:])
        with np.errstate(invalid="ignore"):  # of who thinks that nobody is rational: nan
            regret_of = np.moveaxis(np.stack(best, axis=2), 1, 0) - likelihoods[:, 1:]
            odd[:, 1:] = seen_by.regret(world, tables, 0, regret_of).sum(2)
    return frames


Followed = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, tuple[Any, ...]]
"""What is believed of N scripts of T frames: the beliefs before frame 0 (the prior) and after each,
[N, T + 2, O, H], before each observation, and what each was like, [N, T + 1, U, O, H] each, how odd
it was, [N, T + 1, O], and what is held instead of all hypotheses."""


def _begun(
    world: World, seen: np.ndarray, observations: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Room for all but the last; frame 0 is there."""
    (length, count), prior = seen.shape, world.log_prior(world.tables)
    room = lambda frames, *own: np.empty((count, frames, *own, *prior.shape))
    beliefs, expecting = room(length + 2), room(length + 1, observations)
    likelihoods = room(length + 1, observations)
    beliefs[:, :2], expecting[:, 0], likelihoods[:, 0] = prior, 0.0, 0.0
    return beliefs, expecting, likelihoods, np.zeros((count, length + 1, *prior.shape[:-1]))


def _as_shares(
    world: World, seen: np.ndarray, rows: tuple[np.ndarray, ...], within: bool
) -> Followed:
    """Beliefs of viewers who forget, followed as probabilities: none that is not 0 from the start
    gets too small for a double, and it takes a third of the time."""
    parts = _begun(world, seen, len(rows) if within else 0)
    beliefs, expecting, likelihoods, _ = parts
    spread = spread_of(world.forgetting(world.tables), beliefs.shape[-1])
    everywhere = seen.all()
    share = np.exp(beliefs[:, 0])
    # By what is likeliest of what somebody thinks possible: of the rest nothing is left.
    possible = share > 0
    held = rows if possible.all() else [np.where(possible, row, -np.inf) for row in rows]
    likely = [np.exp(row - row.max(-1, keepdims=True)) for row in held]
    for t, happens in enumerate(seen[..., None, None], 1):
        for u, row in enumerate(rows):
            if within:
                likelihoods[:, t, u], expecting[:, t, u] = row[t - 1], share
            after = share_after(share, likely[u][t - 1], spread)
            share = after if everywhere else np.where(happens, after, share)
        beliefs[:, t + 1] = share
    with np.errstate(divide="ignore"):
        for part in (beliefs[:, 2:], expecting[:, 1:]):
            np.log(part, out=part)
    return *parts, ()


def _as_logs(
    world: World, seen: np.ndarray, rows: tuple[np.ndarray, ...], best: tuple[np.ndarray, ...]
) -> Followed:
    """Beliefs of any viewers, in logs, and what they hold instead of all hypotheses."""
    beliefs, expecting, likelihoods, odd = _begun(world, seen, len(rows))
    tables = world.tables
    given = world.holdings(tables)
    many = lambda part: np.broadcast_to(part, (seen.shape[1], *np.shape(part)))
    start = first_belief(world, tables)
    belief = start.map(many)._replace(holdings=tuple(s.each(many) for s in start.holdings))
    holdings = [belief.holdings]
    beliefs[:, :2] = belief.log[:, None]
    for t, happens in enumerate(seen, 1):
        belief = belief.shown(given)
        for u, row in enumerate(rows):
            expecting[:, t, u] = belief.log
            likelihoods[:, t, u] = belief.likely(world, tables, u, row[t - 1])
            if happens.any():
                after = belief.seeing(world, tables, u, row[t - 1])
                belief = after if happens.all() else after.where(happens, belief)
            if best and not world.lists_hypotheses:
                odd[:, t] += belief.regret(world, tables, u, best[u][t - 1] - row[t - 1])
        if belief.holdings:
            belief = belief.over(given).where(happens, belief)
        holdings.append(belief.holdings)
        beliefs[:, t + 1] = belief.log
    together = lambda *part: np.stack(part, axis=1)
    each = (parts[0].each(together, *parts[1:]) for parts in zip(*holdings, strict=True))
    return beliefs, expecting, likelihoods, odd, tuple(each)


def _side_by_side(part: np.ndarray) -> np.ndarray:
    """[N, T, ...] as [T N, ...]: the worlds take one leading axis fastest."""
    return np.moveaxis(part, 1, 0).reshape(-1, *part.shape[2:])


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
