"""Sizes of arrays that worlds share, so that a program compiled for one serves others."""

from __future__ import annotations


def padded_size(count: int, least: int) -> int:
    """The next of the sizes 1, 5/4, 3/2, 7/4 times a power of two: at most a quarter is added.

    Nothing is smaller than `least`, a power of two up to which all worlds share one size.
    """
    if count <= least:
        return least
    step = 1 << (count - 1).bit_length() - 3
    return -(-count // step) * step
