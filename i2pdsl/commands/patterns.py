"""`i2p patterns`: what patterns there are."""

from __future__ import annotations

import click

from i2pdsl.commands.output import output, output_json


@click.command()
@click.argument("library", required=False, type=click.Path())
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def patterns(library: str | None, as_json: bool) -> None:
    """List the standard patterns, or those of a library (a file or a folder)."""
    from i2pdsl.describe import library_patterns

    found = library_patterns(library)
    if as_json:
        output_json(found)
        return
    for number, pattern in enumerate(found):
        if number:
            output("")
        output(pattern["signature"])
        for line in str(pattern["documentation"]).splitlines():
            output(f"    {line}")
