"""Planes that tests share."""

from dataclasses import replace

import numpy as np

from i2pdsl.worlds.plane.spec import Place, PlaneCharacter, PlaneSettings, PlaneSpec, Wall
from i2pdsl.worlds.plane.world import build_plane

DESK = PlaneSpec(
    "desk",
    12.0,
    8.0,
    (),
    (Place("left", (4.0, 7.0)), Place("right", (8.0, 7.0)), Place("low", (9.0, 1.5))),
    (PlaneCharacter("hand", (6.0, 1.0), goals=("left", "right", "low")),),
    PlaneSettings(forgetting=0.0),
)
ROOM = (
    Wall(((4.0, 2.0), (4.0, 6.0), (8.0, 6.0), (8.0, 2.0), (6.8, 2.0))),
    Wall(((5.2, 2.0), (4.0, 2.0))),
)
PAIR = replace(
    DESK,
    name="pair",
    characters=(
        PlaneCharacter("mouse", (6.0, 4.0), goals=("left", "right", "avoid")),
        PlaneCharacter(
            "cat",
            (2.0, 2.0),
            radius=0.5,
            mass=2.0,
            goals=("none", "approach", "low"),
            toward="mouse",
            attitude=(-2.0, 0.0, 2.0),
        ),
    ),
)
WALLED = replace(PAIR, name="walled", walls=ROOM)


def wandered(world, frames, seed=0, spread=1.0):
    """States [T + 1, 4 n] and actions [T, 2 n] of characters who move at random."""
    generator = np.random.default_rng(seed)
    speed = np.repeat(world.tables.speed, 2)
    drift = generator.normal(size=speed.shape)
    actions = spread * speed * (generator.normal(size=(frames, len(speed))) + drift)
    states = [world.starts()[0]]
    for action in actions:
        states.append(world.transition(world.tables, states[-1], action))
    return np.array(states), actions


def believed(world, states, actions):
    """log P(H | script[:t]) for all t, [T + 1, O, H]."""
    from i2pdsl.audience.filter import update

    tables = world.tables
    beliefs = [world.log_prior(tables)]
    for before, action, after in zip(states, actions, states[1:], strict=False):
        belief = beliefs[-1]
        for row in world.log_rows(tables, before, action, after):
            belief = update(belief, row, world.forgetting(tables))
        beliefs.append(belief)
    return np.array(beliefs)


__all__ = ["DESK", "PAIR", "ROOM", "WALLED", "believed", "build_plane", "wandered"]
