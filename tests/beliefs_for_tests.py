"""Scripts of random turns, and what viewers of them answer."""

from __future__ import annotations

import numpy as np

from i2pdsl.errors import Source
from i2pdsl.language.check import check_query
from i2pdsl.language.scope import Module
from i2pdsl.language.story import USUAL, Audience, default_assumption
from i2pdsl.objective.many import evaluate_many
from i2pdsl.objective.replay import evaluate, replay
from i2pdsl.worlds.grid.world import GridWorld


def random_turns(world: GridWorld, frames: int, seed: int = 5) -> tuple[np.ndarray, np.ndarray]:
    """States [T + 1] and actions [T]."""
    generator = np.random.default_rng(seed)
    states, actions = [np.asarray(generator.choice(world.starts()))], []
    for _ in range(frames):
        turns = world.turns(world.tables, states[-1])
        actions.append(generator.choice(np.flatnonzero(turns.valid)))
        states.append(turns.state[actions[-1]])
    return np.array(states), np.array(actions)


def told(
    world: GridWorld,
    asked: str,
    states: np.ndarray,
    actions: np.ndarray,
    audiences: tuple[Audience, ...] = (USUAL,),
) -> np.ndarray:
    """The answer to a question about a script; the same of it alone and of two side by side."""
    words, nowhere = world.vocabulary, Module(Source("m", ""))
    rational = default_assumption(words)
    query = check_query(Source("q", asked), words, nowhere, len(actions), rational, None, audiences)
    seen = replay(world, states, actions)
    one = np.asarray(evaluate(world, seen, query.value, query.times))
    many = seen.each(lambda part: np.stack([part, part]))
    both = evaluate_many(world, many, query.value, query.times)
    np.testing.assert_allclose(both, np.stack([one, one]), atol=1e-12)
    return one
