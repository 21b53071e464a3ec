"""`i2p explain`: why viewers believe what they believe."""

from __future__ import annotations

import click

from i2pdsl.commands.inputs import script_or_story
from i2pdsl.output import output, output_json


@click.command()
@click.argument("source", metavar="SCRIPT", type=click.Path())
@click.option("--frame", type=click.IntRange(1), help="One frame, with all that it changes.")
@click.option("--seed", type=click.IntRange(0), default=0, help="Where a story is given.")
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def explain(source: str, frame: int | None, seed: int, as_json: bool) -> int:
    """Say why viewers believe what they believe: which actions moved which belief, by how much."""
    from i2pdsl.progress import Bars

    script, status = script_or_story(source, seed)
    with Bars() as bars:
        script = script.vouched(bars.watch).shown()
    if frame is not None and frame > script.length:
        raise click.UsageError(f"the script has {script.length} frames, not {frame}")
    if as_json:
        from i2pdsl.explain import document

        output_json({"script": source, **document(script, frame)})
    else:
        from i2pdsl.render.reasons import reasons_in_words

        output(reasons_in_words(script, frame))
        if script.trust is not None:
            click.echo(script.trust.in_words(), err=True)
    return status
