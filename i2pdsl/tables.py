"""Tables: of beliefs and frames for pandas, which is optional, and as CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from i2pdsl.answers import FRAMES, Answer, optional
from i2pdsl.worlds.kinds import kind_of
from i2pdsl.worlds.record import Record
from i2pdsl.worlds.world import World

if TYPE_CHECKING:
    import pandas


def beliefs_table(answers: Sequence[tuple[str | None, Answer]], length: int) -> pandas.DataFrame:
    """Several questions side by side, a row for each frame 0..T.

    A column is called as it was asked, or by its keyword. A bare latent fills one column for each
    of its values (`G_robot = pink`), several latents one for each combination, a number without a
    free t the same number in every row, and what begins at frame 1 has no value at frame 0.
    """
    pd = optional("pandas")
    frames = pd.RangeIndex(length + 1, name=FRAMES)
    found: dict[str, Any] = {}
    for name, answer in answers:
        for column, values in answer.columns().items():
            if answer.axes:
                column = f"{name}: {column}" if name else column
            elif answer.labels is None:
                column = name or column
            else:
                column = f"{name or answer.latent} = {column}"
            if column in found:
                raise ValueError(f"two columns are called {column!r}; name them by keywords")
            if column == FRAMES:
                raise ValueError(f"the frames are called {FRAMES!r}; name the column by a keyword")
            found[column] = values if answer.t is None else pd.Series(values, index=answer.t)
    return pd.DataFrame(found, index=frames)


def frame_table(
    world: World, record: Record, length: int, ask: Callable[[str], Answer]
) -> pandas.DataFrame:
    """What happens, a row for each frame 0..T, frame 0 being the start.

    On a map: NAME_action and NAME_moved of each character, NAME_column and NAME_row of everything
    (missing where it is absent), and the event. Where bodies move: the world's quantities of a
    frame, which `ask` answers.
    """
    pd = optional("pandas")
    table = pd.DataFrame(index=pd.RangeIndex(length + 1, name=FRAMES))
    words = world.vocabulary
    columns = kind_of(world.spec).columns(words, record)
    for name, (values, dtype) in columns.items():
        table[name] = pd.array(values, dtype=dtype)
    if columns:
        return table
    for predicate in words.predicates.values():
        of = words.characters if predicate.parameters == ("character",) else words.things
        for who in of:
            answer = ask(f"[{predicate.name}({who}) @ script[t]]")
            table[f"{who}_{predicate.name}"] = answer.to_pandas()
    return table


def as_csv(columns: Mapping[str, Sequence[Any]]) -> str:
    """A table as CSV, with its heads."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*columns.values(), strict=True))
    return text.getvalue()
