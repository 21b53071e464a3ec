"""How many random examples a test tries: a few in `make test`, all of them in `make test-all`."""

from __future__ import annotations

import os

FULL = os.environ.get("I2PDSL_TESTS") == "full"  # as `make test-all` sets it


def examples(count: int) -> int:
    """How many of `count` random examples are tried."""
    return count if FULL else -(-count // 12)
