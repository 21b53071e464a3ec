"""`i2p extract`: a story becomes a pattern."""

from __future__ import annotations

from pathlib import Path

import click

from i2pdsl.errors import Diagnostic, StoryError
from i2pdsl.output import check_writable, output, output_json


@click.command()
@click.argument("story", type=click.Path())
@click.option(
    "--param", "params", multiple=True, metavar="NAME=EXPRESSION", help="A part that varies."
)
@click.option("--name", default=None, help="Of the pattern; the file's name without it.")
@click.option("-o", "--out", "target", required=True, type=click.Path(), help="PATTERN.story.")
@click.option("--defaults", is_flag=True, help="The parts become the parameters' defaults.")
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def extract(
    story: str,
    params: tuple[str, ...],
    name: str | None,
    target: str,
    defaults: bool,
    as_json: bool,
) -> None:
    """Turn a story into a pattern: named parts of its objective become parameters."""
    from i2pdsl.language.statements import read_source
    from i2pdsl.library.extract import extract as extract_pattern
    from i2pdsl.library.parts import read_part
    from i2pdsl.resources import write_text

    path = Path(target)
    if path.suffix != ".story":
        raise click.UsageError(f"a pattern is written to NAME.story, not to {path.name}")
    if path.exists() and path.samefile(story):
        raise click.UsageError("the pattern would replace the story")
    check_writable(path.parent)
    parts, problems = [], list[Diagnostic]()
    for param in params:
        try:
            parts.append(read_part(param))
        except StoryError as problem:
            problems.extend(problem.diagnostics)
    if problems:
        raise StoryError(problems)
    source, folder = read_source(story), Path(story).parent
    found = extract_pattern(source, folder, parts, name or path.stem, path, defaults)
    write_text(path, found.text)
    if as_json:
        output_json(
            {
                "pattern": str(path),
                "signature": found.signature,
                "call": found.call,
                "replaced": found.replaced,
                "carried": found.carried,
            }
        )
        return
    output(f"{path}: {found.signature}")
    for part in parts:
        count = found.replaced[part.name]
        places = "1 place" if count == 1 else f"{count} places"
        output(f"  {part.name} for {part.text} in {places}")
    if found.carried:
        output(f"  with {', '.join(found.carried)}")
    output(f"  the story's objective is {found.call}")
