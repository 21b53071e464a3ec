"""Worlds and states as `tests/reference.py` has them: dictionaries and loops."""

from __future__ import annotations

from typing import Any


def plain_world(spec: Any) -> Any:
    """A world of tests/reference.py."""
    import reference

    people = [
        reference.Character(c.name, c.success, c.pushes, c.goals, dict(c.attitudes))
        for c in spec.characters
    ]
    tiles = {tile.name: tile.cells[0] for tile in spec.tiles}
    s = spec.settings
    return reference.World(
        spec.rows, tiles, people, gamma=s.gamma, beta=s.beta, forgetting=s.forgetting
    )


def plain_state(world: Any, state: int) -> Any:
    at = world.dynamics.coordinates[world.dynamics.cells[state]]
    return tuple((int(x), int(y)) for x, y in at)
