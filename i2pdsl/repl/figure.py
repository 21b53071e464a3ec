"""Curves into a file, by matplotlib."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from i2pdsl.answers import Answer
from i2pdsl.errors import error, whole_file
from i2pdsl.render.characters import NOTHING, Curve, curves_of
from i2pdsl.render.fonts import families, quiet_glyphs
from i2pdsl.repl.mistakes import INPUT
from i2pdsl.resources import atomic_path

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LARGEST = 1e300  # matplotlib's axes need some room above it


def write_figure(answers: Sequence[Answer], frames: range, path: Path) -> None:
    """Draws curves over t as PNG, SVG or PDF, by the name of the file.

    Raises StoryError where there is nothing to draw.
    """
    curves = [c for a in answers for c in curves_of(a, frames)]
    every = np.concatenate([c.value[np.isfinite(c.value)] for c in curves])
    if not every.size:
        raise error("plot", NOTHING, whole_file(INPUT))
    if np.abs(every).max() > _LARGEST:
        message = f"numbers greater than {_LARGEST:g} are not drawn into files"
        raise error("plot", message, whole_file(INPUT))
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    with rc_context({"font.family": families("".join(c.name for c in curves))}), quiet_glyphs():
        figure = _figure(curves)
        FigureCanvasAgg(figure)
        with atomic_path(path) as temporary:
            figure.savefig(temporary)


def _figure(curves: Sequence[Curve]) -> Figure:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7, 3.6), layout="constrained", dpi=160)
    axes = figure.add_subplot()
    for curve in curves:
        marker = "o" if len(curve.t) <= 40 else None
        drawn = "steps-mid" if curve.steps else "default"
        axes.plot(
            curve.t, curve.value, marker=marker, markersize=3, label=curve.name, drawstyle=drawn
        )
    if all(((c.value >= -1e-9) & (c.value <= 1 + 1e-9)).all() for c in curves):
        axes.set_ylim(-0.03, 1.03)
    axes.set_xlabel("t")
    axes.grid(alpha=0.25)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, fontsize=8)
    return figure
