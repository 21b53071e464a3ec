"""The files of pictures, the same for every world: which there are, and in which order."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from i2pdsl.resources import write_text

if TYPE_CHECKING:
    import numpy as np

    from i2pdsl.objective.wishes import Wish
    from i2pdsl.render.film_page import Film
    from i2pdsl.render.mind import Mark, Panel, Window
    from i2pdsl.render.reasons import Account

FORMATS = ("png", "svg", "gif", "mp4", "html", "webm", "sheet", "timeline", "godot")
EXPORTS = ("sheet", "timeline", "godot")  # what other programs animate with
FILMS = ("gif", "mp4", "webm")
SEE_THROUGH = ("gif", "webm")  # films that can be
KEY_FRAMES = 8
COMIC_ZOOM = 1.25  # pixels of a PNG for each unit of the drawing
UNSURE = 0.1  # beliefs closer than this are a tie

Progress = Callable[[str, int, int], None]  # picture, steps done, steps in all
# Of a sprite sheet and of a background: RGBA [height, width, 4], and what is where in it.
Sprites = tuple[tuple["np.ndarray", dict[str, Any]], tuple["np.ndarray", dict[str, Any]]]


@dataclass(frozen=True)
class FilmLook:
    """How films are made.

    Attributes:
        pace: how many times faster than usual.
        meter: whether title and curves stand below.
        size: (width, height) in pixels, both even; None for the usual width.
        transparent: only who acts, on nothing.
    """

    pace: float = 1.0
    meter: bool = True
    size: tuple[int, int] | None = None
    transparent: bool = False


class PictureFiles:
    """Writes the pictures of a world's own drawing.

    Attributes:
        title: of all pictures.
        wishes: what became of those of the story, for the page.
        note: what is known of how right the film's beliefs are, for the page.
        explained: tells why viewers believe what they do, for the page, where that is one script's.
        names: of the comic, the page and the film, without suffix.
        offered: the formats that there are of this kind of world.
        look: how its films are made.
        can_be_transparent: whether its films can be.
    """

    title: str
    look: FilmLook = FilmLook()
    can_be_transparent: bool = False
    wishes: Sequence[Wish] = ()
    note: str = ""
    explained: Callable[[], Account | None] | None = None
    offered: tuple[str, ...] = FORMATS
    names: tuple[str, str, str] = ("comic", "page", "film")

    @property
    def panels(self) -> tuple[Panel, ...]:
        """The curves of belief."""
        raise NotImplementedError

    @property
    def marks(self) -> tuple[Mark, ...]:
        """The frames that are lined out in the curves."""
        return ()

    @property
    def windows(self) -> tuple[Window, ...]:
        """The stretches of time to shade in the curves."""
        return ()

    def comic(self) -> str:
        """The comic strip, as SVG."""
        raise NotImplementedError

    def save_mind(self, path: Path, title: str) -> Path | None:
        """Writes the curves of belief, if there are any."""
        raise NotImplementedError

    def page(self) -> str:
        """The page, as HTML in one piece."""
        raise NotImplementedError

    def moving(self) -> Film:
        """The film as pages play it, for those that mount its player beside others."""
        raise NotImplementedError

    @property
    def account(self) -> Account | None:
        """Why viewers believe what they do."""
        return None if self.explained is None else self.explained()

    def save_film(self, path: Path, progress: Callable[[int, int], None] | None) -> None:
        """Writes the film, as a GIF, MP4 or WebM by the suffix."""
        raise NotImplementedError

    def sprites(self) -> Sprites:
        """The cast and the room, for other programs."""
        raise NotImplementedError

    def timeline(self) -> dict[str, Any]:
        """The story as data, for other programs."""
        raise NotImplementedError

    def exported(self, folder: Path, formats: tuple[str, ...]) -> Iterator[tuple[str, Path]]:
        """Writes what other programs animate with, of the formats asked for."""
        from i2pdsl.render import export

        if {"sheet", "godot"} & {*formats} and "sheet" in self.offered:
            for path in export.save_sheet(folder, *self.sprites()):
                yield path.name, path
        if {"timeline", "godot"} & {*formats}:
            path = export.save_timeline(folder, self.timeline())
            yield path.name, path
        if "godot" in formats:
            path = export.save_player(folder)
            yield path.name, path

    def save(
        self, folder: Path, formats: tuple[str, ...], progress: Progress | None = None
    ) -> dict[str, Path]:
        """Writes the pictures of the formats asked for that there are; returns name -> path."""
        return dict(self.drawn(folder, formats, progress))

    def drawn(
        self, folder: Path, formats: tuple[str, ...], progress: Progress | None = None
    ) -> Iterator[tuple[str, Path]]:
        """As `save`, one file after the other, those that take longest last.

        Raises FilmError for films that cannot be written, when everything else is.
        """
        from i2pdsl.render.video import FilmError

        comic, page, film = self.names
        formats = tuple(each for each in formats if each in self.offered)
        if "png" in formats or "svg" in formats:
            yield from self._still(folder, formats, comic)
        if "html" in formats:
            path = folder / f"{page}.html"
            write_text(path, self.page())
            yield "html", path
        yield from self.exported(folder, formats)
        failed: list[FilmError] = []
        for kind in FILMS:
            if kind in formats:
                path = folder / f"{film}.{kind}"
                report = None
                if progress is not None:
                    report = lambda done, total, name=path.name: progress(name, done, total)
                try:
                    self.save_film(path, report)
                except FilmError as problem:
                    failed.append(problem)
                else:
                    yield kind, path
        if failed:
            raise FilmError([name for f in failed for name in f.films], failed[0].reason)

    def _still(
        self, folder: Path, formats: tuple[str, ...], name: str
    ) -> Iterator[tuple[str, Path]]:
        from i2pdsl.render.raster import save_png, save_svg

        drawing = self.comic()
        for kind in ("png", "svg"):
            if kind in formats:
                path = folder / f"{name}.{kind}"
                if kind == "png":
                    save_png(path, drawing, COMIC_ZOOM)
                else:
                    save_svg(path, drawing)
                yield path.name, path
                curves = self.save_mind(
                    folder / f"mind.{kind}", f"What viewers believe: {self.title}"
                )
                if curves is not None:
                    yield curves.name, curves


def percent(p: float) -> str:
    """A probability for people: 0.997 as 99.7 %, but never 100 % where it is not certain."""
    if p >= 0.995:
        return "> 99 %"
    return f"{100 * p:.0f} %"


def printable(name: str) -> str:
    """A name with only what an SVG can hold."""
    return "".join(c if c.isprintable() else " " for c in name)
