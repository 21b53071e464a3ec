"""Progress in a notebook: a bar of text below the cell, gone when the work is done."""

from __future__ import annotations

from i2pdsl.progress import Bars


class CellBars(Bars):
    """As `Bars`, but for a kernel, whose standard error is no terminal yet can show a bar.

    Messages are kept in `said`: what a cell shows while it works is cleared in the end.
    """

    def __init__(self) -> None:
        super().__init__()
        self.shown = True
        self.said: list[str] = []

    def say(self, message: str) -> None:
        self.said.append(message)

    def columns(self) -> int:
        return 80
