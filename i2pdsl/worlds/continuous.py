"""What worlds of moving bodies have in common."""

from __future__ import annotations

from typing import Any, NoReturn

import numpy as np

from i2pdsl.language.typed import Turn
from i2pdsl.worlds.plain import PlainWorld
from i2pdsl.worlds.world import Array, Tables


class ContinuousWorld(PlainWorld):
    """States and actions are vectors, so that neither can be listed, and everything is observed."""

    lists_states = False
    turn_count = 0

    def acting(self, rows: np.ndarray, generator: np.random.Generator) -> NoReturn:
        raise NotImplementedError("actions cannot be listed")

    def alternatives(
        self, tables: Tables, state: Array, action: Array, after: Array
    ) -> tuple[tuple[Array, Array], ...]:
        return ()

    def is_observed(self, action: Array) -> Array:
        xp = action.__array_namespace__()
        return xp.ones(action.shape[:-1], dtype=bool)

    def all_states(self, tables: Tables) -> NoReturn:
        raise NotImplementedError("states cannot be listed")

    def act(self, tables: Tables, state: Array, turn: Turn) -> NoReturn:
        raise NotImplementedError("actions have no names")

    def is_turn(self, tables: Tables, before: Array, action: Array, turn: Any) -> NoReturn:
        raise NotImplementedError("actions have no names")

    def turns(self, tables: Tables, state: Array) -> NoReturn:
        raise NotImplementedError("actions cannot be listed")

    def endings(self, tables: Tables, state: Array) -> NoReturn:
        raise NotImplementedError("actions cannot be listed")

    def branch_actions(self, who: int) -> NoReturn:
        raise NotImplementedError("actions cannot be listed")
