"""Who is how far: a lane for each performance, filled up to where its hopper has come."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from i2pdsl.render.hill.performance import Performance
from i2pdsl.render.lettering import fitted, text_svg
from i2pdsl.render.mind import FAINT, frame_ticks
from i2pdsl.render.performances import HUES
from i2pdsl.render.raster import svg_rgba, text_width

LANE, EDGE, TEXT = 22, 14.0, 12.5
AXIS = "units up the slope"


class Race:
    """A strip of pixels below a film.

    Attributes:
        picture [height, width, 3]: uint8, as last painted.
    """

    def __init__(self, performances: Sequence[Performance], width: int, hold: int) -> None:
        """Numbers change every `hold` frames."""
        self.ways = [p.distance for p in performances]
        self.titles = [fitted(p.title, TEXT, 0.3 * width) for p in performances]
        self.width, self.height = width, 22 + LANE * len(performances)
        self.hold = hold
        names = max(*(text_width(title, TEXT) for title in self.titles), text_width(AXIS, 11))
        self.left, self.right = EDGE + names + 12, width - EDGE - 40
        low = min(float(way.min()) for way in self.ways)
        high = max(float(way.max()) for way in self.ways)
        self.low, self.high = min(low, 0.0), max(high, 1.0)
        self.ahead, self.behind = self._lanes(filled=False), self._lanes(filled=True)
        self.told: int | None = None
        self.words = self.ahead
        self.picture = self.ahead.copy()

    def paint(self, time: float) -> None:
        """The lanes at a time, in frames."""
        told = int(time + 1e-9) // self.hold
        if told != self.told:
            self.told, self.words = told, self._drawn(self._numbers(told * self.hold))
        self.picture[:] = self.ahead
        tail = round(self.right) + 8
        self.picture[:, tail:] = self.words[:, tail:]
        for number, way in enumerate(self.ways):
            here = float(np.interp(time, np.arange(len(way)), way))
            start, end = round(self._x(0)), round(self._x(here))
            rows = slice(LANE * number, LANE * (number + 1))
            columns = slice(min(start, end), max(start, end))
            self.picture[rows, columns] = self.behind[rows, columns]

    def _x(self, way: float) -> float:
        return self.left + (self.right - self.left) * (way - self.low) / (self.high - self.low)

    def _lanes(self, filled: bool) -> np.ndarray:
        wide = self.right - self.left
        parts = []
        for number, title in enumerate(self.titles):
            y = LANE * number + 5
            color = HUES[number % len(HUES)] if filled else "#eee6d8"
            parts.append(
                f'<rect x="{self.left:g}" y="{y}" width="{wide:g}" height="{LANE - 9}" rx="4" '
                f'fill="{color}"/>'
            )
            parts.append(text_svg(EDGE, y + 10.5, title, TEXT))
        bottom = LANE * len(self.titles)
        for tick in frame_ticks(int(self.high)):
            x, more = self._x(tick), ' text-anchor="middle"'
            parts.append(f'<path d="M{x:.1f} {bottom}v4" stroke="{FAINT}"/>')
            parts.append(text_svg(x, bottom + 15, f"{tick}", 11, more=more))
        parts.append(text_svg(EDGE, bottom + 15, AXIS, 11))
        return self._drawn("".join(parts))

    def _numbers(self, frame: int) -> str:
        parts = []
        for number, way in enumerate(self.ways):
            here = f"{round(way[min(frame, len(way) - 1)])}".replace("-", "−")
            y = LANE * number + 15.5
            more = ' text-anchor="end"'
            parts.append(text_svg(self.width - EDGE, y, here, TEXT, True, more))
        return "".join(parts)

    def _drawn(self, content: str) -> np.ndarray:
        document = (
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{self.width}" height="{self.height}">'
            f'<rect width="100%" height="100%" fill="#fff"/>{content}</svg>'
        )
        return np.ascontiguousarray(svg_rgba(document)[..., :3])
