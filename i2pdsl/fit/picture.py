"""Judgements against the model, as a picture."""

from __future__ import annotations

import re
from itertools import compress
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

from i2pdsl.errors import shorten
from i2pdsl.fit.report import Cell, Report
from i2pdsl.resources import atomic_path

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST_NAMED = 60  # points
COLOURS = ("#31688e", "#c7522a", "#3d8f5f", "#8a4f9e", "#a07d1c", "#5a5a5a")
_BESIDE = (
    *(((6, -5), "left", "top"), ((-6, 5), "right", "bottom")),
    *(((6, 5), "left", "bottom"), ((-6, -5), "right", "top")),
)  # away from the diagonal first


@rc_context({"text.parse_math": False})  # names of a table are no formulas
def draw_agreement(report: Report, path: Path) -> None:
    """A point for each question about a script: people's mean and the model's, with intervals.

    Call it within `matplotlib_settings` of nobody else: it makes its own figure.
    """
    cells, scale = report.cells, report.fitted.study.scale
    people, model = (np.array([getattr(c, n) for c in cells]) for n in ("people", "model"))
    r, rmse = report.agreement
    spread = lambda values, low, high: np.abs(
        [values - [getattr(c, low) for c in cells], [getattr(c, high) for c in cells] - values]
    )
    across, along = (
        spread(values, f"{name}_low", f"{name}_high")
        for values, name in ((model, "model"), (people, "people"))
    )
    figure = Figure(figsize=(5.6, 5.6), layout="constrained")
    axes = figure.subplots()
    axes.plot([0, scale], [0, scale], color="0.8", linewidth=1, zorder=0)
    series = [_series(cell) for cell in cells]
    kinds = list(dict.fromkeys(series))
    for kind, name in enumerate(kinds):
        own = np.array([one == name for one in series])
        colour = COLOURS[kind % len(COLOURS)]
        drawn = axes.errorbar(
            model[own],
            people[own],
            xerr=across[:, own],
            yerr=along[:, own],
            fmt="o",
            label=shorten(name),
            markersize=6,
            markeredgecolor="white",
            color=colour,
            ecolor=colour,
            elinewidth=1,
        )
        for bars in drawn[2]:
            bars.set(alpha=0.35, zorder=1)
    axes.set(xlim=(-0.03 * scale, 1.03 * scale), ylim=(-0.03 * scale, 1.03 * scale), aspect="equal")
    axes.set_xlabel("the fitted audience")
    axes.set_ylabel(f"people ({len(report.fitted.study.people)})")
    if 1 < len(kinds) <= len(COLOURS):
        figure.legend(loc="outside lower center", fontsize=8, frameon=False)
    questions = {cell.question for cell in cells}
    asked = shorten(cells[0].question) if len(questions) == 1 else f"{len(questions)} questions"
    axes.set_title(f"{asked}\nr = {r:.3f}, RMSE = {rmse:.3g}", fontsize=10)
    axes.spines[["top", "right"]].set_visible(False)
    if len(cells) <= MOST_NAMED:
        figure.draw_without_rendering()  # places are known from then on
        _name(figure, axes, model, people, _names(cells))
    with atomic_path(path) as temporary:
        figure.savefig(temporary, dpi=150)


def _series(cell: Cell) -> str:
    """What points of one colour have in common."""
    if cell.label is not None:
        return f"{cell.question}: {cell.label}"
    return (
        cell.question if cell.other is None else f"{cell.question}, the first rather than the other"
    )


def _name(figure: Figure, axes: Axes, x: np.ndarray, y: np.ndarray, names: list[str]) -> None:
    """Writes names beside points where there is room; what would cover another one is left out."""
    points = axes.transData.transform(np.column_stack([x, y]))
    radius, frame = 6.0, axes.get_window_extent()
    right = figure.bbox.x1
    taken = [Bbox([point - radius, point + radius]) for point in points]
    for number, name in enumerate(names):
        others = [box for other, box in enumerate(taken) if other != number]
        for away, across, up in _BESIDE:
            text = axes.annotate(
                name,
                (x[number], y[number]),
                away,
                textcoords="offset points",
                fontsize=7,
                color="0.35",
                horizontalalignment=across,
                verticalalignment=up,
                in_layout=False,
            )
            box = text.get_window_extent()
            inside = frame.x0 <= box.x0 and box.x1 <= right
            inside &= frame.y0 <= box.y0 and box.y1 <= frame.y1
            if inside and not any(box.overlaps(other) for other in others):
                taken.append(box)
                break
            text.remove()


def _names(cells: tuple[Cell, ...]) -> list[str]:
    """What tells points apart: the script, of two films both, and which of several frames."""
    paths = {path for cell in cells for path in (cell.script, cell.other) if path is not None}
    short = _short(sorted(paths))
    frames = {(cell.script, cell.frame) for cell in cells}
    found = []
    for cell in cells:
        name = short[cell.script]
        if cell.other is not None:
            name += f" | {short[cell.other]}"
        # One of several that were asked about the script.
        several = sum(script == cell.script for script, _ in frames) > 1
        found.append(f"{name} @ {cell.frame}" if several else name)
    return found


def _short(paths: list[str]) -> dict[str, str]:
    """Paths by what tells them apart: `mime/seed-0/script.json` is `mime 0`."""
    split = [re.split(r"[/_. -]+", Path(path).as_posix()) for path in paths]
    if len(paths) < 2:
        return {path: Path(path).stem for path in paths}
    if len(set(map(len, split))) > 1:
        return {path: Path(path).as_posix() for path in paths}
    differs = [len(set(parts)) > 1 for parts in zip(*split, strict=True)]
    return {
        path: " ".join(compress(parts, differs)) for path, parts in zip(paths, split, strict=True)
    }
