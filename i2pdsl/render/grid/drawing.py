"""How grid worlds are drawn (render/drawing.py)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from i2pdsl.render.alone import Alone
from i2pdsl.render.characters import Ink
from i2pdsl.render.drawing import Drawing, Point, Seen, Spot, one_by_one
from i2pdsl.render.focus import Sentence
from i2pdsl.render.grid.pictures import GridPictures, beliefs_of, stage_of
from i2pdsl.render.grid.stage import break_down, describe
from i2pdsl.scripts import Script
from i2pdsl.worlds.grid.spec import GridSpec
from i2pdsl.worlds.grid.world import GridWorld

if TYPE_CHECKING:
    from i2pdsl.render.grid.sheet import GridSheet


class GridDrawing(Drawing):
    files = GridPictures

    def pictures(self, scripts: Sequence[Script], title: str | None = None) -> GridPictures:
        if len(scripts) > 1:
            raise one_by_one(scripts)
        return GridPictures(scripts[0], title)

    def sheet(self, scripts: Sequence[Script], title: str) -> GridSheet:
        from i2pdsl.render.grid.sheet import GridSheet

        return GridSheet(scripts, title)

    def page_script(self) -> str:
        from i2pdsl.render.grid.page import SCRIPT

        return SCRIPT

    def alone(self, scripts: Sequence[Script], places: int) -> list[Alone]:
        from i2pdsl.render.grid.page import alone

        found = (GridPictures(script) for script in scripts)
        return [alone(each.stage, each.document, each.film, places) for each in found]

    def in_characters(self, world: GridWorld, state: int, ink: Ink) -> str:
        from i2pdsl.render.grid.characters import map_in_characters

        return map_in_characters(world, int(state), ink)

    def sentence(self, spec: Any) -> Sentence:
        return beliefs_of(spec).sentence

    def deeds(self, script: Script) -> list[dict[str, str]]:
        found: list[dict[str, str]] = [{} for _ in range(script.length)]
        for beat in break_down(stage_of(script.world.spec), script.record.as_json()):
            found[beat.frame - 1][beat.actor] = describe(beat)
        return found

    def empty_stage(self, spec: GridSpec) -> str:
        from i2pdsl.render.grid.page import CELL
        from i2pdsl.render.grid.scene import labels_svg, stage_background, svg_document

        stage = stage_of(spec)
        drawn = stage_background(stage, CELL) + labels_svg(stage, CELL)
        return svg_document(stage, CELL, drawn)

    def units(self, spec: GridSpec) -> tuple[Point, Point]:
        from i2pdsl.render.grid.page import CELL

        return (1 / CELL, 0.0), (1 / CELL, 0.0)

    def spots(self, spec: GridSpec) -> list[Spot]:
        return [
            Spot(
                f"({column}, {row})",
                _on_page(column + 0.5, row + 0.5),
                tuple(_on_page(column + x, row + y) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))),
            )
            for column, row in spec.free_cells
        ]

    def seen(self, script: Script) -> list[Seen]:
        record = script.record
        states = [record.start, *(frame["state"] for frame in record.frames)]
        middle = lambda cell: None if cell is None else _on_page(cell[0] + 0.5, cell[1] + 0.5)
        return [Seen(name, tuple(middle(s[name]) for s in states)) for name in record.start]


def _on_page(column: float, row: float) -> Point:
    """A point of the map in the picture that pages show."""
    from i2pdsl.render.grid.page import CELL

    return column * CELL, row * CELL


DRAWING = GridDrawing()
