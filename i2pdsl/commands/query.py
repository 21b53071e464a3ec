"""`i2p query`: one question to a finished script."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from i2pdsl.commands.inputs import script_or_story
from i2pdsl.commands.output import output, output_json, show

if TYPE_CHECKING:
    from i2pdsl.pipeline import Answer


@click.command()
@click.argument("source", type=click.Path())
@click.argument("expression")
@click.option("--assume", default=None, help="Another assumption; 'nothing' drops it.")
@click.option("--seed", type=click.IntRange(0), default=0, help="Where a story is given.")
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def query(source: str, expression: str, assume: str | None, seed: int, as_json: bool) -> int:
    """Evaluate one expression over a finished script, or over a story that is solved first."""
    script, status = script_or_story(source, seed)
    checked = script.check(expression, assume)
    show(checked.warnings)
    answer = script.answer(checked)
    if as_json:
        output_json({"expr": expression, "t": answer.t, "value": answer.as_json()})
    else:
        output(show_answer(answer))
    return status


def show_answer(answer: Answer) -> str:
    """An answer for people: a number, a column over t, or a table of a latent's values."""
    import numpy as np

    number = lambda x: f"{float(x):.6g}"
    if answer.labels is None:
        if answer.t is None:
            return number(answer.value)
        return "\n".join(f"{t:>4} {number(v)}" for t, v in zip(answer.t, answer.value, strict=True))
    assert answer.unknown is not None
    names, table = list(answer.labels), answer.value
    if np.any(answer.unknown > 0):
        names.append("unknown")
        table = np.concatenate([table, answer.unknown[..., None]], axis=-1)
    if answer.t is None:
        width = max(map(len, names))
        return "\n".join(f"{n:<{width}} {number(v)}" for n, v in zip(names, table, strict=True))
    head = "   t " + " ".join(f"{n:>12}" for n in names)
    rows = (
        f"{t:>4} " + " ".join(f"{number(v):>12}" for v in row)
        for t, row in zip(answer.t, table, strict=True)
    )
    return "\n".join((head, *rows))
