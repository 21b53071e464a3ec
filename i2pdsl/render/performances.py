"""Performances of moving bodies, one or several side by side in the same time: what their films
and files have in common, whatever moves."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Generic, Protocol, TypeVar

import numpy as np

from i2pdsl.render.files import PictureFiles, printable
from i2pdsl.render.mind import PALETTE, Panel, Window

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
    for time in times:
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
    """Draws one performance, or several side by side in the same time."""

    def __init__(self, performances: Sequence[P], title: str | None = None):
        if not performances:
            raise ValueError("there is no performance to draw")
        self.performances = tuple(performances)
        self.several = len(self.performances) > 1
        self.title = printable(title or " · ".join(p.title for p in self.performances))
        if self.several:
            self.names = ("together",) * 3

    @abstractmethod
    def compared(self) -> tuple[Panel, ...]:
        """The curves that the performances have in common, side by side."""

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
