"""The panels of a comic strip, the same for every world."""

from __future__ import annotations

GUTTER, TEXT, TITLE = 18.0, 14.0, 24.0  # pixels


def columns_of(count: int) -> int:
    """Panels in a row: four of eight, three of six."""
    return count if count <= 4 else 3 if count in (5, 6, 9) else 4
