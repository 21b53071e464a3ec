"""A performance on the hill as the pictures see it: positions, curves and words, no world."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from i2pdsl.render.key_frames import EDGE, PLACE, minds
from i2pdsl.render.key_frames import key_frames as chosen_frames
from i2pdsl.render.mind import Panel, Window
from i2pdsl.worlds.hill.hopper import HIPS, MUSCLE_COUNT, NODE_COUNT

FAR = 10.0  # units up the slope: who does not come so far has hardly moved
OPENING_FRAMES = 16  # for so long the first key frame waits: the box drops when the world starts


@dataclass(frozen=True, eq=False)
class Performance:
    """What the hopper did in T frames, and what viewers believed.

    Attributes:
        slope: angle in radians.
        positions [T + 1, 2, 19]: x and y of the nodes, in the world's unit.
        actuation [T, 6]: of the muscles; positive ones lengthen.
        weight: of the box, the true one. It is told in words and never shown in the picture.
        panels: curves over t = 0..T.
        leading: the curves that are shown with the film: of what the story is about.
        moments: the frames that belong to the story, and how much they matter (`key_frames`).
        windows: stretches of time to mark, such as a stumble.
        captions: T + 1 lines, or a function that gives the line of a frame.
        source: the story's text.
        frame_seconds: of the world's time to a frame.
    """

    title: str
    slope: float
    positions: np.ndarray
    actuation: np.ndarray
    weight: float
    panels: tuple[Panel, ...] = ()
    leading: Panel | None = None
    moments: Mapping[int, float] = field(default_factory=dict)
    windows: tuple[Window, ...] = ()
    captions: Sequence[str] | Callable[[int], str] = ()
    source: str = ""
    frame_seconds: float = 0.05

    def __post_init__(self) -> None:
        positions, actuation = np.asarray(self.positions), np.asarray(self.actuation)
        frames = len(positions) - 1
        if frames < 0 or positions.shape[1:] != (2, NODE_COUNT):
            raise ValueError(f"positions must be [T + 1, 2, {NODE_COUNT}], not {positions.shape}")
        if actuation.shape != (frames, MUSCLE_COUNT):
            raise ValueError(f"actuation must be [{frames}, {MUSCLE_COUNT}], not {actuation.shape}")
        if not (np.isfinite(positions).all() and np.isfinite(actuation).all()):
            raise ValueError("positions and actuation must be finite")
        for panel in self.panels:
            if panel.last != frames:
                raise ValueError(f"panel {panel.title!r} covers {panel.last} frames, not {frames}")
        for window in self.windows:
            if window.last > frames:
                raise ValueError(f"window {window.label!r} ends after the last frame, {frames}")
        if not callable(self.captions) and len(self.captions) not in (0, frames + 1):
            raise ValueError(f"{frames + 1} captions are needed, not {len(self.captions)}")

    @property
    def frames(self) -> int:
        """T, the last frame."""
        return len(self.positions) - 1

    @cached_property
    def distance(self) -> np.ndarray:
        """How far up the slope the hips have come since the start, [T + 1]."""
        x = self.positions[:, 0, HIPS]
        return (x - x[0]) / np.cos(self.slope)

    @cached_property
    def pull(self) -> np.ndarray:
        """[T + 1, 6] Of each muscle, from -1 (as short as can be) to 1; the start is at rest."""
        return np.concatenate([np.zeros((1, MUSCLE_COUNT)), np.tanh(self.actuation)])

    def caption(self, frame: int) -> str:
        """The line for a frame; without captions, how far the hopper has come."""
        if callable(self.captions):
            return self.captions(frame)
        if len(self.captions):
            return self.captions[frame]
        return f"{units(self.distance[frame])} up the slope"

    def window_at(self, frame: float) -> Window | None:
        """The marked stretch that a frame lies in."""
        return next((w for w in self.windows if w.first <= frame <= w.last), None)


def units(distance: float) -> str:
    """A way in words, in whole units."""
    return f"{round(distance)} units".replace("-", "−")


def key_frames(performance: Performance, count: int) -> list[int]:
    """At most `count` of the frames 0..T: an early one, the last, where windows begin and end,
    where what is asked turns, where the hopper falls, and where it has come far since the one
    before."""
    way = performance.distance
    span = max(float(way.max() - way.min()), FAR)
    beliefs = minds(performance.leading, performance.panels)
    moments = dict(performance.moments)
    for window in performance.windows:
        moments |= {window.first: EDGE, window.last: EDGE}
    first, *others = chosen_frames(
        [PLACE * way / span], beliefs, performance.frames, count, moments
    )
    return sorted({max(first, opening(performance.frames)), *others})


def opening(frames: int) -> int:
    """The first key frame of so many."""
    return min(OPENING_FRAMES, frames // 20)
