"""How the hill is drawn (render/drawing.py)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from i2pdsl.render.alone import NAME, Alone
from i2pdsl.render.characters import Ink
from i2pdsl.render.drawing import Drawing, one_by_one
from i2pdsl.render.focus import Sentence
from i2pdsl.render.hill.pictures import HillPictures
from i2pdsl.scripts import Script
from i2pdsl.worlds.hill.world import HillWorld


class HillDrawing(Drawing):
    files = HillPictures
    strip_tells = False

    def pictures(self, scripts: Sequence[Script], title: str | None = None) -> HillPictures:
        from i2pdsl.render.hill.told import performance_of

        if any(s.world.spec.kind != scripts[0].world.spec.kind for s in scripts):
            raise one_by_one(scripts)
        alone = title if len(scripts) == 1 else None
        return HillPictures([performance_of(s, alone) for s in scripts], title)

    def alone(self, scripts: Sequence[Script], places: int) -> list[Alone]:
        from i2pdsl.render.hill.page import alone
        from i2pdsl.render.hill.told import performance_of

        return alone([performance_of(script, NAME) for script in scripts], places)

    def in_characters(self, world: HillWorld, state: np.ndarray, ink: Ink) -> str:
        from i2pdsl.render.hill.characters import hill_in_characters

        return hill_in_characters(world, np.asarray(state, float), ink)

    def sentence(self, spec: Any) -> Sentence:
        from i2pdsl.render.hill.told import sentence

        return sentence


DRAWING = HillDrawing()
