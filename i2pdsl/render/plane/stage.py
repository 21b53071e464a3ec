"""The stage of films and pages: a room, and below it who is who where there are several."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from i2pdsl.render.ink import mix
from i2pdsl.render.plane.figures import key_svg
from i2pdsl.render.plane.names import names_svg, place_names
from i2pdsl.render.plane.performance import Performance
from i2pdsl.render.plane.room import CREAM, FRAME, View, room_svg, view_within
from i2pdsl.worlds.plane.spec import PlaneSpec

BAND = 32.0  # pixels for who is who


@dataclass(frozen=True)
class Stage:
    """A room, and what lies below it, within one picture."""

    view: View

    @property
    def band(self) -> float:
        """Pixels below the room."""
        return BAND if len(self.view.spec.characters) > 1 else 0.0

    @property
    def height(self) -> float:
        """In pixels."""
        return self.view.height + self.band

    @property
    def box(self) -> str:
        """The `viewBox`."""
        m = self.view.margin
        return f"{-m:g} {-m:g} {self.view.width:.2f} {self.height:.2f}"

    def still(self, performances: Sequence[Performance]) -> str:
        """All that does not move; names keep clear of all ways."""
        view = self.view
        room = room_svg(view) + names_svg(view, place_names(view), performances)
        if not self.band:
            return room
        m, low = view.margin, view.height - view.margin
        ground = (
            f'<rect x="{-m - 1:.1f}" y="{low - 1:.1f}" width="{view.width + 2:.1f}" '
            f'height="{self.band + 2:.1f}" fill="{mix(FRAME, CREAM, 0.78)}"/>'
        )
        return ground + room + key_svg(view.spec, 0, low + 1, view.width - 2 * m)


def stage_within(spec: PlaneSpec, width: float, height: float) -> Stage:
    """The largest stage that is not larger than so many pixels."""
    band = BAND if len(spec.characters) > 1 else 0.0
    return Stage(view_within(spec, width, height - band))
