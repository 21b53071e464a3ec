"""Judgements against the model, as a picture."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.transforms import Bbox

from i2pdsl.errors import shorten
from i2pdsl.fit.report import Report
from i2pdsl.resources import atomic_path

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST_NAMED = 60  # points
_BESIDE = (
    *(((6, -5), "left", "top"), ((-6, 5), "right", "bottom")),
    *(((6, 5), "left", "bottom"), ((-6, -5), "right", "top")),
)  # away from the diagonal first


def draw_agreement(report: Report, path: Path) -> None:
    """A point for each question about a script: people's mean and the model's, with intervals.

    Call it within `matplotlib_settings` of nobody else: it makes its own figure.
    """
    from matplotlib.figure import Figure

    cells, scale = report.cells, report.fitted.study.scale
    people, model = (np.array([getattr(c, n) for c in cells]) for n in ("people", "model"))
    r, rmse = report.agreement
    spread = lambda values, low, high: np.abs(
        [values - [getattr(c, low) for c in cells], [getattr(c, high) for c in cells] - values]
    )
    figure = Figure(figsize=(5.2, 5.2), layout="constrained")
    axes = figure.subplots()
    axes.plot([0, scale], [0, scale], color="0.8", linewidth=1, zorder=0)
    axes.errorbar(
        model,
        people,
        xerr=spread(model, "model_low", "model_high"),
        yerr=spread(people, "people_low", "people_high"),
        fmt="o",
        markersize=6,
        markeredgecolor="white",
        color="#31688e",
        ecolor="#31688e66",
        elinewidth=1.5,
    )
    axes.set(xlim=(-0.03 * scale, 1.03 * scale), ylim=(-0.03 * scale, 1.03 * scale), aspect="equal")
    axes.set_xlabel("the fitted audience")
    axes.set_ylabel(f"people ({len(report.fitted.study.people)})")
    asked = {cell.question for cell in cells}
    question = shorten(asked.pop()) if len(asked) == 1 else f"{len(asked)} questions"
    axes.set_title(f"{question}\nr = {r:.3f}, RMSE = {rmse:.3g}", fontsize=10)
    axes.spines[["top", "right"]].set_visible(False)
    if len(cells) <= MOST_NAMED:
        figure.draw_without_rendering()  # places are known from then on
        _name(axes, model, people, _short(tuple(cell.script for cell in cells)))
    with atomic_path(path) as temporary:
        figure.savefig(temporary, dpi=150)


def _name(axes: Axes, x: np.ndarray, y: np.ndarray, names: list[str]) -> None:
    """Writes names beside points where there is room; what would cover another one is left out."""
    points = axes.transData.transform(np.column_stack([x, y]))
    radius = 6.0
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
            )
            box = text.get_window_extent()
            if not any(box.overlaps(other) for other in others):
                taken.append(box)
                break
            text.remove()


def _short(names: tuple[str, ...]) -> list[str]:
    """Names without what all of them begin and end with."""
    plain = [Path(name).name for name in names]
    if len(set(plain)) < 2:
        return plain
    first, last = min(plain), max(plain)
    begin = next(i for i, (a, b) in enumerate(zip(first, last, strict=False)) if a != b)
    first, last = min(p[::-1] for p in plain), max(p[::-1] for p in plain)
    ends = (i for i, (a, b) in enumerate(zip(first, last, strict=False)) if a != b)
    end = next(ends, 0)
    short = [name[begin : len(name) - end] for name in plain]
    return short if all(short) else plain
