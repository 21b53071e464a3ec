"""Exact planning around scripts of an additive world, where exact plans for all of it do not fit.

What scripts tell of values are those where they lead, and things stand in few places there. So all
arrangements are planned exactly in which the things stand as in one of the scripts, or so that a
few moves of one of them lead there; the characters may be anywhere. What leads out of these has the
additive values: beyond, things may still be in each other's way in ways that are not known of.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from i2pdsl.planning import store
from i2pdsl.planning.problem import Problem
from i2pdsl.sizes import memory_limit
from i2pdsl.worlds.grid import model
from i2pdsl.worlds.grid.arrays import Tables, continued
from i2pdsl.worlds.grid.cost import SWEEP_SECONDS, SWEEPS, state_bytes
from i2pdsl.worlds.grid.dynamics import Dynamics, listed
from i2pdsl.worlds.grid.following import successors
from i2pdsl.worlds.grid.method import planned
from i2pdsl.worlds.grid.packed import States
from i2pdsl.worlds.grid.planning import FORGIVEN, Plan, family_of, largest_value
from i2pdsl.worlds.grid.policy import action_values
from i2pdsl.worlds.grid.problems import rules_of
from i2pdsl.worlds.grid.spec import GridSpec
from i2pdsl.worlds.grid.world import GridWorld, assemble
from i2pdsl.worlds.kind import Watch
from i2pdsl.worlds.record import Trajectory
from i2pdsl.worlds.world import Viewer

EXACT = 1e-3  # of values: a probability is then right to about as much
MOST_MOVES = 1  # of things, away from where they are in a script
PATIENCE = 90.0  # seconds of planning
SHARE = 0.5  # of the memory, which holds the additive plans, too
AT_ONCE = 1 << 16  # states whose successors are computed together


def around(
    world: GridWorld,
    viewers: tuple[Viewer, ...],
    paths: Sequence[Trajectory],
    watch: Watch | None = None,
) -> tuple[GridWorld, list[Trajectory]] | None:
    """The part of an additive world around some scripts, planned exactly, and the scripts in its
    numbers; None where that takes too long, or too much memory."""
    spec, dynamics, walks = world.spec, world.dynamics, world.walks
    seen = np.unique(np.concatenate([_visited(world, path) for path in paths]))
    everywhere = len(walks) ** len(spec.characters)
    for moves in (MOST_MOVES, 0):
        placed = placements(spec, dynamics, walks, seen, moves)
        if _fits(world, len(placed) * everywhere):
            break
    else:
        return None
    states = arrangements(spec, dynamics, placed)
    part, numbers = cut_out(spec, dynamics, world.tables, states)
    plans, watch = {}, watch or Watch()
    for viewer in viewers:
        key = viewer.spec.planning_key
        if key not in plans:
            plan = planned(viewer.spec, dynamics, say=watch.say)
            given = viewer.spec, dynamics, plan, part, numbers, len(states)
            plans[key] = solve_around(*given, watch)
    found = assemble(spec, part, viewers, [plans[v.spec.planning_key] for v in viewers])
    return found, [replace(p, states=np.searchsorted(states, p.states)) for p in paths]


def _visited(world: GridWorld, path: Trajectory) -> np.ndarray:
    """The states of a script, in the middle of its frames too."""
    steps, _ = model.steps(world.tables, world.moves, path.states[:-1], path.actions)
    return np.concatenate([path.states, *(step.before for step in steps)])


def _fits(world: GridWorld, states: int) -> bool:
    """Whether so many states are planned for in little enough time and memory."""
    problems = [table.shape[1] for table in world.tables.continuation]
    # Planning begins with the additive values: it takes as long as from nothing, or half of that
    # (measured: 20 to 60 cells, two characters and three), though values settle slowly at the ends.
    sweeps = SWEEPS / (1 - world.spec.settings.gamma)
    seconds = SWEEP_SECONDS * states * sum(problems) * len(problems) * sweeps
    needed = 2 * states * state_bytes(sum(problems))  # with what leads out of them (measured)
    return seconds <= PATIENCE and needed <= SHARE * memory_limit()


def placements(
    spec: GridSpec, dynamics: States, walks: np.ndarray, states: np.ndarray, moves: int
) -> np.ndarray:
    """The cells [n, things] of the things in some states, or so that so many moves of one of them
    by one cell lead there.

    Args:
        walks: [N, N], the steps from each cell to each.
    """
    count = len(spec.characters)
    placed = np.unique(dynamics.cells_of(states)[:, count:].astype(np.int64), axis=0)
    for _ in range(moves):
        found = [placed]
        for thing in range(placed.shape[1]):
            on_map = placed[placed[:, thing] < len(walks)]
            row, cell = np.nonzero(walks[on_map[:, thing]] == 1)
            moved = on_map[row]
            moved[:, thing] = cell
            found.append(moved)
        placed = np.unique(np.concatenate(found), axis=0)
    return placed


def arrangements(spec: GridSpec, dynamics: States, placed: np.ndarray) -> np.ndarray:
    """All states in which the things stand so, and the characters anywhere; sorted."""
    count, free = len(spec.characters), range(len(spec.free_cells))
    anywhere = np.stack(np.meshgrid(*(free,) * count, indexing="ij"), axis=-1).reshape(-1, count)
    found = []
    for things in placed:
        cells = np.concatenate([anywhere, np.tile(things, (len(anywhere), 1))], axis=1)
        every = dynamics.state_of(cells)
        found.append(every[every >= 0])
    return np.unique(np.concatenate(found))


def cut_out(
    spec: GridSpec, dynamics: States, tables: Tables, states: np.ndarray
) -> tuple[Dynamics, np.ndarray]:
    """Some states, sorted, as a world of their own, and the numbers [L] of its states: first these,
    then those that they lead to, from which nothing leads on."""
    pieces = range(0, len(states), AT_ONCE)
    after = [
        np.concatenate([successors(tables, who, states[i : i + AT_ONCE]) for i in pieces]).T
        for who in range(len(spec.characters))
    ]
    ends = np.unique(np.concatenate([each.reshape(-1) for each in after]))
    numbers = np.concatenate([states, np.setdiff1d(ends, states)])
    order = np.argsort(numbers)
    local = lambda there: order[np.searchsorted(numbers, there, sorter=order)].astype(np.int32)
    every = np.arange(len(numbers), dtype=np.int32)
    successor = tuple(
        np.concatenate([local(each), np.tile(every[len(states) :], (len(each), 1))], axis=1)
        for each in after
    )
    return listed(spec, dynamics.cells_of(numbers), successor), numbers


def solve_around(
    spec: GridSpec,
    dynamics: States,
    plan: Plan,
    part: Dynamics,
    numbers: np.ndarray,
    inside: int,
    watch: Watch,
) -> Plan:
    """The exact plan of a part of a world, given additive values where it ends.

    What was planned last around scripts of the world is kept in the cache. Values are only begun
    with: whatever the cache holds, they are as right as without it. An entry that holds no values
    of the part, or such as nothing settles from, is said and made again.

    Args:
        plan: the additive one.
        part, numbers: see `cut_out`.
        inside: so many of the part's states are planned for.
    """
    from i2pdsl.planning.value_iteration import NotConverged

    rules = rules_of(spec, dynamics, plan.keys, frames=False)
    tables = rules._replace(continuation=plan.continuation, terms=plan.terms)
    name, mark = f"around-{spec.planning_key}", _mark(plan, numbers, inside)
    kept = _kept(spec, name, mark, plan, len(numbers), watch.say)
    given = spec, part, plan, tables, numbers, inside, watch
    if kept is not None:
        known = rules_of(spec, part, plan.keys, frames=False)._replace(continuation=kept)
        try:
            return _solved(*given, known)
        except NotConverged:
            store.refuse(name, "is no plan of this part", watch.say)
    found = _solved(*given, None)
    arrays = {f"continuation_{i}": values for i, values in enumerate(found.continuation)}
    store.save(name, {"mark": mark, **arrays}, watch.say)
    return found


def _solved(
    spec: GridSpec,
    part: Dynamics,
    plan: Plan,
    tables: Tables,
    numbers: np.ndarray,
    inside: int,
    watch: Watch,
    known: Tables | None,
) -> Plan:
    """`solve_around`, beginning with the values in some tables of the part, or the additive ones.

    Raises NotConverged.
    """
    from i2pdsl.planning.value_iteration import solve

    found: dict[int, np.ndarray] = {}
    residuals = []
    for who in map(spec.characters.index, spec.by_depth):
        problem = family_of(spec, part, who, plan.keys, found)
        start, problem = _ended(tables, who, part, numbers, inside, problem)
        if known is not None:
            start[:inside] = action_values(known, who, np.arange(inside)).max(-2)
        tolerance = EXACT * (1 - spec.settings.gamma)
        report = watch.planning and partial(watch.planning, spec.characters[who].name)
        solution = solve(
            problem,
            tolerance=tolerance,
            forgiven=FORGIVEN,
            start=start,
            progress=report,
            say=watch.say,
        )
        found[who] = solution.continuation
        residuals.append(solution.residual)
    values = tuple(found[who] for who in range(len(plan.keys)))
    return Plan(plan.keys, values, max(residuals), float("nan"))


def _mark(plan: Plan, numbers: np.ndarray, inside: int) -> np.ndarray:
    """What a part is, and by which additive values it ends."""
    found = hashlib.sha256(f"{plan.keys}{inside}{numbers.dtype}".encode())
    for array in (numbers, *(each for terms in plan.terms or () for each in terms)):
        found.update(np.ascontiguousarray(array).tobytes())
    return np.frombuffer(found.digest(), np.uint8)


def _kept(
    spec: GridSpec,
    name: str,
    mark: np.ndarray,
    plan: Plan,
    states: int,
    say: Callable[[str], None] | None,
) -> tuple[np.ndarray, ...] | None:
    """The values that the cache holds of a part, if it holds that part's, and none is larger than
    any can be. Those where the part ends are sums of values of sub-worlds."""
    found = store.load(name, say, 8 * states * sum(map(len, plan.keys)) + 2**16)
    if found is None or not np.array_equal(found.pop("mark", np.zeros(0)), mark):
        return None
    values = [found.get(f"continuation_{i}", np.zeros(0)) for i in range(len(plan.keys))]
    for who, (array, problems) in enumerate(zip(values, plan.keys, strict=True)):
        terms = 1.0 if plan.terms is None else float(np.abs(plan.terms[who].sign).sum())
        most = (1 + EXACT) * max(1.0, terms) * largest_value(spec, who)
        right = array.shape == (states, len(problems)) and array.dtype == np.float64
        if not (right and bool((np.abs(array) <= most).all())):  # of what is no number never
            store.refuse(name, "does not fit the world", say)
            return None
    return tuple(map(np.ascontiguousarray, values))


def _ended(
    tables: Tables, who: int, part: Dynamics, numbers: np.ndarray, inside: int, problem: Problem
) -> tuple[np.ndarray, Problem]:
    """A character's problems, with rewards for which staying for ever where the part ends is worth
    the additive values: those after its own action, or before, where only others lead there. And
    values to begin with, [L, P]."""
    ends, gamma = slice(inside, None), problem.gamma
    start = action_values(tables, who, numbers).max(-2)
    own = np.unique(part.successor[who][:, :inside])
    own = own[own >= inside]
    start[own] = continued(tables, who, numbers[own])
    reward = problem.reward[:, problem.goal]
    reward[ends] = (1 - gamma) * start[ends] - problem.cost.max()
    answers = []
    for answer in problem.answers:
        if answer.social is not None:
            social = answer.social.copy()
            social[ends] = 0
            answer = replace(answer, social=social)
        answers.append(answer)
    goal = np.arange(len(problem.goal))
    return start, replace(problem, reward=reward, goal=goal, answers=tuple(answers))
