"""Beliefs and frames as tables of pandas and xarray, which are optional."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from i2pdsl.answers import Answer
from i2pdsl.errors import Source
from i2pdsl.language.scope import Module
from i2pdsl.worlds.kinds import kind_of

if TYPE_CHECKING:
    import pandas
    import xarray

    from i2pdsl.scripts import Script


FRAMES = "t"  # what the index of frames is called


def _library(name: str) -> Any:
    """An optional library. Raises ImportError that says how to get it."""
    try:
        return import_module(name)
    except ModuleNotFoundError as missing:
        if missing.name != name:
            raise
        message = f"this needs {name}, which is not installed: pip install 'i2pdsl[tables]'"
        raise ModuleNotFoundError(message, name=name) from None


def _name(answer: Answer) -> str | None:
    """What an answer's numbers are called: as they were asked for, but never as the frames are."""
    return answer.expression if answer.expression not in ("", FRAMES) else None


def answer_to_pandas(answer: Answer) -> pandas.Series | pandas.DataFrame:
    """A Series, or a DataFrame for a latent over t; rows are frames where there are any."""
    pd = _library("pandas")
    columns, name = answer.columns(), _name(answer)
    if answer.labels is None:
        rows = None if answer.t is None else pd.Index(answer.t, name=FRAMES)
        return pd.Series(np.atleast_1d(answer.value), index=rows, name=name)
    labels = pd.Index(list(columns), name=answer.latent)
    table = np.stack(list(columns.values()), axis=-1)
    if answer.t is None:
        return pd.Series(table, index=labels, name=name)
    return pd.DataFrame(table, index=pd.Index(answer.t, name=FRAMES), columns=labels)


def answer_to_xarray(answer: Answer) -> xarray.DataArray:
    """A DataArray with those of the dimensions (t, latent) that the answer has."""
    xr = _library("xarray")
    coordinates: dict[str, Any] = {} if answer.t is None else {FRAMES: answer.t}
    values = answer.value
    if answer.labels is not None:
        columns = answer.columns()
        coordinates[answer.latent or "latent"] = list(columns)
        values = np.stack(list(columns.values()), axis=-1)
    name = _name(answer)
    return xr.DataArray(values, coords=coordinates, dims=list(coordinates), name=name)


def beliefs_table(
    script: Script, expressions: tuple[str, ...], named: Mapping[str, str], assume: str | None
) -> pandas.DataFrame:
    """Several questions side by side, a row for each frame 0..T.

    A column is called as it was asked, or by its keyword. A bare latent fills one column for each
    of its values (`G_robot = pink`), a number without a free t the same number in every row, and
    what begins at frame 1 has no value at frame 0.
    """
    pd = _library("pandas")
    frames = pd.RangeIndex(script.length + 1, name=FRAMES)
    found: dict[str, Any] = {}
    questions = [(None, e) for e in expressions] + [(n, e) for n, e in named.items()]
    for name, expression in questions:
        answer = script.ask(expression, assume)
        for column, values in answer.columns().items():
            if answer.labels is None:
                column = name or column
            else:
                column = f"{name or answer.latent} = {column}"
            if column in found:
                raise ValueError(f"two columns are called {column!r}; name them by keywords")
            if column == FRAMES:
                raise ValueError(f"the frames are called {FRAMES!r}; name the column by a keyword")
            found[column] = values if answer.t is None else pd.Series(values, index=answer.t)
    return pd.DataFrame(found, index=frames)


def frame_table(script: Script) -> pandas.DataFrame:
    """What happens, a row for each frame 0..T, frame 0 being the start.

    On a map: NAME_action and NAME_moved of each character, NAME_column and NAME_row of everything
    (missing where it is absent), and the event. Where bodies move: the world's quantities of a
    frame.
    """
    pd = _library("pandas")
    table = pd.DataFrame(index=pd.RangeIndex(script.length + 1, name=FRAMES))
    words = script.world.vocabulary
    columns = kind_of(script.world.spec).columns(words, script.record)
    for name, (values, dtype) in columns.items():
        table[name] = pd.array(values, dtype=dtype)
    if columns:
        return table
    plain = replace(script, module=Module(Source("table", "")))  # without the story's names
    for predicate in words.predicates.values():
        of = words.characters if predicate.parameters == ("character",) else words.things
        for who in of:
            answer = plain.ask(f"[{predicate.name}({who}) @ script[t]]")
            table[f"{who}_{predicate.name}"] = answer.to_pandas()
    return table
