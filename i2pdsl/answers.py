"""Answers to questions about scripts: numbers, with their frames and their names."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from i2pdsl.errors import display_width, padded
from i2pdsl.language import typed as ty
from i2pdsl.language.vocabulary import UNKNOWN, Vocabulary, show_value
from i2pdsl.shown import Shown

if TYPE_CHECKING:
    import pandas
    import xarray


@dataclass(frozen=True)
class Answer(Shown):
    """The answer to a query: over `t` if that is not None, and over `labels` for a latent.

    Attributes:
        t: the frames; None where the expression has no free t.
        value: a number, [t], [labels] or [t, labels].
        labels: the values of a bare latent, in the world's order, else None.
        unknown: the probability of hypotheses in which the latent plays no part: a number or [t].
        expression: what was asked.
        latent: the name of a bare latent.
        steps: it is 1 or 0 in each frame, as a predicate is, and nothing in between.
    """

    t: list[int] | None
    value: np.ndarray
    labels: tuple[str, ...] | None
    unknown: np.ndarray | None
    expression: str = ""
    latent: str | None = None
    steps: bool = False

    def as_json(self) -> Any:
        """The `value` of `i2p query --json`."""
        if self.labels is None:
            return self.value.tolist()
        assert self.unknown is not None
        table = np.concatenate([self.value, self.unknown[..., None]], axis=-1)
        names = (*self.labels, UNKNOWN)
        rows = [dict(zip(names, map(float, row), strict=True)) for row in np.atleast_2d(table)]
        return rows if self.t is not None else rows[0]

    def in_words(self) -> str:
        """A number, a row for each frame, or a table of a latent's values."""
        columns = self.columns()
        if self.labels is None and self.t is None:
            return number(self.value)
        if self.labels is None:
            return "\n".join(
                f"{t:>4} {number(v)}" for t, v in zip(self.t or (), self.value, strict=True)
            )
        if self.t is None:
            width = max(map(display_width, columns))
            return "\n".join(f"{padded(name, width)} {number(v)}" for name, v in columns.items())
        head = "   t " + " ".join(padded(name, 12, right=True) for name in columns)
        rows = zip(self.t, *columns.values(), strict=True)
        return "\n".join(
            (head, *(f"{t:>4} " + " ".join(f"{number(v):>12}" for v in row) for t, *row in rows))
        )

    def columns(self) -> dict[str, np.ndarray]:
        """A latent's values with their probabilities, a number or [t] each, and `unknown` where
        that can be; for a number or a curve one column, named by the expression."""
        if self.labels is None:
            return {self.expression or "value": self.value}
        assert self.unknown is not None
        found = {name: self.value[..., i] for i, name in enumerate(self.labels)}
        return found | ({UNKNOWN: self.unknown} if np.any(self.unknown > 0) else {})

    def to_pandas(self) -> pandas.Series | pandas.DataFrame:
        """A Series over t (or over a latent's values), or a DataFrame [t, values] for both.

        Raises ImportError where pandas is not installed.
        """
        from i2pdsl.tables import answer_to_pandas

        return answer_to_pandas(self)

    def to_xarray(self) -> xarray.DataArray:
        """A DataArray with the dimension t, and one named after the latent.

        >>> script.ask("P(G_robot | script[:t])").to_xarray().sel(G_robot="pink")

        Raises ImportError where xarray is not installed.
        """
        from i2pdsl.tables import answer_to_xarray

        return answer_to_xarray(self)


def number(value: float | np.ndarray) -> str:
    """A number as people read it; one that is none is said in words."""
    value = float(value) + 0.0  # -0 is 0
    if math.isnan(value):
        return "undefined"
    return f"{value:.6g}" if math.isfinite(value) else "infinite" if value > 0 else "-infinite"


def latent_of(partition: ty.Partition, vocabulary: Vocabulary) -> str | None:
    """The name of the latent by whose values a query's distribution parts the hypotheses."""
    told = [partition.labels[index] for index in partition.index]
    for name in vocabulary.latents:
        rows = vocabulary.hypotheses
        if told == [show_value(row[name]) if name in row else UNKNOWN for row in rows]:
            return name
    return None
