"""What viewers expect where scripts have passed, kept: who asks once asks again, and scripts of one
story pass where others did. In NumPy and doubles; a search has a table of all places instead."""

from __future__ import annotations

from threading import Lock
from typing import Any

import numpy as np

from i2pdsl.worlds.grid.arrays import Tables, state_count
from i2pdsl.worlds.grid.policy import log_softmax

MOST_BYTES = 64 * 2**20  # of one character


class Known:
    """log P(a | s) of a character in all of its planning problems, place by place."""

    def __init__(self, tables: Tables, who: int) -> None:
        self.tables, self.who = tables, who
        self.shape = (len(tables.successor[who]), len(tables.sharpness[who]))  # [A, P]
        self.forget()

    def forget(self) -> None:
        self.lock = Lock()
        self.number = np.full(state_count(self.tables), -1, np.int32)  # of each state among rows
        self.rows, self.count = np.empty((0, *self.shape)), 0

    def __getstate__(self) -> dict[str, Any]:
        """What another process gets: it finds out by itself."""
        return {"tables": self.tables, "who": self.who, "shape": self.shape}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self.forget()

    def taken(self, state: np.ndarray, act: np.ndarray) -> np.ndarray | None:
        """log P(act | s), [..., P]; None where so many places are not kept."""
        with self.lock:
            new = np.unique(state[self.number[state] < 0])
            size = 8 * int(np.prod(self.shape))
            if (self.count + len(new)) * size > MOST_BYTES:
                return None
            if len(new):
                self._add(new)
            return self.rows[self.number[state], act]

    def _add(self, new: np.ndarray) -> None:
        total = self.count + len(new)
        if total > len(self.rows):
            longer = np.empty((max(total, 2 * len(self.rows)), *self.shape))
            longer[: self.count] = self.rows[: self.count]
            self.rows = longer
        self.rows[self.count : total] = log_softmax(self.tables, self.who, new)
        self.number[new] = np.arange(self.count, total)
        self.count = total
