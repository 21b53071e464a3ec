"""`i2p render`: pictures of finished scripts."""

from __future__ import annotations

from pathlib import Path

import click

from i2pdsl.commands.arguments import Formats
from i2pdsl.commands.inputs import script_or_story
from i2pdsl.commands.pictures import draw, film_options
from i2pdsl.commands.run import folder_name
from i2pdsl.output import DONE, INTERRUPTED, check_writable, output, output_json
from i2pdsl.render.files import FORMATS, FilmLook


@click.command()
@click.argument("scripts", nargs=-1, required=True, type=click.Path())
@click.option("--format", "formats", type=Formats(), default="png,html", help=", ".join(FORMATS))
@click.option(
    "--out", type=click.Path(file_okay=False), help="Folder; default: the script's, or in out/."
)
@click.option("--seed", type=click.IntRange(0), default=0, help="Where a story is given.")
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
@film_options
def render(
    scripts: tuple[str, ...],
    formats: tuple[str, ...],
    out: str | None,
    seed: int,
    as_json: bool,
    look: FilmLook,
) -> int:
    """Draw the pictures of a finished script, or of a story that is solved first.

    Several scripts of the hill, or of one plane, are drawn side by side, in the same time.
    """
    if out is not None:
        check_writable(Path(out))
    from i2pdsl.progress import Bars

    status, solved = DONE, []
    for name in scripts:
        found, ended = script_or_story(name, seed)
        with Bars() as bars:
            solved.append(found.vouched(bars.watch))
        status = max(status, ended)
    if len(solved) > 1:
        beside = Path("out", "together")
    elif solved[0].record.where == scripts[0]:
        beside = Path(scripts[0]).parent
    else:
        beside = Path("out", folder_name(solved[0].record.title))
    folder = Path(out) if out is not None else beside
    files: dict[str, str] = {}
    try:
        status = max(status, draw(solved, folder, formats, files, look=look))
    except KeyboardInterrupt:
        click.echo("interrupted: not all pictures are drawn", err=True)
        status = INTERRUPTED
    if as_json:
        shown = scripts[0] if len(scripts) == 1 else list(scripts)
        output_json({"script": shown, "files": files})
    else:
        for path in files.values():
            output(path)
    return status
