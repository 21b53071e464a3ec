"""All pictures of performances on the hill: which there are, where they go."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from i2pdsl.render.files import FORMATS, KEY_FRAMES
from i2pdsl.render.hill.performance import Performance, key_frames
from i2pdsl.render.mind import PANELS_MAX, Panel
from i2pdsl.render.performances import PerformancePictures, hued
from i2pdsl.render.performances import compared as curves_compared
from i2pdsl.render.video import Times
from i2pdsl.worlds.hill.springs import FRAME_SECONDS

if TYPE_CHECKING:
    from i2pdsl.render.film_page import Film


class HillPictures(PerformancePictures[Performance]):
    """Draws one performance, or several side by side in the same time."""

    offered = tuple(each for each in FORMATS if each != "sheet")
    # Every frame of the world in the MP4; the GIF is small.
    usual: ClassVar = {
        ".mp4": (1 / FRAME_SECONDS, (800, 1280)),
        ".webm": (1 / FRAME_SECONDS, (800, 1280)),
        ".gif": (10, (480, 780)),
    }

    def compared(self) -> tuple[Panel, ...]:
        return compared(self.performances)

    def comic(self) -> str:
        from i2pdsl.render.hill.comic import comic_svg, together_svg

        if self.several:
            return together_svg(self.performances, self.title)
        one = self.performances[0]
        return comic_svg(one, key_frames(one, KEY_FRAMES), self.title)

    def page(self) -> str:
        from i2pdsl.render.hill.page import page_html

        return page_html(
            self.performances, self.panels, self.title, self.windows, self.wishes, self.account,
            self.clock,
        )  # fmt: skip

    def moving(self) -> Film:
        from i2pdsl.render.hill.page import moving

        return moving(self.performances, self.clock)

    def timeline(self) -> dict[str, Any]:
        from i2pdsl.render.hill.export import timeline

        return timeline(self.performances[0], self.clock)

    @property
    def seconds(self) -> float:
        return self.performances[0].frame_seconds

    def film_frames(self, times: Times, width: int) -> Iterator[np.ndarray]:
        from i2pdsl.render.hill.film import film_frames

        return film_frames(self.performances, times, width, self.title, self.look.meter)


def compared(performances: Sequence[Performance]) -> tuple[Panel, ...]:
    """The curves that the performances have in common, and how far the hoppers have come, where
    no panel tells it."""
    found = list(curves_compared(performances))
    if not any("distance" in panel.title.lower() for panel in found):
        last = max(p.frames for p in performances)
        ways = hued(performances, [p.distance for p in performances], last)
        found.append(Panel("distance", "units", ways, "value"))
    return tuple(found[:PANELS_MAX])
