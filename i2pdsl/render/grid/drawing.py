"""How grid worlds are drawn (render/drawing.py)."""

from __future__ import annotations

from collections.abc import Sequence

from i2pdsl.render.characters import Ink
from i2pdsl.render.drawing import Drawing, one_by_one
from i2pdsl.render.grid.pictures import GridPictures
from i2pdsl.scripts import Script
from i2pdsl.worlds.grid.world import GridWorld


class GridDrawing(Drawing):
    def pictures(self, scripts: Sequence[Script], title: str | None = None) -> GridPictures:
        if len(scripts) > 1:
            raise one_by_one(scripts)
        return GridPictures(scripts[0], title)

    def in_characters(self, world: GridWorld, state: int, ink: Ink) -> str:
        from i2pdsl.render.grid.characters import map_in_characters

        return map_in_characters(world, int(state), ink)


DRAWING = GridDrawing()
