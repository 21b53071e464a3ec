"""`i2p worlds`: what worlds there are."""

from __future__ import annotations

import re
from contextlib import suppress
from pathlib import Path

import click

from i2pdsl.commands.arguments import complete_world
from i2pdsl.commands.inputs import spec_of
from i2pdsl.errors import harmless
from i2pdsl.output import check_writable, output, output_json

LARGEST_IMPORT = 1_000_000  # bytes


@click.command()
@click.argument("name", required=False, shell_complete=complete_world)
@click.option(
    "--import",
    "imported",
    metavar="FILE",
    type=click.Path(dir_okay=False),
    help="A map of Sokoban, MiniGrid, doors-keys-gems or agentmodels: writes a world and a story.",
)
@click.option("--name", "called", default=None, help="Of the imported world; else the file's.")
@click.option(
    "--out", type=click.Path(file_okay=False), default=".", help="Where an imported world goes."
)
@click.option(
    "--level", type=click.IntRange(1), default=1, help="Which level of a file with several."
)
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def worlds(
    name: str | None, imported: str | None, called: str | None, out: str, level: int, as_json: bool
) -> None:
    """List the worlds, describe one, or import a map of another tool."""
    from i2pdsl.describe import describe_world, world_as_json
    from i2pdsl.worlds.find import builtin_worlds

    if imported is not None:
        if name is not None:
            raise click.UsageError("--import takes a file; what it is called says --name")
        import_map(Path(imported), called, Path(out), level, as_json)
        return
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


def import_map(file: Path, called: str | None, folder: Path, level: int, as_json: bool) -> None:
    """Writes the world and the story that a map of another tool comes to."""
    from i2pdsl.beginnings.imported import first_story
    from i2pdsl.errors import error, whole_file
    from i2pdsl.language.statements import decode, read_data
    from i2pdsl.resources import write_text
    from i2pdsl.untrusted import is_plain_name
    from i2pdsl.worlds.find import builtin_worlds
    from i2pdsl.worlds.kinds import USUAL, kind_named

    plain = re.sub(r"\W+", "_", file.stem.lower()).strip("_")
    name = called if called is not None else plain
    if not is_plain_name(name) or '"' in name or name in builtin_worlds():
        hint = "--name NAME: letters, digits and _, and no built-in world"
        raise error("name", f"no world can be called `{name}`", whole_file(str(file)), hint)
    source = decode(read_data(file, LARGEST_IMPORT), str(file))
    found = kind_named(USUAL).imported(source, file.name, name, level)
    world, story = folder / f"{name}.world", folder / f"{name}.story"
    text = first_story(found, name, str(story))
    for path in (world, story):
        if path.exists() or path.is_symlink():
            message = "there is such a file already, and nothing is overwritten"
            raise error("taken", message, whole_file(str(path)), "another name: --name NAME")
    check_writable(folder)
    write_text(world, found.text, new=True)
    try:
        write_text(story, text, new=True)
    except BaseException:
        with suppress(OSError):
            world.unlink()
        raise
    if as_json:
        files = {"story": str(story), "world_file": str(world)}
        output_json({"world": name, **files, "from": found.what, "notes": list(found.notes)})
        return
    output(str(story))
    output(str(world))
    for note in found.notes:
        click.echo(harmless(f"otherwise here: {note}"), err=True)
