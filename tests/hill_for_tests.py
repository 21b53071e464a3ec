"""The hill for tests: a search that they share, and states between fast code and reference."""

from __future__ import annotations

import jax
import numpy as np

import hill_reference as reference
from i2pdsl.planning.actor_critic import improve_often
from i2pdsl.programs import BRIEF

# A descent takes ten seconds to compile, once for each length, objective and search (whatever
# its numbers): a test that needs just any descent takes this one, with `length 20` and depict().
DESCENT = "search descend(seeds = 2, window = 20, overlap = 0, lookahead = 0, steps = 2)"

# A training for tests, compiled in a third of the time: it is run a few times only.
BRIEFLY = jax.jit(improve_often.__wrapped__, static_argnums=(0, 1, 2), compiler_options=BRIEF)


def as_reference(state: np.ndarray) -> reference.State:
    """A state [76] as the reference has it: (x, y, vx, vy) of each node."""
    return [tuple(map(float, node)) for node in state.reshape(4, -1).T]  # type: ignore[misc]


def from_reference(state: reference.State) -> np.ndarray:
    return np.array(state).T.reshape(-1)
