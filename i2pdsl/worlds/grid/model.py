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

import math
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from i2pdsl.worlds.grid import following
from i2pdsl.worlds.grid.arrays import (
    Against,
    Moves,
    Tables,
    arrangement,
    at_goal,
    cell_of,
    continued,
    entries,
    namespace,
)
from i2pdsl.worlds.grid.following import action_count, successor, successors, values_after
from i2pdsl.worlds.grid.spec import STAY
from i2pdsl.worlds.world import Branches, ByProblem

if TYPE_CHECKING:
    from i2pdsl.worlds.grid.known import Known

Array = Any

MANY = 256  # places: from so many on they are looked for among each other first
AT_ONCE = 8192  # values of an action that are computed side by side: more do not fit the cache


def action_values(tables: Tables, who: int, state: Array) -> Array:
    """Q(s, a) of every planning problem: [..., A, P] (model.md, "Kitchen")."""
    here = arrangement(tables, state)
    on_goal = at_goal(tables, who, here)
    cost = tables.cost[: action_count(tables, who)]
    ground = tables.ground[cell_of(tables, here, who)][..., None, None]
    reward = tables.reward * on_goal[..., None, :] + (cost[:, None] - ground)
    if tables.against is not None:
        return reward + _together_values(tables, tables.against[who][0], who, state)
    if tables.layer is None:
        values = values_after(tables, who, here)
    else:
        after = successors(tables, who, here)
        values = continued(tables, who, in_frame(state - here, after))
    p = tables.success[who]
    expected = p * values + (1 - p) * values[..., STAY : STAY + 1, :]  # who fails stays
    return reward + tables.gamma * expected


def _together_values(tables: Tables, against: Against, who: int, state: Array) -> Array:
    """What one expects besides its own reward: the other's now, and what comes: [..., A, P]."""
    xp = namespace(tables.coordinates)
    other, here = 1 - who, arrangement(tables, state)
    ends = _joint(tables, here)[0] + (state - here)[..., None, None]
    future = tables.continuation[who][ends]  # [..., A_1, A_2, P]
    for p, axis in zip(against.success, (-3, -2), strict=True):
        if p is not None:
            future = p * future + (1 - p) * xp.take(future, xp.asarray([STAY]), axis=axis)
    policy = expected_of_other(tables, against, other, state)
    facing = policy[..., None, :, :] if who == 0 else policy[..., :, None, :]
    expected = (facing * future).sum(-2 if who == 0 else -3)
    social = others_reward(tables, against, policy, other, here)
    return (against.rho * social)[..., None, :] + tables.gamma * expected


def expected_of_other(tables: Tables, against: Against, other: int, state: Array) -> Array:
    """P(a | s) of the other in each of one's problems: [..., A, P]."""
    xp = namespace(tables.coordinates)
    if against.problem is None:
        return xp.broadcast_to(against.fixed, (*state.shape, *against.fixed.shape))
    scaled = against.beta * action_values(tables, other, state)
    weights = xp.exp(scaled - xp.max(scaled, axis=-2, keepdims=True))
    policy = (weights / xp.sum(weights, axis=-2, keepdims=True))[..., against.problem]
    return xp.where(against.known, policy, against.fixed)


def others_reward(
    tables: Tables, against: Against, policy: Array, other: int, here: Array
) -> Array:
    """What one expects the other to be paid for its action in an arrangement, [..., P]; 0 where it
    is not seen through.

    Args:
        policy: [..., A, P], of the other.
    """
    xp = namespace(tables.coordinates)
    cost = (policy * tables.cost[: policy.shape[-2], None]).sum(-2)
    cost = cost - tables.ground[cell_of(tables, here, other)][..., None]
    if against.problem is None:
        return cost * 0
    goals = at_goal(tables, other, here)
    return xp.where(against.known, cost + tables.reward * goals[..., against.problem], 0)


def _joint(tables: Tables, here: Array) -> tuple[Array, Array, Array]:
    """The arrangement after each pair of actions of two who act together, if both succeed, and
    whether the first and the second are moved by them: [..., A_1, A_2] each."""
    xp = namespace(tables.coordinates)
    first, second = (successors(tables, who, here) for who in (0, 1))
    in_order = successors(tables, 1, first)  # [..., A_1, A_2]
    in_turn = xp.swapaxes(successors(tables, 0, second), -1, -2)
    waits = (first == here[..., None])[..., None]
    second, first = second[..., None, :], first[..., None]
    return (
        xp.where(waits, in_turn, in_order),
        ~waits | (in_turn != second),
        xp.where(waits, second != here[..., None, None], in_order != first),
    )


def log_policy(tables: Tables, who: int, state: Array) -> Array:
    """log P(a | s, H): softmax of beta Q, uniform for the irrational. [..., A, O, H]."""
    if tables.policies is not None:
        return entries(tables.policies[who], state)
    return _by_hypothesis(tables, who, log_softmax(tables, who, state))


def log_softmax(tables: Tables, who: int, state: Array) -> Array:
    """log P(a | s) of every planning problem: [..., A, P]."""
    xp = namespace(tables.coordinates)
    if xp is np:
        each = (_choices(tables, who, some) for some in _few(tables, who, state))
        found = np.concatenate([scaled - total for scaled, total in each], axis=1)
        return np.moveaxis(found, 0, 1).reshape(*state.shape, *found.shape[::2])
    return _softmax(tables, who, state)[0]


def _softmax(tables: Tables, who: int, state: Array) -> tuple[Array, Array]:
    """log P(a | s) and P(a | s) of every planning problem: [..., A, P] each."""
    xp = namespace(tables.coordinates)
    scaled = tables.sharpness[who] * action_values(tables, who, state)
    scaled = scaled - xp.max(scaled, axis=-2, keepdims=True)
    weights = xp.exp(scaled)
    total = xp.sum(weights, axis=-2, keepdims=True)
    return scaled - xp.log(total), weights / total


def _few(tables: Tables, who: int, every: np.ndarray) -> list[np.ndarray]:
    """States, or what belongs to them, [...], as parts [n] that are small enough to be computed in
    the cache."""
    flat, size = every.reshape(-1), max(1, AT_ONCE // max(1, len(tables.sharpness[who])))
    return [flat[first : first + size] for first in range(0, len(flat), size)] or [flat]


def _choices(tables: Tables, who: int, state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """beta Q(s, a) of every planning problem but for what all actions share, [A, n, P], and the log
    of the sum of their exponentials, [n, P]. With the actions in front NumPy sums fastest."""
    plain = tables.against is None and tables.layer is None
    if plain and tables.packed is None and tables.terms is None:
        p, gamma, beta = tables.success[who], tables.gamma, tables.sharpness[who]
        scaled = tables.continuation[who][tables.successor[who][:, state]]
        if p < 1:
            scaled = p * scaled + (1 - p) * scaled[STAY]
        scaled *= gamma * beta
        scaled += tables.cost[: len(scaled), None, None] * beta
    else:
        scaled = np.moveaxis(action_values(tables, who, state), -2, 0) * tables.sharpness[who]
    scaled -= scaled.max(0)
    return scaled, np.log(np.exp(scaled).sum(0))


def _log_taken(tables: Tables, who: int, state: Array, act: Array) -> Array:
    """log P(act | s, H), [..., O, H]."""
    xp = namespace(tables.coordinates)
    if xp is not np:
        policy = log_softmax(tables, who, state)
        taken = xp.take_along_axis(policy, act[..., None, None], axis=-2)[..., 0, :]
        return _by_hypothesis(tables, who, taken)
    # Many scripts come by the same places, and do the same there.
    count = action_count(tables, who)
    pairs = (state.astype(np.int64) * count + act).reshape(-1)
    which: Any = None
    if len(pairs) >= MANY:
        pairs, which = np.unique(pairs, return_inverse=True)
    found = []
    for some in _few(tables, who, pairs):
        scaled, total = _choices(tables, who, (some // count).astype(state.dtype))
        found.append(scaled[some % count, np.arange(len(some))] - total)
    rows = _by_hypothesis(tables, who, np.concatenate(found))
    rows = rows if which is None else rows.take(which, axis=0)
    return rows.reshape(*state.shape, *rows.shape[1:])


def _with_irrational(tables: Tables, who: int, log_probability: Array) -> Array:
    """What is known of each planning problem, [..., P], and of who acts at random: [..., P + 1]."""
    xp = namespace(tables.coordinates)
    count = action_count(tables, who)
    irrational = xp.full_like(log_probability[..., :1], -math.log(count))
    return xp.concatenate([log_probability, irrational], axis=-1)


def _by_problem(tables: Tables, who: int, state: Array, columns: Array) -> tuple[Array, Array]:
    """log P(a | s) and P(a | s) of the problems in some columns, [..., A, O, Q] each."""
    log_policy, policy = _softmax(tables, who, state)
    log_policy = _with_irrational(tables, who, log_policy)
    xp = namespace(tables.coordinates)
    random = xp.full_like(policy[..., :1], 1 / action_count(tables, who))
    policy = xp.concatenate([policy, random], axis=-1)
    if columns.shape == (1, policy.shape[-1]):  # one observer, who knows of all problems
        return log_policy[..., None, :], policy[..., None, :]
    return log_policy[..., columns], policy[..., columns]


def _by_hypothesis(tables: Tables, who: int, log_probability: Array) -> Array:
    """What is known of each planning problem, [..., P], of each hypothesis: [..., O, H]."""
    xp = namespace(tables.coordinates)
    every = _with_irrational(tables, who, log_probability)
    # `take` lays them out in this order: sums over them then round alike, of one script or many.
    return xp.take(every, tables.columns[who], axis=-1, mode="clip")


def value(tables: Tables, who: int, state: Array) -> Array:
    """V(s) = max_a Q(s, a) of a character under each hypothesis: [..., O, H].

    0 under hypotheses in which the character is irrational; expectations exclude those.
    """
    xp = namespace(tables.coordinates)
    best = xp.max(action_values(tables, who, state), axis=-2)
    padded = xp.concatenate([best, xp.zeros_like(best[..., :1])], axis=-1)
    return padded[..., tables.columns[who]]


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
                known = _by_problem(tables, who, seen, columns)
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
    ends, *moved = _joint(tables, arrangement(tables, state))
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
        ends = _joint(tables, here)[0][..., effects[0], :][..., effects[1]]
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


def in_frame(frame: Array, place: Array) -> Array:
    """The states of arrangements [..., more axes] in a frame, of which `state - arrangement` [...]
    tells."""
    return place + frame.reshape(frame.shape + (1,) * (place.ndim - frame.ndim))


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
                row = _log_taken(tables, who, states[who], step.act)
            else:
                row = _by_hypothesis(tables, who, found)
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
            row = _by_hypothesis(tables, who, best)
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
