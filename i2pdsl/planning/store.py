"""The cache of solved plans: arrays by name, safe to delete, damage, forge or share at any time."""

from __future__ import annotations

import os
import stat
from collections.abc import Callable
from contextlib import suppress
from math import prod
from pathlib import Path
from typing import IO
from zipfile import ZIP_STORED, ZipFile

import numpy as np

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
        return _read(path, largest)
    except FileNotFoundError:
        return None
    except OSError as problem:
        if say is not None:
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


def _read(path: Path, largest: int) -> dict[str, np.ndarray]:
    """The arrays of a file. Raises OSError, or anything else where it is damaged."""
    # A pipe in the file's place must not be waited for.
    opener = lambda file, flags: os.open(file, flags | getattr(os, "O_NONBLOCK", 0))
    with open(path, "rb", opener=opener) as file:
        about = os.fstat(file.fileno())
        size = about.st_size
        if not stat.S_ISREG(about.st_mode):
            raise ValueError("it is no file")
        if size > largest:
            raise ValueError(f"it has {size:,} bytes")
        # The entries carry checksums, so damage anywhere is noticed.
        with ZipFile(file) as archive:
            entries = archive.infolist()
            packed = any(e.compress_type != ZIP_STORED for e in entries)
            if packed or sum(e.file_size for e in entries) > size:
                raise ValueError("it claims to hold more than it does")
            found = {}
            for entry in entries:
                with archive.open(entry) as member:
                    found[entry.filename.removesuffix(".npy")] = _array(member, entry.file_size)
            return found


def _array(member: IO[bytes], size: int) -> np.ndarray:
    """An array whose header is true, before memory is taken for it."""
    version = np.lib.format.read_magic(member)
    read = {
        (1, 0): np.lib.format.read_array_header_1_0,
        (2, 0): np.lib.format.read_array_header_2_0,
    }
    shape, _, dtype = read[version](member)
    if dtype.hasobject or min(shape, default=0) < 0:
        raise ValueError("it holds no numbers")
    if member.tell() + dtype.itemsize * prod(shape) != size:
        raise ValueError("an array has another size than it says")
    member.seek(0)
    return np.lib.format.read_array(member, allow_pickle=False)


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
