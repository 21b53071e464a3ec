"""Whether this process was forked from one in which JAX was running already.

Looked at from the first import of the library on, whoever has started JAX; imports nothing.
"""

from __future__ import annotations

import os
import sys

_forked = False


def jax_is_running() -> bool:
    """Whether this process, or the one that it was forked from, has started JAX."""
    return bool(getattr(sys.modules.get("jax._src.xla_bridge"), "_backends", None))


def jax_is_lost() -> bool:
    """Whether JAX would wait for ever for threads that only the parent has."""
    return _forked


def _in_child() -> None:
    global _forked
    _forked = _forked or jax_is_running()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_in_child)
