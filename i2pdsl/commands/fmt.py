"""`i2p fmt`: one way to write a story."""

from __future__ import annotations

import re
import sys

import click

from i2pdsl.folders import written_files
from i2pdsl.output import DONE, WRONG

_MAP = re.compile(r"^map\b", re.MULTILINE)  # every world has one, or says its kind; no story does


@click.command()
@click.argument("paths", nargs=-1, required=True, type=click.Path(allow_dash=True))
@click.option("--check", "only_check", is_flag=True, help="Change nothing; status 1 if it would.")
def fmt(paths: tuple[str, ...], only_check: bool) -> int:
    """Format stories, worlds and studies in place ('-': from standard input to standard output)."""
    from i2pdsl.language.format import format_source
    from i2pdsl.language.statements import LARGEST_TEXT, decode, read_data
    from i2pdsl.resources import write_text
    from i2pdsl.study.parse import SYNTAX
    from i2pdsl.worlds.blocks import kind_said
    from i2pdsl.worlds.kinds import format_world

    forms = {".world": format_world, ".study": SYNTAX.formatted}
    status = DONE
    for path in paths:
        if path == "-":
            source = decode(sys.stdin.buffer.read(), "standard input")
            is_world = _MAP.search(source.text) or kind_said(source)
            form = format_world if is_world else format_source
            click.echo(form(source), nl=False)
            continue
        for file in written_files(path):
            form = forms.get(file.suffix, format_source)
            data = read_data(file, LARGEST_TEXT)
            text = form(decode(data, str(file)))
            if data == text.encode():
                continue
            click.echo(str(file))
            if only_check:
                status = WRONG
            else:
                write_text(file, text)
    return status
