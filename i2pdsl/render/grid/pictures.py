"""All pictures of a finished script in a grid world: which there are, what they show."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from i2pdsl.render.beliefs import Beliefs
from i2pdsl.render.files import KEY_FRAMES, PictureFiles, Sprites, printable
from i2pdsl.render.focus import Focus, focus_of, led, whose
from i2pdsl.render.grid.stage import TURNING, Actor, Beat, Stage, Tile, describe, followed, on_map
from i2pdsl.render.key_frames import EDGE, PLACE, TURN, key_frames, minds
from i2pdsl.render.mind import Mark, Panel
from i2pdsl.scripts import Script
from i2pdsl.worlds.drawings import is_own
from i2pdsl.worlds.grid.spec import NO_GOAL, GridSpec

if TYPE_CHECKING:
    from i2pdsl.render.film_page import Film
    from i2pdsl.render.strip import Meter

# For characters that the palette does not name; dashes and labels tell them apart too.
_CAST_COLORS = ("#d98b4a", "#7fae6b", "#b48ad1", "#d9718e", "#c9b04f", "#5fb3b0")

TELLING = ("push", "pull", *TURNING)  # what captions tell
GLIMPSES = {
    "push": 0.15,
    "pull": 0.15,
    "fail": 0.03,
    "bump": 0.03,
}  # what is worth seeing, and how much
CONTACT = 2.5  # how much the first time matters that one character pushes the other


def stage_of(spec: GridSpec) -> Stage:
    """A world as the drawing sees it."""
    look, own = spec.look, dict(spec.look.drawings)
    # Own drawings of tiles and walls that a script lacks: they are rugs and blocks.
    shown = lambda sprite: "" if is_own(sprite) and sprite not in own else sprite
    tiles = tuple(
        Tile(t.name, cell, t.color, shown(t.sprite), own.get(t.sprite, ""), t.one_way)
        for t in spec.tiles
        for cell in t.cells
    )
    kinds = (("character", spec.characters), ("object", spec.things))
    cast = [
        Actor(c.name, c.sprite, c.color, kind, own.get(c.sprite, ""))
        for kind, group in kinds
        for c in group
    ]
    # Each kind of thing has its colour, and all of a kind are drawn like it.
    names = {t.name: t.names for t in spec.things}
    told = [
        replace(actor, name=name)
        for actor in _told_apart(cast)
        for name in names.get(actor.name, (actor.name,))
    ]
    walls = shown(look.wall_sprite), own.get(look.wall_sprite, "")
    surface = spec.floor, spec.wall, look.frame, look.ground
    return Stage(
        spec.name,
        spec.rows,
        tiles,
        tuple(told),
        *surface,
        *walls,
        fences=spec.walls,
        together=spec.together,
        pulls=any(c.pulls for c in spec.characters),
        alike=tuple(t.names for t in spec.things if t.count > 1),
    )


def beliefs_of(spec: GridSpec) -> Beliefs:
    """Words and curves of what viewers believe of its cast."""
    return Beliefs(spec, {NO_GOAL: "wants nothing"})


def _told_apart(cast: Sequence[Actor]) -> tuple[Actor, ...]:
    """The cast in colours that tell those of one drawing apart, where the world leaves it open."""
    found: list[Actor] = []
    for actor in cast:
        taken = {(other.sprite, other.color) for other in found}
        free = [c for c in (actor.color, *_CAST_COLORS) if (actor.sprite, c) not in taken]
        found.append(replace(actor, color=free[0] if free else actor.color))
    return tuple(found)


class GridPictures(PictureFiles):
    """Draws one script of a grid world; what several pictures share is computed once."""

    can_be_transparent = True

    def __init__(self, script: Script, title: str | None = None):
        self.told = script.length  # later frames are those that the story appends
        self.script = script = script.shown()
        self.stage = stage_of(script.world.spec)
        self.beliefs = beliefs_of(script.world.spec)
        self.document = dict(followed(self.stage, script.record.as_json()))
        name = title or (script.record.title or script.world.name)
        self.title = printable(name)

    @cached_property
    def film(self) -> Any:
        """The choreography."""
        from i2pdsl.render.grid.choreography import choreograph

        return choreograph(self.stage, self.document)

    @cached_property
    def usual(self) -> tuple[Panel, ...]:
        """The audience's mind over time: goals, alignment, rationality, values."""
        return self.beliefs.panels(self.script)

    @cached_property
    def focus(self) -> Focus:
        """What the story is about."""
        return focus_of(self.script, self.usual, self.beliefs.sentence)

    @cached_property
    def panels(self) -> tuple[Panel, ...]:
        """The usual curves, and first what the story is about, where that is none of them."""
        return led(self.focus.leading, self.usual)

    @property
    def marks(self) -> tuple[Mark, ...]:
        """The frames in which an event happened."""
        found = []
        for t, frame in enumerate(self.document["frames"], 1):
            event = frame.get("event")
            if event:
                thing = next(v for k, v in event.items() if k != "to")
                found.append(Mark(t, f"the {thing} falls"))
        return tuple(found)

    def captions(self, frames: list[int]) -> list[str]:
        """For each frame what happens in it that is out of the ordinary, and what viewers think
        of what the story is about."""
        lines = []
        for since, t in zip([None, *frames], frames, strict=False):
            seen = [describe(b) for b in self.film.beats if b.frame == t and b.verb in TELLING]
            parts = [*(["and then"] if t > self.told else []), *([", ".join(seen)] if seen else [])]
            lines.append(": ".join([*parts, self.focus.caption(t, since)]))
        return lines

    def key_frames(self, count: int) -> list[int]:
        """The frames that a comic shows: where what is asked turns, what falls, who meets whom."""
        moments = {t: TURN * weight for t, weight in self.focus.turns.items()}
        glimpses: dict[int, float] = {}
        names, met = {c.name for c in self.stage.characters}, False
        last: dict[str, Beat] = {}  # of each actor
        for beat in self.film.beats:
            t, before = beat.frame, last.get(beat.actor)
            last[beat.actor] = beat
            if beat.verb in TURNING:
                moments[t] = EDGE
            elif not met and any(shove.name in names for shove in beat.pushed):
                met = True
                moments[t] = max(moments.get(t, 0.0), CONTACT)
            # Who goes on with what it did is not looked at again.
            if before is None or (before.verb, before.direction) != (beat.verb, beat.direction):
                glimpses[t] = max(glimpses.get(t, 0.0), GLIMPSES.get(beat.verb, 0.0))
        beliefs = minds(self.focus.leading, self.panels)
        return key_frames([self._places()], beliefs, self.script.length, count, moments, glimpses)

    def _places(self) -> np.ndarray:
        """[T + 1, n, 2] Where everybody is, in units of what the way across the map counts."""
        states = [self.document["start"], *(f["state"] for f in self.document["frames"])]
        cells = [[on_map(s, a.name) or (-1, -1) for a in self.stage.cast] for s in states]
        return PLACE * np.array(cells, float) / np.hypot(self.stage.width, self.stage.height)

    def meters(self) -> list[Meter]:
        """The curves below the film: those of what the story is about."""
        leading = whose(self.focus.leading, self.usual)
        return [(s.label, s.color, s.values) for s in leading.series] if leading else []

    # Files.

    def comic(self) -> str:
        from i2pdsl.render.grid.comic import comic_svg

        frames = self.key_frames(KEY_FRAMES)
        return comic_svg(self.stage, self.document, frames, self.captions(frames), self.title)

    def save_mind(self, path: Path, title: str) -> Path | None:
        from i2pdsl.render.mind import PANELS_MAX, save_mind

        return save_mind(path, self.panels[:PANELS_MAX], title, marks=self.marks)

    @property
    def clock(self) -> tuple[np.ndarray, np.ndarray]:
        """How long each frame lasts and how long its end is held, [T] seconds each."""
        from i2pdsl.render.grid.film import lengths

        return lengths(self.film, twists=self.focus.turns, pace=self.look.pace)

    def page(self) -> str:
        from i2pdsl.render.grid.page import page_html

        return page_html(
            self.stage,
            self.document,
            self.film,
            self.panels,
            self.title,
            self.script.record.text,
            marks=self.marks,
            wishes=self.wishes,
            account=self.account,
            clock=self.clock,
            note=self.note,
        )

    def moving(self) -> Film:
        from i2pdsl.render.grid.page import frame_captions, moving

        told = frame_captions(self.stage, self.document, self.film)
        return moving(self.stage, self.film, self.title, told, self.clock)

    def sprites(self) -> Sprites:
        from i2pdsl.render.grid.export import background, sheet

        return sheet(self.stage), background(self.stage)

    def timeline(self) -> dict[str, Any]:
        from i2pdsl.render.grid.export import timeline

        return timeline(self.stage, self.document, self.film, self.panels, self.title, *self.clock)

    def save_film(self, path: Path, progress: Callable[[int, int], None] | None) -> None:
        from i2pdsl.render.grid.film import save_film

        save_film(
            path,
            self.stage,
            self.film,
            title=self.title,
            meters=self.meters(),
            look=self.look,
            twists=self.focus.turns,
            progress=progress,
        )
