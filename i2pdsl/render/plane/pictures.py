"""All pictures of performances in the plane: which there are, where they go."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from i2pdsl.render.mind import PANELS_MAX, Panel, Series
from i2pdsl.render.performances import HUES, PerformancePictures
from i2pdsl.render.plane.performance import Performance, key_frames

KEY_FRAMES = 6  # beside the whole way


class PlanePictures(PerformancePictures[Performance]):
    """Draws one performance, or several of one room side by side in the same time."""

    def compared(self) -> tuple[Panel, ...]:
        return compared(self.performances)

    def comic(self) -> str:
        from i2pdsl.render.plane.comic import comic_svg, together_svg

        if self.several:
            return together_svg(self.performances, self.title)
        one = self.performances[0]
        return comic_svg(one, key_frames(one, KEY_FRAMES), self.title)

    def save_page(self, path: Path) -> Path:
        from i2pdsl.render.plane.page import save_page

        return save_page(
            path, self.performances, self.panels, self.title, self.windows, self.wishes
        )

    def save_film(self, path: Path, progress: Callable[[int, int], None] | None) -> None:
        from i2pdsl.render.plane.film import save_gif, save_mp4

        save = save_gif if path.suffix == ".gif" else save_mp4
        save(path, self.performances, self.title, progress=progress)


def compared(performances: Sequence[Performance]) -> tuple[Panel, ...]:
    """For each curve that the performances have in common a panel with one of each, those of
    shorter ones ending with them. Of two that say the same, only the first."""
    last = max(p.frames for p in performances)
    courses = [{(q.title, s.label): s.values for q in p.panels for s in q.series}
               for p in performances]  # fmt: skip
    found = []
    for panel in performances[0].panels:
        for label in (s.label for s in _telling(panel)):
            if not all((panel.title, label) in course for course in courses):
                continue
            series = tuple(
                Series(
                    p.title,
                    np.pad(
                        course[panel.title, label], (0, last - p.frames), constant_values=np.nan
                    ),
                    HUES[number % len(HUES)],
                )
                for number, (p, course) in enumerate(zip(performances, courses, strict=True))
            )
            found.append(Panel(f"{panel.title}: {label}", panel.ylabel, series, panel.kind))
    return tuple(found[:PANELS_MAX])


def _telling(panel: Panel) -> tuple[Series, ...]:
    """A panel's curves without the second of two probabilities that sum to 1."""
    total = np.sum([s.values for s in panel.series], axis=0)
    is_both = panel.kind == "probability" and len(panel.series) == 2
    return panel.series[:1] if is_both and np.allclose(total, 1) else panel.series
