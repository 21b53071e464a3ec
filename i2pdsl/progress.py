"""Progress on standard error: bars on a terminal, nothing elsewhere."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import TracebackType
from typing import Any

import click

from i2pdsl.errors import harmless
from i2pdsl.worlds.ready import Watch


class Bars:
    """Progress bars for planning, searching and drawing. Use it as a context.

    `waiting` is shown before there is anything to count, while programs are compiled.
    """

    def __init__(self, waiting: str = "") -> None:
        self.bar: Any = None
        self.name = ""
        self.whole = ""  # what the work at hand is a part of
        self.waiting = waiting
        self.shown = sys.stderr is not None and sys.stderr.isatty()
        self.watch = Watch(self._planning, self._searching, self.training, self.say)

    def __enter__(self) -> Bars:
        if self.shown and self.waiting:
            click.echo(f"{self.waiting} ...", err=True, nl=False)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def say(self, message: str) -> None:
        """A message for the person at the terminal; standard output carries results only."""
        self.close()
        click.echo(harmless(message), err=True)

    @contextmanager
    def within(self, whole: str) -> Iterator[None]:
        """Bars that say what their work is a part of: `3 of 28, twist-kitchen: searching`."""
        self.close()
        self.whole = f"{whole}: "
        if self.shown:  # before there is anything to count
            self._show("begins", 1).refresh()
        try:
            yield
        finally:
            self.close()
            self.whole = ""

    def close(self) -> None:
        if self.shown and self.waiting:
            click.echo("\r\x1b[2K", err=True, nl=False)  # the whole line is cleared
            self.waiting = ""
        if self.bar is not None:
            self.bar.close()
            self.bar = None

    def _show(self, name: str, total: int) -> Any:
        if self.bar is None or self.name != name:
            from tqdm import tqdm

            self.close()
            self.name = name
            layout = "{desc}: {percentage:3.0f} %|{bar}| {elapsed}<{remaining}{postfix}"
            width = self.columns()
            self.bar = tqdm(
                total=total,
                desc=self.whole + name,
                bar_format=layout,
                leave=False,
                ncols=width,
                nrows=20,
            )
        return self.bar

    def columns(self) -> int:
        """The width of a bar. Some terminals do not know theirs and say 0."""
        return os.get_terminal_size(sys.stderr.fileno()).columns or 80

    def _planning(self, who: str, sweep: int, residual: float, expected: float | None) -> None:
        if not self.shown:
            return
        # Values settle geometrically, so progress is measured in the logarithm of the residual.
        bar = self._show(f"planning {who}", 1000)
        if expected is not None and expected > 0:
            bar.n = min(999, round(1000 * sweep / max(expected, sweep)))
        residual_shown = "" if math.isinf(residual) else f", residual {residual:.1e}"
        bar.set_postfix_str(f"sweep {sweep}{residual_shown}", refresh=True)

    def _searching(self, done: int, total: int) -> None:
        self._count("searching", done, total)

    def training(self, done: int, total: int, figures: dict[str, float]) -> None:
        """Some more iterations of a training are done."""
        self._count("training", done, total)
        if self.shown:
            shown = f"reward {figures['best']:.2f}, falls {100 * figures['falls']:.0f} %"
            self.bar.set_postfix_str(shown, refresh=True)

    def fitting(self, done: int, total: int) -> None:
        """Some more draws from a posterior are made."""
        self._count("fitting", done, total)

    def drawing(self, name: str, done: int, total: int) -> None:
        """One more frame of a film is drawn."""
        self._count(f"drawing {name}", done, total)

    def compiling(self, done: int, total: int) -> None:
        """One more story's search is compiled."""
        self._count("compiling", done, total)

    def sweeping(self, done: int, total: int) -> None:
        """One more job of a sweep is done."""
        self._count("jobs", done, total)

    def judging(self, done: int, total: int) -> None:
        """A panel has watched one more group of films."""
        self._count("viewers watch", done, total)

    def saving(self, done: int, total: int) -> None:
        """One more script is written."""
        self._count("writing", done, total)

    def _count(self, name: str, done: int, total: int) -> None:
        if self.shown:
            bar = self._show(name, total)
            bar.n = done
            bar.refresh()
