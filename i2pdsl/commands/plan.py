"""`i2p plan`: solves a world ahead of time."""

from __future__ import annotations

from pathlib import Path

import click

from i2pdsl.commands.arguments import complete_world
from i2pdsl.commands.inputs import spec_of
from i2pdsl.commands.output import output, output_json, show
from i2pdsl.errors import error, whole_file


@click.command()
@click.argument("world", shell_complete=complete_world)
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def plan(world: str, as_json: bool) -> None:
    """Solve a world's planning problem ahead of time and store it."""
    import time

    from i2pdsl.progress import Bars
    from i2pdsl.worlds.find import world_warnings
    from i2pdsl.worlds.grid.world import build_world
    from i2pdsl.worlds.hill.spec import HillSpec

    spec = spec_of(world)
    if isinstance(spec, HillSpec):
        message = f"world {spec.name} is not planned but trained"
        raise error("no-plan", message, whole_file(world), f"`i2p train {spec.name}`")
    show(world_warnings(world, Path()))
    began = time.perf_counter()
    with Bars() as bars:
        built = build_world(spec, None, bars.watch.planning, bars.watch.say)
    problems = sum(table.shape[1] for table in built.tables.continuation)
    document = {
        "world": spec.name,
        "states": spec.state_count,
        "problems": problems,
        "residual": built.residual,
        "bound": built.bound,
        "cached": built.planning_seconds == 0,
        "seconds": round(time.perf_counter() - began, 3),
    }
    if as_json:
        output_json(document)
        return
    where = "read from the cache" if document["cached"] else "solved and stored"
    output(
        f"{spec.name}: {spec.state_count:,} states, {problems} problems, residual "
        f"{built.residual:.2g}, values right to {built.bound:.2g}, {where} in "
        f"{document['seconds']:.1f} s"
    )
