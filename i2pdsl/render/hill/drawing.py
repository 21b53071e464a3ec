"""How the hill is drawn (render/drawing.py)."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, sin, tan
from typing import Any

import numpy as np

from i2pdsl.language.story import TypedStory
from i2pdsl.render.alone import NAME, Alone
from i2pdsl.render.characters import Ink
from i2pdsl.render.drawing import Drawing, Point, Room, Seen, one_by_one
from i2pdsl.render.focus import Sentence
from i2pdsl.render.hill.pictures import HillPictures
from i2pdsl.render.hill.rig import SCALE
from i2pdsl.scripts import Script
from i2pdsl.worlds.hill.hopper import GROUPS, HIPS, NODE_COUNT
from i2pdsl.worlds.hill.spec import HillSpec
from i2pdsl.worlds.hill.springs import FRAME_SECONDS
from i2pdsl.worlds.hill.vocabulary import BOX, HOPPER
from i2pdsl.worlds.hill.world import HillWorld
from i2pdsl.worlds.kinds import kind_of

ROOM = 0.5  # units up and down the slope that are as good as where somebody was put


class HillDrawing(Drawing):
    files = HillPictures
    strip_tells = False

    def pictures(self, scripts: Sequence[Script], title: str | None = None) -> HillPictures:
        from i2pdsl.render.hill.told import performance_of

        if any(kind_of(s.world.spec) is not kind_of(scripts[0].world.spec) for s in scripts):
            raise one_by_one(scripts)
        alone = title if len(scripts) == 1 else None
        return HillPictures([performance_of(s, alone) for s in scripts], title)

    def page_script(self) -> str:
        from i2pdsl.render.hill.page import SCRIPT

        return SCRIPT

    def alone(self, scripts: Sequence[Script], places: int) -> list[Alone]:
        from i2pdsl.render.hill.page import alone
        from i2pdsl.render.hill.told import performance_of

        return alone([performance_of(script, NAME) for script in scripts], places)

    def in_characters(self, world: HillWorld, state: np.ndarray, ink: Ink) -> str:
        from i2pdsl.render.hill.characters import hill_in_characters

        return hill_in_characters(world, np.asarray(state, float), ink)

    def held(self, spec: HillSpec) -> tuple[str, ...]:
        return (HOPPER, BOX)

    def room(self, world: Any, story: TypedStory, frame: int, who: str) -> Room:
        """Up and down the slope."""
        slope = world.spec.settings.slope
        return Room(along=(cos(slope), -sin(slope)))

    def said_of(self, script: Script, frame: int, who: str, at: Point) -> str:
        """How far up the slope it is, to half a unit."""
        slope = script.world.spec.settings.slope
        here = next(seen.at[frame] for seen in self.seen(script) if seen.name == who)
        assert here is not None
        gone = (at[0] - here[0]) * cos(slope) - (at[1] - here[1]) * sin(slope)
        now = float(script.query(f"[climbed({who}) @ script[{frame}]]"))
        wanted = round(2 * (now + gone / SCALE)) / 2 + 0.0
        return f"{wanted - ROOM:g} <= climbed({who}) <= {wanted + ROOM:g}"

    def seen(self, script: Script) -> list[Seen]:
        """Where the middles of hopper and box are, as the camera sees them."""
        from i2pdsl.render.hill.scene import followed

        states = np.asarray(script.trajectory.states)
        positions = states[:, : 2 * NODE_COUNT].reshape(-1, 2, NODE_COUNT)
        x = followed(positions[:, 0, HIPS], FRAME_SECONDS)
        eye = np.stack([x, tan(script.world.spec.settings.slope) * x], axis=-1)  # [T + 1, 2]
        found = []
        for name, nodes in GROUPS.items():
            middle = positions[:, :, list(nodes)].mean(-1) - eye
            points = np.round(SCALE * middle * np.array([1, -1]), 2).tolist()
            found.append(Seen(name, tuple((x, y) for x, y in points)))
        return found

    def sentence(self, spec: Any) -> Sentence:
        from i2pdsl.render.hill.told import sentence

        return sentence


DRAWING = HillDrawing()
