"""`i2p plan`: solves a world ahead of time."""

from __future__ import annotations

from pathlib import Path

import click

from i2pdsl.commands.arguments import complete_world
from i2pdsl.commands.inputs import spec_of
from i2pdsl.output import output, output_json, show


@click.command()
@click.argument("world", shell_complete=complete_world)
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def plan(world: str, as_json: bool) -> None:
    """Solve a world's planning problem ahead of time and store it."""
    from i2pdsl.objective.nearer import trust_in
    from i2pdsl.progress import Bars
    from i2pdsl.worlds.find import world_warnings
    from i2pdsl.worlds.kinds import kind_of

    spec = spec_of(world)
    show(world_warnings(world, Path()))
    with Bars() as bars:
        planned = kind_of(spec).plan(spec, bars.watch)
        trust = trust_in(spec, bars.watch)
    if as_json:
        output_json(planned.document | ({} if trust is None else {"trust": trust.as_json()}))
        return
    output(planned.words)
    if trust is not None:
        output(trust.in_words())
