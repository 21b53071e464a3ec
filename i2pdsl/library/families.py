"""Families of patterns, by what one gives first: the pages of a catalogue."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Family:
    """Patterns that are shown on one page, `NAME.html`. `kind` is that of their first parameter
    (language/kinds.py); the family without one takes all others."""

    name: str
    title: str
    lead: str
    kind: str


FAMILIES = (
    Family("beliefs", "Beliefs", "You give an event, and they shape when it is believed.", "event"),
    Family(
        "characters", "Characters", "You give a character, and they shape its fortune.", "character"
    ),
    Family("questions", "Questions", "You give what viewers shall wonder about.", "latent"),
    Family("others", "Others", "They begin with something else, or with nothing.", ""),
)


def by_family(patterns: list[dict[str, Any]]) -> dict[Family, list[dict[str, Any]]]:
    """The families that these patterns (library/description.py) belong to, each with its own."""
    kinds = {family.kind: family for family in FAMILIES}
    found: dict[Family, list[dict[str, Any]]] = {family: [] for family in FAMILIES}
    for pattern in patterns:
        first = pattern["parameters"][0]["kind"] if pattern["parameters"] else ""
        found[kinds.get(first, kinds[""])].append(pattern)
    return {family: members for family, members in found.items() if members}
