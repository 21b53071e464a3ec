"""What moves and what viewers expect in a grid world, as functions of arrays.

Every function takes the tables first and works on NumPy and on JAX arrays alike, with any number
of leading axes on states: queries run in NumPy without compiling, searches in JAX. Shapes:
S states, E entities, C characters, A = 5 actions, N cells, O observers, H hypotheses.

An action of the story is a number: o_1 * n_2 + o_2 for a turn in which the characters have the
outcomes o_1 and o_2 (an outcome is an action and whether it succeeded), then, for events,
`turn_count` + e * slots + cell.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from i2pdsl.sizes import padded_size
from i2pdsl.worlds.grid.spec import ACTIONS, OFFSETS, STAY
from i2pdsl.worlds.world import Branches

Array = Any


class Tables(NamedTuple):
    """The numbers of a world under one or several observers.

    Attributes:
        cells [S, E], lookup, strides [E], successor [C, A, S]: see dynamics.py.
        coordinates [N + 1, 2]: (column, row) of each cell; the last row stands for absence.
        absent []: the cell number of a thing that is not there, N.
        success [C]: probability that a character's move succeeds.
        cost [A]: reward of an action away from the goal.
        gamma []: discount factor.
        reward []: reward on the goal tile.
        continuation: for each character [S, P], the value W after an action, before the other's
            answer, for each planning problem (planning/value_iteration.py).
        columns: for each character [O, H], the problem of a hypothesis; P where irrational.
        sharpness: for each character [P], beta of the problem's observer.
        goals: for each character [P, N + 1], whether a cell is the problem's goal.
        log_prior [O, H]: the belief before anything moved.
        forgetting [O]: share of belief that is reassigned after each action.
    """

    cells: Array
    lookup: Array
    strides: Array
    successor: Array
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


def padded(tables: Tables) -> Tables:
    """The tables with states and cells up to sizes that worlds share, so that they share programs.

    No number of a real state or cell leads to what is added.
    """
    states, cells = padded_size(len(tables.cells), 8192), padded_size(len(tables.coordinates), 128)
    along = lambda axis, size: lambda a: _lengthened(a, axis, size)
    return tables._replace(
        cells=along(0, states)(tables.cells),
        lookup=along(0, padded_size(len(tables.lookup), 8192))(tables.lookup),
        successor=along(2, states)(tables.successor),
        coordinates=along(0, cells)(tables.coordinates),
        continuation=tuple(map(along(0, states), tables.continuation)),
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

    def outcomes(self, who: int) -> tuple[tuple[int, bool], ...]:
        """(action, success) for each outcome of a character; staying cannot fail."""
        succeed = tuple((a, True) for a in range(len(ACTIONS)))
        fail = tuple((a, False) for a in range(len(ACTIONS)) if a != STAY)
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
    table = tables.continuation[who]
    after = xp.moveaxis(tables.successor[who][:, state], 0, -1)
    p = tables.success[who]
    expected = p * table[after] + (1 - p) * table[state][..., None, :]
    on_goal = xp.moveaxis(tables.goals[who][:, tables.cells[state, who]], 0, -1)
    reward = tables.reward * on_goal[..., None, :] + tables.cost[:, None]
    return reward + tables.gamma * expected


def log_policy(tables: Tables, who: int, state: Array) -> Array:
    """log P(a | s, H): softmax of beta Q, uniform for the irrational. [..., A, O, H]."""
    xp = namespace(tables.cells)
    scaled = tables.sharpness[who] * action_values(tables, who, state)
    scaled = scaled - xp.max(scaled, axis=-2, keepdims=True)
    log_probability = scaled - xp.log(xp.sum(xp.exp(scaled), axis=-2, keepdims=True))
    irrational = xp.full_like(log_probability[..., :1], -_LOG_ACTIONS)
    return xp.concatenate([log_probability, irrational], axis=-1)[..., tables.columns[who]]


_LOG_ACTIONS = 1.6094379124341003  # log 5


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
    xp = namespace(tables.cells)
    first = moves.outcomes(0)
    actions = [a for a, _ in first]
    reached = xp.moveaxis(tables.successor[0][:, state], 0, -1)  # [..., A]
    # Failing leaves the state as it is, which is where staying leads.
    middle = reached[..., [a if ok else STAY for a, ok in first]]
    moved = reached != state[..., None]
    valid = xp.stack([moved[..., a] | ok for a, ok in first], axis=-1)
    p = tables.success[0]
    chance = _chance(xp, first, moved, p)
    row = log_policy(tables, 0, state)[..., actions, :, :]
    if len(moves.weak) == 1:
        return Branches(middle, valid, (row[..., :, None, :, :],), chance)
    second = moves.outcomes(1)
    answers = [a for a, _ in second]
    landed = xp.moveaxis(tables.successor[1][:, reached], 0, -1)  # [..., A, A]
    answered = log_policy(tables, 1, reached)[..., answers, :, :]  # [..., A, n_2, O, H]
    by_outcome = [a if ok else STAY for a, ok in first]
    end = landed[..., by_outcome, :][..., [a if ok else STAY for a, ok in second]]
    moved2 = landed[..., by_outcome, :] != middle[..., None]
    valid2 = xp.stack([moved2[..., a] | ok for a, ok in second], axis=-1)
    chance2 = _chance(xp, second, moved2, tables.success[1])
    shape = (*end.shape[:-2], end.shape[-2] * end.shape[-1])
    return Branches(
        end.reshape(shape),
        (valid[..., None] & valid2).reshape(shape),
        (row[..., :, None, :, :], answered[..., by_outcome, :, :, :]),
        (chance[..., None] * chance2).reshape(shape),
    )


def endings(tables: Tables, moves: Moves, state: Array) -> Array:
    """The states after each joint turn, [..., K]: `turns` without what anybody expects."""
    xp = namespace(tables.cells)
    ends = xp.asarray(state)[..., None]
    for who in range(len(moves.weak)):
        acts = [action if ok else STAY for action, ok in moves.outcomes(who)]
        moved = xp.moveaxis(tables.successor[who][:, ends], 0, -1)[..., acts]
        ends = moved.reshape(*ends.shape[:-1], -1)
    return ends


def _chance(xp: Any, outcomes: tuple[tuple[int, bool], ...], moved: Array, p: Array) -> Array:
    """Probability of each outcome given its action: 1 where there was nothing to attempt."""
    one = xp.ones_like(p)
    return xp.stack(
        [xp.where(moved[..., a], p if ok else 1 - p, one * ok) for a, ok in outcomes], axis=-1
    )


def drops(tables: Tables, moves: Moves, state: Array) -> tuple[Array, Array]:
    """The states after each event (every thing onto every cell) and whether it can happen.

    Shapes [..., events * slots]. A thing falls only while it is absent, onto a free cell.
    """
    xp = namespace(tables.cells)
    cells = xp.arange(moves.slots)
    here = tables.cells[state]
    results, possible = [], []
    for entity in moves.events:
        code = (here * tables.strides).sum(-1)[..., None]
        there = xp.where(cells < tables.absent, cells - tables.absent, 0)
        after = tables.lookup[code + there * tables.strides[entity]]
        absent = here[..., entity, None] == tables.absent
        possible.append(absent & (cells < tables.absent) & (after >= 0))
        results.append(xp.where(possible[-1], after, state[..., None]))
    return xp.concatenate(results, axis=-1), xp.concatenate(possible, axis=-1)


def transition(tables: Tables, moves: Moves, state: Array, action: Array) -> Array:
    """The state after an action of the story (chance outcomes are part of the action)."""
    xp = namespace(tables.cells)
    after = _step(tables, moves, state, action)[-1]
    if not moves.events:
        return after
    fallen, _ = drops(tables, moves, state)
    event = xp.clip(action - moves.turn_count, 0, fallen.shape[-1] - 1)
    dropped = xp.take_along_axis(fallen, event[..., None], axis=-1)[..., 0]
    return xp.where(action >= moves.turn_count, dropped, after)


def _step(tables: Tables, moves: Moves, state: Array, action: Array) -> list[Array]:
    """The state before, between and after the characters' actions in a turn."""
    xp = namespace(tables.cells)
    states = [state]
    for who in range(len(moves.weak)):
        act, success = decode(moves, who, action, xp)
        moved = tables.successor[who][act, states[-1]]
        states.append(xp.where(success, moved, states[-1]))
    return states


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
    states = _step(tables, moves, state, action)
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
    states = _step(tables, moves, state, action)
    is_turn = (action < moves.turn_count)[..., None, None]
    best = (xp.max(log_policy(tables, who, states[who]), axis=-3) for who in range(len(moves.weak)))
    return tuple(xp.where(is_turn, row, 0.0) for row in best)


def alternatives(
    tables: Tables, moves: Moves, state: Array, action: Array
) -> tuple[tuple[Array, Array], ...]:
    """log P(a | H) of all that each character could do where it acts, [..., A, O, H], and what it
    did, [...]."""
    states = _step(tables, moves, state, action)
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
    states = _step(tables, moves, state, action)
    tried, succeeded = [], []
    for who, weak in enumerate(moves.weak):
        if weak:
            act, success = decode(moves, who, action, xp)
            possible = tables.successor[who][act, states[who]] != states[who]
            tried.append(possible)
            succeeded.append(possible & success)
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
    states, done = _step(tables, moves, before, action), action < moves.turn_count
    for who, act in enumerate(acts):
        if act is None:
            continue
        chosen, success = decode(moves, who, action, xp)
        done &= (chosen == act[0]) & (success != act[1])
        if act[1]:  # what is in the way makes no move fail
            done &= tables.successor[who][chosen, states[who]] != states[who]
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
    xp = namespace(tables.cells)
    match name:
        case "at":
            entity, places = arguments
            return (tables.cells[state, entity][..., None] == xp.asarray(places)).any(-1)
        case "absent":
            return tables.cells[state, arguments[0]] == tables.absent
        case "adjacent" | "touching":
            return _adjacent(tables, state, *arguments)
        case "sees" | "distance":
            entity, other, table = arguments
            here = tables.cells[state, entity]
            if other is not None:
                here = here * (tables.absent + 1) + tables.cells[state, other]
            return xp.asarray(table)[here]
    assert before is not None
    assert action is not None
    is_turn = action < moves.turn_count
    if name == "fell":
        gone = tables.cells[before, arguments[0]] == tables.absent
        return gone & (tables.cells[state, arguments[0]] != tables.absent)
    who = arguments[0]
    act, _ = decode(moves, who, action, xp)
    if name in ("tried", "idle"):
        tried = is_turn & (act != STAY)
        return tried if name == "tried" else ~tried
    states = _step(tables, moves, before, action)
    if name == "faces":
        return is_turn & _ahead(tables, states[who], who, act, arguments[1])
    entity = who if name == "moved" else arguments[1]
    changed = tables.cells[states[who], entity] != tables.cells[states[who + 1], entity]
    return is_turn & changed if name == "moved" or entity != who else is_turn & False


def _ahead(tables: Tables, state: Array, who: int, act: Array, spot: Any) -> Array:
    """Whether an action points to an entity or a place: into the quarter in which that lies."""
    xp = namespace(tables.cells)
    here = tables.coordinates[tables.cells[state, who]]
    there = tables.cells[state, spot][..., None] if isinstance(spot, int) else xp.asarray(spot)
    way = tables.coordinates[there] - here[..., None, :]
    ahead = (way * xp.asarray(OFFSETS)[act][..., None, :]).sum(-1)
    return ((ahead > 0) & (2 * ahead >= abs(way).sum(-1)) & (there != tables.absent)).any(-1)


def _adjacent(tables: Tables, state: Array, a: int, b: int) -> Array:
    """Whether two entities stand on neighbouring cells (both must be there)."""
    first, second = tables.cells[state, a], tables.cells[state, b]
    present = (first != tables.absent) & (second != tables.absent)
    distance = abs(tables.coordinates[first] - tables.coordinates[second]).sum(-1)
    return present & (distance == 1)
