"""Sizes of arrays that worlds share, so that a program compiled for one serves others."""

from __future__ import annotations


def padded_size(count: int, least: int = 1, parts: int = 4) -> int:
    """The next multiple of a `parts`-th of a power of two: at most so large a part is added.

    Nothing is smaller than `least`, up to which all worlds share one size.
    """
    step = max(1, (1 << (count - 1).bit_length()) // (2 * parts))
    return max(least, -(-count // step) * step)
