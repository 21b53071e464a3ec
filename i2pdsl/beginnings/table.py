"""The ways to begin of all kinds of worlds (worlds/beginnings.py). No JAX."""

from __future__ import annotations

from i2pdsl.worlds.beginnings import Beginnings
from i2pdsl.worlds.kinds import KINDS, beginnings_named


def table() -> dict[str, Beginnings]:
    """Of each kind that has any, by what animators call it. The first kind is the usual one; those
    in which a world of one's own is written come before the others."""
    every = (beginnings_named(name) for name in KINDS)
    found = {each.called: each for each in every if each.ways}
    return dict(sorted(found.items(), key=lambda item: item[1].template is None))
