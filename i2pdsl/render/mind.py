"""The audience's mind over time: small panels of belief curves beside a film.

The paper's figures 1 and 2 show five of them under each animation: the cheese's goal, the
robot's goal, the robot's alignment, the rationality of both, the expected values of both
(DOI 10.1145/3588432.3591510, section 4). A panel knows nothing of stories; whoever asks the
audience fills in the numbers. `page.py` draws the same panels live, `mind_figure` as a picture.

The x axis counts frames: 0 is the start, before anybody moved, and T the end of the story.
"""

from __future__ import annotations

import math
import re
import unicodedata
from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from i2pdsl.language.story import VIEWERS
from i2pdsl.render.fonts import families, lacked, quiet_glyphs
from i2pdsl.render.lettering import units
from i2pdsl.render.raster import text_width
from i2pdsl.resources import atomic_path

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Tellable apart under each of the three dichromacies (Machado et al. 2009, DOI
# 10.1109/TVCG.2009.113), and in grey print by their dashes and markers.
PALETTE = {
    "pink": "#d9468f",
    "green": "#00664a",
    "none": "#8c7a3a",
    "hindering": "#c65102",
    "indifferent": "#77777f",
    "helping": "#0068b0",
    "cheese": "#b07300",
    "robot": "#2f4f9e",
}

# One for each series of a panel, in order: lengths of dash and gap in line widths; markers.
DASHES: tuple[tuple[float, ...], ...] = ((), (4.5, 1.8), (1.2, 1.4), (6, 1.6, 1.2, 1.6))
MARKERS = ("o", "s", "^", "D")

PANELS_MAX = 8
INK, FAINT, GRID = "#1d1e24", "#5c5e6a", "#e3e4ea"
WINDOW = "#e8b64c"  # shades a stretch of time, under the curves

# Inches: the plot itself, and the room around it.
PLOT_WIDTH, PLOT_HEIGHT = 1.7, 1.45
ABOVE, BELOW, EDGE = 0.36, 0.46, 0.14
LABEL_GAP, LABEL_WIDTH = 0.09, 1.4
TITLE_SIZE, PANEL_SIZE, TEXT_SIZE = 12.0, 9.5, 8.0  # points
NAME_GAP = TEXT_SIZE * 1.25 / 72  # from one curve's name to the next
NAMES_SHARE = 0.94  # of a plot's height, beside which names stand


@dataclass(frozen=True, eq=False)
class Series:
    """One curve: `values` [T + 1], NaN where there is no value; `color` as #rrggbb.

    `steps`: it is 1 or 0 in each frame, and nothing in between. `claim`: what those think who
    believe it, as a sentence; `audience`: who they are; `event`: the hypotheses of which it is
    true, where it is one of several that are asked under one condition.
    """

    label: str
    values: NDArray[np.float64]
    color: str
    steps: bool = False
    claim: str = ""
    audience: str = VIEWERS
    event: tuple[bool, ...] = ()

    def __post_init__(self) -> None:
        values = np.asarray(self.values, dtype=np.float64)
        if values.ndim != 1 or len(values) == 0:
            raise ValueError(f"series {self.label!r} needs values [T + 1], not {values.shape}")
        if not re.fullmatch(r"#[0-9a-fA-F]{6}", self.color):
            raise ValueError(f"series {self.label!r} needs a #rrggbb color, not {self.color!r}")
        object.__setattr__(self, "values", values)


@dataclass(frozen=True)
class Panel:
    """One small plot: curves of equal length over the frames 0..T.

    `kind` is 'probability' (the y axis runs from 0 to 1) or 'value' (on its own scale). `latent`:
    of whose values these are the probabilities, if of one; `question`: what viewers then wonder.
    """

    title: str
    ylabel: str
    series: tuple[Series, ...]
    kind: Literal["probability", "value"] = "probability"
    latent: str = ""
    question: str = ""

    def __post_init__(self) -> None:
        if self.kind not in ("probability", "value"):
            raise ValueError(f"panel {self.title!r}: no such kind: {self.kind!r}")
        if len({len(series.values) for series in self.series}) != 1:
            raise ValueError(f"panel {self.title!r} needs series of one and the same length")

    @property
    def last(self) -> int:
        """T, the last frame."""
        return len(self.series[0].values) - 1


@dataclass(frozen=True)
class Mark:
    """An event that deserves a vertical line: at `frame` (0..T), explained by `label`."""

    frame: float
    label: str = ""


@dataclass(frozen=True)
class Window:
    """A stretch of time to shade, from frame `first` to frame `last`, explained by `label`."""

    first: int
    last: int
    label: str = ""

    def __post_init__(self) -> None:
        if not 0 <= self.first < self.last:
            raise ValueError(f"window {self.label!r} must be of frames 0 <= first < last")


def panel_values(panel: Panel, series: Series) -> NDArray[np.float64]:
    """[T + 1] The values as drawn: probabilities cut to 0..1, infinities left out as NaN."""
    values = np.where(np.isfinite(series.values), series.values, np.nan)
    return np.clip(values, 0.0, 1.0) if panel.kind == "probability" else values


def value_axis(panel: Panel) -> tuple[float, float, tuple[float, ...]]:
    """Lower end, upper end and ticks of a panel's y axis, in the values' units.

    Ticks are 3 to 6 multiples of 1, 2 or 5 times a power of ten.
    """
    if panel.kind == "probability":
        return 0.0, 1.0, (0.0, 0.5, 1.0)
    values = np.concatenate([panel_values(panel, series) for series in panel.series])
    values = values[np.isfinite(values)]
    low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 1.0)
    return axis_ticks(low, high)


def axis_ticks(low: float, high: float) -> tuple[float, float, tuple[float, ...]]:
    """An axis that holds low..high: its ends, and its ticks as in `value_axis`."""
    if high - low < 1e-9 * max(1.0, abs(high), abs(low)):  # a flat line sits in the middle
        low, high = low - max(1.0, abs(low) / 2), high + max(1.0, abs(high) / 2)
    rough = (high - low) / 4
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(power * nice for nice in (1, 2, 5, 10) if power * nice >= rough)
    first, count = math.floor(low / step), math.ceil(high / step)
    ticks = tuple(round(k * step, 12) + 0.0 for k in range(first, count + 1))
    return ticks[0], ticks[-1], ticks


def frame_ticks(last: int) -> tuple[int, ...]:
    """Whole frames to number on an x axis of 0..last, at most eight."""
    steps = (s * 10**p for p in range(9) for s in (1, 2, 5))
    step = next(s for s in steps if last / s <= 6)
    return tuple(range(0, last + 1, step))


def spread(wanted: Sequence[float], gap: float, low: float, high: float) -> list[float]:
    """Places for labels near `wanted`, at least `gap` apart, inside low..high.

    Least squares: with the gaps taken out, the nearest non-decreasing sequence, found by
    pooling adjacent violators. Where they do not fit, the gap shrinks.
    """
    count = len(wanted)
    if count > 1:
        gap = min(gap, (high - low) / (count - 1))
    order = sorted(range(count), key=lambda i: (wanted[i], -i))
    pools: list[tuple[float, int]] = []
    for rank, index in enumerate(order):
        mean, size = wanted[index] - rank * gap, 1
        while pools and pools[-1][0] >= mean:
            before, many = pools.pop()
            mean, size = (before * many + mean * size) / (many + size), many + size
        pools.append((mean, size))
    level = [mean for mean, size in pools for _ in range(size)]
    places = [0.0] * count
    for rank, index in enumerate(order):
        places[index] = min(max(level[rank], low), high - (count - 1) * gap) + rank * gap
    return places


def mind_figure(
    panels: Sequence[Panel],
    title: str,
    frame: float | None = None,
    marks: Sequence[Mark] = (),
    columns: int | None = None,
    windows: Sequence[Window] = (),
) -> Figure:
    """One to eight panels in a row (more than five: in two), as in the paper.

    `frame` in 0..T draws the moment at hand: a line, dots on the curves, and what is yet to
    come faintly. `columns` panels stand side by side, 1 for a stack.
    """
    from matplotlib.figure import Figure

    if not 1 <= len(panels) <= PANELS_MAX:
        raise ValueError(f"a figure has 1 to {PANELS_MAX} panels, not {len(panels)}")
    if len({panel.last for panel in panels}) != 1:
        raise ValueError("the panels of a figure must cover the same frames")
    usual = len(panels) if len(panels) <= 5 else math.ceil(len(panels) / 2)
    columns = min(columns or usual, len(panels))
    rows = math.ceil(len(panels) / columns)
    lefts = [_left_room(panels, index, columns) for index in range(len(panels))]
    rights = [_right_room(panel) for panel in panels]
    left = [max(lefts[column::columns]) for column in range(columns)]
    cells = [left[column] + PLOT_WIDTH + max(rights[column::columns]) for column in range(columns)]
    width = sum(cells)
    titles = [_wrap(panel.title, PANEL_SIZE, PLOT_WIDTH + min(rights)) for panel in panels]
    names = max(len(panel.series) for panel in panels)
    plot_height = max(PLOT_HEIGHT, names * NAME_GAP / NAMES_SHARE)  # or names lie on each other
    cell_height = ABOVE + 0.16 * (max(map(len, titles)) - 1) + plot_height + BELOW
    heading = _wrap(title, TITLE_SIZE, width - 2 * EDGE)
    notes = [f"┊ frame {m.frame:g}: {m.label}" for m in marks if m.label]
    notes += [f"▒ frames {w.first} to {w.last}: {w.label}" for w in windows if w.label]
    footing = _wrap("   ".join(notes), TEXT_SIZE, width - 2 * EDGE) if notes else []
    top = 0.1 + 0.21 * len(heading)
    height = top + rows * cell_height + 0.16 * len(footing)

    figure = Figure(figsize=(width, height), facecolor="white")
    for line, text in enumerate(heading):
        place = (EDGE / width, 1 - (0.09 + 0.21 * line) / height)
        figure.text(*place, text, va="top", size=TITLE_SIZE, color=INK, parse_math=False)
    for index, panel in enumerate(panels):
        row, column = divmod(index, columns)
        x = sum(cells[:column]) + left[column]
        y = height - top - (row + 1) * cell_height + BELOW
        box = (x / width, y / height, PLOT_WIDTH / width, plot_height / height)
        axes = figure.add_axes(box)
        axes.set_title(
            "\n".join(titles[index]), loc="left", pad=7, size=PANEL_SIZE, weight="bold",
            color=INK, parse_math=False, linespacing=1.2,
        )  # fmt: skip
        _draw_panel(axes, panel, frame, marks, windows, _says_ylabel(panels, index, columns))
        _label_series(axes, panel, NAME_GAP / plot_height)
    for line, text in enumerate(footing):
        place = (EDGE / width, (0.06 + 0.16 * (len(footing) - 1 - line)) / height)
        figure.text(*place, text, va="bottom", size=TEXT_SIZE, color=FAINT, parse_math=False)
    return figure


def save_mind(
    path: str | Path,
    panels: Sequence[Panel],
    title: str,
    frame: float | None = None,
    marks: Sequence[Mark] = (),
    columns: int | None = None,
    dpi: int = 200,
    windows: Sequence[Window] = (),
) -> Path:
    """Writes `mind_figure` as .png or .svg, whole or not at all; the same bytes every time."""
    from matplotlib import rc_context

    path = Path(path)
    kind = path.suffix.lower().removeprefix(".")
    if kind not in ("png", "svg"):
        raise ValueError(f"{path.name}: belief plots are written as .png or .svg")
    metadata = {"Software": None} if kind == "png" else {"Date": None, "Creator": None}
    text = title + "".join(
        f"{p.title}{p.ylabel}{''.join(s.label for s in p.series)}" for p in panels
    )
    text += "".join((*(m.label for m in marks), *(w.label for w in windows)))
    fixed = rc_context(
        {"svg.hashsalt": "i2p", "svg.fonttype": "path", "font.family": families(text)}
    )
    with fixed, quiet_glyphs():
        figure = mind_figure(panels, title, frame, marks, columns, windows)
        with atomic_path(path) as temporary:
            figure.savefig(temporary, format=kind, dpi=dpi, metadata=metadata)
    return path


def _says_ylabel(panels: Sequence[Panel], index: int, columns: int) -> bool:
    """A label that the left neighbour already carries is not repeated."""
    return index % columns == 0 or panels[index].ylabel != panels[index - 1].ylabel


def _left_room(panels: Sequence[Panel], index: int, columns: int) -> float:
    """Inches for the numbers of the y axis and, where it is said, its label."""
    numbers = max(_width(_number(tick), TEXT_SIZE) for tick in value_axis(panels[index])[2])
    return EDGE + numbers + (0.28 if _says_ylabel(panels, index, columns) else 0.08)


def _right_room(panel: Panel) -> float:
    """Inches for the names beside the curves."""
    names = (_fit_name(series.label) for series in panel.series)
    return LABEL_GAP + max(_width(name, TEXT_SIZE) for name in names) + EDGE


def _draw_panel(
    axes: Axes,
    panel: Panel,
    frame: float | None,
    marks: Sequence[Mark],
    windows: Sequence[Window],
    says_ylabel: bool,
) -> None:
    low, high, ticks = value_axis(panel)
    margin = 0.045 * (high - low)
    axes.set_xlim(0 - 0.02 * max(panel.last, 1), max(panel.last, 1) * 1.02)
    axes.set_ylim(low - margin, high + margin)
    axes.set_xticks(frame_ticks(panel.last))
    axes.set_yticks(ticks, [_number(tick) for tick in ticks])
    axes.grid(color=GRID, linewidth=0.6)
    axes.set_axisbelow(True)
    axes.tick_params(length=0, pad=3, labelsize=TEXT_SIZE, labelcolor=FAINT)
    for side, spine in axes.spines.items():
        spine.set_visible(side in ("left", "bottom"))
        spine.set(color="#b9bbc6", linewidth=0.7)
    text: dict[str, Any] = {"parse_math": False, "color": FAINT, "size": TEXT_SIZE}
    axes.set_xlabel("frame", labelpad=2, **text)
    if says_ylabel:
        axes.set_ylabel(_fit(panel.ylabel, TEXT_SIZE, PLOT_HEIGHT), labelpad=3, **text)
    for window in windows:
        axes.axvspan(window.first, window.last, color=WINDOW, alpha=0.28, linewidth=0, zorder=0.5)
    for mark in marks:
        axes.axvline(mark.frame, color=FAINT, linewidth=0.9, linestyle=(0, (1, 1.6)), zorder=1.5)
    if frame is not None:
        axes.axvline(frame, color=INK, linewidth=1.0, zorder=1.8)
    for index, series in enumerate(panel.series):
        _draw_series(axes, panel, series, index, frame)


def _draw_series(axes: Axes, panel: Panel, series: Series, index: int, frame: float | None) -> None:
    """The curve with its dashes and a few markers; before `frame` strongly, after it faintly."""
    values, frames = panel_values(panel, series), np.arange(panel.last + 1)
    dashes = DASHES[index % len(DASHES)]
    step = max(1, math.ceil(panel.last / 8))
    every = (index * step // len(panel.series), step)
    style: dict[str, Any] = {
        "color": series.color,
        "linewidth": 1.6,
        "linestyle": (0, dashes) if dashes else "-",
        "marker": MARKERS[index % len(MARKERS)],
        "markersize": (3.8, 3.4, 4.4, 3.4)[index % 4],
        "markeredgecolor": "white",
        "markeredgewidth": 0.6,
        "zorder": 3,
        "drawstyle": "steps-mid" if series.steps else "default",
    }
    if frame is None:
        axes.plot(frames, values, markevery=every, **style)
        return
    here = np.interp(frame, frames, values)
    past = frames <= frame
    shown = int(past.sum())
    marked = [k for k in range(every[0], panel.last + 1, every[1]) if k < shown]
    axes.plot(frames, values, **{**style, "alpha": 0.28, "marker": ""})
    axes.plot(
        np.append(frames[past], frame), np.append(values[past], here), markevery=marked, **style
    )
    axes.plot(frame, here, **{**style, "markersize": 5.5, "marker": "o", "zorder": 4})


def _label_series(axes: Axes, panel: Panel, gap: float) -> None:
    """Names beside the curves' right ends, at least `gap` of the axis apart."""
    bottom, top = axes.get_ylim()
    ends = []
    for series in panel.series:
        values = panel_values(panel, series)
        known = values[np.isfinite(values)]
        ends.append((float(known[-1]) - bottom) / (top - bottom) if len(known) else 0.5)
    places = spread(ends, gap, (1 - NAMES_SHARE) / 2, (1 + NAMES_SHARE) / 2)
    for series, end, place in zip(panel.series, ends, places, strict=True):
        name = _fit_name(series.label)
        if abs(place - end) > 0.02:  # a leader from the curve's end to its name
            x = np.array([0.985, 1.0 + 0.7 * LABEL_GAP / PLOT_WIDTH])
            axes.plot(
                x, [end, place], transform=axes.transAxes, color=series.color, linewidth=0.5,
                alpha=0.7, clip_on=False, zorder=2,
            )  # fmt: skip
        axes.text(
            1 + LABEL_GAP / PLOT_WIDTH, place, name, transform=axes.transAxes,
            va="center_baseline", size=TEXT_SIZE, color=series.color, parse_math=False,
        )  # fmt: skip


def _number(value: float) -> str:
    return f"{value:g}".replace("-", "−")


@lru_cache(1000)
def _width(text: str, size: float) -> float:
    """Inches that a line of text takes; panel titles are bold."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import text_to_path

    if lacked(text):
        return text_width(text, size, size == PANEL_SIZE) / 72
    font = FontProperties(size=size, weight="bold" if size == PANEL_SIZE else "normal")
    return float(text_to_path.get_text_width_height_descent(text, font, False)[0]) / 72


def _wrap(text: str, size: float, width: float) -> list[str]:
    """Lines no wider than `width` inches, at most three; what is left over ends in '…'."""
    lines, room = [""], 0.0
    for word in units(_clean(text), lambda word: _width(word, size) <= width):
        needed = _width(f" {word}", size)
        if needed > room and lines[-1]:
            if len(lines) == 3:
                lines[-1] += " …"
                break
            lines, room = [*lines, ""], width
        elif not lines[-1]:
            room = width
        lines[-1], room = f"{lines[-1]} {word}".strip(), room - needed
    return [_fit(line, size, width) for line in lines]


def _fit(text: str, size: float, width: float) -> str:
    """The text, cut and ended by '…' where it is wider than `width` inches."""
    text = _clean(text)
    if _width(text, size) <= width:
        return text
    kept = bisect_left(range(len(text)), True, key=lambda n: _width(text[:n] + "…", size) > width)
    return text[: max(kept - 1, 0)] + "…"


def _fit_name(name: str) -> str:
    """A curve's name; of a long one its middle is left out, since names often begin alike."""
    name = _clean(name)
    if _width(name, TEXT_SIZE) <= LABEL_WIDTH:
        return name
    head, tail = _fit(name, TEXT_SIZE, 0.6 * LABEL_WIDTH), name[::-1]
    return head + _fit(tail, TEXT_SIZE, 0.42 * LABEL_WIDTH)[-2::-1]


def _clean(text: str) -> str:
    """Without control characters and lone surrogates, which no SVG can hold; of bearable length."""
    return "".join(" " if unicodedata.category(c) in ("Cc", "Cs") else c for c in text[:1000])
