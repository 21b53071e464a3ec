"""`i2p query`: one question to a finished script."""

from __future__ import annotations

import click

from i2pdsl.commands.inputs import script_or_story
from i2pdsl.output import output, output_json, show


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
        output(answer.in_words())
    return status
