"""Candidates of one story on a map side by side: a row of key frames for each, and one page that
plays them together."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from i2pdsl.render.files import PictureFiles, printable
from i2pdsl.render.film_page import Film, film_page
from i2pdsl.render.grid.comic import comic_svg
from i2pdsl.render.grid.page import CELL, SCRIPT, film_data, poses_of, stage_svg
from i2pdsl.render.grid.pictures import GridPictures
from i2pdsl.render.grid.scene import scene_size, stage_symbols
from i2pdsl.render.lettering import heading_svg
from i2pdsl.render.markup import plain
from i2pdsl.render.mind import Panel, Window
from i2pdsl.render.panels import GUTTER, TITLE
from i2pdsl.render.performances import compared
from i2pdsl.scripts import Script

SHOWN = 6  # key frames of each candidate
ACROSS = 3  # stages in a row of the page
_SIZE = re.compile(r'<svg [^>]*?width="([\d.]+)" height="([\d.]+)"')


@dataclass(frozen=True)
class Told:
    """A candidate as curves are compared (performances.Performed)."""

    title: str
    frames: int
    panels: Sequence[Panel]
    leading: Panel | None
    windows: Sequence[Window] = ()


class GridSheet(PictureFiles):
    """Draws several scripts of one map."""

    offered = ("png", "svg", "html")
    names = ("sheet", "sheet", "sheet")

    def __init__(self, scripts: Sequence[Script], title: str):
        self.each = [GridPictures(script) for script in scripts]
        self.title = printable(title)

    @property
    def panels(self) -> tuple[Panel, ...]:
        """The curves that they have in common, compared; first what the story is about."""
        told = []
        for number, each in enumerate(self.each, 1):
            leading = each.focus.leading
            first = [p for p in each.panels if leading is not None and p.title == leading.title]
            panels = first + [p for p in each.panels if p not in first]
            told.append(Told(f"candidate {number}", each.script.length, panels, leading))
        return compared(told)

    def comic(self) -> str:
        rows = []
        for number, each in enumerate(self.each):
            frames = each.key_frames(SHOWN)
            last = number == len(self.each) - 1
            rows.append(
                comic_svg(
                    each.stage,
                    each.document,
                    frames,
                    each.captions(frames),
                    each.title,
                    SHOWN,
                    explained=last,
                )
            )
        return stacked(rows, self.title)

    def save_mind(self, path: Path, title: str) -> Path | None:
        from i2pdsl.render.mind import PANELS_MAX, save_mind

        return save_mind(path, self.panels[:PANELS_MAX], title)

    def page(self) -> str:
        """A self-contained page."""
        lasting = max((each.script.length for each in self.each), default=0)
        stage = self.each[0].stage
        width, height = scene_size(stage, CELL)
        across = min(len(self.each), ACROSS)
        shows = "\n".join(self._show(number) for number in range(len(self.each)))
        captions = [self._caption(t) for t in range(lasting + 1)]
        seconds, rests = self._clock(lasting)
        shown = Film(
            stage=f'      <div class="shows">\n{shows}\n      </div>',
            aspect=across * width / height,
            last=lasting,
            seconds=seconds,
            rests=rests,
            captions=captions,
            happenings=range(lasting + 1),
            script=SCRIPT,
            data={"shows": [film_data(each.stage, each.film) for each in self.each]},
            classes="theatre wide",
        )
        about = (
            f"{stage.name} · {lasting} frame{'s' * (lasting != 1)} · {len(self.each)} candidates"
        )
        return film_page(shown, self.panels, self.title, about, self.each[0].script.record.text)

    def _clock(self, lasting: int) -> np.ndarray:
        """[2, T] Seconds that each frame lasts, and that its end is held: as long as any of the
        candidates needs."""
        clocks = [
            np.pad(each.clock, ((0, 0), (0, lasting - each.script.length))) for each in self.each
        ]
        longest: np.ndarray = np.max(clocks, axis=0)
        return longest

    def _show(self, number: int) -> str:
        each = self.each[number]
        symbols = stage_symbols(each.stage, self._poses()) if number == 0 else ""
        drawn = stage_svg(each.stage, each.film, each.title, f"-{number}", symbols)
        return f'<div class="show"><p class="label">{plain(each.title)}</p>\n{drawn}</div>'

    def _poses(self) -> dict[str, tuple[str, ...]]:
        """The poses that each actor takes in any of the films."""
        found: dict[str, set[str]] = {}
        for each in self.each:
            for name, poses in poses_of(each.film).items():
                found.setdefault(name, set()).update(poses)
        return {name: tuple(sorted(poses)) for name, poses in found.items()}

    def _caption(self, t: int) -> str:
        """What is believed after a frame of each."""
        return "; ".join(
            f"{number}: {each.captions([min(t, each.script.length)])[0]}"
            for number, each in enumerate(self.each, 1)
        )


def stacked(drawings: Sequence[str], title: str) -> str:
    """SVG documents below each other, under a title, as one."""
    sizes = []
    for drawing in drawings:
        found = _SIZE.match(drawing)
        assert found is not None  # our own
        sizes.append((float(found[1]), float(found[2])))
    top = GUTTER + 1.6 * TITLE
    width, y, parts = max(w for w, _ in sizes), top, []
    for drawing, (_, high) in zip(drawings, sizes, strict=True):
        parts.append(drawing.replace("<svg ", f'<svg y="{y:g}" ', 1))
        y += high
    heading = heading_svg(GUTTER, GUTTER + TITLE, title, 1.2 * TITLE, width - 2 * GUTTER)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}" height="{y:g}" '
        f'viewBox="0 0 {width:g} {y:g}"><rect width="100%" height="100%" fill="#fff"/>'
        f"{heading}{''.join(parts)}</svg>"
    )
