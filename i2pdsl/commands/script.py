"""`i2p script`: a script from a table of positions."""

from __future__ import annotations

from pathlib import Path

import click

from i2pdsl.commands.arguments import complete_world
from i2pdsl.commands.inputs import load_story, spec_of
from i2pdsl.output import output, output_json, show


@click.command()
@click.argument("source", metavar="WORLD_OR_STORY", shell_complete=complete_world)
@click.argument("table", type=click.Path())
@click.option("-o", "--out", type=click.Path(dir_okay=False), default="script.json")
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def script(source: str, table: str, out: str, as_json: bool) -> None:
    """Make a script of a TABLE of positions: a CSV file with who, frame, x, y and maybe action."""
    from i2pdsl.progress import Bars
    from i2pdsl.scripts import script_of_positions

    with Bars() as bars:
        if source.endswith(".story"):
            story = load_story(source)
            show(story.warnings)
            made = story.script_from_positions(table, bars.watch)
        else:
            made = script_of_positions(spec_of(source), table, {}, {}, bars.watch)
    show(made.warnings)
    path = made.save(Path(out))
    if as_json:
        output_json({"script": str(path), "world": made.world.name, "frames": made.length})
    else:
        output(f"{path}: {made.length} frames {made.world.vocabulary.where}")
