"""All pictures of performances in the plane: which there are, where they go."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from i2pdsl.render.files import Sprites
from i2pdsl.render.performances import PerformancePictures
from i2pdsl.render.plane.performance import Performance, frame_seconds, key_frames
from i2pdsl.render.video import Times

if TYPE_CHECKING:
    from i2pdsl.render.film_page import Film

KEY_FRAMES = 6  # beside the whole way


class PlanePictures(PerformancePictures[Performance]):
    """Draws one performance, or several of one room side by side in the same time."""

    def comic(self) -> str:
        from i2pdsl.render.plane.comic import comic_svg, together_svg

        if self.several:
            return together_svg(self.performances, self.title)
        one = self.performances[0]
        return comic_svg(one, key_frames(one, KEY_FRAMES), self.title)

    def page(self) -> str:
        from i2pdsl.render.plane.page import page_html

        return page_html(
            self.performances, self.panels, self.title, self.windows, self.wishes, self.account,
            self.clock,
        )  # fmt: skip

    def moving(self) -> Film:
        from i2pdsl.render.plane.page import moving

        return moving(self.performances, self.clock)

    def sprites(self) -> Sprites:
        from i2pdsl.render.plane.export import background, sheet

        (one,) = self.performances
        return sheet(one.spec), background(one)

    def timeline(self) -> dict[str, Any]:
        from i2pdsl.render.plane.export import timeline

        return timeline(self.performances[0], self.clock)

    @property
    def seconds(self) -> float:
        return frame_seconds(self.performances)

    def film_frames(self, times: Times, width: int) -> Iterator[np.ndarray]:
        from i2pdsl.render.plane.film import film_frames

        return film_frames(self.performances, times, width, self.title, self.look.meter)
