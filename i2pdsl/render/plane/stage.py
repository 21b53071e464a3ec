"""The stage of films and pages: a room, and below it who is who where there are several."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from i2pdsl.render.ink import mix
from i2pdsl.render.plane.figures import key_svg
from i2pdsl.render.plane.names import names_svg, place_names
from i2pdsl.render.plane.performance import Performance
from i2pdsl.render.plane.room import CREAM, FRAME, View, rect_svg, room_svg, view_within
from i2pdsl.worlds.plane.spec import PlaneSpec

BAND, LEAST = 32.0, 310.0  # pixels for who is who: high, and at least wide


@dataclass(frozen=True)
class Stage:
    """A room, and what lies below it, within one picture."""

    view: View

    @property
    def band(self) -> float:
        """Pixels below the room."""
        return BAND if len(self.view.spec.characters) > 1 else 0.0

    @property
    def width(self) -> float:
        """In pixels."""
        return max(self.view.width, LEAST) if self.band else self.view.width

    @property
    def left(self) -> float:
        """Of the picture: rooms that are narrower stand in its middle."""
        return -self.view.margin - (self.width - self.view.width) / 2

    @property
    def height(self) -> float:
        """In pixels."""
        return self.view.height + self.band

    @property
    def box(self) -> str:
        """The `viewBox`."""
        return f"{self.left:.2f} {-self.view.margin:g} {self.width:.2f} {self.height:.2f}"

    def still(self, performances: Sequence[Performance]) -> str:
        """All that does not move; names keep clear of all ways."""
        view = self.view
        room = room_svg(view) + names_svg(view, place_names(view), performances)
        if not self.band:
            return room
        low, m = view.height - view.margin, view.margin
        ground = rect_svg(
            self.left - 1, -m - 1, self.width + 2, self.height + 2, mix(FRAME, CREAM, 0.78)
        )
        return ground + room + key_svg(view.spec, self.left + m, low + 1, self.width - 2 * m)


def stage_within(spec: PlaneSpec, width: float, height: float) -> Stage:
    """The largest stage that is not larger than so many pixels."""
    band = BAND if len(spec.characters) > 1 else 0.0
    return Stage(view_within(spec, width, height - band))
