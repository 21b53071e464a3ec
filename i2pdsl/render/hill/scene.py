"""One moment on the hill as SVG: a camera that follows the hopper, and what it sees."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import tan

import numpy as np

from i2pdsl.render.hill.figures import CRATES, LAYERS, pose_svg
from i2pdsl.render.hill.performance import Performance
from i2pdsl.render.hill.rig import SCALE
from i2pdsl.render.hill.scenery import (
    FAR_SHARE,
    NEAR_SHARE,
    ground_svg,
    range_svg,
    sky_svg,
)
from i2pdsl.worlds.hill.hopper import HIPS

FOLLOW_SECONDS = 0.8  # over about so long the camera evens out the hopper's steps
HEAD_ROOM, BEHIND, AHEAD, SOIL_ROOM = 5.0, 2.0, 4.0, 7.0  # world units around what moves


def camera_way(performance: Performance) -> np.ndarray:
    """The camera's x in each frame, [T + 1]: the hips', smoothed. It stays on the slope's line,
    so that the ground keeps its place in the picture."""
    return followed(performance.positions[:, 0, HIPS], performance.frame_seconds)


def followed(x: np.ndarray, frame_seconds: float) -> np.ndarray:
    """Where the camera is that follows hips at x, [T + 1]."""
    width = max(FOLLOW_SECONDS / frame_seconds, 1e-6)
    reach = int(3 * width)
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / width) ** 2)
    return np.convolve(np.pad(x, reach, mode="edge"), weights / weights.sum(), "valid")


@dataclass(frozen=True)
class View:
    """What the camera sees, in world units from its own point on the slope."""

    left: float
    right: float
    bottom: float
    top: float

    @property
    def width(self) -> float:
        """In SVG units."""
        return SCALE * (self.right - self.left)

    @property
    def height(self) -> float:
        """In SVG units."""
        return SCALE * (self.top - self.bottom)

    @property
    def box(self) -> str:
        """The `viewBox`, with the camera at (0, 0)."""
        return f"{SCALE * self.left:g} {-SCALE * self.top:g} {self.width:g} {self.height:g}"


def view_of(performances: Sequence[Performance]) -> View:
    """The smallest view in which nothing of any performance is ever cut off; whole units."""
    left, right, bottom, top = 0.0, 0.0, 0.0, 0.0
    for performance in performances:
        x = camera_way(performance)
        away = performance.positions[:, 0] - x[:, None]
        above = performance.positions[:, 1] - (tan(performance.slope) * x)[:, None]
        left, right = min(left, away.min()), max(right, away.max())
        top = max(top, above.max())
        bottom = min(bottom, above.min(), tan(performance.slope) * (left - BEHIND))
    edges = (left - BEHIND, right + AHEAD, bottom - SOIL_ROOM, top + HEAD_ROOM)
    return View(*(float(round(edge)) for edge in edges))


def scene_svg(
    performance: Performance,
    frame: float,
    view: View,
    crate: str = CRATES[0],
    ghosts: Sequence[int] = (),
) -> str:
    """The contents of an SVG with the view's `viewBox`, at a frame or between two.

    `ghosts` are earlier frames whose poses are drawn faintly, the first of them faintest.
    """
    camera = float(np.interp(frame, np.arange(performance.frames + 1), camera_way(performance)))
    return backdrop_svg(performance, camera, view) + cast_svg(
        performance, frame, camera, crate, ghosts
    )


def backdrop_svg(performance: Performance, camera: float, view: View) -> str:
    """Sky and ground as the camera at x sees them."""
    slope = performance.slope
    parts = [sky_svg(SCALE * view.left, -SCALE * view.top, view.width, view.height)]
    for which, share in enumerate((FAR_SHARE, NEAR_SHARE)):
        at = share * camera
        hills = range_svg(which, view.left + at, view.right + at, range_crest(which, view))
        parts.append(moved(hills, at, slope))
    origin = float(performance.positions[0, 0, HIPS])
    ground = ground_svg(slope, view.left + camera, view.right + camera, origin)
    return "".join(parts) + moved(ground, camera, slope)


def range_crest(which: int, view: View) -> float:
    """The height of a range of hills, lower where it is nearer."""
    return (0.42, 0.2)[which] * view.top


def cast_svg(
    performance: Performance,
    frame: float,
    camera: float,
    crate: str = CRATES[0],
    ghosts: Sequence[int] = (),
) -> str:
    """Hopper, rope and box as the camera at x sees them."""
    slope = performance.slope
    poses = [
        f'<g opacity="{0.10 + 0.14 * (rank + 1) / len(ghosts):.2f}">'
        f"{pose_svg(*pose_at(performance, ghost), slope, crate, LAYERS[1:])}</g>"
        for rank, ghost in enumerate(ghosts)
    ]
    poses.append(pose_svg(*pose_at(performance, frame), slope, crate))
    return moved("".join(poses), camera, slope)


def pose_at(performance: Performance, frame: float) -> tuple[np.ndarray, np.ndarray]:
    """Positions [2, 19] and pull [6] at a frame or, evenly mixed, between two."""
    frame = min(max(frame, 0.0), performance.frames)
    before = int(frame)
    after, share = min(before + 1, performance.frames), frame - before
    # The pull of a frame lasts for all of it, and is felt from its beginning.
    pull = performance.pull[before if share == 0 else after]
    mixed = performance.positions[before] * (1 - share) + performance.positions[after] * share
    return mixed, pull


def moved(content: str, x: float, slope: float) -> str:
    """Drawn in the world, as a camera at x on the slope sees it."""
    return f'<g transform="translate({-SCALE * x:.2f} {SCALE * x * tan(slope):.2f})">{content}</g>'


def svg_document(view: View, content: str, zoom: float = 1.0) -> str:
    """A complete SVG document of a view's size around the content."""
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{view.width * zoom:g}" '
        f'height="{view.height * zoom:g}" viewBox="{view.box}">{content}</svg>'
    )
