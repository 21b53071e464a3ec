"""Sizes of arrays: what worlds share, so that a program compiled for one serves others, and what
the machine holds."""

from __future__ import annotations

import os
from pathlib import Path


def padded_size(count: int, least: int = 1, parts: int = 4) -> int:
    """The next multiple of a `parts`-th of a power of two: at most so large a part is added.

    Nothing is smaller than `least`, up to which all worlds share one size.
    """
    step = max(1, (1 << (count - 1).bit_length()) // (2 * parts))
    return max(least, -(-count // step) * step)


def memory_limit() -> int:
    """Bytes that may be used: 80 % of the machine's memory, or of the container's share."""
    total = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    for name in ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"):
        try:
            total = min(total, int(Path(name).read_text(encoding="ascii")))
        except (OSError, ValueError):
            continue
    return int(total * 0.8)


def processors() -> int:
    """How many processors this process may use."""
    if hasattr(os, "sched_getaffinity"):  # not on macOS
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
