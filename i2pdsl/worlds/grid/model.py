"""What moves and what viewers expect in a grid world, as functions of arrays.

Every function takes the tables first and works on NumPy and on JAX arrays alike, with any number
of leading axes on states: queries run in NumPy without compiling, searches in JAX. Shapes:
S states, E entities, C characters, A actions of a character, N cells, O observers, H hypotheses,
F frames of a horizon (1 without).

Where there is a horizon, what is best depends on how many frames are left, and a state's number
says so: it is S times the frame (from 0) plus the number of the arrangement. The last frame goes
on: whatever comes after it is taken as the last one, too.

Where both act `together`, each chooses by the state before the frame. What then happens: the first
of them moves and then the second, unless the first can move only once the second is out of its way.
So one may follow the other, two do not change places, and of two who want a cell the first gets it.

An action of the story is a number: for a turn in which the characters have the outcomes o_1, o_2,
... (an outcome is an action and whether it succeeded) the number with these digits, the last the
lowest; then, for events, `turn_count` + e * slots + cell.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from i2pdsl.worlds.grid import following
from i2pdsl.worlds.grid.arrays import (
    Moves,
    Tables,
    arrangement,
    entries,
    namespace,
)
from i2pdsl.worlds.grid.following import in_frame, joint, successor, successors
from i2pdsl.worlds.grid.policy import (
    by_hypothesis,
    by_problem,
    log_policy,
    log_softmax,
    log_taken,
)
from i2pdsl.worlds.grid.spec import STAY
from i2pdsl.worlds.world import Branches, ByProblem

if TYPE_CHECKING:
    from i2pdsl.worlds.grid.known import Known

Array = Any


def turns(tables: Tables, moves: Moves, state: Array) -> Branches:
    """All joint turns from `state`, with what each hypothesis says of them."""
    if moves.together:
        return _turns_together(tables, moves, state)
    xp = namespace(tables.coordinates)
    here = arrangement(tables, state)
    frame, lead, count = state - here, here.ndim, len(moves.weak)
    # The place after each series of actions that succeed; failing leads where staying does.
    place = here
    effects: list[list[int]] = []
    rows: list[Array] = []
    problems: list[ByProblem | None] = []
    valid: Array = True
    chance: Array = 1.0

    def of_outcomes(array: Array) -> Array:
        """[..., A_1, ..., *more] of actions, as [..., n_1, ..., *more] of outcomes."""
        for axis, effect in enumerate(effects):
            if effect != list(range(array.shape[lead + axis])):  # of those who never fail it is all
                array = array[(slice(None),) * (lead + axis) + (effect,)]
        return array

    def placed(array: Array, more: int = 0) -> Array:
        """With an axis of 1 for each of those who act later, before the last `more` axes."""
        later, at = (1,) * (count - len(effects) - 1), array.ndim - more
        return array.reshape(*array.shape[:at], *later, *array.shape[at:])

    for who in range(count):
        outcomes = moves.outcomes[who]
        landed = successors(tables, who, place)
        seen = place if tables.layer is None else in_frame(frame, place)
        row = of_outcomes(log_policy(tables, who, seen))
        chosen = [a for a, _ in outcomes]
        if moves.weak[who]:
            row = row[..., chosen, :, :]
        if tables.by_problem:
            columns, hypotheses = tables.by_problem[who]
            by = None
            if columns.size:
                known = by_problem(tables, who, seen, columns)
                logs, likely = (placed(of_outcomes(k)[..., chosen, :, :], 2) for k in known)
                by = ByProblem(logs, likely, hypotheses)
            problems.append(by)
        moved = of_outcomes(landed != place[..., None])
        rows.append(placed(row, 2))
        able = xp.stack([moved[..., a] | ok for a, ok in outcomes], axis=-1)
        valid = valid & placed(able)
        chance = chance * placed(_chance(xp, outcomes, moved, tables.success[who]))
        effects.append([a if ok else STAY for a, ok in outcomes])
        place = landed
    end = of_outcomes(place)
    shape = (*here.shape, moves.turn_count)
    return Branches(
        _later(tables, moves, state, end.reshape(shape)),
        xp.broadcast_to(valid, end.shape).reshape(shape),
        tuple(rows),
        xp.broadcast_to(chance, end.shape).reshape(shape),
        tuple(problems),
    )


def _turns_together(tables: Tables, moves: Moves, state: Array) -> Branches:
    """`turns` of two who act together."""
    xp = namespace(tables.coordinates)
    ends, *moved = joint(tables, arrangement(tables, state))
    (acts, done), (acts2, done2) = (zip(*moves.outcomes[who], strict=True) for who in (0, 1))
    acts, acts2 = xp.asarray(acts)[:, None], xp.asarray(acts2)
    done, done2 = xp.asarray(done)[:, None], xp.asarray(done2)
    effect, effect2 = xp.where(done, acts, STAY), xp.where(done2, acts2, STAY)
    # Whether the action of each would move it, with what comes of the other's.
    would = moved[0][..., acts, effect2], moved[1][..., effect, acts2]
    chance = _chance_of(xp, done, would[0], tables.success[0]) * _chance_of(
        xp, done2, would[1], tables.success[1]
    )
    row, row2 = (
        log_policy(tables, who, state)[..., chosen, :, :]
        for who, chosen in enumerate((acts[:, 0], acts2))
    )
    shape = (*state.shape, -1)
    return Branches(
        _later(tables, moves, state, ends[..., effect, effect2].reshape(shape)),
        ((would[0] | done) & (would[1] | done2)).reshape(shape),
        (row[..., :, None, :, :], row2[..., None, :, :, :]),
        chance.reshape(shape),
    )


def _later(tables: Tables, moves: Moves, state: Array, after: Array) -> Array:
    """The states [..., K] of arrangements that a frame from `state` [...] leads to."""
    if tables.layer is None:
        return after
    frame = (state // tables.layer + 1)[..., None]
    return after + tables.layer * namespace(tables.coordinates).minimum(frame, moves.frames - 1)


def endings(tables: Tables, moves: Moves, state: Array) -> Array:
    """The states after each joint turn, [..., K]: `turns` without what anybody expects."""
    xp = namespace(tables.coordinates)
    here = arrangement(tables, xp.asarray(state))
    effects = [
        [action if ok else STAY for action, ok in moves.outcomes[who]]
        for who in range(len(moves.weak))
    ]
    if moves.together:
        ends = joint(tables, here)[0][..., effects[0], :][..., effects[1]]
        ends = ends.reshape(*here.shape, -1)
    else:
        ends = here[..., None]
        for who, acts in enumerate(effects):
            moved = successors(tables, who, ends)[..., acts]
            ends = moved.reshape(*ends.shape[:-1], -1)
    return _later(tables, moves, xp.asarray(state), ends)


def _chance(xp: Any, outcomes: tuple[tuple[int, bool], ...], moved: Array, p: Array) -> Array:
    """Probability of each outcome given its action: 1 where there was nothing to attempt."""
    one = xp.ones_like(p)
    return xp.stack(
        [xp.where(moved[..., a], p if ok else 1 - p, one * ok) for a, ok in outcomes], axis=-1
    )


def _chance_of(xp: Any, done: Array, would: Array, p: Array) -> Array:
    """`_chance`, of outcomes side by side."""
    return xp.where(would, xp.where(done, p, 1 - p), xp.ones_like(p) * done)


def drops(tables: Tables, moves: Moves, state: Array) -> tuple[Array, Array]:
    """The states after each event (every thing onto every cell) and whether it can happen:
    [..., events * slots] (following.py)."""
    after, possible = following.drops(tables, moves, state)
    return _later(tables, moves, state, after), possible


def transition(tables: Tables, moves: Moves, state: Array, action: Array) -> Array:
    """The state after an action of the story (chance outcomes are part of the action)."""
    return _transition(tables, moves, state, action, steps(tables, moves, state, action)[1])


def _transition(tables: Tables, moves: Moves, state: Array, action: Array, after: Array) -> Array:
    """`transition`, given the arrangement after a turn."""
    xp = namespace(tables.coordinates)
    if tables.layer is not None:
        after = _later(tables, moves, state, after[..., None])[..., 0]
    if not moves.events:
        return after
    fallen, _ = drops(tables, moves, state)
    event = xp.clip(action - moves.turn_count, 0, fallen.shape[-1] - 1)
    dropped = xp.take_along_axis(fallen, event[..., None], axis=-1)[..., 0]
    return xp.where(action >= moves.turn_count, dropped, after)


class Step(NamedTuple):
    """What one character does in a frame.

    Attributes:
        act, success: its action, and whether it succeeds.
        before, after: the arrangements just before and after its action.
        would: whether its action is one that could move it.
    """

    act: Array
    success: Array
    before: Array
    after: Array
    would: Array


def steps(tables: Tables, moves: Moves, state: Array, action: Array) -> tuple[list[Step], Array]:
    """What each character does in a turn, and the arrangement in which that ends."""
    xp = namespace(tables.coordinates)
    here = arrangement(tables, state)
    chosen = [decode(moves, who, action, xp) for who in range(len(moves.weak))]
    if moves.together:
        return _steps_together(tables, here, chosen)
    found: list[Step] = []
    for who, (act, success) in enumerate(chosen):
        before = found[-1].after if found else here
        moved = successor(tables, who, act, before)
        after = xp.where(success, moved, before)
        found.append(Step(act, success, before, after, moved != before))
    return found, found[-1].after


def _steps_together(
    tables: Tables, here: Array, chosen: list[tuple[Array, Array]]
) -> tuple[list[Step], Array]:
    """`steps` of two who act together; as in `_joint`."""
    xp = namespace(tables.coordinates)
    one, two = (partial(successor, tables, who) for who in (0, 1))
    (act, success), (act2, success2) = chosen
    effect, effect2 = xp.where(success, act, STAY), xp.where(success2, act2, STAY)
    first, second = one(effect, here), two(effect2, here)
    in_order, in_turn = two(effect2, first), one(effect, second)
    waits = first == here
    would = (one(act, here) != here) | (one(act, second) != second)
    return [
        Step(act, success, xp.where(waits, second, here), xp.where(waits, in_turn, first), would),
        Step(act2, success2, first, xp.where(waits, second, in_order), two(act2, first) != first),
    ], xp.where(waits, in_turn, in_order)


def chosen_at(tables: Tables, moves: Moves, state: Array, done: list[Step]) -> list[Array]:
    """The state that each character sees as it chooses what it does in a turn."""
    if moves.together:
        return [state, state]
    frame = state - arrangement(tables, state)
    return [step.before + frame for step in done]


def decode(moves: Moves, who: int, action: Array, xp: Any) -> tuple[Array, Array]:
    """A character's action in a turn, and whether it succeeded; an event reads as staying."""
    number = xp.minimum(action, moves.turn_count)
    act, success = (entries(xp.asarray(each), number) for each in moves.turns[who])
    return act, success


def outcome(
    tables: Tables, moves: Moves, state: Array, action: Array
) -> tuple[Array, tuple[Array, ...], tuple[Array, ...]]:
    """`transition`, `log_rows` and `best_rows`."""
    done, end = steps(tables, moves, state, action)
    seen = (tables, moves, state, action)
    return _transition(*seen, end), log_rows(*seen, done), best_rows(*seen, done)


def log_rows(
    tables: Tables,
    moves: Moves,
    state: Array,
    action: Array,
    done: list[Step] | None = None,
    known: Sequence[Known] = (),
) -> tuple[Array, ...]:
    """log P(observed action | H) for each character in the order of acting: [..., O, H] each.

    An event is expected by nobody and explained by nothing: its rows are 0.

    Args:
        done: what each of them does, where that is known.
        known: what was expected of each of them before, if it is kept.
    """
    xp = namespace(tables.coordinates)
    done = done or steps(tables, moves, state, action)[0]
    states = chosen_at(tables, moves, state, done)
    is_turn = action < moves.turn_count
    rows = []
    for who, step in enumerate(done):
        if tables.policies is not None:
            row = entries(tables.policies[who], (states[who], step.act))
        else:
            found = known[who].taken(states[who], step.act) if known else None
            if found is None:
                row = log_taken(tables, who, states[who], step.act)
            else:
                row = by_hypothesis(tables, who, found)
        if xp is not np or not is_turn.all():
            row = xp.where(is_turn[..., None, None], row, 0.0)
        rows.append(row)
    return tuple(rows)


def best_rows(
    tables: Tables, moves: Moves, state: Array, action: Array, done: list[Step] | None = None
) -> tuple[Array, ...]:
    """max_a log P(a | H) of each character where it acts: [..., O, H] each; 0 in an event. `done`
    as for `log_rows`."""
    xp = namespace(tables.coordinates)
    states = chosen_at(tables, moves, state, done or steps(tables, moves, state, action)[0])
    is_turn = (action < moves.turn_count)[..., None, None]
    rows = []
    for who in range(len(moves.weak)):
        if tables.policies is not None:
            row = xp.max(entries(tables.policies[who], states[who]), axis=-3)
        else:
            best = xp.max(log_softmax(tables, who, states[who]), axis=-2)
            row = by_hypothesis(tables, who, best)
        rows.append(xp.where(is_turn, row, 0.0))
    return tuple(rows)


def alternatives(
    tables: Tables, moves: Moves, state: Array, action: Array
) -> tuple[tuple[Array, Array], ...]:
    """log P(a | H) of all that each character could do where it acts, [..., A, O, H], and what it
    did, [...]."""
    done, _ = steps(tables, moves, state, action)
    states = chosen_at(tables, moves, state, done)
    return tuple((log_policy(tables, who, states[who]), step.act) for who, step in enumerate(done))
