"""A performance as pixels, frame by frame: what stands still is drawn once, as panoramas.

The ground and both ranges of hills are wide pictures of which each frame shows a cut-out, moved by
whole pixels; only hopper, rope and box are drawn anew.
"""

from __future__ import annotations

from math import ceil, floor, tan

import numpy as np

from i2pdsl.render.hill.figures import pose_svg
from i2pdsl.render.hill.performance import Performance
from i2pdsl.render.hill.rig import SCALE
from i2pdsl.render.hill.scene import View, camera_way, pose_at, range_crest
from i2pdsl.render.hill.scenery import (
    FAR_SHARE,
    NEAR_SHARE,
    ground_svg,
    range_svg,
    sky_svg,
)
from i2pdsl.render.ink import INK
from i2pdsl.render.lettering import TAG, fitted, text_svg
from i2pdsl.render.mind import WINDOW
from i2pdsl.render.raster import composite, svg_rgba, text_width
from i2pdsl.worlds.hill.hopper import HEAD_LEFT, HEAD_RIGHT, HIPS

FIGURE_REACH, HEAD_REACH = 2.0, 7.0  # world units that drawings reach beyond their nodes


class Painter:
    """Paints one performance.

    Attributes:
        picture [height, width, 3]: uint8, as last painted.
    """

    def __init__(
        self, performance: Performance, view: View, width: int, crate: str, label: str = ""
    ) -> None:
        self.performance, self.view, self.crate = performance, view, crate
        self.zoom = width / view.width
        self.width, self.height = width, round(view.height * self.zoom)
        self.cameras = camera_way(performance)
        sky = sky_svg(SCALE * view.left, -SCALE * view.top, view.width, view.height)
        self.sky = self._drawn(sky, (0, 0, self.width, self.height))[..., :3]
        slope, low, high = performance.slope, self.cameras.min(), self.cameras.max()
        origin = float(performance.positions[0, 0, HIPS])
        ranges = [
            (share, range_svg(k, view.left + share * low, view.right + share * high, crest))
            for k, share in enumerate((FAR_SHARE, NEAR_SHARE))
            for crest in (range_crest(k, view),)
        ]
        ground = ground_svg(slope, view.left + low, view.right + high, origin)
        self.layers = [
            Panorama(content, view, self.zoom, tan(slope), share * low, share * high, share)
            for share, content in (*ranges, (1.0, ground))
        ]
        self.seen: list[tuple[int, int]] = []
        self.background = self.sky
        self.label = _tag(label, TAG) if label else None
        self.signs = {window: _tag(window.label, WINDOW) for window in performance.windows}
        self.picture = self.background.copy()

    def paint(self, frame: float) -> None:
        """Paints a frame or a moment between two; after the last one everybody rests."""
        frame = min(frame, self.performance.frames)
        camera = float(np.interp(frame, np.arange(len(self.cameras)), self.cameras))
        seen = [layer.corner(camera) for layer in self.layers]
        if seen != self.seen:
            self.seen, self.background = seen, self.sky.copy()
            for layer in self.layers:
                layer.paint(self.background, camera)
        self.picture[:] = self.background
        self._paint_cast(frame)
        window = self.performance.window_at(frame)
        left = 8
        for sign in (self.label, self.signs[window] if window else None):
            if sign is not None:
                left = self._paint_sign(sign, left)

    def _paint_cast(self, frame: float) -> None:
        positions, pull = pose_at(self.performance, frame)
        ground = self.layers[-1]
        x, y = ground.origin_at(self.seen[-1])
        columns, rows = SCALE * positions[0] - x, -SCALE * positions[1] - y
        reach = np.full(len(columns), FIGURE_REACH * SCALE)
        reach[[HEAD_LEFT, HEAD_RIGHT]] = HEAD_REACH * SCALE
        # The shadow lies on the slope, below whatever jumps or flies.
        fall = positions[1] - tan(self.performance.slope) * positions[0]
        floor_ = rows + SCALE * np.maximum(fall, 0)
        box = (
            max(floor(((columns - reach).min()) * self.zoom), 0),
            max(floor(((rows - reach).min()) * self.zoom), 0),
            min(ceil(((columns + reach).max()) * self.zoom), self.width),
            min(ceil(max((rows + reach).max(), floor_.max() + 20) * self.zoom), self.height),
        )
        if box[0] >= box[2] or box[1] >= box[3]:
            return
        cast = pose_svg(positions, pull, self.performance.slope, self.crate)
        drawn = self._drawn(cast, box, (x, y))
        part = self.picture[box[1] : box[3], box[0] : box[2]]
        part[:] = composite(part, drawn)

    def _drawn(
        self,
        content: str,
        box: tuple[int, int, int, int],
        origin: tuple[float, float] | None = None,
    ) -> np.ndarray:
        """The content in a rectangle of the picture (left, top, right, bottom; pixels), RGBA.

        `origin` is the SVG point at the picture's top left.
        """
        x, y = origin or (SCALE * self.view.left, -SCALE * self.view.top)
        return _raster(content, x + box[0] / self.zoom, y + box[1] / self.zoom,
                       box[2] - box[0], box[3] - box[1], self.zoom)  # fmt: skip

    def _paint_sign(self, sign: np.ndarray, left: int) -> int:
        high, wide = sign.shape[:2]
        part = self.picture[8 : 8 + high, left : left + wide]
        part[:] = composite(part, sign[: part.shape[0], : part.shape[1]])
        return left + wide + 6


class Panorama:
    """A layer of the background that follows the camera's way by a share of it."""

    def __init__(
        self,
        content: str,
        view: View,
        zoom: float,
        rise: float,
        low: float,
        high: float,
        share: float,
    ) -> None:
        """`low` and `high` are the x between which the layer's own camera moves."""
        self.zoom, self.rise, self.low, self.high, self.share = zoom, rise, low, high, share
        self.left = SCALE * (view.left + low)
        self.top = -SCALE * (view.top + rise * high)
        self.width, self.height = round(view.width * zoom), round(view.height * zoom)
        across, down = self._pixels(high - low), self._pixels(rise * (high - low))
        self.pixels = _raster(
            content, self.left, self.top, self.width + across, self.height + down, zoom
        )
        alpha = self.pixels[..., 3]
        rows = len(alpha)
        self.first = (alpha > 0).argmax(axis=0)  # in each column, where something begins
        self.solid = rows - (alpha[::-1] < 255).argmax(axis=0)  # and below which nothing is clear

    def _pixels(self, length: float) -> int:
        return round(SCALE * self.zoom * length)

    def corner(self, camera: float) -> tuple[int, int]:
        """Where the cut-out for the camera at x begins, in pixels."""
        at = self.share * camera
        return self._pixels(at - self.low), self._pixels(self.rise * (self.high - at))

    def origin_at(self, corner: tuple[int, int]) -> tuple[float, float]:
        """The SVG point at a cut-out's top left."""
        return self.left + corner[0] / self.zoom, self.top + corner[1] / self.zoom

    def paint(self, canvas: np.ndarray, camera: float) -> None:
        """Lays the cut-out over a picture of the view's size."""
        x, y = self.corner(camera)
        cut = self.pixels[y : y + self.height, x : x + self.width]
        columns = slice(x, x + self.width)
        first = max(int(self.first[columns].min()) - y, 0)
        solid = min(max(int(self.solid[columns].max()) - y, first), self.height)
        canvas[first:solid] = composite(canvas[first:solid], cut[first:solid])
        canvas[solid:] = cut[solid:, :, :3]


def _raster(content: str, x: float, y: float, width: int, height: int, zoom: float) -> np.ndarray:
    return svg_rgba(
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
        f'viewBox="{x:.4f} {y:.4f} {width / zoom:.4f} {height / zoom:.4f}">{content}</svg>'
    )


def _tag(text: str, color: str) -> np.ndarray:
    """A name on a tag, RGBA."""
    text = fitted(text, 13, 240, bold=True)
    wide = ceil(text_width(text, 13, bold=True)) + 20
    return svg_rgba(
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{wide}" height="24"><rect x="1" y="1" '
        f'width="{wide - 2}" height="22" rx="7" fill="{color}" stroke="{INK}" stroke-width="1.6"/>'
        f"{text_svg(10, 16.8, text, 13, True)}</svg>"
    )
