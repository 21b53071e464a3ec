"""Who plans what in a grid world, and what each expects of the other (model.md, "Kitchen")."""

from __future__ import annotations

import numpy as np

from i2pdsl.worlds.grid.arrays import Against, Tables
from i2pdsl.worlds.grid.dynamics import Dynamics
from i2pdsl.worlds.grid.hypotheses import grid_hypotheses
from i2pdsl.worlds.grid.spec import STAY, Character, GridSpec
from i2pdsl.worlds.hypotheses import ATTITUDE, goal_of, rationality_of

Key = tuple[str | float | None, ...]
"""A planning problem: (goal,), or for one who models the other (the other's goal, own goal, rho);
the other's goal is None where the other is irrational."""


def problem_keys(spec: GridSpec) -> tuple[tuple[Key, ...], ...]:
    """The distinct problems of each character, in the order in which hypotheses name them."""
    rows = grid_hypotheses(spec)
    found = []
    for c in spec.characters:
        keys = (problem_of(spec, c, row) for row in rows if row[rationality_of(c.name)])
        found.append(tuple(dict.fromkeys(keys)))
    return tuple(found)


def problem_of(spec: GridSpec, character: Character, row: dict[str, float | str | bool]) -> Key:
    """The problem that a rational character solves under a hypothesis."""
    own = str(row[goal_of(character.name)])
    modeller = spec.modeller
    if modeller is None or modeller.name != character.name:
        return (own,)
    other = next(c for c in spec.characters if c.name != character.name)
    rho = row.get(ATTITUDE)
    believed = row.get(goal_of(other.name))
    return (None if believed is None else str(believed), own, None if rho is None else float(rho))


def costs(spec: GridSpec, who: int | None = None) -> np.ndarray:
    """The reward of each action of a character, or of any, away from the goal: [A]."""
    counts = [len(c.actions) for c in spec.characters]
    cost = np.full(max(counts) if who is None else counts[who], spec.settings.move)
    cost[STAY] = spec.settings.stay
    return cost


def on_goal(spec: GridSpec, dynamics: Dynamics, goals: list[str]) -> np.ndarray:
    """Whether each cell is one of a goal's: bool [G, N + 1]; absence and no goal never are."""
    number = {tuple(cell): i for i, cell in enumerate(dynamics.coordinates.tolist())}
    cells = {t.name: [number[c] for c in t.cells] for t in spec.tiles}
    table = np.zeros((len(goals), len(number) + 1), dtype=bool)
    for i, goal in enumerate(goals):
        table[i, cells.get(goal, [])] = True
    return table


def imagined(spec: GridSpec, other: int) -> np.ndarray:
    """The policy of level 0: [A]."""
    cost = costs(spec, other)
    if spec.settings.level0 == "costs":
        weights = np.exp(spec.settings.beta * (cost - cost.max()))
    else:
        weights = np.ones(len(cost))
    return weights / weights.sum()


def expectations(spec: GridSpec, keys: tuple[tuple[Key, ...], ...]) -> tuple[Against, ...] | None:
    """What each character expects of the other in each of its problems; None of one alone."""
    if len(keys) == 1:
        return None
    found = []
    success = tuple(np.array(c.success) if c.is_weak else None for c in spec.characters)
    for who, own in enumerate(keys):
        other = 1 - who
        beta, nobody = np.full(len(keys[other]), spec.settings.beta), np.zeros(len(own))
        policy = imagined(spec, other)
        if spec.characters[who] != spec.modeller:
            fixed = np.repeat(policy[:, None], len(own), axis=1)
            found.append(Against(fixed, None, nobody.astype(bool), beta, nobody, success))
            continue
        names, models = [key[0] for key in keys[other]], bool(spec.characters[who].models)
        known = np.array([models and key[0] is not None for key in own])
        problem = [
            names.index(key[0]) if is_known else 0 for key, is_known in zip(own, known, strict=True)
        ]
        fixed = np.full((len(policy), len(own)), 1 / len(policy))
        rho = np.array([float(key[2] or 0) for key in own])
        found.append(Against(fixed, np.array(problem), known, beta, rho, success))
    return tuple(found)


def rules_of(
    spec: GridSpec, dynamics: Dynamics, keys: tuple[tuple[Key, ...], ...], frames: bool
) -> Tables:
    """The tables that planning by induction reads, without any values.

    Args:
        frames: whether the numbers of states tell the frame.
    """
    nothing = np.zeros(0)
    goals = tuple(on_goal(spec, dynamics, goals_of(each)) for each in keys)
    return Tables(
        cells=dynamics.cells,
        lookup=dynamics.lookup,
        strides=dynamics.strides,
        successor=dynamics.successor,
        coordinates=dynamics.coordinates,
        absent=np.array(dynamics.absent),
        success=np.array([c.success for c in spec.characters]),
        cost=costs(spec),
        gamma=np.array(spec.settings.gamma),
        reward=np.array(spec.settings.goal),
        continuation=(),
        columns=(),
        sharpness=(),
        goals=goals,
        log_prior=nothing,
        forgetting=nothing,
        layer=np.array(dynamics.state_count) if frames else None,
        against=expectations(spec, keys) if spec.together else None,
    )


def goals_of(keys: tuple[Key, ...]) -> list[str]:
    """Each problem's goal of the character itself."""
    return [str(key[1] if len(key) == 3 else key[0]) for key in keys]
