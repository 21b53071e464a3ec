"""Scripts from tables of positions: who was where in which frame. What moved whom is inferred.

A table has the columns `who`, `frame` (from 0, the first picture), `x`, `y` and maybe `action`.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from i2pdsl.errors import Diagnostic, Source, Span, StoryError, did_you_mean, error, shorten
from i2pdsl.language.methods import LONGEST_STORY
from i2pdsl.language.naming import same_name
from i2pdsl.language.statements import read_source
from i2pdsl.language.vocabulary import Vocabulary

NEEDED, OPTIONAL = ("who", "frame", "x", "y"), "action"
MOST_ROWS = 1_000_000


@dataclass(frozen=True)
class Seen:
    """A row: where somebody was, what he did to get there if that is known, and where it says so.

    `x` and `y` are None where it was absent.
    """

    x: float | None
    y: float | None
    action: str | None
    place: Span


@dataclass(frozen=True)
class Positions:
    """A table of positions, checked for itself: frames 0..T.

    Attributes:
        seen: by frame and name.
        place: of the whole table.
    """

    length: int
    seen: tuple[dict[str, Seen], ...]
    place: Span

    def wrong(self, frame: int, message: str, who: str = "", hint: str | None = None) -> NoReturn:
        """Says what is wrong in a frame, at the row of `who` if there is one."""
        row = self.seen[frame].get(who)
        span = row.place if row else self.place
        raise error("positions", f"frame {frame}: {message}", span, hint)


@dataclass(frozen=True)
class Inferred:
    """The script that positions tell, as its file has it, and what could not be told for sure."""

    start: dict[str, Any]
    frames: tuple[dict[str, Any], ...]
    warnings: tuple[Diagnostic, ...] = ()


# Reading.


def read_positions(table: Any, words: Vocabulary) -> Positions:
    """A table of positions: the path of a CSV file, columns by their names (a DataFrame, a record
    array, a dict of arrays), or rows as mappings. Raises StoryError with all its mistakes."""
    rows, place = _rows(table)
    problems: list[Diagnostic] = []
    found: dict[int, dict[str, Seen]] = {}
    for row, span in rows:
        try:
            frame, who, seen = _seen(row, span, words)
            if who in found.setdefault(frame, {}):
                raise error("positions", f"frame {frame} has `{who}` twice", span)
            found[frame][who] = seen
        except StoryError as problem:
            problems.extend(problem.diagnostics)
    if problems:
        raise StoryError(problems)
    if len(found) < 2:
        hint = "frame 0 is the first picture, and each frame after it a row for everyone"
        raise error("positions", "a script needs frame 0 and at least one more", place, hint)
    missing = next((n for n, frame in enumerate(sorted(found)) if n != frame), None)
    if missing is not None:
        raise error("positions", f"frame {missing} is missing", place, "frames begin at 0")
    return Positions(len(found) - 1, tuple(found[n] for n in range(len(found))), place)


def _rows(table: Any) -> tuple[list[tuple[Mapping[str, Any], Span]], Span]:
    """Rows with their places, and the place of the table."""
    if isinstance(table, str | Path):
        source = read_source(table)
        return _csv_rows(source), Span(source, 0, 0)
    names = getattr(getattr(table, "dtype", None), "names", None)
    if names is None and isinstance(table, Mapping):
        names = list(table)
    if names is None:
        names = getattr(table, "columns", None)
    if names is not None:
        columns = {str(name): _plain(table[name]) for name in names}
        if len({len(column) for column in columns.values()}) > 1:
            span = Span(Source("table", ""), 0, 0)
            raise error("positions", "the columns have different lengths", span)
        each = zip(*columns.values(), strict=True)
        table = [dict(zip(columns, values, strict=True)) for values in each]
    where = [(row, Span(Source(f"table, row {n}", ""), 0, 0)) for n, row in enumerate(table)]
    return where, Span(Source("table", ""), 0, 0)


def _plain(column: Any) -> list[Any]:
    """The values of a column; what is missing is None, as far as it is a number that is none."""
    values = np.asarray(column, dtype=object).tolist()
    return [None if isinstance(v, float) and math.isnan(v) else v for v in values]


def _csv_rows(source: Source) -> list[tuple[Mapping[str, Any], Span]]:
    """The rows of a CSV file, each with the place of its line."""
    lines = source.text.splitlines(keepends=True)
    starts = np.cumsum([0, *map(len, lines)])
    reader = csv.reader(lines, strict=True)
    rows: list[tuple[Mapping[str, Any], Span]] = []
    heads: list[str] | None = None
    first = 0
    try:
        for cells in reader:
            last = reader.line_num
            text = source.text[starts[first] : starts[last]]
            span = Span(source, int(starts[first]), int(starts[first]) + len(text.rstrip()))
            first = last
            if not any(cell.strip() for cell in cells):
                continue
            if heads is None:
                heads = [cell.strip() for cell in cells]
                _check_heads(heads, span)
            elif len(cells) != len(heads):
                message = f"this row has {len(cells)} cells, the first one has {len(heads)}"
                raise error("positions", message, span)
            else:
                rows.append((dict(zip(heads, map(str.strip, cells), strict=True)), span))
            if len(rows) > MOST_ROWS:
                raise error("positions", f"at most {MOST_ROWS:,} rows are read", span)
    except csv.Error as problem:
        start = int(starts[min(first, len(lines))])
        raise error("positions", f"this is no CSV: {problem}", Span(source, start, start)) from None
    if heads is None:
        raise error("positions", "the table is empty", Span(source, 0, 0), _columns())
    return rows


def _columns() -> str:
    return f"columns: {', '.join(NEEDED)} and maybe {OPTIONAL}"


def _check_heads(heads: Sequence[str], span: Span) -> None:
    missing = [name for name in NEEDED if name not in heads]
    if missing:
        raise error("positions", f"there is no column `{missing[0]}`", span, _columns())


def _seen(row: Mapping[str, Any], span: Span, words: Vocabulary) -> tuple[int, str, Seen]:
    _check_heads(list(row), span)

    def wrong(message: str, hint: str | None = None) -> NoReturn:
        raise error("positions", message, span, hint)

    who = same_name(str(row["who"]))
    names = (*words.characters, *words.things)
    if who not in names:
        wrong(f"there is no `{shorten(who)}` {words.where}", did_you_mean(who, names))
    frame = _number(row["frame"])
    if frame is None or frame != int(frame) or not 0 <= frame <= LONGEST_STORY:
        wrong(f"frames are whole numbers from 0 on, not {shorten(repr(row['frame']))}")
    places = []
    for axis in ("x", "y"):
        value = row[axis]
        number = None if value in (None, "") else _number(value)
        if number is None and value not in (None, ""):
            wrong(f"`{axis}` must be a number, not {shorten(repr(value))}")
        places.append(number)
    if (places[0] is None) != (places[1] is None):
        wrong("both `x` and `y` are given, or none where it is absent")
    action = row.get(OPTIONAL)
    action = None if action in (None, "") else same_name(str(action))
    if action is not None and who not in words.characters:
        wrong(f"`{who}` does not act", "leave its action empty")
    if action is not None and action not in words.actions:
        known = did_you_mean(action, words.actions) if words.actions else None
        wrong(f"there is no action `{shorten(action)}` {words.where}", known)
    return int(frame), who, Seen(places[0], places[1], action, span)


def _number(value: Any) -> float | None:
    try:
        number = float(value)
    except (TypeError, ValueError):
        return None
    return number if math.isfinite(number) else None
