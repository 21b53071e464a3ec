"""Drawing with characters: curves of braille dots, or of letters."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from i2pdsl.answers import Answer
from i2pdsl.errors import display_width

COLOURS = (34, 31, 32, 35, 36, 33)  # of ANSI terminals, in the order of the curves
LETTERS = "*o+x#%"
NOTHING = "nothing to draw: no value is finite"
_GREATEST = sys.float_info.max
# The bits of the eight dots of a braille character, by row and column.
_DOTS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))


@dataclass(frozen=True)
class Curve:
    """Numbers over frames, and what they are called; `steps` if there is nothing in between."""

    name: str
    t: np.ndarray
    value: np.ndarray
    steps: bool = False


@dataclass(frozen=True)
class Ink:
    """What a terminal can show.

    Attributes:
        colour: whether it understands ANSI colours.
        unicode: whether it has braille and other signs beyond ASCII.
        columns: its width.
    """

    colour: bool = False
    unicode: bool = True
    columns: int = 80

    def paint(self, text: str, code: int | str) -> str:
        return f"\x1b[{code}m{text}\x1b[0m" if self.colour else text


def curves_of(answer: Answer, frames: Sequence[int]) -> list[Curve]:
    """The curves of an answer: one for each value of a latent; a number is a level line."""
    t = np.array(frames if answer.t is None else answer.t)
    found = []
    for label, value in answer.columns().items():
        name = label if answer.labels is None else f"{answer.latent or answer.expression} = {label}"
        values = np.broadcast_to(np.asarray(value, float), t.shape)
        found.append(Curve(name, t, values, answer.steps))
    return found


class Canvas:
    """Dots 2 x 4 to a character (1 x 1 with letters), each with the number of its curve."""

    def __init__(self, columns: int, rows: int, ink: Ink):
        self.columns, self.rows, self.ink = columns, rows, ink
        self.fine = ink.unicode and ink.colour
        self.across, self.down = (2, 4) if self.fine else (1, 1)
        self.dots = np.zeros((rows, columns), dtype=int)
        self.owner = np.full((rows, columns), -1)

    @property
    def size(self) -> tuple[int, int]:
        """Dots across and down."""
        return self.columns * self.across, self.rows * self.down

    def dot(self, x: int, y: int, number: int) -> None:
        column, row = x // self.across, y // self.down
        if 0 <= column < self.columns and 0 <= row < self.rows:
            bit = _DOTS[y % 4][x % 2] if self.fine else 1
            self.dots[row, column] |= bit
            self.owner[row, column] = number

    def line(self, x0: float, y0: float, x1: float, y1: float, number: int) -> None:
        steps = max(1, math.ceil(max(abs(x1 - x0), abs(y1 - y0))))
        for i in range(steps + 1):
            part = i / steps
            self.dot(round(x0 + part * (x1 - x0)), round(y0 + part * (y1 - y0)), number)

    def lines(self) -> list[str]:
        return [
            "".join(self._sign(int(d), int(o)) for d, o in zip(dots, owner, strict=True)).rstrip()
            for dots, owner in zip(self.dots, self.owner, strict=True)
        ]

    def _sign(self, dots: int, owner: int) -> str:
        if not dots:
            return " "
        if self.fine:
            return self.ink.paint(chr(0x2800 + dots), COLOURS[owner % len(COLOURS)])
        return LETTERS[owner % len(LETTERS)]


def draw_curves(curves: Sequence[Curve], ink: Ink, rows: int = 10) -> str:
    """Curves over t with their axes and names."""
    finite = [c.value[np.isfinite(c.value)] for c in curves]
    every = np.concatenate(finite) if finite else np.zeros(0)
    if not every.size:
        return NOTHING
    low, high = _range(float(every.min()), float(every.max()))
    first, last = extent(curves)
    ticks = [f"{v:.3g}" for v in (high, low / 2 + high / 2, low)]
    margin = max(map(len, ticks))
    # Beside it stand the ticks and the axis, and at its foot the name of the last frame and of t.
    canvas = Canvas(max(20, min(ink.columns - margin - 5, 96)), rows, ink)
    across, down = canvas.size

    def place(t: float, value: float) -> tuple[float, float]:
        x = (t - first) / max(1, last - first) * (across - 1)
        # Divided first: the greatest numbers there are may be this far apart.
        y = (high / 2 - value / 2) / (high / 2 - low / 2) * (down - 1)
        return x, y

    for number, curve in enumerate(curves):
        before: tuple[float, float] | None = None
        for t, value in zip(curve.t, curve.value, strict=True):
            here = place(float(t), float(value)) if np.isfinite(value) else None
            if here is not None:
                _join(canvas, before or here, here, curve.steps, number)
            before = here
    axis, corner, edge = ("│", "└", "─") if ink.unicode else ("|", "+", "-")
    names = dict(zip((0, rows // 2, rows - 1), ticks, strict=True))
    lines = [
        f"{names.get(row, ''):>{margin}} {axis}{text}" for row, text in enumerate(canvas.lines())
    ]
    lines.append(f"{'':>{margin}} {corner}{edge * canvas.columns}")
    lines.append(f"{'':>{margin}}  {_foot(first, last, canvas.columns)}")
    return "\n".join((*lines, *_legend(curves, ink)))


def _foot(first: int, last: int, columns: int) -> str:
    """The first, the middle and the last frame, as far as they differ."""
    middle = (first + last) // 2
    told = str(middle) if first < middle < last else ""
    end = str(last) if last > first else ""
    return f"{first}{told:^{columns - len(str(first)) - len(end)}}{end}  t"


def _range(low: float, high: float) -> tuple[float, float]:
    """The scale: all of 0..1 for what looks like probabilities."""
    if low >= -1e-9 and high <= 1 + 1e-9 and high > 0.2:
        return 0.0, 1.0
    size = max(abs(low), abs(high))
    if high / 2 - low / 2 < 1e-12 * max(size, 0.5):  # a level line stands in the middle
        room = 0.5 * max(size, 1.0)
        return max(low - room, -_GREATEST), min(high + room, _GREATEST)
    return low, high


def _join(
    canvas: Canvas, one: tuple[float, float], other: tuple[float, float], steps: bool, number: int
) -> None:
    """A line, or half a step along, up or down, and the other half."""
    if not steps:
        canvas.line(*one, *other, number)
        return
    middle = (one[0] + other[0]) / 2
    places = (one, (middle, one[1]), (middle, other[1]), other)
    for a, b in pairwise(places):
        canvas.line(*a, *b, number)


def extent(curves: Sequence[Curve]) -> tuple[int, int]:
    """The first and the last frame of curves of which some have any."""
    drawn = [c.t for c in curves if len(c.t)]
    return min(int(t[0]) for t in drawn), max(int(t[-1]) for t in drawn)


def _legend(curves: Sequence[Curve], ink: Ink) -> list[str]:
    shown = []
    for number, curve in enumerate(curves):
        sign = "━━" if ink.colour and ink.unicode else LETTERS[number % len(LETTERS)]
        shown.append(f"  {ink.paint(sign, COLOURS[number % len(COLOURS)])} {curve.name}")
    return shown


def laid_out(parts: Iterable[tuple[str, str]], gap: int, indent: int, columns: int) -> list[str]:
    """Pieces side by side, as many as a line holds.

    Args:
        parts: each as it counts, and as it is written: with colours.
    """
    lines, width = [""], 0
    for plain, written in parts:
        if width and indent + width + gap + display_width(plain) > columns:
            lines.append("")
            width = 0
        between = " " * gap if width else ""
        lines[-1] += between + written
        width += len(between) + display_width(plain)
    return [" " * indent + line for line in lines]
