"""How planes are drawn (render/drawing.py)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from i2pdsl.errors import error, whole_file
from i2pdsl.language.story import TypedStory
from i2pdsl.render.alone import NAME, Alone
from i2pdsl.render.characters import Ink
from i2pdsl.render.drawing import Drawing, Point, Room, Seen, Spot
from i2pdsl.render.focus import Sentence
from i2pdsl.render.plane.pictures import PlanePictures
from i2pdsl.scripts import Script
from i2pdsl.worlds.kinds import kind_of
from i2pdsl.worlds.plane.spec import PlaneSpec

SIDES = 24  # of a round place's outline


class PlaneDrawing(Drawing):
    files = PlanePictures

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

    def page_script(self) -> str:
        from i2pdsl.render.plane.page import SCRIPT

        return SCRIPT

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

    def empty_stage(self, spec: PlaneSpec) -> str:
        from i2pdsl.render.plane.page import page_stage
        from i2pdsl.render.plane.performance import Performance

        stage, first = page_stage(spec, 1), np.array([[c.at for c in spec.characters]])
        drawn = stage.still([Performance("", spec, first, captions=("",))])
        return f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{stage.box}">{drawn}</svg>'

    def units(self, spec: PlaneSpec) -> tuple[Point, Point]:
        from i2pdsl.render.plane.page import page_view

        scale = page_view(spec).scale
        return (1 / scale, 0.0), (-1 / scale, spec.height)

    def spots(self, spec: PlaneSpec) -> list[Spot]:
        """Its places; all other points are there, too."""
        from i2pdsl.render.plane.page import page_view

        view, found = page_view(spec), []
        turns = np.linspace(0, 2 * np.pi, SIDES, endpoint=False)
        circle = np.stack([np.cos(turns), np.sin(turns)], axis=-1)
        for place in spec.places:
            middle, *shape = _points(
                view.pixels(place.at + place.radius * np.vstack([[0, 0], circle]))
            )
            found.append(Spot(place.name, middle, tuple(shape)))
        return found

    def room(self, world: Any, story: TypedStory, frame: int, who: str) -> Room:
        from i2pdsl.render.plane.hands import reached

        return Room(tuple(reached(world, story, frame, self.held(world.spec).index(who))))

    def said_of(self, script: Script, frame: int, who: str, at: Point) -> str:
        from i2pdsl.render.plane.hands import nearest
        from i2pdsl.render.plane.page import page_view

        spec = script.world.spec
        view = page_view(spec)
        point = np.array([at[0] / view.scale, spec.height - at[1] / view.scale])
        free = nearest(spec, self.held(spec).index(who), point)
        if free is None:
            where = whole_file(script.record.where)
            raise error("pin", f"`{who}` has no room there", where)
        return f"at({who}, ({free[0]:g}, {free[1]:g}))"

    def seen(self, script: Script) -> list[Seen]:
        from i2pdsl.render.plane.page import page_view

        spec = script.world.spec
        count = 2 * len(spec.characters)
        states = np.asarray(script.trajectory.states)[:, :count].reshape(-1, count // 2, 2)
        ways = page_view(spec).pixels(states)
        return [Seen(c.name, tuple(_points(ways[:, k]))) for k, c in enumerate(spec.characters)]


def _points(array: np.ndarray) -> list[Point]:
    return [(round(float(x), 2), round(float(y), 2)) for x, y in array]


DRAWING = PlaneDrawing()
