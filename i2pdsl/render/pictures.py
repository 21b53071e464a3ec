"""All pictures of a finished script: which there are, what they show, where they go."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from i2pdsl.errors import error, whole_file
from i2pdsl.render.mind import PALETTE, Mark, Panel, Series
from i2pdsl.render.stage import Actor, Stage, Tile
from i2pdsl.scripts import Script
from i2pdsl.worlds.grid.spec import GridSpec
from i2pdsl.worlds.hill.world import HillWorld
from i2pdsl.worlds.hypotheses import ATTITUDE, goal_of, rationality_of

if TYPE_CHECKING:
    from i2pdsl.render.hill.pictures import HillPictures

FORMATS = ("png", "svg", "gif", "mp4", "html")
KEY_FRAMES = 8
UNSURE = 0.1  # beliefs closer than this are a tie
# For values and characters that the palette does not name; dashes and labels tell them apart too.
_MORE_COLORS = ("#0068b0", "#c65102", "#00664a", "#8a3ffc", "#8c7a3a", "#d9468f")

Progress = Callable[[str, int, int], None]  # picture, steps done, steps in all


def stage_of(spec: GridSpec) -> Stage:
    """A world as the drawing sees it."""
    tiles = tuple(Tile(t.name, cell, t.color) for t in spec.tiles for cell in t.cells)
    cast = [Actor(c.name, c.sprite, c.color, "character") for c in spec.characters]
    cast += [Actor(t.name, t.sprite, t.color, "object") for t in spec.things]
    return Stage(spec.name, spec.rows, tiles, tuple(cast), spec.floor, spec.wall)


def pictures_of(scripts: Sequence[Script], title: str | None = None) -> Pictures | HillPictures:
    """What draws a script, or several scripts of the hill side by side.

    Raises StoryError for several scripts of other worlds.
    """
    if all(isinstance(s.world, HillWorld) for s in scripts):
        from i2pdsl.render.hill.pictures import HillPictures
        from i2pdsl.render.hill.told import performance_of

        alone = title if len(scripts) == 1 else None
        return HillPictures([performance_of(s, alone) for s in scripts], title)
    if len(scripts) > 1:
        message = "only scripts of the hill are drawn side by side"
        raise error(
            "pictures", message, whole_file(scripts[1].record.where), "draw them one by one"
        )
    return Pictures(scripts[0], title)


class Pictures:
    """Draws one script of a grid world; what several pictures share is computed once."""

    def __init__(self, script: Script, title: str | None = None):
        self.told = script.length  # later frames are those that the story appends
        self.script = script = script.shown()
        self.stage = stage_of(script.world.spec)
        self.document: dict[str, Any] = script.record.as_json()
        name = title or str(script.record.story.get("name") or script.world.name)
        self.title = "".join(c if c.isprintable() else " " for c in name)  # all that an SVG holds

    @cached_property
    def film(self) -> Any:
        """The choreography."""
        from i2pdsl.render.choreography import choreograph

        return choreograph(self.stage, self.document)

    @cached_property
    def panels(self) -> tuple[Panel, ...]:
        """The audience's mind over time: goals, alignment, rationality, values."""
        spec, ask = self.script.world.spec, self.script.query
        found = []
        for c in spec.characters:
            if len(c.goals) > 1:
                goal = goal_of(c.name)
                beliefs = ask(f"P({goal} | script[:t])")
                series = _series(zip(c.goals, beliefs.T, strict=True))
                found.append(Panel(f"{c.name}'s goal", "probability", series))
        if spec.social:
            kinds = {"hindering": "< 0", "indifferent": "= 0", "helping": "> 0"}
            possible = {
                "hindering": min(spec.social.attitude) < 0,
                "indifferent": 0 in spec.social.attitude,
                "helping": max(spec.social.attitude) > 0,
            }
            curves = [
                (name, ask(f"P({ATTITUDE} {test} | script[:t])"))
                for name, test in kinds.items()
                if possible[name]
            ]
            found.append(Panel(f"{spec.social.name}'s alignment", "probability", _series(curves)))
        names = [c.name for c in spec.characters]
        rational = [
            (n, ask(f"P({rationality_of(n)} | script[:t])", assume="nothing")) for n in names
        ]
        found.append(Panel("rationality", "probability", _series(rational)))
        hypotheses = self.script.world.vocabulary.hypotheses
        assumed = [
            row for row, holds in zip(hypotheses, self.script.assumption, strict=True) if holds
        ]
        # Who is irrational by the story's assumption has no value.
        minded = [n for n in names if any(row[rationality_of(n)] for row in assumed)]
        values = [(n, ask(f"E[V({n}) | script[:t]]")) for n in minded]
        if values:
            found.append(Panel("expected value", "value", _series(values), "value"))
        return tuple(found)

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
        """For each frame what viewers believe most, of the alignment or else of the goals."""
        panels = [p for p in self.panels if "alignment" in p.title] or [
            p for p in self.panels if p.kind == "probability" and p.title != "rationality"
        ]
        lines = []
        for t in frames:
            line = ", ".join(_belief(panel, t) for panel in panels[:2])
            lines.append(f"and then: {line}" if t > self.told else line)
        return lines

    def beliefs(self) -> np.ndarray:
        """All probability curves side by side: [T + 1, n]."""
        curves = [s.values for p in self.panels if p.kind == "probability" for s in p.series]
        return np.stack(curves, axis=1)

    def meters(self) -> list[tuple[str, str, Any]]:
        """The curves below the film: the alignment's if there is one, else the first goal's."""
        chosen = [p for p in self.panels if "alignment" in p.title] or list(self.panels[:1])
        return [(s.label, s.color, s.values) for s in chosen[0].series]

    # Files.

    def save(
        self, folder: Path, formats: tuple[str, ...], progress: Progress | None = None
    ) -> dict[str, Path]:
        """Writes the pictures of the formats asked for; returns name -> path."""
        return dict(self.drawn(folder, formats, progress))

    def drawn(
        self, folder: Path, formats: tuple[str, ...], progress: Progress | None = None
    ) -> Iterator[tuple[str, Path]]:
        """As `save`, one file after the other, those that take longest last."""
        if "png" in formats or "svg" in formats:
            yield from self._still(folder, formats)
        if "html" in formats:
            from i2pdsl.render.page import save_page

            page = save_page(
                folder / "page.html",
                self.stage,
                self.document,
                self.film,
                self.panels,
                self.title,
                str(self.script.record.story.get("source") or ""),
                marks=self.marks,
            )
            yield "html", page
        for kind in ("gif", "mp4"):
            if kind in formats:
                yield kind, self._film(folder / f"film.{kind}", progress)

    def _still(self, folder: Path, formats: tuple[str, ...]) -> Iterator[tuple[str, Path]]:
        from i2pdsl.render.comic import comic_svg, key_frames
        from i2pdsl.render.mind import save_mind
        from i2pdsl.render.raster import save_png, save_svg

        frames = key_frames(self.document, self.beliefs(), KEY_FRAMES)
        comic = comic_svg(self.stage, self.document, frames, self.captions(frames), self.title)
        title = f"What viewers believe: {self.title}"
        for kind in ("png", "svg"):
            if kind in formats:
                path = folder / f"comic.{kind}"
                if kind == "png":
                    save_png(path, comic, zoom=1.25)
                else:
                    save_svg(path, comic)
                yield path.name, path
                path = folder / f"mind.{kind}"
                yield path.name, save_mind(path, self.panels, title, marks=self.marks)

    def _film(self, path: Path, progress: Progress | None) -> Path:
        from i2pdsl.render.film import save_gif, save_mp4

        save = save_gif if path.suffix == ".gif" else save_mp4
        report = None
        if progress is not None:
            report = lambda done, total: progress(path.name, done, total)
        save(path, self.stage, self.film, title=self.title, meters=self.meters(), progress=report)
        return path


def _series(curves: Any) -> tuple[Series, ...]:
    found = []
    for number, (label, values) in enumerate(curves):
        color = PALETTE.get(label, _MORE_COLORS[number % len(_MORE_COLORS)])
        found.append(Series(str(label), np.asarray(values), color))
    return tuple(found)


def _belief(panel: Panel, t: int) -> str:
    """What viewers believe of one thing after frame t, or that they cannot tell."""
    first, *others = sorted(panel.series, key=lambda s: -s.values[t])
    who, _, what = panel.title.partition("'s ")
    if others and first.values[t] - others[0].values[t] < UNSURE:
        return f"{who}: hard to tell"
    verb = "wants" if what == "goal" else "is"
    return f"{who} {verb} {first.label} ({_percent(first.values[t])})"


def _percent(p: float) -> str:
    """A probability for people: 0.997 as 99.7 %, but never 100 % where it is not certain."""
    if p >= 0.995:
        return "> 99 %"
    return f"{100 * p:.0f} %"
