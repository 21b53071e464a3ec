"""All pictures of performances on the hill: which there are, where they go."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Literal

import numpy as np

from i2pdsl.render.files import KEY_FRAMES
from i2pdsl.render.hill.performance import Performance, key_frames
from i2pdsl.render.mind import PANELS_MAX, Panel, Series
from i2pdsl.render.performances import HUES, PerformancePictures


class HillPictures(PerformancePictures[Performance]):
    """Draws one performance, or several side by side in the same time."""

    def compared(self) -> tuple[Panel, ...]:
        return compared(self.performances)

    def comic(self) -> str:
        from i2pdsl.render.hill.comic import comic_svg, together_svg

        if self.several:
            return together_svg(self.performances, self.title)
        one = self.performances[0]
        return comic_svg(one, key_frames(one.frames, one.windows, KEY_FRAMES), self.title)

    def save_page(self, path: Path) -> Path:
        from i2pdsl.render.hill.page import save_page

        return save_page(
            path, self.performances, self.panels, self.title, self.windows, self.wishes
        )

    def save_film(self, path: Path, progress: Callable[[int, int], None] | None) -> None:
        from i2pdsl.render.hill.film import save_gif, save_mp4

        save = save_gif if path.suffix == ".gif" else save_mp4
        save(path, self.performances, self.title, progress=progress)


def compared(performances: Sequence[Performance]) -> tuple[Panel, ...]:
    """For each curve that the performances have in common a panel with one of each.

    Of a panel with two probabilities only the first is compared: the other says the same. How far
    the hoppers have come is added where no panel tells it.
    """
    found = []
    for panel in performances[0].panels:
        told = panel.series[:1] if _complementary(panel) else panel.series
        for series in told:
            curves = [_curve(p, panel.title, series.label) for p in performances]
            known = [curve for curve in curves if curve is not None]
            if len(known) == len(performances):
                title = panel.title if len(panel.series) == 1 else f"{panel.title}: {series.label}"
                found.append(_compared(performances, title, panel.ylabel, panel.kind, known))
    if not any("distance" in panel.title.lower() for panel in found):
        ways = [p.distance for p in performances]
        found.append(_compared(performances, "distance", "units", "value", ways))
    return tuple(found[:PANELS_MAX])


def _complementary(panel: Panel) -> bool:
    return panel.kind == "probability" and len(panel.series) == 2


def _curve(performance: Performance, title: str, label: str) -> np.ndarray | None:
    """A performance's curve of that name; where a panel has but one, its name does not matter."""
    for panel in performance.panels:
        if panel.title == title:
            for series in panel.series:
                if series.label == label or len(panel.series) == 1:
                    return series.values
    return None


def _compared(
    performances: Sequence[Performance],
    title: str,
    ylabel: str,
    kind: Literal["probability", "value"],
    curves: Sequence[np.ndarray],
) -> Panel:
    """One curve of each performance; those of shorter ones end with them."""
    last = max(p.frames for p in performances)
    series = tuple(
        Series(
            p.title,
            np.pad(curve, (0, last - p.frames), constant_values=np.nan),
            HUES[number % len(HUES)],
        )
        for number, (p, curve) in enumerate(zip(performances, curves, strict=True))
    )
    return Panel(title, ylabel, series, kind)
