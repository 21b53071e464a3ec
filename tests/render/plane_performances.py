"""Performances in planes for tests: made-up ways and curves, no world."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from i2pdsl.render.mind import PALETTE, Panel, Series, Window
from i2pdsl.render.plane.performance import Performance
from i2pdsl.render.plane.room import View
from i2pdsl.worlds.plane.spec import Place, PlaneCharacter, PlaneSpec, Wall

MOVER = PlaneCharacter("mover", (2.0, 1.0), goals=("lamp", "chair", "none"))
CHASER = PlaneCharacter(
    "chaser", (10.0, 6.5), goals=("approach", "avoid", "none"), toward="mover",
    attitude=(-3.0, 0.0, 3.0), color="#d98b4a",
)  # fmt: skip
ROOM = PlaneSpec(
    "room", 12, 8,
    walls=(
        Wall(((6.0, 8.0), (6.0, 5.0))),
        Wall(((6.0, 3.0), (6.0, 0.0))),
        Wall(((8.0, 3.0), (9.5, 3.0), (9.5, 4.5), (8.0, 4.5)), closed=True),
    ),
    places=(Place("lamp", (10.5, 1.2)), Place("chair", (1.2, 6.6), color="#7fbf7f")),
    characters=(MOVER,),
)  # fmt: skip
DUET = replace(ROOM, characters=(MOVER, CHASER))

CROWD = replace(
    DUET,
    walls=(Wall(((0.0, 4.8), (5.0, 4.8))), Wall(((6.5, 4.8), (12.0, 4.8)))),
    places=tuple(
        Place(name, (1.0 + k % 5 * 2.5, 1.2 + k // 5 * 5.2), 0.6)
        for k, name in enumerate(
            ("lamp", "chair", "a very long name of a place", "door", "window_seat_by_the_fire",
             "bed", "sofa", "rug", "<b> & x", "hearth")
        )
    ),
)  # fmt: skip


def along(points: tuple[tuple[float, float], ...], frames: int) -> np.ndarray:
    """[T + 1, 2] At an even speed through points."""
    corners = np.array(points)
    lengths = np.concatenate([[0], np.hypot(*np.diff(corners, axis=0).T).cumsum()])
    at = np.linspace(0, lengths[-1], frames + 1)
    return np.stack([np.interp(at, lengths, corners[:, k]) for k in (0, 1)], axis=1)


def performance(
    title: str = "legible",
    frames: int = 80,
    spec: PlaneSpec = ROOM,
    windows: tuple[Window, ...] = (),
) -> Performance:
    """Everybody goes through the door, with curves that are made up."""
    ways = [along((c.at, (5.0, 4.0), (7.0, 4.0), (10.5, 1.2)), frames) for c in spec.characters]
    if len(spec.characters) == 2:
        ways[1] = along((spec.characters[1].at, (7.5, 5.5), (6.5, 4.2), (4.0, 3.0)), frames)
    share = np.linspace(0, 1, frames + 1)
    rising = 1 / (1 + np.exp(-12 * (share - 0.4)))
    goal = Panel("mover's goal", "probability", (
        Series("lamp", rising, "#0068b0"), Series("chair", 0.8 * (1 - rising), "#c65102"),
        Series("none", 0.2 * (1 - rising), PALETTE["none"]),
    ))  # fmt: skip
    value = Panel(
        "expected value", "value", (Series("mover", -30 * (1 - share), "#0068b0"),), "value"
    )
    captions = [
        "mover: hard to tell" if p < 0.55 else f"mover wants lamp ({100 * p:.0f} %) <so> & so"
        for p in rising
    ]
    return Performance(
        title, spec, np.stack(ways, axis=1), (goal, value), windows, captions, goal,
        source=f"story {title}\n",
    )  # fmt: skip


def svg_document(view: View, content: str) -> str:
    """A complete SVG document of a room's size around the content."""
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{view.width:.2f}" '
        f'height="{view.height:.2f}" viewBox="{view.box}">{content}</svg>'
    )
