"""Films of one performance, or of several of one room side by side in the same time."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from math import ceil

import numpy as np

from i2pdsl.render.ink import INK, mix
from i2pdsl.render.lettering import TAG, fitted, text_svg
from i2pdsl.render.mind import WINDOW, Window
from i2pdsl.render.performances import meters, side_by_side, spread, windows_of
from i2pdsl.render.plane.figures import film_svg
from i2pdsl.render.plane.performance import Performance, frame_seconds
from i2pdsl.render.plane.room import CREAM, FRAME
from i2pdsl.render.plane.stage import stage_within
from i2pdsl.render.raster import composite, svg_rgba, text_width
from i2pdsl.render.strip import Strip
from i2pdsl.render.video import Times

SIGN_HEIGHT = 30  # pixels at the top that names and windows may take
HIGH = 0.72  # of a film's width: a stage is not higher
NUMBERS_SECONDS = 0.25  # how often numbers change, to be read


class Painter:
    """Paints one performance: what stands still once, and of each moment only the rectangle in
    which anybody has been.

    Attributes:
        picture [height, width, 3]: uint8, as last painted.
    """

    def __init__(
        self, performance: Performance, together: Sequence[Performance], width: int, name: str
    ) -> None:
        self.performance, self.name, self.width = performance, name, width
        self.stage = stage_within(performance.spec, width, HIGH * width)
        self.height = ceil(self.stage.height)
        view = self.stage.view
        # Of the picture's upper left corner; narrow rooms stand in its middle.
        self.left, self.top = self.stage.left - (width - self.stage.width) / 2, -view.margin
        ground = (
            f'<rect x="{self.left - 1:.1f}" y="{self.top - 1:.1f}" width="{width + 2}" '
            f'height="{self.height + 2}" fill="{mix(FRAME, CREAM, 0.78)}"/>'
        )
        whole = (0, 0, width, self.height)
        self.background = self._drawn(ground + self.stage.still(together), whole)[..., :3]
        self.signs = {
            window: self._drawn(self._sign(window), whole)
            for window in (None, *performance.windows)
        }
        self.picture = self.background.copy()

    def paint(self, time: float) -> None:
        """Paints a frame or a moment between two; after the last one everybody rests."""
        time = min(time, self.performance.frames)
        sign = self.signs[self.performance.window_at(time)][:SIGN_HEIGHT]
        self.picture[:] = self.background
        self.picture[: len(sign)] = composite(self.picture[: len(sign)], sign)
        left, top, right, bottom = box = self._box(time)
        moving = self._drawn(film_svg(self.performance, self.stage.view, time), box)
        part = self.picture[top:bottom, left:right]
        part[:] = composite(part, moving)

    def _box(self, time: float) -> tuple[int, int, int, int]:
        """The rectangle (left, top, right, bottom; pixels) of where anybody has been."""
        view = self.stage.view
        been = view.pixels(self.performance.positions[: ceil(time) + 1].reshape(-1, 2))
        reach = 1.3 * max(view.radius(k) for k in range(len(view.spec.characters))) + 2
        low = np.floor(been.min(axis=0) - reach - (self.left, self.top)).astype(int)
        high = np.ceil(been.max(axis=0) + reach - (self.left, self.top)).astype(int)
        (left, top), (right, bottom) = np.maximum(low, 0), high
        return int(left), int(top), min(int(right), self.width), min(int(bottom), self.height)

    def _sign(self, window: Window | None) -> str:
        """The performance's name, and that of the window that a time lies in."""
        told = [(self.name, TAG)] if self.name else []
        told += [(window.label, WINDOW)] if window and window.label else []
        x, y, parts = self.left + 6, self.top + 5, []
        for text, color in told:
            text = fitted(text, 13, 0.45 * self.width, bold=True)
            wide = text_width(text, 13, bold=True) + 16
            parts.append(
                f'<rect x="{x:.1f}" y="{y:.1f}" width="{wide:.1f}" height="21" rx="6" '
                f'fill="{color}" stroke="{INK}" stroke-width="1.4"/>'
                f"{text_svg(x + 8, y + 15, text, 13, True)}"
            )
            x += wide + 6
        return "".join(parts)

    def _drawn(self, content: str, box: tuple[int, int, int, int]) -> np.ndarray:
        """The content in a rectangle of the picture, RGBA."""
        left, top, right, bottom = box
        return svg_rgba(
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{right - left}" '
            f'height="{bottom - top}" viewBox="{self.left + left:.3f} {self.top + top:.3f} '
            f'{right - left} {bottom - top}">{content}</svg>'
        )


def film_frames(
    performances: Sequence[Performance],
    times: Times,
    width: int,
    title: str,
    meter: bool = True,
) -> Iterator[np.ndarray]:
    """The film's pictures at the given times (in frames), uint8 [height, width, 3], sizes even.

    Performances stand side by side at one scale, up to three in a row; those that end early rest.
    The array is reused: copy what must outlive the next step.
    """
    several = len(performances) > 1
    width = width // 2 * 2
    _, each = spread(len(performances), width)
    painters = [Painter(p, performances, each, p.title if several else "") for p in performances]
    lasting = max(p.frames for p in performances)
    hold = max(1, round(NUMBERS_SECONDS / frame_seconds(performances)))
    strip = Strip(
        lasting, width, title, meters(performances), _clock(lasting), windows_of(performances), hold
    )
    yield from side_by_side(painters, [strip] if meter else [], width, times)


def _clock(last: int) -> Callable[[int], str]:
    return lambda frame: "start" if frame == 0 else f"frame {frame} of {last}"
