"""The baseline without an audience: characters who simply do what is best for them
(paper, section 2, "naive planning")."""

from __future__ import annotations

import numpy as np

from i2pdsl.worlds.grid import model
from i2pdsl.worlds.grid.arrays import arrangement
from i2pdsl.worlds.grid.following import successor
from i2pdsl.worlds.grid.policy import action_values
from i2pdsl.worlds.grid.world import GridWorld

_TIE = 1e-9


def naive_rollout(
    world: GridWorld, length: int, allowed: np.ndarray, mask: np.ndarray, seed: int
) -> tuple[int, np.ndarray, int]:
    """A rollout of the characters' own best actions.

    From a uniformly random state, under a hypothesis drawn from those in `mask`, everyone takes
    the action of the highest Q (the first of equals); an irrational one acts uniformly; chance
    decides what succeeds.

    Returns: the start, the actions [T], and the hypothesis' number.
    """
    generator = np.random.default_rng(seed)
    tables, moves = world.tables, world.moves
    start = state = int(generator.choice(allowed))
    hypothesis = int(generator.choice(np.flatnonzero(mask)))
    actions = []
    for _ in range(length):
        chosen, seen = [], state
        for who, character in enumerate(world.spec.characters):
            column = int(tables.columns[who][0, hypothesis])
            values = action_values(tables, who, np.asarray(seen))
            if column == values.shape[-1]:
                act = int(generator.integers(len(values)))
            else:
                act = int(np.argmax(values[:, column] >= values[:, column].max() - _TIE))
            here = arrangement(tables, seen)
            after = int(successor(tables, who, np.asarray(act), np.asarray(here)))
            is_sure = after == here and not moves.together
            success = is_sure or bool(generator.random() < character.success)
            chosen.append((act, success))
            if success and not moves.together:
                seen += after - here
        if moves.together:
            steps, _ = model.steps(tables, moves, np.asarray(state), world.turn_number(chosen))
            pairs = zip(chosen, steps, strict=True)
            chosen = [(act, ok or not bool(step.would)) for (act, ok), step in pairs]
        actions.append(int(world.turn_number(chosen)))
        state = int(model.transition(tables, moves, np.asarray(state), np.asarray(actions[-1])))
    return start, np.array(actions), hypothesis
