"""How listed worlds are drawn, unless their kind draws them otherwise: a picture of the cells for
each frame, and the curves of belief."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

import numpy as np

from i2pdsl.render.beliefs import COLORS, most_believed, series_of
from i2pdsl.render.characters import Ink
from i2pdsl.render.drawing import Drawing, one_by_one
from i2pdsl.render.files import PictureFiles, printable
from i2pdsl.render.focus import focus_of, led
from i2pdsl.render.lettering import fitted, text_svg
from i2pdsl.render.mind import PANELS_MAX, Panel, Series, save_mind
from i2pdsl.scripts import Script
from i2pdsl.worlds.kinds import kind_of

CELL, GAP, HEAD = 40, 16, 20  # units: a cell, between pictures, and a line above one
_LINE_HIGH = 15
_WIDTH = 760  # of a strip, at most
_FLOOR, _LINE = "#f1e8d8", "#7d6b5d"
_TINTS = ("#e8c7d2", "#c4dcc8", "#c9d6ea", "#eed9b4", "#d9cdea", "#bfe0dd")  # of places


class ListedPictures(PictureFiles):
    """Draws one script of a listed world."""

    offered = ("png", "svg")

    def __init__(self, script: Script, drawing: ListedDrawing, title: str | None = None):
        self.script = script = script.shown()
        self.drawing = drawing
        self.title = printable(title or script.record.title or script.world.name)

    @cached_property
    def panels(self) -> tuple[Panel, ...]:
        """What viewers believe of each latent; first what the story asks, if that is none."""
        words, told = self.script.world.vocabulary, []
        for name in words.apart:
            if name not in words.rational.values():
                title = words.latents[name].documentation or name
                curves = self._curves(name)
                told.append(Panel(title, "probability", curves, latent=name, question=title))
        sentence = self.drawing.sentence(self.script.world.spec)
        usual = led(focus_of(self.script, told, sentence).leading, tuple(told))
        rational = [(who, name) for who, name in words.rational.items() if name in words.apart]
        ask = lambda name: self.script.query(f"P({name} | script[:t])", assume="nothing")
        minds = series_of((who, ask(name)) for who, name in rational)
        if minds:
            usual = (*usual, Panel("rationality", "probability", minds))
        return usual[:PANELS_MAX]

    def _curves(self, name: str) -> tuple[Series, ...]:
        answer = self.script.ask(f"P({name} | script[:t])")
        if answer.labels is None:
            return series_of([("true", answer.value)])
        columns = answer.columns()
        return series_of(most_believed(list(columns), np.stack(list(columns.values()))))

    def comic(self) -> str:
        """The frames beside and below each other, each with what is done in it above."""
        drawn, wide, high = self.strip()
        return _document(drawn, wide, high)

    def strip(self) -> tuple[str, int, int]:
        """The same, and its width and height."""
        script, kind = self.script, kind_of(self.script.world.spec)
        words = script.world.vocabulary
        head = HEAD + _LINE_HIGH * (len(words.characters) - 1)
        wide, high = CELL * words.columns, CELL * words.rows + head
        across = max(1, min(script.length + 1, (_WIDTH - GAP) // (wide + GAP)))
        parts = []
        for t, state in enumerate(script.trajectory.states):
            deeds = kind.frame_in_words(script.world, script.trajectory, t) if t else "the start"
            x, y = GAP + t % across * (wide + GAP), GAP + t // across * (high + GAP)
            lines = f"{t}  {deeds}".split(", ")
            told = "".join(
                text_svg(0, 13 + _LINE_HIGH * number, fitted(line, 12, wide), 12)
                for number, line in enumerate(lines)
            )
            picture = self.drawing.picture(script.world, state)
            parts.append(
                f'<g transform="translate({x} {y})">{told}'
                f'<g transform="translate(0 {head})">{picture}</g></g>'
            )
        down = -(-(script.length + 1) // across)
        return "".join(parts), GAP + across * (wide + GAP), GAP + down * (high + GAP)

    def save_mind(self, path: Path, title: str) -> Path | None:
        return save_mind(path, self.panels, title) if self.panels else None


class ListedSheet(PictureFiles):
    """Draws the candidates of a story below each other."""

    offered = ("png", "svg")

    def __init__(self, each: Sequence[ListedPictures]):
        self.each = each

    def comic(self) -> str:
        parts, wide, high = [], 0, 0
        for one in self.each:
            drawn, width, height = one.strip()
            head = text_svg(GAP, HEAD, fitted(one.title, 14, width, bold=True), 14, True)
            parts.append(
                f'<g transform="translate(0 {high})">{head}'
                f'<g transform="translate(0 {HEAD})">{drawn}</g></g>'
            )
            wide, high = max(wide, width), high + HEAD + height
        return _document("".join(parts), wide, high)


def _document(drawn: str, wide: int, high: int) -> str:
    ground = '<rect width="100%" height="100%" fill="#fff"/>'
    size = f'width="{wide}" height="{high}"'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size}>{ground}{drawn}</svg>'


class ListedDrawing(Drawing):
    files = ListedPictures

    def figure(self, name: str, number: int, short: str) -> str:
        """Somebody or something, as SVG around (0, 0) and at most 26 units wide and high.

        Args:
            number: its place among the characters and things.
            short: so much of its name as tells it from the others.
        """
        size, middle = {1: 14, 2: 11}.get(len(short), 9), ' text-anchor="middle" style="fill:#fff"'
        label = text_svg(0, 0.36 * size, fitted(short, size, 22, True), size, True, middle)
        return f'<circle r="12" fill="{COLORS[number % len(COLORS)]}"/>{label}'

    def picture(self, world: Any, state: Any) -> str:
        """A state as SVG, CELL units for each cell."""
        words, parts = world.vocabulary, []
        tints = {
            cell: (name, _TINTS[number % len(_TINTS)])
            for number, (name, cells) in enumerate(words.places.items())
            for cell in cells
        }
        for column, row in sorted(words.free):
            name, tint = tints.get((column, row), ("", _FLOOR))
            told = f"<title>{escape(name)}</title>" if name else ""
            parts.append(
                f'<rect x="{CELL * column}" y="{CELL * row}" width="{CELL}" height="{CELL}" '
                f'fill="{tint}" stroke="{_LINE}">{told}</rect>'
            )
            label, middle = fitted(name, 9, CELL - 4), ' text-anchor="middle"'
            x, y = CELL * (column + 0.5), CELL * (row + 1) - 4
            parts.append(text_svg(x, y, label, 9, more=middle))
        where = kind_of(world.spec).start_as_json(world, state)
        places = list(where.values())
        for number, (name, (column, row)) in enumerate(where.items()):
            here = places.count([column, row])
            beside, size = places[:number].count([column, row]) - (here - 1) / 2, 1.5 / (here + 0.5)
            x, y = CELL * (column + 0.5) + 27 * size * beside, CELL * row + 15
            figure = self.figure(name, number, _short(name, where))
            parts.append(f'<g transform="translate({x:g} {y:g}) scale({size:g})">{figure}</g>')
        return "".join(parts)

    def pictures(self, scripts: Sequence[Script], title: str | None = None) -> ListedPictures:
        if len(scripts) > 1:
            raise one_by_one(scripts)
        return ListedPictures(scripts[0], self, title)

    def sheet(self, scripts: Sequence[Script], title: str) -> ListedSheet:
        return ListedSheet([ListedPictures(script, self) for script in scripts])

    def in_characters(self, world: Any, state: Any, ink: Ink) -> str:
        """The cells as dots, places by their first letters, who is there by a capital."""
        words = world.vocabulary
        signs = dict.fromkeys(words.free, ".")
        signs |= {cell: name[0].lower() for name, of in words.places.items() for cell in of}
        where = kind_of(world.spec).start_as_json(world, state)
        signs |= {(c, r): name[0].upper() for name, (c, r) in where.items()}
        return "\n".join(
            "    " + "".join(signs.get((c, r), " ") for c in range(words.columns)).rstrip()
            for r in range(words.rows)
        )


def _short(name: str, names: Iterable[str]) -> str:
    """The first letters of a name that no other begins with."""
    others = [other for other in names if other != name]
    ends = (n for n in range(1, len(name)) if not any(o.startswith(name[:n]) for o in others))
    return name[: next(ends, len(name))].capitalize()
