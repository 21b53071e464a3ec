"""Performances of moving bodies, one or several side by side in the same time: what their films
and files have in common, whatever moves."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, Generic, Protocol, TypeVar

import numpy as np

from i2pdsl.render.files import EXPORTS, PictureFiles, printable
from i2pdsl.render.mind import PALETTE, PANELS_MAX, Panel, Series, Window
from i2pdsl.render.video import Progress, Times, padded, shown_times, write_film

if TYPE_CHECKING:
    from i2pdsl.render.strip import Meter

# Of performances side by side; labels tell them apart too.
HUES = (PALETTE["cheese"], PALETTE["helping"], PALETTE["pink"], PALETTE["green"])
GAP = 6  # pixels between performances side by side


class Performed(Protocol):
    """What is asked of a performance, whatever moves."""

    @property
    def title(self) -> str: ...

    @property
    def frames(self) -> int:
        """T, the number of the last frame."""

    @property
    def panels(self) -> Sequence[Panel]: ...

    @property
    def leading(self) -> Panel | None:
        """The curves below the film."""

    @property
    def windows(self) -> Sequence[Window]: ...


class Painting(Protocol):
    """A part of a film's picture, repainted for each moment."""

    picture: np.ndarray

    @property
    def height(self) -> int: ...

    def paint(self, time: float) -> None: ...


def windows_of(performances: Sequence[Performed]) -> tuple[Window, ...]:
    """The stretches of time to shade: all there are, each once."""
    return tuple(dict.fromkeys(w for p in performances for w in p.windows))


def meters(performances: Sequence[Performed]) -> list[Meter]:
    """The curves below a film: the leading panel of one performance, or, of several, the first
    series of each one's, held after its end."""
    if len(performances) == 1:
        leading = performances[0].leading
        return [(s.label, s.color, s.values) for s in leading.series] if leading else []
    last = max(p.frames for p in performances)
    found: list[Meter] = []
    for number, p in enumerate(performances):
        if p.leading:
            first = p.leading.series[0]
            values = np.pad(first.values, (0, last - p.frames), mode="edge")
            found.append((f"{p.title}: {first.label}", HUES[number % len(HUES)], values))
    return found


def spread(count: int, width: int) -> tuple[int, int]:
    """How many performances stand side by side in a picture of that width, and how wide each is."""
    columns = count if count <= 3 else 2 if count == 4 else 3
    return columns, (width - GAP * (columns - 1)) // columns


def side_by_side(
    painters: Sequence[Painting],
    below: Sequence[Painting],
    width: int,
    times: Sequence[float] | np.ndarray,
) -> Iterator[np.ndarray]:
    """The pictures of a film, uint8 [height, width, 3], sizes even: painters in rows, and what
    stands below them. The array is reused."""
    columns, each = spread(len(painters), width)
    rows = -(-len(painters) // columns)
    stage = rows * painters[0].height + GAP * (rows - 1)
    height = -(-(stage + sum(part.height for part in below)) // 2) * 2
    canvas = np.full((height, width, 3), 255, dtype=np.uint8)
    painted: float | None = None
    for time in times:
        if time == painted:  # both ends of a film are held a while
            yield canvas
            continue
        painted = time
        for number, painter in enumerate(painters):
            painter.paint(float(time))
            row, column = divmod(number, columns)
            x, y = column * (each + GAP), row * (painter.height + GAP)
            canvas[y : y + painter.height, x : x + each] = painter.picture
        top = stage
        for part in below:
            part.paint(float(time))
            canvas[top : top + part.height, : part.picture.shape[1]] = part.picture
            top += part.height
        yield canvas


P = TypeVar("P", bound=Performed)


class PerformancePictures(PictureFiles, ABC, Generic[P]):
    """Draws one performance, or several side by side in the same time.

    Attributes:
        usual: of a film by its suffix, pictures a second, and how wide it is: of one, of several.
    """

    usual: ClassVar[dict[str, tuple[float, tuple[int, int]]]] = {
        ".mp4": (25, (800, 1280)),
        ".webm": (25, (800, 1280)),
        ".gif": (20, (640, 960)),
    }

    def __init__(self, performances: Sequence[P], title: str | None = None):
        if not performances:
            raise ValueError("there is no performance to draw")
        self.performances = tuple(performances)
        self.several = len(self.performances) > 1
        self.title = printable(title or " · ".join(p.title for p in self.performances))
        if self.several:
            self.names = ("together",) * 3
            self.offered = tuple(each for each in self.offered if each not in EXPORTS)

    def compared(self) -> tuple[Panel, ...]:
        """The curves that the performances have in common, side by side."""
        return compared(self.performances)

    @property
    @abstractmethod
    def seconds(self) -> float:
        """How long a frame is shown."""

    @abstractmethod
    def film_frames(self, times: Times, width: int) -> Iterator[np.ndarray]:
        """The film's pictures at some times, in frames (`side_by_side`)."""

    @property
    def clock(self) -> tuple[np.ndarray, np.ndarray]:
        """How long each frame lasts and how long its end is held, [T] seconds each."""
        last = max(p.frames for p in self.performances)
        return np.full(last, self.seconds / self.look.pace), np.zeros(last)

    @cached_property
    def panels(self) -> tuple[Panel, ...]:
        """The curves: a performance's own, or those that several have in common, compared."""
        return self.compared() if self.several else tuple(self.performances[0].panels)

    @property
    def windows(self) -> tuple[Window, ...]:
        """The stretches of time to shade in the curves."""
        return windows_of(self.performances)

    def save_mind(self, path: Path, title: str) -> Path | None:
        from i2pdsl.render.mind import save_mind

        return save_mind(path, self.panels, title, windows=self.windows) if self.panels else None

    def save_film(
        self, path: Path, progress: Progress | None = None, width: int | None = None
    ) -> None:
        fps, widths = self.usual[path.suffix]
        pixels = width or widths[self.several]
        seconds = self.seconds / self.look.pace
        times = shown_times(max(p.frames for p in self.performances), fps, seconds)
        size = self.look.size
        if size is None:
            write_film(path, lambda at: self.film_frames(at, pixels), times, fps, progress)
            return
        pixels = self.fitting(*size)
        frames = lambda at: padded(self.film_frames(at, pixels), size)
        write_film(path, frames, times, fps, progress)

    def fitting(self, width: int, height: int) -> int:
        """How wide a film is that stands in a picture of a size."""
        pixels = width
        while pixels > 2 and (high := next(self.film_frames([0.0], pixels)).shape[0]) > height:
            pixels = min(pixels - 2, pixels * height // high) // 2 * 2
        return pixels


def compared(performances: Sequence[Performed]) -> tuple[Panel, ...]:
    """For each curve that the performances have in common a panel with one of each, those of
    shorter ones ending with them. Of two that say the same, only the first."""
    last = max(p.frames for p in performances)
    courses = [
        {(q.title, s.label): s.values for q in p.panels for s in q.series} for p in performances
    ]
    found = []
    for panel in performances[0].panels:
        for label in (s.label for s in _telling(panel)):
            curves = [course.get((panel.title, label)) for course in courses]
            known = [curve for curve in curves if curve is not None]
            if len(known) == len(courses):
                title = f"{panel.title}: {label}" if len(panel.series) > 1 else panel.title
                found.append(
                    Panel(title, panel.ylabel, hued(performances, known, last), panel.kind)
                )
    return tuple(found[:PANELS_MAX])


def hued(
    performances: Sequence[Performed], curves: Sequence[np.ndarray], last: int
) -> tuple[Series, ...]:
    """A curve of each performance in its colour; those of shorter ones end with them."""
    return tuple(
        Series(
            p.title,
            np.pad(curve, (0, last - p.frames), constant_values=np.nan),
            HUES[number % len(HUES)],
        )
        for number, (p, curve) in enumerate(zip(performances, curves, strict=True))
    )


def _telling(panel: Panel) -> tuple[Series, ...]:
    """A panel's curves without the second of two probabilities that sum to 1."""
    total = np.sum([s.values for s in panel.series], axis=0)
    is_both = panel.kind == "probability" and len(panel.series) == 2
    return panel.series[:1] if is_both and np.allclose(total, 1) else panel.series
