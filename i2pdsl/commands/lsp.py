"""`i2p lsp`: mistakes, completion and documentation for editors."""

from __future__ import annotations

import click

from i2pdsl.output import DONE, WRONG

_EXTRA = ("pygls", "lsprotocol", "cattrs", "attrs", "attr")


@click.command()
@click.option("--stdio", is_flag=True, help="What it does anyway; some editors always say it.")
def lsp(stdio: bool) -> int:
    """Serve an editor over standard input and output (the language server protocol)."""
    try:
        from i2pdsl.editor.server import serve
    except ModuleNotFoundError as missing:
        if (missing.name or "").split(".")[0] not in _EXTRA:
            raise
        click.echo("error: the language server needs pygls: pip install 'i2pdsl[lsp]'", err=True)
        return WRONG
    serve()
    return DONE
