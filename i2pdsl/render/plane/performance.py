"""A performance in the plane as the pictures see it: a room, ways, curves and words, no world."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from i2pdsl.render.key_frames import EDGE, PLACE, TURN, minds
from i2pdsl.render.key_frames import key_frames as chosen_frames
from i2pdsl.render.mind import Panel, Window
from i2pdsl.worlds.plane.spec import PlaneSpec

FRAME_SECONDS = 0.07  # a hundred frames in seven seconds
LONGEST, SHORTEST = 24.0, 2.5  # seconds of a film's motion, as far as frames can be shown so
SLOWEST = 0.3  # seconds of a frame
GAZE_FRAMES = 1.5  # over about so many the eyes even out the motion that they look along
TURNING = 0.25  # what a turn of the eyes counts beside a belief
NEAR = 0.1  # of a radius: two discs that are as near as this touch


@dataclass(frozen=True, eq=False)
class Performance:
    """What the characters of a plane did in T frames, and what viewers believed.

    Attributes:
        positions [T + 1, n, 2]: of the characters, in the world's units, y to the north.
        tries [T, n, 2]: what each tried to move in a frame, where somebody may have been in the
            way; None where all moved as they tried.
        panels: curves over t = 0..T.
        windows: stretches of time to mark.
        captions: T + 1 lines.
        leading: the curves that are shown with the film: of what the story is about.
        turns: the frames in which what the story asks turns, and how much that matters.
        source: the story's text.
    """

    title: str
    spec: PlaneSpec
    positions: np.ndarray
    panels: tuple[Panel, ...] = ()
    windows: tuple[Window, ...] = ()
    captions: Sequence[str] = ()
    leading: Panel | None = None
    turns: Mapping[int, float] = field(default_factory=dict)
    source: str = ""
    tries: np.ndarray | None = None

    def __post_init__(self) -> None:
        positions, count = np.asarray(self.positions), len(self.spec.characters)
        frames = len(positions) - 1
        if frames < 0 or positions.shape[1:] != (count, 2):
            raise ValueError(f"positions must be [T + 1, {count}, 2], not {positions.shape}")
        if not np.isfinite(positions).all():
            raise ValueError("positions must be finite")
        if self.tries is not None and np.shape(self.tries) != (frames, count, 2):
            raise ValueError(f"tries must be [{frames}, {count}, 2], not {np.shape(self.tries)}")
        for panel in self.panels:
            if panel.last != frames:
                raise ValueError(f"panel {panel.title!r} covers {panel.last} frames, not {frames}")
        for window in self.windows:
            if window.last > frames:
                raise ValueError(f"window {window.label!r} ends after the last frame, {frames}")
        if len(self.captions) != frames + 1:
            raise ValueError(f"{frames + 1} captions are needed, not {len(self.captions)}")

    @property
    def frames(self) -> int:
        """T, the last frame."""
        return len(self.positions) - 1

    @cached_property
    def gaze(self) -> np.ndarray:
        """[T + 1, n, 2] Where the eyes look, x to the east and y to the north, at most 1 long:
        where they try to go, also when they are pushed elsewhere, and straight ahead (0) at
        rest."""
        speed = np.array([c.speed for c in self.spec.characters])[:, None]
        steps = (np.diff(self.positions, axis=0) if self.tries is None else self.tries) / speed
        if not len(steps):
            return np.zeros_like(self.positions)
        # Who looks around a corner sees it a little before turning.
        offsets = np.arange(len(steps)) - np.arange(self.frames + 1)[:, None]
        weights = np.exp(-0.5 * ((offsets - 0.5) / GAZE_FRAMES) ** 2)
        weights /= weights.sum(axis=1, keepdims=True)
        along = 1.5 * np.einsum("ts,snd->tnd", weights, steps)
        return along / np.maximum(np.linalg.norm(along, axis=-1, keepdims=True), 1)

    def at(self, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Positions [n, 2] and gaze [n, 2] at a frame or, evenly mixed, between two."""
        time = min(max(time, 0.0), self.frames)
        before = int(time)
        after, share = min(before + 1, self.frames), time - before
        positions, gaze = (
            course[before] * (1 - share) + course[after] * share
            for course in (self.positions, self.gaze)
        )
        return positions, gaze

    def way(self, number: int, first: float, last: float) -> np.ndarray:
        """[k, 2] The way of a character from one time to another, k >= 2."""
        inside = np.arange(np.floor(first) + 1, np.ceil(last))
        times = np.concatenate([[first], inside, [last]])
        frames = np.arange(self.frames + 1)
        course = self.positions[:, number]
        return np.stack([np.interp(times, frames, course[:, k]) for k in (0, 1)], axis=1)

    @property
    def contacts(self) -> list[int]:
        """The frames in which two come to touch each other."""
        if len(self.spec.characters) != 2:
            return []
        first, second = (c.radius for c in self.spec.characters)
        apart = np.linalg.norm(self.positions[:, 0] - self.positions[:, 1], axis=-1)
        touching = apart < (1 + NEAR) * (first + second)
        return [int(t) + 1 for t in np.flatnonzero(touching[1:] & ~touching[:-1])]

    def window_at(self, time: float) -> Window | None:
        """The marked stretch that a time lies in."""
        return next((w for w in self.windows if w.first <= time <= w.last), None)


def frame_seconds(performances: Sequence[Performance]) -> float:
    """How long a frame is shown: short performances slowly, long ones quickly."""
    frames = max(1, *(p.frames for p in performances))
    return float(np.clip(FRAME_SECONDS, min(SHORTEST / frames, SLOWEST), LONGEST / frames))


def key_frames(performance: Performance, count: int) -> list[int]:
    """At most `count` of the frames 0..T, first and last among them: where what is asked turns,
    where the two meet, where somebody turns, and where somebody has come far since the one
    before."""
    room = np.hypot(performance.spec.width, performance.spec.height)
    seen = [TURNING * performance.gaze, PLACE * performance.positions / room]
    beliefs = minds(performance.leading, performance.panels)
    moments = {t: TURN * weight for t, weight in performance.turns.items()}
    moments |= dict.fromkeys(performance.contacts[:1], EDGE)
    return chosen_frames(seen, beliefs, performance.frames, count, moments)
