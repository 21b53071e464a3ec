"""Curves into a file, by matplotlib."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from i2pdsl.answers import Answer
from i2pdsl.repl.curves import curves_of
from i2pdsl.resources import atomic_path


def write_figure(answers: Sequence[Answer], frames: range, path: Path) -> None:
    """Draws curves over t as PNG, SVG or PDF, by the name of the file."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7, 3.6), layout="constrained", dpi=160)
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    values = []
    for curve in [c for a in answers for c in curves_of(a, frames)]:
        marker = "o" if len(curve.t) <= 40 else None
        axes.plot(curve.t, curve.value, marker=marker, markersize=3, label=curve.name)
        values.append(curve.value)
    if all(((v >= -1e-9) & (v <= 1 + 1e-9)).all() for v in values):
        axes.set_ylim(-0.03, 1.03)
    axes.set_xlabel("t")
    axes.grid(alpha=0.25)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, fontsize=8)
    with atomic_path(path) as temporary:
        figure.savefig(temporary)
