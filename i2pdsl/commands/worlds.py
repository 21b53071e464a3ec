"""`i2p worlds`: what worlds there are."""

from __future__ import annotations

import click

from i2pdsl.commands.arguments import complete_world
from i2pdsl.commands.inputs import spec_of
from i2pdsl.output import output, output_json


@click.command()
@click.argument("name", required=False, shell_complete=complete_world)
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def worlds(name: str | None, as_json: bool) -> None:
    """List the worlds, or describe one."""
    from i2pdsl.describe import describe_world, world_as_json
    from i2pdsl.worlds.find import builtin_worlds

    if name is not None:
        spec = spec_of(name)
        if as_json:
            output_json(world_as_json(spec))
        else:
            output(describe_world(spec))
        return
    specs = [spec_of(world) for world in builtin_worlds()]
    if as_json:
        output_json([world_as_json(spec) for spec in specs])
        return
    width = max(len(spec.name) for spec in specs)
    for spec in specs:
        output(f"{spec.name:<{width}}  {spec.documentation.partition(chr(10))[0]}")
