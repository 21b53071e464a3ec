"""A grid world, planned and ready: the World protocol over worlds/grid/model.py."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NoReturn

import numpy as np

from i2pdsl.audience.filter import Switching
from i2pdsl.audience.holding import HoldingTables, way_of
from i2pdsl.audience.particles import looked_up
from i2pdsl.language import typed as ty
from i2pdsl.language.vocabulary import Vocabulary
from i2pdsl.sizes import padded_size
from i2pdsl.worlds.grid import features, model
from i2pdsl.worlds.grid.arrays import (
    Moves,
    Tables,
    arrangement,
    cells_at,
    entries,
    namespace,
    padded,
    state_count,
)
from i2pdsl.worlds.grid.dynamics import Dynamics, initial_marks
from i2pdsl.worlds.grid.expected import expected
from i2pdsl.worlds.grid.holdings import holdings_of, problems_in_space, space_and_rows
from i2pdsl.worlds.grid.known import Known
from i2pdsl.worlds.grid.looked_up import by_problem, with_policies
from i2pdsl.worlds.grid.method import check_size, planned, states_of
from i2pdsl.worlds.grid.packed import Computed, States
from i2pdsl.worlds.grid.parts import part_of
from i2pdsl.worlds.grid.planning import Plan, Report
from i2pdsl.worlds.grid.policy import value
from i2pdsl.worlds.grid.problems import (
    problem_keys,
)
from i2pdsl.worlds.grid.sight import in_sight, walking
from i2pdsl.worlds.grid.spec import GridSpec
from i2pdsl.worlds.grid.vocabulary import grid_vocabulary
from i2pdsl.worlds.world import (
    Branches,
    Part,
    SmallWorld,
    Viewer,
    on_device,
)

Array = Any

LEAST_DOUBT = 1e-9  # forgotten after each action: in single precision far from 0 for all hypotheses


@dataclass(frozen=True)
class GridWorld:
    """A world as the audience, the objectives and the searches see it.

    Attributes:
        spec: the world as it is; viewers may believe in other numbers.
        tables: the arrays, in NumPy and doubles (arrays.Tables).
        residual: the Bellman residual of the values.
        bound: how far values may be from the truth.
        planning_seconds: time spent on planning, 0 where all came from the cache.
    """

    spec: GridSpec
    dynamics: States
    tables: Tables
    moves: Moves
    residual: float
    bound: float
    planning_seconds: float

    @property
    def name(self) -> str:
        return self.spec.name

    @cached_property
    def vocabulary(self) -> Vocabulary:
        return grid_vocabulary(self.spec)

    @cached_property
    def cell_number(self) -> dict[tuple[int, int], int]:
        return {(int(c), int(r)): i for i, (c, r) in enumerate(self.dynamics.coordinates)}

    @property
    def weak_chances(self) -> tuple[float, ...]:
        """The success probabilities of the weak characters."""
        return tuple(c.success for c in self.spec.characters if c.is_weak)

    # The protocol (worlds/world.py).

    @cached_property
    def search_tables(self) -> Tables:
        tables = on_device(padded(self.tables))
        if self.lists_states:
            tables = with_policies(tables, state_count(self.tables))
        if tables.policies is not None or not self.lists_hypotheses:
            return tables
        return tables._replace(by_problem=on_device(by_problem(self.tables)))

    def program_key(self, turns: tuple[ty.Turn, ...]) -> tuple[Any, ...]:
        cells = tuple(self.cell_number[t.cell] for t in turns if isinstance(t, ty.Drop))
        return (self.moves, cells, self.keeps_doubt)

    def log_prior(self, tables: Tables) -> Array:
        return tables.log_prior

    def forgetting(self, tables: Tables) -> Array:
        return tables.forgetting

    def switching(self, tables: Tables) -> tuple[Switching | None, ...]:
        return tables.switching or (None,) * len(self.moves.weak)

    def holdings(self, tables: Tables) -> tuple[HoldingTables | None, ...]:
        return tables.holdings

    def holding(self, viewers: tuple[Viewer, ...]) -> GridWorld:
        holdings = holdings_of(self.spec, self.vocabulary, viewers, self.tables)
        return replace(self, tables=self.tables._replace(holdings=holdings))

    @property
    def lists_hypotheses(self) -> bool:
        return not self.spec.is_sampled

    def acting(self, rows: np.ndarray, generator: np.random.Generator) -> np.ndarray:
        if self.lists_hypotheses:
            return np.broadcast_to(rows[:, None], (len(rows), len(self.moves.weak)))
        space, every = space_and_rows(self.spec, self.vocabulary)
        minds = every.drawn(rows, generator)
        problems = problems_in_space(self.spec, space)
        return np.stack([looked_up(each, minds) for each in problems], axis=-1)

    @property
    def keeps_doubt(self) -> bool:
        if not self.lists_hypotheses:
            return all(way_of(each).doubts(each) for each in self.tables.holdings if each)
        if self.tables.holdings:
            return False
        possible, forgetting = self.tables.log_prior > -np.inf, self.tables.forgetting
        each = np.broadcast_to(
            forgetting if forgetting.ndim == 2 else forgetting[:, None], possible.shape
        )
        return not self.tables.switching and bool((each[possible] >= LEAST_DOUBT).all())

    def all_states(self, tables: Tables) -> Array:
        # With a horizon, each arrangement in each of its frames.
        return namespace(tables.coordinates).arange(state_count(tables))

    @property
    def lists_states(self) -> bool:
        return isinstance(self.dynamics, Dynamics)

    def small(self, about: frozenset[int]) -> SmallWorld | None:
        return part_of(self.spec, about, unplanned_world)

    def row(self, tables: Tables, rows: Array, state: Array) -> Array:
        cells = cells_at(tables, arrangement(tables, state))
        return sum(entries(part, cells[..., e]) for e, part in enumerate(rows))

    def turns(self, tables: Tables, state: Array) -> Branches:
        return model.turns(tables, self.moves, state)

    def endings(self, tables: Tables, state: Array) -> Array:
        return model.endings(tables, self.moves, state)

    def branch_actions(self, who: int) -> tuple[int, ...]:
        return tuple(action for action, _ in self.moves.outcomes[who])

    def drops(self, tables: Tables, state: Array) -> tuple[Array, Array]:
        return model.drops(tables, self.moves, state)

    def transition(self, tables: Tables, state: Array, action: Array) -> Array:
        return model.transition(tables, self.moves, state, action)

    def no_action(self, state: Array) -> Array:
        return state * 0

    def log_rows(
        self, tables: Tables, state: Array, action: Array, after: Array
    ) -> tuple[Array, ...]:
        known = self._known if tables is self.tables else ()
        return model.log_rows(tables, self.moves, state, action, known=known)

    @cached_property
    def _known(self) -> tuple[Known, ...]:
        if not self.lists_states or not self.lists_hypotheses or self.tables.terms is not None:
            return ()
        return tuple(Known(self.tables, who) for who in range(len(self.moves.weak)))

    def best_rows(
        self, tables: Tables, state: Array, action: Array, after: Array
    ) -> tuple[Array, ...]:
        return model.best_rows(tables, self.moves, state, action)

    def alternatives(
        self, tables: Tables, state: Array, action: Array, after: Array
    ) -> tuple[tuple[Array, Array], ...]:
        return model.alternatives(tables, self.moves, state, action)

    def is_still(self, tables: Tables, state: Array, after: Array) -> Array:
        return arrangement(tables, state) == arrangement(tables, after)

    def stillness(self, tables: Tables, state: Array, after: Array) -> Array:
        xp = namespace(tables.coordinates)
        return xp.where(self.is_still(tables, state, after), 1.0, 0.0)

    def outcome(
        self, tables: Tables, state: Array, action: Array
    ) -> tuple[Array, tuple[Array, ...], tuple[Array, ...]]:
        return model.outcome(tables, self.moves, state, action)

    def is_observed(self, action: Array) -> Array:
        return action < self.moves.turn_count

    def value(self, tables: Tables, who: int, state: Array) -> Array:
        return value(tables, who, state)

    def attempts(self, tables: Tables, state: Array, action: Array) -> tuple[Array, Array]:
        return features.attempts(tables, self.moves, state, action)

    def feature(
        self,
        tables: Tables,
        name: str,
        arguments: tuple[Any, ...],
        state: Array,
        before: Array | None = None,
        action: Array | None = None,
    ) -> Array:
        return features.feature(tables, self.moves, name, arguments, state, before, action)

    def feature_arguments(self, name: str, arguments: tuple[Any, ...]) -> tuple[Any, ...]:
        """The checker's arguments in the model's numbers: cells instead of (column, row), and
        what is known of pairs of cells (of each cell and the nearest of a place)."""
        found = tuple(
            tuple(self.cell_number[c] for c in a) if isinstance(a, tuple) else a for a in arguments
        )
        if name not in ("sees", "distance"):
            return found
        table = self._sight if name == "sees" else self.walks
        first, other = found
        if isinstance(other, int):
            return first, other, table.reshape(-1)
        cells = table[:, list(other)]
        return first, None, cells.any(1) if name == "sees" else cells.min(1)

    @cached_property
    def _sight(self) -> np.ndarray:
        return in_sight(self.dynamics.coordinates, self.spec.walls)

    @cached_property
    def walks(self) -> np.ndarray:
        """The steps from each cell to each: [N, N]."""
        return walking(self.dynamics.coordinates, self.spec.walls)

    def act(self, tables: Tables, state: Array, turn: ty.Turn) -> tuple[Array, Array]:
        """An appended turn as an action, and whether it can happen in a state."""
        xp = namespace(tables.coordinates)
        zero = xp.asarray(state) * 0
        if isinstance(turn, ty.Drop):
            number = self._drop(turn)
            _, possible = self.drops(tables, xp.asarray(state))
            return zero + self.moves.turn_count + number, possible[..., number]
        code = self.turn_number([self._done(who, act) for who, act in enumerate(turn)])
        return zero + code, zero == 0

    def turn_number(self, chosen: Sequence[tuple[int, bool]]) -> np.ndarray:
        """The number of a turn in which each character does an action, and succeeds or not."""
        number: Array = 0
        for who, outcome in enumerate(chosen):
            number = number * self.moves.counts[who] + self.moves.outcomes[who].index(outcome)
        return np.asarray(number)

    def _drop(self, drop: ty.Drop) -> int:
        """Its number among the events."""
        event = self.moves.events.index(self.spec.entities.index(drop.thing))
        return event * self.moves.slots + self.cell_number[drop.cell]

    def is_turn(
        self,
        tables: Tables,
        before: Array,
        action: Array,
        turn: tuple[ty.Act | None, ...] | ty.Drop,
    ) -> Array:
        if isinstance(turn, ty.Drop):
            return action == self.moves.turn_count + self._drop(turn)
        acts = [None if act is None else self._done(who, act) for who, act in enumerate(turn)]
        return features.is_turn(tables, self.moves, before, action, acts)

    def _done(self, who: int, act: ty.Act) -> tuple[int, bool]:
        """An action of a character in its own numbers, and whether it succeeds."""
        name = self.vocabulary.actions[act.action]
        return self.moves.actions[who].index(name), not act.fails

    def with_audience(self, sharpness: float, forgetting: Array, log_prior: Array) -> GridWorld:
        """Values stay as they are: beta changes what is made of them, not what the modelled one
        is expected to do. The other viewers hold all hypotheses; where nobody can, they hold the
        particles of these, and differ in sharpness alone."""
        sharper = tuple(sharpness * beta for beta in self.tables.sharpness)
        if not self.lists_hypotheses:
            return replace(self, tables=self.tables._replace(sharpness=sharper))
        told = {"sharpness": sharper, "forgetting": forgetting, "log_prior": log_prior}
        switching = tuple(each.given(log_prior) for each in self.tables.switching)
        return replace(self, tables=self.tables._replace(**told, switching=switching, holdings=()))

    action_shape = ()
    rows_are_scaled = False

    @property
    def turn_count(self) -> int:
        return self.moves.turn_count

    @property
    def dropped(self) -> tuple[int, ...]:
        return self.moves.events

    @property
    def event_slots(self) -> int:
        return self.moves.slots

    def events(self, allowed: tuple[tuple[str, str], ...]) -> tuple[int, ...]:
        entities = self.spec.entities
        return tuple(self.moves.events.index(entities.index(thing)) for _, thing in allowed)

    def guesses(
        self, length: int, seeds: int, noise: float, seed: int, state: np.ndarray
    ) -> NoReturn:
        raise NotImplementedError("actions are listed, not descended to")

    def starts(self, points: Sequence[ty.Point] = (), parts: Sequence[Part] = ()) -> np.ndarray:
        """All arrangements, with everybody in the place that the world gives him at first, and
        nobody having been anywhere else; some, where states are computed."""
        placed = [-1 if cell is None else self.cell_number[cell] for cell in self.spec.placed]
        if isinstance(self.dynamics, Computed):
            return self.dynamics.drawn(placed, parts)
        every = np.arange(self.dynamics.state_count)
        return every[self.begins(every)]

    def begins(self, states: np.ndarray) -> np.ndarray:
        """Whether somebody can begin in some arrangements: with everybody in the place that the
        world gives him at first, and nobody having been anywhere else."""
        placed = [-1 if cell is None else self.cell_number[cell] for cell in self.spec.placed]
        given = [entity for entity, cell in enumerate(placed) if cell >= 0]
        cells, first = self.dynamics.cells_of(states), len(self.spec.entities)
        there: np.ndarray = (cells[..., given] == np.array(placed, dtype=int)[given]).all(-1)
        marks = cells[..., first : first + len(self.spec.marks)]
        return there & (marks == initial_marks(self.spec, cells)).all(-1)


def build_world(
    spec: GridSpec,
    viewers: tuple[Viewer, ...] | None = None,
    report: Report | None = None,
    say: Callable[[str], None] | None = None,
) -> GridWorld:
    """Plans a world (or reads its plans from the cache) for one or several viewers.

    Raises StoryError where the world is too large.
    """
    check_size(spec)
    viewers = viewers or (Viewer(spec),)
    dynamics = states_of(spec)
    plans: dict[str, Plan] = {}
    for viewer in viewers:
        if viewer.spec.planning_key not in plans:
            plans[viewer.spec.planning_key] = planned(viewer.spec, dynamics, report, say)
    return assemble(spec, dynamics, viewers, [plans[v.spec.planning_key] for v in viewers])


def unplanned_world(spec: GridSpec) -> GridWorld:
    """A world that knows its moves but not what anyone expects: enough to check a script.

    Raises StoryError where the world is too large.
    """
    check_size(spec)
    keys = problem_keys(spec)
    dynamics = states_of(spec)
    states = dynamics.state_count * spec.frame_count if isinstance(dynamics, Dynamics) else 0
    nothing = tuple(np.broadcast_to(np.zeros(()), (states, len(problems))) for problems in keys)
    return assemble(spec, dynamics, (Viewer(spec),), [Plan(keys, nothing, 0.0, 0.0)])


def assemble(
    spec: GridSpec, dynamics: States, viewers: tuple[Viewer, ...], plans: list[Plan]
) -> GridWorld:
    """Puts the viewers' plans side by side into one set of tables."""
    tables = expected(spec, dynamics, viewers, plans)
    tables = tables._replace(holdings=holdings_of(spec, grid_vocabulary(spec), viewers, tables))
    moves = Moves(
        tuple(c.is_weak for c in spec.characters),
        padded_size(len(dynamics.coordinates), 32) if spec.events else 0,
        len(spec.entities),
        tuple(spec.entities.index(thing) for _, things in spec.events for thing in things),
        tuple(c.actions for c in spec.characters),
        spec.groups,
        spec.frame_count,
        spec.together,
    )
    return GridWorld(
        spec,
        dynamics,
        tables,
        moves,
        max(p.residual for p in plans),
        max(p.bound for p in plans),
        sum(p.seconds for p in {id(p): p for p in plans}.values()),
    )
