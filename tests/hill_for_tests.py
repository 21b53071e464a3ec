"""States of the hill between the fast code and the reference."""

from __future__ import annotations

import numpy as np

import hill_reference as reference


def as_reference(state: np.ndarray) -> reference.State:
    """A state [76] as the reference has it: (x, y, vx, vy) of each node."""
    return [tuple(map(float, node)) for node in state.reshape(4, -1).T]  # type: ignore[misc]


def from_reference(state: reference.State) -> np.ndarray:
    return np.array(state).T.reshape(-1)
