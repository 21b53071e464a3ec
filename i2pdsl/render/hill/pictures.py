"""All pictures of performances on the hill: which there are, where they go."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cached_property
from pathlib import Path
from typing import Literal

import numpy as np

from i2pdsl.render.hill.performance import HUES, Performance, key_frames
from i2pdsl.render.mind import PANELS_MAX, Panel, Series, Window

FORMATS = ("png", "svg", "gif", "mp4", "html")
KEY_FRAMES = 8

Progress = Callable[[str, int, int], None]  # picture, steps done, steps in all


class HillPictures:
    """Draws one performance, or several side by side in the same time."""

    def __init__(self, performances: Sequence[Performance], title: str | None = None):
        if not performances:
            raise ValueError("there is no performance to draw")
        self.performances = tuple(performances)
        self.several = len(self.performances) > 1
        name = title or " · ".join(p.title for p in self.performances)
        self.title = "".join(c if c.isprintable() else " " for c in name)  # all that an SVG holds

    @cached_property
    def panels(self) -> tuple[Panel, ...]:
        """The curves: a performance's own, or those that several have in common, compared."""
        return compared(self.performances) if self.several else self.performances[0].panels

    @property
    def windows(self) -> tuple[Window, ...]:
        """The stretches of time to shade in the curves: all there are, each once."""
        return tuple(dict.fromkeys(w for p in self.performances for w in p.windows))

    def save(
        self, folder: Path, formats: tuple[str, ...], progress: Progress | None = None
    ) -> dict[str, Path]:
        """Writes the pictures of the formats asked for; returns name -> path."""
        return dict(self.drawn(folder, formats, progress))

    def drawn(
        self, folder: Path, formats: tuple[str, ...], progress: Progress | None = None
    ) -> Iterator[tuple[str, Path]]:
        """As `save`, one file after the other, those that take longest last."""
        if "png" in formats or "svg" in formats:
            yield from self._still(folder, formats)
        if "html" in formats:
            from i2pdsl.render.hill.page import save_page

            name = "together.html" if self.several else "page.html"
            path = save_page(
                folder / name, self.performances, self.panels, self.title, self.windows
            )
            yield "html", path
        for kind in ("gif", "mp4"):
            if kind in formats:
                name = f"together.{kind}" if self.several else f"film.{kind}"
                yield kind, self._film(folder / name, progress)

    def _still(self, folder: Path, formats: tuple[str, ...]) -> Iterator[tuple[str, Path]]:
        from i2pdsl.render.hill.comic import comic_svg, together_svg
        from i2pdsl.render.mind import save_mind
        from i2pdsl.render.raster import save_png, save_svg

        if self.several:
            name, drawing = "together", together_svg(self.performances, self.title)
        else:
            one = self.performances[0]
            frames = key_frames(one.frames, one.windows, KEY_FRAMES)
            name, drawing = "comic", comic_svg(one, frames, self.title)
        title = f"What viewers believe: {self.title}"
        for kind in ("png", "svg"):
            if kind in formats:
                path = folder / f"{name}.{kind}"
                if kind == "png":
                    save_png(path, drawing, zoom=1.25)
                else:
                    save_svg(path, drawing)
                yield path.name, path
                if self.panels:
                    path = folder / f"mind.{kind}"
                    yield path.name, save_mind(path, self.panels, title, windows=self.windows)

    def _film(self, path: Path, progress: Progress | None) -> Path:
        from i2pdsl.render.hill.film import save_gif, save_mp4

        save = save_gif if path.suffix == ".gif" else save_mp4
        report = None
        if progress is not None:
            report = lambda done, total: progress(path.name, done, total)
        save(path, self.performances, self.title, progress=report)
        return path


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
