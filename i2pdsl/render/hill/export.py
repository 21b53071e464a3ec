"""What other programs animate a story on the hill with: its bodies as nodes, and what is drawn
through them (docs/export.md). Bodies of springs bend: there are no sprites of them. Lengths are the
world's units; y is down, as on screens."""

from __future__ import annotations

from math import tan
from typing import Any

import numpy as np

from i2pdsl.render import export
from i2pdsl.render.hill.figures import BASE, BODY, CRATES, IDLE, OUTLINE, ROPE
from i2pdsl.render.hill.performance import Performance
from i2pdsl.render.hill.rig import SCALE
from i2pdsl.render.ink import INK
from i2pdsl.worlds.hill.hopper import BOX_OUTLINE, GROUPS, HAND, HIPS, HOOK, MUSCLES

# Through which nodes of the hopper its foot, its body and its head are drawn.
PARTS = (((0, 1, 2), BASE), ((2, 3, 5, 4), BODY), ((5, 6, 8, 7), BODY), ((8, 9, 10), BODY))
MUSCLE, LINE = 0.5, 0.35  # units: how wide muscles and the rope are
CENTRES = {"hopper": (HIPS,), "box": BOX_OUTLINE}  # where a body is taken to be


def timeline(performance: Performance, clock: tuple[np.ndarray, np.ndarray]) -> dict[str, Any]:
    """The story as data; `clock` is how long each frame lasts, and its end is held, [T] each."""
    nodes = np.round(performance.positions * np.array([1.0, -1.0])[:, None], 4)  # [T + 1, 2, 19]
    centres = {
        name: np.round(nodes[:, :, list(centre)].mean(-1), 4).tolist()
        for name, centre in CENTRES.items()
    }
    pull = np.round(performance.pull, 4).tolist()
    frames = [
        {
            "hopper": {"at": centres["hopper"][t], "pull": pull[t]},
            "box": {"at": centres["box"][t]},
        }
        for t in range(performance.frames + 1)
    ]
    return export.timeline(
        performance.title,
        {
            "kind": "hill",
            "name": "hill",
            "slope": performance.slope,
            "rise": tan(performance.slope),
        },
        [{"name": name, "kind": "body", "nodes": list(group)} for name, group in GROUPS.items()],
        frames,
        [None] * (performance.frames + 1),
        performance.panels,
        clock,
        nodes=np.moveaxis(nodes, 1, 2).tolist(),
        shapes=_shapes(),
    )


def _shapes() -> list[dict[str, Any]]:
    """What is drawn, from the back to the front."""
    edge = OUTLINE / SCALE
    return [
        _shape("box", BOX_OUTLINE, CRATES[0], edge, True),
        _shape("rope", (HAND, HOOK), ROPE, LINE, False),
        *(_shape("muscle", ends, IDLE, MUSCLE, False) for ends in MUSCLES),
        *(_shape("hopper", part, color, edge, True) for part, color in PARTS),
    ]


def _shape(
    part: str, nodes: tuple[int, ...], color: str, width: float, closed: bool
) -> dict[str, Any]:
    """A polygon that is filled and has an edge in ink, or an open line."""
    return {
        "part": part,
        "nodes": list(nodes),
        "closed": closed,
        "color": color,
        "edge": INK if closed else color,
        "width": round(width, 3),
    }
