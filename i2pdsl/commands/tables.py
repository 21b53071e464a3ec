"""Tables that commands write: CSV, or with `--json` a list of objects."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import click

from i2pdsl.output import finite, output_json


def write_table(columns: Mapping[str, Sequence[Any]], out: Path | None, as_json: bool) -> None:
    """Writes a table to a file, atomically, or to standard output; None is an empty cell.

    Numbers are written in full: the shortest decimals that are read as the same number.
    """
    from i2pdsl.resources import write_text
    from i2pdsl.tables import as_csv

    if out is None and as_json:
        output_json(_rows(columns))
    elif out is None:
        click.echo(as_csv(columns), nl=False)
    elif out.suffix == ".json":
        write_text(out, json.dumps(finite(_rows(columns)), ensure_ascii=False) + "\n")
    elif out.suffix == ".csv":
        write_text(out, as_csv(columns))
    else:
        raise click.UsageError(f"{out}: tables end in .csv or .json")


def _rows(columns: Mapping[str, Sequence[Any]]) -> list[dict[str, Any]]:
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
