"""The arrays of a grid world that is ready, and the layout of its actions. What they mean together,
and the letters of their shapes, says model.py."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from i2pdsl.audience.filter import Switching
from i2pdsl.audience.holding import HoldingTables
from i2pdsl.sizes import padded_size
from i2pdsl.worlds.grid.spec import STAY

Array = Any


class Tables(NamedTuple):
    """The numbers of a world under one or several observers.

    Attributes:
        cells [S, E], lookup, strides [E], successor, for each character [A, S]: see dynamics.py;
            None, and no successors, where states are computed.
        spots [C]: the column of `cells` with which `goals` are looked up, see dynamics.py.
        coordinates [M, 2]: (column, row) of each cell; the rows from N on stand for no cell.
        absent []: the cell number of a thing that is not there, N.
        success [C]: probability that a character's move succeeds.
        cost [9]: reward of an action away from the goal.
        ground [M]: what any action on a cell costs besides.
        gamma []: discount factor.
        reward []: reward on the goal tile.
        continuation: for each character [F * S, P], the value W after an action, before the
            other's answer, for each planning problem (planning/value_iteration.py); of both who
            act together, the value after the frame.
        columns: for each character [O, H], the problem of a hypothesis; P where irrational.
        sharpness: for each character [P], beta of the problem's observer.
        goals: for each character [P, (N + 1) 2^m], whether it counts as being at its goal in a cell
            with its m marks (dynamics.py:cells).
        log_prior [O, H]: the belief before anything moved.
        forgetting [O]: share of belief that is reassigned after each action.
        switching: how each character's goal changes after its actions; empty if none does.
        layer []: S, where there is a horizon; else None.
        against: what each character expects of those who act together with it; else None.
        policies: for each character log P(a | s, H), [F * S, A, O, H]; None where that is made of
            the values whenever it is asked for.
        by_problem: for each character its problems, for searches without `policies`; empty where
            they would save nothing.
        holdings: the particles or factors of each observer (None of who lists all hypotheses);
            empty where everybody lists them.
        terms: for each character, of what its values are the sum, where they are additive: then
            `continuation` holds [R, P], the values of all sub-worlds one below the other.
        packed: how states are computed, where they are not listed.
    """

    cells: Array
    lookup: Array
    strides: Array
    spots: Array
    successor: tuple[Array, ...]
    coordinates: Array
    absent: Array
    success: Array
    cost: Array
    ground: Array
    gamma: Array
    reward: Array
    continuation: tuple[Array, ...]
    columns: tuple[Array, ...]
    sharpness: tuple[Array, ...]
    goals: tuple[Array, ...]
    log_prior: Array
    forgetting: Array
    switching: tuple[Switching, ...] = ()
    layer: Array | None = None
    against: tuple[tuple[Against, ...], ...] | None = None
    policies: tuple[Array, ...] | None = None
    by_problem: tuple[Problems, ...] = ()
    holdings: tuple[HoldingTables | None, ...] = ()
    terms: tuple[Terms, ...] | None = None
    packed: Packed | None = None


class Problems(NamedTuple):
    """What a character may act by, as each observer sees it; Q is 0 where that would save nothing
    (programs are kept by shapes, so it is told by these).

    Attributes:
        columns [O, Q]: of its P problems those that an observer knows of, and last P: that it is
            irrational. P again where others know of more.
        hypotheses [O, Q, H]: those of each, one-hot; none of such a repetition.
    """

    columns: Array
    hypotheses: Array


class Terms(NamedTuple):
    """A value as a sum over K sub-worlds (additive.py).

    Attributes:
        rows [E, M, K]: what a cell of each entity adds to the number of the row of each term.
        first [K]: the first row of each term's sub-world.
        sign [K]: how often it counts.
    """

    rows: Array
    first: Array
    sign: Array


class Packed(NamedTuple):
    """How states are numbers that tell cells, and what follows them (packed.py).

    Attributes:
        radix [E]: how many places each entity has; the last one's digit is the lowest.
        places [E, most]: the cell of each digit.
        digits [E, M]: what each cell adds to the number.
        absent []: the cell number of a thing that is not there.
        rules: what each character can do.
        alike [E - 1]: whether an entity and the next one are told apart only by their cells; None
            where all are.
    """

    radix: Array
    places: Array
    digits: Array
    absent: Array
    rules: tuple[Rules, ...]
    alike: Array


class Rules(NamedTuple):
    """What a character's A actions do, None where nothing does such a thing; cells are -1 where
    there is none.

    Attributes:
        target [N + 1, A]: the cell to which it goes; its own where it stays.
        others [E]: who is not itself.
        beyond [N + 1, A]: the cell to which what stands on the target is pushed.
        pushes, takes, opens [A, E]: whether what stands on the target is pushed, taken or opened.
        keys [E, E]: which doors open to who has which things.
        behind [N + 1, A]: the cell from which something is pulled.
        pulls [E], is_pull [A]: what it pulls, and by which actions.
        aside [N + 1, A]: the cell onto which it puts something.
        puts [n]: what it puts down, the first first.
        holders [n, C]: who carries each of these.
    """

    target: Array
    others: Array
    beyond: Array
    pushes: Array
    takes: Array
    opens: Array
    keys: Array
    behind: Array
    pulls: Array
    is_pull: Array
    aside: Array
    puts: Array
    holders: Array


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


def entries(table: Array, index: Any) -> Array:
    """`table[index]`, of numbers that are in it: JAX need not look for others, which is half of
    what it does otherwise."""
    if not hasattr(table, "at"):
        return table[index]
    return table.at[index].get(mode="promise_in_bounds", wrap_negative_indices=False)


def cells_of(packed: Packed, state: Array) -> Array:
    """The cells [..., E] in computed states."""
    left, found = state, []
    for entity in range(len(packed.radix) - 1, -1, -1):
        radix = packed.radix[entity]
        found.append(entries(packed.places[entity], left % radix if entity else left))
        left = left // radix
    return namespace(packed.radix).stack(found[::-1], axis=-1)


def state_of(packed: Packed, cells: Array) -> Array:
    """The numbers of computed states with such cells [..., E]."""
    return sum(entries(part, cells[..., e]) for e, part in enumerate(packed.digits))


def cells_at(tables: Tables, here: Array) -> Array:
    """The cells [..., E] in some arrangements, and what follows them (dynamics.py)."""
    return tables.cells[here] if tables.packed is None else cells_of(tables.packed, here)


def cell_of(tables: Tables, here: Array, entity: Any) -> Array:
    """The cell of an entity in some arrangements, [...]."""
    if tables.packed is None:
        return tables.cells[here, entity]
    return cells_at(tables, here)[..., entity]


def at_goal(tables: Tables, who: int, here: Array) -> Array:
    """Whether a character counts as being at its goal in an arrangement, in each of its problems:
    [..., P]."""
    spot = cell_of(tables, here, tables.spots[who])
    return namespace(tables.coordinates).moveaxis(tables.goals[who][:, spot], 0, -1)


def arrangement(tables: Tables, state: Array) -> Array:
    """A state without its frame."""
    return state if tables.layer is None else state % tables.layer


def state_count(tables: Tables) -> int:
    """How many states are listed; with a horizon, in all frames."""
    return len(tables.cells if tables.terms is not None else tables.continuation[0])


def continued(tables: Tables, who: int, state: Array) -> Array:
    """W(s) of every planning problem: [..., P]."""
    if tables.terms is None:
        return tables.continuation[who][state]
    return summed_terms(tables, who, cells_at(tables, state))


def summed_terms(tables: Tables, who: int, cells: Array) -> Array:
    """W(s) of every planning problem as a sum, where entities stand in such cells [..., E]."""
    assert tables.terms is not None
    rows, first, sign = tables.terms[who]
    row = first + sum(entries(part, cells[..., e]) for e, part in enumerate(rows))
    return (entries(tables.continuation[who], row) * sign[:, None]).sum(-2)


def padded(tables: Tables) -> Tables:
    """The tables with states and cells up to sizes that worlds share, so that they share programs.

    No number of a real state or cell leads to what is added.
    """
    cells = padded_size(len(tables.coordinates), 128)
    along = lambda axis, size: lambda a: _lengthened(a, axis, size)
    if tables.packed is None:
        states = padded_size(len(tables.cells), 8192)
        tables = tables._replace(
            cells=along(0, states)(tables.cells),
            lookup=_lengthened_lookup(tables.lookup),
            successor=tuple(map(along(1, states), tables.successor)),
        )
    else:
        by_cell = ("target", "beyond", "behind", "aside")
        packed = tables.packed
        longer = lambda table: None if table is None else along(0, cells)(table)
        rules = (
            r._replace(**{name: longer(getattr(r, name)) for name in by_cell}) for r in packed.rules
        )
        tables = tables._replace(
            packed=packed._replace(
                places=along(1, cells)(packed.places),
                digits=along(1, cells)(packed.digits),
                rules=tuple(rules),
            )
        )
    return tables._replace(
        coordinates=along(0, cells)(tables.coordinates),
        ground=along(0, cells)(tables.ground),
        continuation=tuple(
            along(0, padded_size(len(table), 8192))(table) for table in tables.continuation
        ),
        terms=tables.terms
        and tuple(t._replace(rows=along(1, cells)(t.rows)) for t in tables.terms),
        goals=tuple(along(1, padded_size(g.shape[1], 128))(g) for g in tables.goals),
    )


def _lengthened_lookup(lookup: np.ndarray) -> np.ndarray:
    """Longer, without numbers that are asked for; a list of those that there are stays sorted."""
    size = padded_size(lookup.shape[-1], 8192)
    if lookup.ndim == 1:
        return _lengthened(lookup, 0, size)
    return np.pad(lookup, [(0, 0), (0, size - lookup.shape[-1])], mode="maximum")


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
    actions: tuple[tuple[str, ...], ...]  # of each character
    alike: tuple[tuple[int, ...], ...] = ()  # entities that are not told apart
    frames: int = 1  # F
    together: bool = False

    @cached_property
    def outcomes(self) -> tuple[tuple[tuple[int, bool], ...], ...]:
        """(action, success) for each outcome of each character; staying cannot fail."""
        found = []
        for actions, is_weak in zip(self.actions, self.weak, strict=True):
            succeed = tuple((a, True) for a in range(len(actions)))
            fail = tuple((a, False) for a, _ in succeed if a != STAY)
            found.append(succeed + fail if is_weak else succeed)
        return tuple(found)

    @cached_property
    def counts(self) -> tuple[int, ...]:
        return tuple(map(len, self.outcomes))

    @property
    def turn_count(self) -> int:
        return math.prod(self.counts)

    @cached_property
    def turns(self) -> tuple[tuple[np.ndarray, np.ndarray], ...]:
        """Each character's action in each turn, and whether it succeeds, [turn_count + 1] each; the
        last place is for all events, in which everybody stays."""
        number, found = np.arange(self.turn_count), []
        for who, outcomes in enumerate(self.outcomes):
            own = number // math.prod(self.counts[who + 1 :]) % len(outcomes)
            acts, done = (
                np.asarray(each)[np.append(own, STAY)] for each in zip(*outcomes, strict=True)
            )
            found.append((acts, done))
        return tuple(found)


def namespace(array: Array) -> Any:
    """numpy or jax.numpy, whichever the array belongs to."""
    return array.__array_namespace__()
