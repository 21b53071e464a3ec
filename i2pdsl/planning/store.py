"""The cache of solved plans: arrays by name, safe to delete, damage or share at any time."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

import numpy as np

from i2pdsl.resources import atomic_path, cache_folder

VERSION = 1  # of the files' content; another version is another name


def load(name: str, say: Callable[[str], None] | None = None) -> dict[str, np.ndarray] | None:
    """The arrays stored under a name, or None. A damaged entry is said and removed."""
    try:
        path = cache_folder("plans") / f"{name}-v{VERSION}.npz"
    except OSError:
        return None  # `save` says so
    try:
        # zip entries carry checksums, so damage anywhere is noticed.
        with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
            return {key: archive[key] for key in archive.files}
    except FileNotFoundError:
        return None
    except Exception as problem:  # zipfile and NumPy raise a dozen kinds for a damaged file
        if say is not None:
            reason = str(problem).partition(". ")[0]
            say(f"the cached plan {path.name} is damaged ({reason}); it is made again")
        with suppress(OSError):
            path.unlink()
        return None


def save(
    name: str, arrays: dict[str, np.ndarray], say: Callable[[str], None] | None = None
) -> None:
    """Stores arrays under a name; a full or read-only disk is said, not fatal."""
    try:
        with atomic_path(cache_folder("plans") / f"{name}-v{VERSION}.npz") as temporary:
            np.savez(temporary, allow_pickle=False, **arrays)
    except OSError as problem:
        if say is not None:
            say(f"the plan could not be cached: {problem}")


def remove(name: str) -> None:
    """Forgets what is stored under a name."""
    (cache_folder("plans") / f"{name}-v{VERSION}.npz").unlink(missing_ok=True)
