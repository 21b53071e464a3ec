"""Progress in a notebook: a bar of text below the cell, gone when the work is done."""

from __future__ import annotations

from typing import Any

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

    def _show(self, name: str, total: int) -> Any:
        if self.bar is None or self.name != name:
            from tqdm import tqdm

            self.close()
            self.name = name
            layout = "{desc}: {percentage:3.0f} %|{bar}| {elapsed}<{remaining}{postfix}"
            self.bar = tqdm(total=total, desc=name, bar_format=layout, leave=False, ncols=80)
        return self.bar
