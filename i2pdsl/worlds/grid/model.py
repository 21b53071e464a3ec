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

An action of the story is a number: o_1 * n_2 + o_2 for a turn in which the characters have the
outcomes o_1 and o_2 (an outcome is an action and whether it succeeded), then, for events,
`turn_count` + e * slots + cell.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from i2pdsl.sizes import padded_size
from i2pdsl.worlds.grid.spec import ALL_OFFSETS, STAY
from i2pdsl.worlds.world import Branches

Array = Any


class Tables(NamedTuple):
    """The numbers of a world under one or several observers.

    Attributes:
        cells [S, E], lookup, strides [E], successor, for each character [A, S]: see dynamics.py.
        coordinates [N + 1, 2]: (column, row) of each cell; the last row stands for absence.
        absent []: the cell number of a thing that is not there, N.
        success [C]: probability that a character's move succeeds.
        cost [9]: reward of an action away from the goal.
        gamma []: discount factor.
        reward []: reward on the goal tile.
        continuation: for each character [F * S, P], the value W after an action, before the
            other's answer, for each planning problem (planning/value_iteration.py); of both who
            act together, the value after the frame.
        columns: for each character [O, H], the problem of a hypothesis; P where irrational.
        sharpness: for each character [P], beta of the problem's observer.
        goals: for each character [P, N + 1], whether a cell is the problem's goal.
        log_prior [O, H]: the belief before anything moved.
        forgetting [O]: share of belief that is reassigned after each action.
        layer []: S, where there is a horizon; else None.
        against: what each character expects of the other who acts together with it; else None.
    """

    cells: Array
    lookup: Array
    strides: Array
    successor: tuple[Array, ...]
    coordinates: Array
    absent: Array
    success: Array
    cost: Array
    gamma: Array
    reward: Array
    continuation: tuple[Array, ...]
    columns: tuple[Array, ...]
    sharpness: tuple[Array, ...]
    goals: tuple[Array, ...]
    log_prior: Array
    forgetting: Array
    layer: Array | None = None
    against: tuple[Against, ...] | None = None


class Against(NamedTuple):
    """What a character expects of the other in each of its problems.

    Attributes:
        fixed [A, P]: how the other acts, wherever it is, where it is not seen through.
        problem [P]: the other's problem that is seen through; None if there is none such.
        known [P]: where that is so.
        beta [P']: how sharply the other chooses in each of its problems.
        rho [P]: how much its reward counts.
        success []: the probability that each character's move succeeds; None where it is sure.
    """

    fixed: Array
    problem: Array | None
    known: Array
    beta: Array
    rho: Array
    success: tuple[Array | None, ...]


def arrangement(tables: Tables, state: Array) -> Array:
    """A state without its frame."""
    return state if tables.layer is None else state % tables.layer


def padded(tables: Tables) -> Tables:
    """The tables with states and cells up to sizes that worlds share, so that they share programs.

    No number of a real state or cell leads to what is added.
    """
    states, cells = padded_size(len(tables.cells), 8192), padded_size(len(tables.coordinates), 128)
    along = lambda axis, size: lambda a: _lengthened(a, axis, size)
    return tables._replace(
        cells=along(0, states)(tables.cells),
        lookup=along(0, padded_size(len(tables.lookup), 8192))(tables.lookup),
        successor=tuple(map(along(1, states), tables.successor)),
        coordinates=along(0, cells)(tables.coordinates),
        continuation=tuple(
            along(0, padded_size(len(table), 8192))(table) for table in tables.continuation
        ),
        goals=tuple(map(along(1, cells), tables.goals)),
    )


def _lengthened(array: np.ndarray, axis: int, size: int) -> np.ndarray:
    widths = [(0, size - array.shape[axis] if i == axis else 0) for i in range(array.ndim)]
    return np.pad(array, widths)


@dataclass(frozen=True)
class Moves:
    """The static layout of actions: it does not depend on the numbers of a world.

    `slots` numbers are kept for the cell that a thing falls on, at least as many as there are
    cells, so that maps of about one size share programs; none where nothing falls.
    """

    weak: tuple[bool, ...]
    slots: int
    entities: int
    events: tuple[int, ...]  # the entity that each event drops
    actions: tuple[int, ...]  # how many each character has
    alike: tuple[tuple[int, ...], ...] = ()  # entities that are not told apart
    frames: int = 1  # F
    together: bool = False

    def outcomes(self, who: int) -> tuple[tuple[int, bool], ...]:
        """(action, success) for each outcome of a character; staying cannot fail."""
        succeed = tuple((a, True) for a in range(self.actions[who]))
        fail = tuple((a, False) for a in range(self.actions[who]) if a != STAY)
        return succeed + fail if self.weak[who] else succeed

    @property
    def counts(self) -> tuple[int, ...]:
        return tuple(len(self.outcomes(who)) for who in range(len(self.weak)))

    @property
    def turn_count(self) -> int:
        first, *rest = self.counts
        return first * (rest[0] if rest else 1)


def namespace(array: Array) -> Any:
    """numpy or jax.numpy, whichever the array belongs to."""
    return array.__array_namespace__()


def action_values(tables: Tables, who: int, state: Array) -> Array:
    """Q(s, a) of every planning problem: [..., A, P] (model.md, "Kitchen")."""
    xp = namespace(tables.cells)
    table, here = tables.continuation[who], arrangement(tables, state)
    on_goal = xp.moveaxis(tables.goals[who][:, tables.cells[here, who]], 0, -1)
    cost = tables.cost[: len(tables.successor[who])]
    reward = tables.reward * on_goal[..., None, :] + cost[:, None]
    if tables.against is not None:
        return reward + _together_values(tables, tables.against[who], who, state)
    after = xp.moveaxis(tables.successor[who][:, here], 0, -1)
    if tables.layer is not None:
        after = after + (state - here)[..., None]
    p = tables.success[who]
    expected = p * table[after] + (1 - p) * table[state][..., None, :]
    return reward + tables.gamma * expected


def _together_values(tables: Tables, against: Against, who: int, state: Array) -> Array:
    """What one expects besides its own reward: the other's now, and what comes: [..., A, P]."""
    xp = namespace(tables.cells)
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
    xp = namespace(tables.cells)
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
    xp = namespace(tables.cells)
    cost = (policy * tables.cost[: policy.shape[-2], None]).sum(-2)
    if against.problem is None:
        return cost * 0
    goals = xp.moveaxis(tables.goals[other][:, tables.cells[here, other]], 0, -1)
    return xp.where(against.known, cost + tables.reward * goals[..., against.problem], 0)


def _joint(tables: Tables, here: Array) -> tuple[Array, Array, Array]:
    """The arrangement after each pair of actions of two who act together, if both succeed, and
    whether the first and the second are moved by them: [..., A_1, A_2] each."""
    xp = namespace(tables.cells)
    one, two = tables.successor
    first, second = xp.moveaxis(one[:, here], 0, -1), xp.moveaxis(two[:, here], 0, -1)
    in_order = xp.moveaxis(two[:, first], 0, -1)  # [..., A_1, A_2]
    in_turn = xp.moveaxis(one[:, second], 0, -2)
    waits = (first == here[..., None])[..., None]
    second, first = second[..., None, :], first[..., None]
    return (
        xp.where(waits, in_turn, in_order),
        ~waits | (in_turn != second),
        xp.where(waits, second != here[..., None, None], in_order != first),
    )


def log_policy(tables: Tables, who: int, state: Array) -> Array:
    """log P(a | s, H): softmax of beta Q, uniform for the irrational. [..., A, O, H]."""
    xp = namespace(tables.cells)
    scaled = tables.sharpness[who] * action_values(tables, who, state)
    scaled = scaled - xp.max(scaled, axis=-2, keepdims=True)
    log_probability = scaled - xp.log(xp.sum(xp.exp(scaled), axis=-2, keepdims=True))
    irrational = xp.full_like(log_probability[..., :1], -math.log(scaled.shape[-2]))
    return xp.concatenate([log_probability, irrational], axis=-1)[..., tables.columns[who]]


def value(tables: Tables, who: int, state: Array) -> Array:
    """V(s) = max_a Q(s, a) of a character under each hypothesis: [..., O, H].

    0 under hypotheses in which the character is irrational; expectations exclude those.
    """
    xp = namespace(tables.cells)
    best = xp.max(action_values(tables, who, state), axis=-2)
    padded = xp.concatenate([best, xp.zeros_like(best[..., :1])], axis=-1)
    return padded[..., tables.columns[who]]


def turns(tables: Tables, moves: Moves, state: Array) -> Branches:
    """All joint turns from `state`, with what each hypothesis says of them."""
    if moves.together:
        return _turns_together(tables, moves, state)
    xp = namespace(tables.cells)
    first = moves.outcomes(0)
    actions = [a for a, _ in first]
    here = arrangement(tables, state)
    reached = xp.moveaxis(tables.successor[0][:, here], 0, -1)  # [..., A]
    # Failing leaves the state as it is, which is where staying leads.
    middle = reached[..., [a if ok else STAY for a, ok in first]]
    moved = reached != here[..., None]
    valid = xp.stack([moved[..., a] | ok for a, ok in first], axis=-1)
    p = tables.success[0]
    chance = _chance(xp, first, moved, p)
    row = log_policy(tables, 0, state)[..., actions, :, :]
    if len(moves.weak) == 1:
        middle = _later(tables, moves, state, middle)
        return Branches(middle, valid, (row[..., :, None, :, :],), chance)
    second = moves.outcomes(1)
    answers = [a for a, _ in second]
    landed = xp.moveaxis(tables.successor[1][:, reached], 0, -1)  # [..., A, A]
    seen = reached if tables.layer is None else reached + (state - here)[..., None]
    answered = log_policy(tables, 1, seen)[..., answers, :, :]  # [..., A, n_2, O, H]
    by_outcome = [a if ok else STAY for a, ok in first]
    end = landed[..., by_outcome, :][..., [a if ok else STAY for a, ok in second]]
    moved2 = landed[..., by_outcome, :] != middle[..., None]
    valid2 = xp.stack([moved2[..., a] | ok for a, ok in second], axis=-1)
    chance2 = _chance(xp, second, moved2, tables.success[1])
    shape = (*end.shape[:-2], end.shape[-2] * end.shape[-1])
    return Branches(
        _later(tables, moves, state, end.reshape(shape)),
        (valid[..., None] & valid2).reshape(shape),
        (row[..., :, None, :, :], answered[..., by_outcome, :, :, :]),
        (chance[..., None] * chance2).reshape(shape),
    )


def _turns_together(tables: Tables, moves: Moves, state: Array) -> Branches:
    """`turns` of two who act together."""
    xp = namespace(tables.cells)
    ends, *moved = _joint(tables, arrangement(tables, state))
    (acts, done), (acts2, done2) = (zip(*moves.outcomes(who), strict=True) for who in (0, 1))
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
    return after + tables.layer * namespace(tables.cells).minimum(frame, moves.frames - 1)


def endings(tables: Tables, moves: Moves, state: Array) -> Array:
    """The states after each joint turn, [..., K]: `turns` without what anybody expects."""
    xp = namespace(tables.cells)
    here = arrangement(tables, xp.asarray(state))
    effects = [
        [action if ok else STAY for action, ok in moves.outcomes(who)]
        for who in range(len(moves.weak))
    ]
    if moves.together:
        ends = _joint(tables, here)[0][..., effects[0], :][..., effects[1]]
        ends = ends.reshape(*here.shape, -1)
    else:
        ends = here[..., None]
        for who, acts in enumerate(effects):
            moved = xp.moveaxis(tables.successor[who][:, ends], 0, -1)[..., acts]
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
    """The states after each event (every thing onto every cell) and whether it can happen.

    Shapes [..., events * slots]. A thing falls only while it is absent, onto a free cell.
    """
    xp = namespace(tables.cells)
    cells = xp.arange(moves.slots)
    place = arrangement(tables, state)
    here = tables.cells[place]
    results, possible = [], []
    for entity in moves.events:
        code = (here * tables.strides).sum(-1)[..., None]
        there = xp.where(cells < tables.absent, cells - tables.absent, 0)
        after = tables.lookup[code + there * tables.strides[entity]]
        absent = here[..., entity, None] == tables.absent
        possible.append(absent & (cells < tables.absent) & (after >= 0))
        results.append(xp.where(possible[-1], after, place[..., None]))
    ends = _later(tables, moves, state, xp.concatenate(results, axis=-1))
    return ends, xp.concatenate(possible, axis=-1)


def transition(tables: Tables, moves: Moves, state: Array, action: Array) -> Array:
    """The state after an action of the story (chance outcomes are part of the action)."""
    xp = namespace(tables.cells)
    _, after = steps(tables, moves, state, action)
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
        before, after: the arrangements just before and after its action.
        would: whether its action is one that could move it.
    """

    before: Array
    after: Array
    would: Array


def steps(tables: Tables, moves: Moves, state: Array, action: Array) -> tuple[list[Step], Array]:
    """What each character does in a turn, and the arrangement in which that ends."""
    xp = namespace(tables.cells)
    here = arrangement(tables, state)
    chosen = [decode(moves, who, action, xp) for who in range(len(moves.weak))]
    if moves.together:
        return _steps_together(tables, here, chosen)
    found: list[Step] = []
    for who, (act, success) in enumerate(chosen):
        before = found[-1].after if found else here
        moved = tables.successor[who][act, before]
        found.append(Step(before, xp.where(success, moved, before), moved != before))
    return found, found[-1].after


def _steps_together(
    tables: Tables, here: Array, chosen: list[tuple[Array, Array]]
) -> tuple[list[Step], Array]:
    """`steps` of two who act together; as in `_joint`."""
    xp = namespace(tables.cells)
    one, two = tables.successor
    (act, success), (act2, success2) = chosen
    effect, effect2 = xp.where(success, act, STAY), xp.where(success2, act2, STAY)
    first, second = one[effect, here], two[effect2, here]
    in_order, in_turn = two[effect2, first], one[effect, second]
    waits = first == here
    would = (one[act, here] != here) | (one[act, second] != second)
    return [
        Step(xp.where(waits, second, here), xp.where(waits, in_turn, first), would),
        Step(first, xp.where(waits, second, in_order), two[act2, first] != first),
    ], xp.where(waits, in_turn, in_order)


def _chosen_at(tables: Tables, moves: Moves, state: Array, action: Array) -> list[Array]:
    """The state that each character sees as it chooses."""
    if moves.together:
        return [state, state]
    frame = state - arrangement(tables, state)
    return [step.before + frame for step in steps(tables, moves, state, action)[0]]


def decode(moves: Moves, who: int, action: Array, xp: Any) -> tuple[Array, Array]:
    """A character's action in a turn, and whether it succeeded; an event reads as staying."""
    counts = moves.counts
    own = action // counts[1] if len(counts) == 2 and who == 0 else action % counts[-1]
    outcomes = moves.outcomes(who)
    is_turn = action < moves.turn_count
    own = xp.where(is_turn, own, STAY)
    acts = xp.asarray([a for a, _ in outcomes])
    return acts[own], xp.asarray([ok for _, ok in outcomes])[own]


def log_rows(tables: Tables, moves: Moves, state: Array, action: Array) -> tuple[Array, ...]:
    """log P(observed action | H) for each character in the order of acting: [..., O, H] each.

    An event is expected by nobody and explained by nothing: its rows are 0.
    """
    xp = namespace(tables.cells)
    states = _chosen_at(tables, moves, state, action)
    rows = []
    for who in range(len(moves.weak)):
        act, _ = decode(moves, who, action, xp)
        policy = log_policy(tables, who, states[who])
        row = xp.take_along_axis(policy, act[..., None, None, None], axis=-3)[..., 0, :, :]
        rows.append(xp.where((action < moves.turn_count)[..., None, None], row, 0.0))
    return tuple(rows)


def best_rows(tables: Tables, moves: Moves, state: Array, action: Array) -> tuple[Array, ...]:
    """max_a log P(a | H) of each character where it acts: [..., O, H] each; 0 in an event."""
    xp = namespace(tables.cells)
    states = _chosen_at(tables, moves, state, action)
    is_turn = (action < moves.turn_count)[..., None, None]
    best = (xp.max(log_policy(tables, who, states[who]), axis=-3) for who in range(len(moves.weak)))
    return tuple(xp.where(is_turn, row, 0.0) for row in best)


def alternatives(
    tables: Tables, moves: Moves, state: Array, action: Array
) -> tuple[tuple[Array, Array], ...]:
    """log P(a | H) of all that each character could do where it acts, [..., A, O, H], and what it
    did, [...]."""
    states = _chosen_at(tables, moves, state, action)
    return tuple(
        (
            log_policy(tables, who, states[who]),
            decode(moves, who, action, namespace(tables.cells))[0],
        )
        for who in range(len(moves.weak))
    )


def attempts(tables: Tables, moves: Moves, state: Array, action: Array) -> tuple[Array, Array]:
    """Which weak characters made a move that could succeed, and whose did: [..., weak] each."""
    xp = namespace(tables.cells)
    done, _ = steps(tables, moves, state, action)
    tried, succeeded = [], []
    for who, weak in enumerate(moves.weak):
        if weak:
            _, success = decode(moves, who, action, xp)
            tried.append(done[who].would)
            succeeded.append(done[who].would & success)
    return xp.stack(tried, axis=-1), xp.stack(succeeded, axis=-1)


def is_turn(
    tables: Tables,
    moves: Moves,
    before: Array,
    action: Array,
    acts: tuple[tuple[int, bool] | None, ...],
) -> Array:
    """Whether everybody does so: (action, whether it fails) for each, None for anything."""
    xp = namespace(tables.cells)
    each, _ = steps(tables, moves, before, action)
    done = action < moves.turn_count
    for who, act in enumerate(acts):
        if act is None:
            continue
        chosen, success = decode(moves, who, action, xp)
        done &= (chosen == act[0]) & (success != act[1])
        if act[1]:  # what is in the way makes no move fail
            done &= each[who].would
    return done


def feature(
    tables: Tables,
    moves: Moves,
    name: str,
    arguments: tuple[Any, ...],
    state: Array,
    before: Array | None = None,
    action: Array | None = None,
) -> Array:
    """Whether a predicate holds at `state`, or in the frame that led from `before` to it.

    Entities are numbers; a place is given by its cell numbers [n]. What is asked of pairs of
    cells comes with its table, [(N + 1)^2]; of a cell and a place [N + 1] and None for the place.
    """
    xp, here = namespace(tables.cells), arrangement(tables, state)
    match name:
        case "at":
            entity, places = arguments
            return (tables.cells[here, entity][..., None] == xp.asarray(places)).any(-1)
        case "absent":
            return tables.cells[here, arguments[0]] == tables.absent
        case "adjacent" | "touching":
            return _adjacent(tables, here, *arguments)
        case "sees" | "distance":
            entity, other, table = arguments
            place = tables.cells[here, entity]
            if other is not None:
                place = place * (tables.absent + 1) + tables.cells[here, other]
            return xp.asarray(table)[place]
    assert before is not None
    assert action is not None
    is_turn = action < moves.turn_count
    if name == "fell":
        gone = tables.cells[arrangement(tables, before), arguments[0]] == tables.absent
        return gone & (tables.cells[here, arguments[0]] != tables.absent)
    who = arguments[0]
    act, _ = decode(moves, who, action, xp)
    if name in ("tried", "idle"):
        tried = is_turn & (act != STAY)
        return tried if name == "tried" else ~tried
    if name == "faces":
        seen = arrangement(tables, _chosen_at(tables, moves, before, action)[who])
        return is_turn & _ahead(tables, seen, who, act, arguments[1])
    entity = who if name == "moved" else arguments[1]
    step = steps(tables, moves, before, action)[0][who]
    left, now = tables.cells[step.before, entity], tables.cells[step.after, entity]
    changed = left != now
    for group in moves.alike:
        if entity in group:  # whoever of them stood there is there no more
            now = tables.cells[step.after][..., list(group)]
            changed = (left[..., None] != now).all(-1)
    return is_turn & changed if name == "moved" or entity != who else is_turn & False


def _ahead(tables: Tables, state: Array, who: int, act: Array, spot: Any) -> Array:
    """Whether an action points to an entity or a place: into the quarter in which that lies."""
    xp = namespace(tables.cells)
    here = tables.coordinates[tables.cells[state, who]]
    there = tables.cells[state, spot][..., None] if isinstance(spot, int) else xp.asarray(spot)
    way = tables.coordinates[there] - here[..., None, :]
    ahead = (way * xp.asarray(ALL_OFFSETS)[act][..., None, :]).sum(-1)
    return ((ahead > 0) & (2 * ahead >= abs(way).sum(-1)) & (there != tables.absent)).any(-1)


def _adjacent(tables: Tables, state: Array, a: int, b: int) -> Array:
    """Whether two entities stand on neighbouring cells (both must be there)."""
    first, second = tables.cells[state, a], tables.cells[state, b]
    present = (first != tables.absent) & (second != tables.absent)
    distance = abs(tables.coordinates[first] - tables.coordinates[second]).sum(-1)
    return present & (distance == 1)
