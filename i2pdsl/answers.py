"""Answers to questions about scripts: numbers, with their frames and their names."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from importlib import import_module
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from i2pdsl.errors import display_width, padded
from i2pdsl.language import typed as ty
from i2pdsl.language.check import TypedQuery
from i2pdsl.language.typed import Labels
from i2pdsl.language.vocabulary import UNKNOWN
from i2pdsl.shown import Shown

if TYPE_CHECKING:
    import pandas
    import xarray

    from i2pdsl.objective.trust import Trust

FRAMES = "t"  # what the index of frames is called


@dataclass(frozen=True)
class Answer(Shown):
    """The answer to a query: over `t` if that is not None, over `labels` for a latent (or for a
    character's actions), over `axes` for several latents together.

    Attributes:
        t: the frames; None where the expression has no free t.
        value: a number, [t], [labels] or [t, labels]; with `axes` [t, n_1, n_2, ...].
        labels: the values of a bare latent, in the world's order, else None.
        unknown: the probability of hypotheses in which the latent plays no part: a number or [t];
            None where there are no such hypotheses.
        expression: what was asked.
        latent: the name of a bare latent, or of a character whose actions are asked for.
        axes: several latents, each with its values and `unknown` as the last of them.
        steps: it is 1 or 0 in each frame, as a predicate is, and nothing in between.
        judge: finds `trust`.
    """

    t: list[int] | None
    value: np.ndarray
    labels: tuple[str, ...] | None
    unknown: np.ndarray | None
    expression: str = ""
    latent: str | None = None
    steps: bool = False
    axes: tuple[Labels, ...] = ()
    judge: Callable[[], Trust | None] | None = field(default=None, compare=False, repr=False)

    @cached_property
    def trust(self) -> Trust | None:
        """What is known of the error of a belief, where the world's plans are approximate or its
        viewers hold particles: `trust.answer` is how far off this is by what is nearer to exact.
        It is found when it is first asked for (`Script.vouched`).

        >>> script.ask("P(rho > 0 | script[:T])").trust.answer
        """
        return None if self.judge is None else self.judge()

    def __getstate__(self) -> dict[str, Any]:
        """What is kept of it in another process: not the world that could judge it."""
        return {**self.__dict__, "judge": None}

    def as_json(self) -> Any:
        """The `value` of `i2p query --json`."""
        if self.axes:
            axes = [{"name": axis.name, "values": list(axis.values)} for axis in self.axes]
            return {"axes": axes, "probabilities": self.value.tolist()}
        if self.labels is None:
            return self.value.tolist()
        table, names = self.value, self.labels
        if self.unknown is not None:
            table = np.concatenate([table, self.unknown[..., None]], axis=-1)
            names = (*names, UNKNOWN)
        rows = [dict(zip(names, map(float, row), strict=True)) for row in np.atleast_2d(table)]
        return rows if self.t is not None else rows[0]

    def in_words(self) -> str:
        """A number, a row for each frame, or a table of a latent's values."""
        columns = self.columns()
        if self.axes:
            return self._joint_in_words()
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

    def _joint_in_words(self) -> str:
        """A row for each frame and each combination of the first latents' values, a column for
        each value of the last."""
        heads, rows = self.grid()
        first = len(heads) - len(rows[0][1]) if rows else len(heads)
        told = [(*keys, *map(number, values)) for keys, values in rows]
        widths = [max(map(display_width, column)) for column in zip(heads, *told, strict=True)]
        return "\n".join(
            " ".join(
                padded(cell, max(width, 12) if i >= first else width, right=i >= first)
                for i, (cell, width) in enumerate(zip(row, widths, strict=True))
            ).rstrip()
            for row in (heads, *told)
        )

    def grid(self) -> tuple[tuple[str, ...], list[tuple[tuple[str, ...], np.ndarray]]]:
        """Several latents as a table: its heads, and each row's names and probabilities."""
        axes, value = self.present()
        *before, last = axes
        named = [axis.values for axis in before]
        frames = [] if self.t is None else [tuple(map(str, self.t))]
        heads = (*(["t"] if frames else []), *(axis.name for axis in before))
        rows = value.reshape(-1, len(last.values))
        columns = tuple(f"{last.name} = {v}" for v in last.values)
        return (*heads, *columns), list(zip(product(*frames, *named), rows, strict=True))

    def present(self) -> tuple[tuple[Labels, ...], np.ndarray]:
        """The axes of several latents and their probabilities, without `unknown` where it has
        none."""
        axes, value = [], self.value
        for place, axis in enumerate(self.axes, start=0 if self.t is None else 1):
            kept = axis.values
            if not np.any(np.take(value, -1, place) > 0):
                kept = kept[:-1]
                value = np.take(value, range(len(kept)), place)
            axes.append(Labels(axis.name, kept))
        return tuple(axes), value

    def columns(self) -> dict[str, np.ndarray]:
        """A latent's values with their probabilities, a number or [t] each, and `unknown` where
        that can be; those of several latents together; for a number or a curve one column, named
        by the expression."""
        if self.axes:
            axes, value = self.present()
            value = value.reshape(*value.shape[: value.ndim - len(axes)], -1)
            events = product(*(tuple(f"{a.name} = {v}" for v in a.values) for a in axes))
            return {", ".join(event): value[..., i] for i, event in enumerate(events)}
        if self.labels is None:
            return {self.expression or "value": self.value}
        found = {name: self.value[..., i] for i, name in enumerate(self.labels)}
        if self.unknown is not None and np.any(self.unknown > 0):
            found[UNKNOWN] = self.unknown
        return found

    def to_pandas(self) -> pandas.Series | pandas.DataFrame:
        """A Series over t (or over a latent's values), or a DataFrame [t, values] for both.

        The values of several latents are a MultiIndex with a level for each.

        Raises ImportError where pandas is not installed.
        """
        pd = optional("pandas")
        columns, name = self.columns(), self._name
        if self.axes:
            axes, _ = self.present()
            levels = [axis.values for axis in axes]
            labels = pd.MultiIndex.from_product(levels, names=[axis.name for axis in axes])
        elif self.labels is None:
            rows = None if self.t is None else pd.Index(self.t, name=FRAMES)
            return pd.Series(np.atleast_1d(self.value), index=rows, name=name)
        else:
            labels = pd.Index(list(columns), name=self.latent)
        table = np.stack(list(columns.values()), axis=-1)
        if self.t is None:
            return pd.Series(table, index=labels, name=name)
        return pd.DataFrame(table, index=pd.Index(self.t, name=FRAMES), columns=labels)

    def to_xarray(self) -> xarray.DataArray:
        """A DataArray with the dimension t, and one named after each latent.

        >>> script.ask("P(G_robot | script[:t])").to_xarray().sel(G_robot="pink")

        Raises ImportError where xarray is not installed.
        """
        xr = optional("xarray")
        coordinates: dict[str, Any] = {} if self.t is None else {FRAMES: self.t}
        values = self.value
        if self.axes:
            axes, values = self.present()
            coordinates |= {axis.name: list(axis.values) for axis in axes}
        elif self.labels is not None:
            columns = self.columns()
            coordinates[self.latent or "latent"] = list(columns)
            values = np.stack(list(columns.values()), axis=-1)
        name = self._name
        return xr.DataArray(values, coords=coordinates, dims=list(coordinates), name=name)

    @property
    def _name(self) -> str | None:
        """What its numbers are called: as they were asked for, but never as the frames are."""
        return self.expression if self.expression not in ("", FRAMES) else None


def answer_of(query: TypedQuery, value: np.ndarray) -> Answer:
    """What a query's value says, with the names of its axes."""
    times = None if query.times is None else list(query.times)
    axes = query.value.labels if isinstance(query.value, ty.Belief) else ()
    if not axes:
        steps = bool(((value == 0) | (value == 1)).all()) and any(
            isinstance(node, ty.Feature) for node in ty.walk(query.value)
        )
        return Answer(times, value, None, None, steps=steps)
    if len(axes) > 1:
        sizes = tuple(len(axis.values) for axis in axes)
        value = value.reshape(*value.shape[:-1], *sizes)
        return Answer(times, value, None, None, axes=axes)
    (axis,) = axes
    if axis.values[-1] != UNKNOWN:  # of actions, each of which has its name
        return Answer(times, value, axis.values, None, latent=axis.name)
    names = axis.values[:-1]
    return Answer(times, value[..., :-1], names, value[..., -1], latent=axis.name)


def optional(name: str, extra: str = "tables") -> Any:
    """An optional library. Raises ImportError that says how to get it."""
    try:
        return import_module(name)
    except ModuleNotFoundError as missing:
        if missing.name != name:
            raise
        message = f"this needs {name}, which is not installed: pip install 'i2pdsl[{extra}]'"
        raise ModuleNotFoundError(message, name=name) from None


def number(value: float | np.ndarray) -> str:
    """A number as people read it; one that is none is said in words."""
    value = float(value) + 0.0  # -0 is 0
    if math.isnan(value):
        return "undefined"
    return f"{value:.6g}" if math.isfinite(value) else "infinite" if value > 0 else "-infinite"
