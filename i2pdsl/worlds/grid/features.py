"""What can be asked of the states and frames of a grid world, as functions of arrays (model.py)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from i2pdsl.worlds.grid.arrays import Moves, Tables, arrangement, cell_of, cells_at, namespace
from i2pdsl.worlds.grid.model import chosen_at, decode, steps
from i2pdsl.worlds.grid.spec import OFFSET_OF, STAY

Array = Any


def attempts(tables: Tables, moves: Moves, state: Array, action: Array) -> tuple[Array, Array]:
    """Which weak characters made a move that could succeed, and whose did: [..., weak] each."""
    xp = namespace(tables.coordinates)
    done, _ = steps(tables, moves, state, action)
    tried, succeeded = [], []
    for who, weak in enumerate(moves.weak):
        if weak:
            tried.append(done[who].would)
            succeeded.append(done[who].would & done[who].success)
    return xp.stack(tried, axis=-1), xp.stack(succeeded, axis=-1)


def is_turn(
    tables: Tables,
    moves: Moves,
    before: Array,
    action: Array,
    acts: Sequence[tuple[int, bool] | None],
) -> Array:
    """Whether everybody does so: (action, whether it succeeds) of each, None for anything."""
    each, _ = steps(tables, moves, before, action)
    done = action < moves.turn_count
    for who, act in enumerate(acts):
        if act is None:
            continue
        done &= (each[who].act == act[0]) & (each[who].success == act[1])
        if not act[1]:  # what is in the way makes no move fail
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
    xp, here = namespace(tables.coordinates), arrangement(tables, state)
    match name:
        case "at":
            entity, places = arguments
            return (cell_of(tables, here, entity)[..., None] == xp.asarray(places)).any(-1)
        case "absent":
            return cell_of(tables, here, arguments[0]) == tables.absent
        case "holds":
            who, thing = arguments
            return cell_of(tables, here, thing) == tables.absent + 1 + who
        case "adjacent" | "touching":
            return _adjacent(tables, here, *arguments)
        case "sees" | "distance":
            entity, other, table = arguments
            on_map = lambda thing: xp.minimum(cell_of(tables, here, thing), tables.absent)
            place = on_map(entity)
            if other is not None:
                place = place * (tables.absent + 1) + on_map(other)
            return xp.asarray(table)[place]
    assert before is not None
    assert action is not None
    is_turn = action < moves.turn_count
    if name == "fell":
        gone = cell_of(tables, arrangement(tables, before), arguments[0]) == tables.absent
        return gone & (cell_of(tables, here, arguments[0]) != tables.absent)
    who = arguments[0]
    act, _ = decode(moves, who, action, xp)
    if name in ("tried", "idle"):
        tried = is_turn & (act != STAY)
        return tried if name == "tried" else ~tried
    if name == "faces":
        done, _ = steps(tables, moves, before, action)
        seen = arrangement(tables, chosen_at(tables, moves, before, done)[who])
        offsets = [OFFSET_OF[name] for name in moves.actions[who]]
        return is_turn & _ahead(tables, seen, who, xp.asarray(offsets)[act], arguments[1])
    entity = who if name == "moved" else arguments[1]
    step = steps(tables, moves, before, action)[0][who]
    left, now = cell_of(tables, step.before, entity), cell_of(tables, step.after, entity)
    changed = left != now
    for group in moves.alike:
        if entity in group:  # whoever of them stood there is there no more
            now = cells_at(tables, step.after)[..., list(group)]
            changed = (left[..., None] != now).all(-1)
    if name == "moved":
        return is_turn & changed
    mine = tables.absent + 1 + who
    match name:
        case "takes":
            return is_turn & changed & (now == mine)
        case "opens":
            return is_turn & changed & (now == tables.absent)
        case "puts":
            return is_turn & (left == mine) & (now < tables.absent)
        case "gives":
            return is_turn & (left == mine) & (now > tables.absent) & changed
    on_map = (left < tables.absent) & (cell_of(tables, step.after, entity) < tables.absent)
    return is_turn & changed & on_map if entity != who else is_turn & False


def _ahead(tables: Tables, state: Array, who: int, offset: Array, spot: Any) -> Array:
    """Whether a way [..., 2] points to something or a place: into the quarter where that lies."""
    xp = namespace(tables.coordinates)
    here = tables.coordinates[cell_of(tables, state, who)]
    there = cell_of(tables, state, spot)[..., None] if isinstance(spot, int) else xp.asarray(spot)
    way = tables.coordinates[there] - here[..., None, :]
    ahead = (way * offset[..., None, :]).sum(-1)
    return ((ahead > 0) & (2 * ahead >= abs(way).sum(-1)) & (there < tables.absent)).any(-1)


def _adjacent(tables: Tables, state: Array, a: int, b: int) -> Array:
    """Whether two entities stand on neighbouring cells (both must be there)."""
    first, second = cell_of(tables, state, a), cell_of(tables, state, b)
    present = (first < tables.absent) & (second < tables.absent)
    distance = abs(tables.coordinates[first] - tables.coordinates[second]).sum(-1)
    return present & (distance == 1)
