"""Experiences in order: where one ends and the next begins is chosen so that their sum is largest.

What a frame is worth depends on the beat that it belongs to, and no beat has fewer than m frames.
So the best way to cut a prefix is known by dynamic programming over n * m cells: the best sum of
the frames so far, if the last one is the a-th of beat i (a = m stands for m and more). It is exact.

Arrays of NumPy and JAX alike. T frames.
"""

from __future__ import annotations

from typing import Any

import numpy as np

Array = Any

NEVER = -1e30  # the sum of what cannot be: finite, so that it can be compared


def begun(xp: Any, count: int, least: int, dtype: Any) -> Array:
    """The cells before the first frame, [1 + n m]: the first one stands for no frame at all."""
    return xp.concatenate([xp.zeros(1, dtype=dtype), xp.full(count * least, NEVER, dtype=dtype)])


def further(cells: Array, values: Array, least: int) -> Array:
    """The cells after one frame more, of which `values` [n] say what it is worth in each beat."""
    xp = values.__array_namespace__()
    grid = cells[1:].reshape(-1, least)
    # A beat begins where the one before it may end.
    begins = xp.concatenate([cells[:1], grid[:-1, -1]])
    if least == 1:
        new = xp.maximum(begins, grid[:, 0])[:, None]
    else:
        stays = xp.maximum(grid[:, -2], grid[:, -1])
        new = xp.concatenate([begins[:, None], grid[:, :-2], stays[:, None]], axis=1)
    new = xp.maximum(new + values[:, None], NEVER)
    return xp.concatenate([xp.full_like(cells[:1], NEVER), new.reshape(-1)])


def best(cells: Array, left: Array, least: int) -> Array:
    """The greatest sum so far of those cuts that the frames that are `left` can complete."""
    xp = cells.__array_namespace__()
    count = (cells.shape[0] - 1) // least
    beat, age = np.divmod(np.arange(count * least), least)
    missing = xp.asarray((least - 1 - age) + (count - 1 - beat) * least)
    value = xp.where(missing <= left, cells[1:], NEVER).max()
    return xp.where(cells[0] == 0, 0.0, value)


def through(cells: Array, values: Array, taken: Array, least: int) -> Array:
    """The cells after those of many frames [T, n] that are `taken` [T]."""
    xp = values.__array_namespace__()

    def turn(cells: Array, now: tuple[Array, Array]) -> tuple[Array, None]:
        value, is_taken = now
        return xp.where(is_taken, further(cells, value, least), cells), None

    if xp is not np:
        import jax

        return jax.lax.scan(turn, cells, (values, taken))[0]
    for now in zip(values, taken, strict=True):
        cells, _ = turn(cells, now)
    return cells


def cut(values: np.ndarray, least: int) -> np.ndarray:
    """The beat that each frame belongs to, [T], in the best cut of a finished script."""
    length, count = values.shape
    sums = np.concatenate([np.zeros((1, count)), values.cumsum(0)])
    # value[i, t]: of the first t frames in i beats; from[i, t]: where the last of them begins.
    value = np.full((count + 1, length + 1), -np.inf)
    begins = np.zeros((count + 1, length + 1), dtype=int)
    value[0, 0] = 0.0
    for i in range(1, count + 1):
        for t in range(i * least, length + 1):
            ends = value[i - 1, : t - least + 1] - sums[: t - least + 1, i - 1]
            begins[i, t] = ends.argmax()
            value[i, t] = ends.max() + sums[t, i - 1]
    found, t = np.zeros(length, dtype=int), length
    for i in range(count, 0, -1):
        found[begins[i, t] : t] = i - 1
        t = begins[i, t]
    return found
