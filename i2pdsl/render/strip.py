"""Below a film: its title, a clock, and curves of what viewers believe, drawn as far as known."""

from collections.abc import Callable, Sequence
from xml.sax.saxutils import quoteattr

import numpy as np
from PIL import ImageColor

from i2pdsl.render.lettering import fitted, text_svg
from i2pdsl.render.mind import WINDOW, Window
from i2pdsl.render.raster import svg_rgba, text_width

Meter = tuple[str, str, Sequence[float] | np.ndarray]  # label, CSS colour, values [T + 1]


class Strip:
    """A strip of pixels, repainted for each moment of the film.

    Attributes:
        picture [height, width, 3]: uint8, as last painted.
    """

    def __init__(
        self,
        duration: float,
        width: float,
        title: str,
        meters: Sequence[Meter],
        clock: Callable[[int], str],
        windows: Sequence[Window] = (),
        hold: int = 1,
    ) -> None:
        """`clock` tells the time in words. Numbers change every `hold` frames only, to be read."""
        for label, _, values in meters:
            if len(values) != round(duration) + 1:
                raise ValueError(
                    f"meter {label!r} needs {round(duration) + 1} values, not {len(values)}"
                )
        self.duration, self.title, self.meters = duration, title, meters
        self.clock, self.windows, self.hold = clock, windows, hold
        self.width = round(width)
        self.plot_top, self.plot_height = 30, 66 if meters else 8
        self.legend = self._legend_places()
        rows = 1 + max((row for _, row in self.legend), default=-1)
        self.height = self.plot_top + self.plot_height + 12 + 19 * rows
        self.low, self.high = self._range()
        numbers = max(text_width(f"{value:.3g}", 11) for value in (self.low, self.high))
        self.left, self.right = (max(34.0, numbers + 16) if meters else 12.0), self.width - 14.0
        self.ahead, self.known = self._plot(False), self._plot(True)
        self.told: tuple[int, int] | None = None  # what `words` says
        self.words = self.ahead
        self.picture = self.ahead.copy()

    def paint(self, time: float) -> None:
        """The strip at a time: curves are drawn up to it, numbers are those after the last turn."""
        # Curves run on during a turn, for the eye; a turn's belief is a number only at its end.
        turn, done = int(np.ceil(time - 1e-9)), int(np.floor(time + 1e-9))
        if time < self.duration:  # the end is told exactly
            turn, done = (number // self.hold * self.hold for number in (turn, done))
        if self.told != (turn, done):
            self.told, self.words = (turn, done), self._drawn(self._words(turn, done))
        self.picture[:] = self.words
        plot = slice(self.plot_top - 6, self.plot_top + self.plot_height + 6)
        x = round(self._x(time))
        self.picture[plot, x:] = self.ahead[plot, x:]
        self.picture[plot, :x] = self.known[plot, :x]
        for _, color, values in self.meters:
            at = float(np.interp(time, np.arange(len(values)), values))
            if np.isfinite(at):
                self._dot(self._x(time), self._y(at), color)

    def _x(self, time: float) -> float:
        return self.left + (self.right - self.left) * time / max(self.duration, 1e-9)

    def _y(self, value: float) -> float:
        share = (value - self.low) / (self.high - self.low)
        return self.plot_top + self.plot_height * (1 - share)

    def _range(self) -> tuple[float, float]:
        """Probabilities share the axis from 0 to 1; anything else gets its own."""
        values = np.asarray([v for _, _, vs in self.meters for v in vs], dtype=float)
        values = values[np.isfinite(values)]
        if not values.size or (values.min() >= 0 and values.max() <= 1):
            return 0.0, 1.0
        low, high = float(values.min()), float(values.max())
        return (low, high) if high > low else (low - 0.5, high + 0.5)

    def _drawn(self, content: str) -> np.ndarray:
        document = (
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{self.width}" height="{self.height}">'
            f'<rect width="100%" height="100%" fill="#fff"/>{content}</svg>'
        )
        return np.ascontiguousarray(svg_rgba(document)[..., :3])

    def _plot(self, known: bool) -> np.ndarray:
        """The plot with or without what is still to come."""
        y, h, wide = self.plot_top, self.plot_height, self.right - self.left
        box = f'x="{self.left:g}" y="{y}" width="{wide:g}" height="{h}"'
        if not self.meters:  # a plain bar that fills
            return self._drawn(f'<rect {box} rx="4" fill="{"#d9a441" if known else "#eee6d8"}"/>')
        shade = "#faf5ea" if known else "#f3f0ea"
        middle = f"M{self.left:g} {y + h / 2:g} h{wide:g}"
        parts = [f'<rect {box} fill="{shade}"/>', f'<path d="{middle}" stroke="#ddd3c2"/>']
        for window in self.windows:
            x, end = self._x(window.first), self._x(window.last)
            parts.append(
                f'<rect x="{x:.1f}" y="{y}" width="{end - x:.1f}" height="{h}" fill="{WINDOW}" '
                'opacity="0.34"/>'
            )
            parts.append(text_svg(x + 4, y + 12, fitted(window.label, 10.5, end - x - 6), 10.5))
        for value, place in ((self.high, y + 8), (self.low, y + h)):
            parts.append(
                text_svg(self.left - 6, place, f"{value:.3g}", 11, more=' text-anchor="end"')
            )
        for _, color, values in self.meters if known else ():
            paint = quoteattr(color)
            parts.append(
                f'<path d="{self._curve(values)}" fill="none" stroke={paint} stroke-width="2.4" '
                'stroke-linejoin="round"/>'
            )
        return self._drawn("".join(parts))

    def _curve(self, values: Sequence[float] | np.ndarray) -> str:
        """Path data through the finite values; others leave gaps."""
        path, pen = "", "M"
        for t, value in enumerate(values):
            if np.isfinite(value):
                path += f"{pen}{self._x(t):.1f} {self._y(float(value)):.1f} "
                pen = "L"
            else:
                pen = "M"
        return path or "M0 0"

    def _legend_places(self) -> list[tuple[float, int]]:
        """(x, row) of each meter's name, as many in a row as there is room for."""
        places, x, row = [], 34.0, 0
        for label, _, _ in self.meters:
            wide = text_width(label, 12.5) + 74
            if x + wide > self.width and x > 34:
                x, row = 34.0, row + 1
            places.append((x, row))
            x += wide
        return places

    def _words(self, turn: int, done: int) -> str:
        """Title, number of the turn, and the meters' names with their values after turn `done`."""
        number = self.clock(turn)
        room = self.width - text_width(number, 13) - 40
        parts = [
            text_svg(12, 20, fitted(self.title, 14, room, bold=True), 14, True),
            text_svg(self.width - 12, 20, number, 13, more=' text-anchor="end"'),
        ]
        for (label, color, values), (x, row) in zip(self.meters, self.legend, strict=True):
            y = self.plot_top + self.plot_height + 21 + 19 * row
            value = f"{values[done]:.2f}" if np.isfinite(values[done]) else "–"
            parts.append(f'<circle cx="{x + 5:g}" cy="{y - 4.5:g}" r="5" fill={quoteattr(color)}/>')
            parts.append(text_svg(x + 15, y, label, 12.5))
            wide = text_width(label, 12.5)
            parts.append(text_svg(x + 22 + wide, y, value, 12.5, True))
        return "".join(parts)

    def _dot(self, x: float, y: float, color: str) -> None:
        """A round dot with a soft edge, straight into the pixels: it moves in every frame."""
        radius = 4.5
        x0, y0 = int(x - radius - 1), int(y - radius - 1)
        x1, y1 = x0 + int(2 * radius + 4), y0 + int(2 * radius + 4)
        x0, y0, x1, y1 = max(x0, 0), max(y0, 0), min(x1, self.width), min(y1, self.height)
        rows, columns = np.mgrid[y0:y1, x0:x1]
        distance = np.hypot(columns + 0.5 - x, rows + 0.5 - y)
        cover = np.clip(radius - distance + 0.5, 0, 1)[..., None]
        patch = self.picture[y0:y1, x0:x1]
        ink = np.asarray(ImageColor.getrgb(color)[:3], dtype=float)
        patch[:] = np.round(patch * (1 - cover) + ink * cover).astype(np.uint8)
