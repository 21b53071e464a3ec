"""The cache of solved plans: arrays by name, safe to delete, damage, forge or share at any time."""

from __future__ import annotations

import errno
from collections.abc import Callable
from contextlib import suppress

import numpy as np

from i2pdsl.npz import read_arrays
from i2pdsl.resources import atomic_path, cache_folder

VERSION = 2  # of the files' content; another version is another name
LARGEST = 2**30  # bytes of a file, unless the caller knows


def load(
    name: str, say: Callable[[str], None] | None = None, largest: int = LARGEST
) -> dict[str, np.ndarray] | None:
    """The arrays stored under a name, or None. A damaged entry is said and removed.

    Whether they are what the caller expects is for the caller to check (`refuse`).
    """
    try:
        path = cache_folder("plans") / f"{name}-v{VERSION}.npz"
    except OSError:
        return None  # `save` says so
    try:
        return read_arrays(path, largest)
    except FileNotFoundError:
        return None
    except OSError as problem:
        if problem.errno in (errno.EINVAL, errno.EFBIG):  # a pipe, or too large
            refuse(name, f"is damaged ({problem.strerror})", say)
        elif say is not None:
            say(f"the cached plan {path} cannot be read: {problem.strerror}; it is made again")
        return None
    except Exception as problem:  # zipfile and NumPy raise a dozen kinds for a damaged file
        refuse(name, f"is damaged ({str(problem).partition('. ')[0]})", say)
        return None


def refuse(name: str, why: str, say: Callable[[str], None] | None = None) -> None:
    """Says what is wrong with the entry of a name, and removes it."""
    file = f"{name}-v{VERSION}.npz"
    if say is not None:
        say(f"the cached plan {file} {why}; it is made again")
    with suppress(OSError):
        remove(name)


def save(
    name: str, arrays: dict[str, np.ndarray], say: Callable[[str], None] | None = None
) -> None:
    """Stores arrays under a name; a full or read-only disk is said, not fatal."""
    where = ""
    try:
        path = cache_folder("plans") / f"{name}-v{VERSION}.npz"
        where = f" in {path}"
        with atomic_path(path) as temporary:
            np.savez(temporary, allow_pickle=False, **arrays)
    except OSError as problem:
        if say is not None:
            reason = problem.strerror if where and problem.strerror else problem
            say(f"the plan could not be cached{where}: {reason}")


def remove(name: str) -> None:
    """Forgets what is stored under a name."""
    (cache_folder("plans") / f"{name}-v{VERSION}.npz").unlink(missing_ok=True)
