"""How planes are drawn (render/drawing.py)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from i2pdsl.errors import error, whole_file
from i2pdsl.render.alone import NAME, Alone
from i2pdsl.render.characters import Ink
from i2pdsl.render.drawing import Drawing
from i2pdsl.render.focus import Sentence
from i2pdsl.render.plane.pictures import PlanePictures
from i2pdsl.scripts import Script
from i2pdsl.worlds.kinds import kind_of


class PlaneDrawing(Drawing):
    def pictures(self, scripts: Sequence[Script], title: str | None = None) -> PlanePictures:
        from i2pdsl.render.plane.told import performance_of

        first, *others = (s.world.spec for s in scripts)
        kind = kind_of(first)
        if not all(kind.has_same_rules(first, other) for other in others):
            message = "only scripts of one plane are drawn side by side"
            where = whole_file(scripts[1].record.where)
            raise error("pictures", message, where, "draw them one by one")
        alone = title if len(scripts) == 1 else None
        return PlanePictures([performance_of(s, alone) for s in scripts], title)

    def alone(self, scripts: Sequence[Script], places: int) -> list[Alone]:
        from i2pdsl.render.plane.page import alone
        from i2pdsl.render.plane.told import performance_of

        return alone([performance_of(script, NAME) for script in scripts], places)

    def in_characters(self, world: Any, state: np.ndarray, ink: Ink) -> str:
        from i2pdsl.render.plane.characters import plane_in_characters

        return plane_in_characters(world.spec, np.asarray(state, float), ink)

    def sentence(self, spec: Any) -> Sentence:
        from i2pdsl.render.plane.told import beliefs_of

        return beliefs_of(spec).sentence


DRAWING = PlaneDrawing()
