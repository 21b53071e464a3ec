"""Judgements against the model, as a picture."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from i2pdsl.fit.report import Report
from i2pdsl.resources import atomic_path


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
    names = _short(tuple(cell.script for cell in cells))
    if len(cells) <= 40:
        for x, y, name in zip(model, people, names, strict=True):
            axes.annotate(
                name, (x, y), (5, -9), textcoords="offset points", fontsize=7, color="0.35"
            )
    axes.set(xlim=(-0.03 * scale, 1.03 * scale), ylim=(-0.03 * scale, 1.03 * scale), aspect="equal")
    axes.set_xlabel("the fitted audience")
    axes.set_ylabel(f"people ({len(report.fitted.study.people)})")
    axes.set_title(f"r = {r:.3f}, RMSE = {rmse:.3g}", fontsize=11)
    axes.spines[["top", "right"]].set_visible(False)
    with atomic_path(path) as temporary:
        figure.savefig(temporary, dpi=150)


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
