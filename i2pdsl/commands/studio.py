"""`i2p studio`: stories made by hand, in the browser."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from i2pdsl.output import DONE, WRONG

_EXTRA = (
    *("starlette", "uvicorn", "websockets", "anyio", "h11"),
    *("pygls", "lsprotocol", "cattrs", "attrs", "attr"),
)
LOCAL = "127.0.0.1"


@click.command()
@click.argument("place", default=".", type=click.Path(), metavar="[FOLDER_OR_STORY]")
@click.option(
    "--port", type=click.IntRange(1, 65_535), default=None, help="Default: the first that is free."
)
@click.option("--no-browser", is_flag=True, help="Only print the address.")
@click.option("--host", default=LOCAL, help="Another address to listen at; see --i-know.")
@click.option(
    "--i-know",
    is_flag=True,
    help="Listen where other machines can connect: whoever learns the address may read and change "
    "the folder, and nothing is encrypted.",
)
def studio(place: str, port: int | None, no_browser: bool, host: str, i_know: bool) -> int:
    """Write, draw, pin and watch stories in the browser. The address is printed first; Ctrl-C ends
    it."""
    folder, start = _place(place)
    try:
        from i2pdsl.studio.serve import is_loopback, serve
    except ModuleNotFoundError as missing:
        if (missing.name or "").split(".")[0] not in _EXTRA:
            raise
        click.echo("error: the studio needs more: pip install 'i2pdsl[studio]'", err=True)
        return WRONG
    if not is_loopback(host) and not i_know:
        message = f"at {host} other machines can connect: whoever learns the studio's address may "
        message += "read and change the folder, and nothing is encrypted"
        raise click.UsageError(f"{message}; if you want that, add --i-know")
    if host in ("0.0.0.0", "::"):
        message = "name the address that the others use: pages of every other one are refused"
        raise click.UsageError(message)

    def ready(address: str) -> None:
        click.echo(address)
        sys.stdout.flush()
        if not no_browser:
            import threading
            import webbrowser

            # Some browsers return when they are closed.
            threading.Thread(target=webbrowser.open, args=(address,), daemon=True).start()

    try:
        serve(folder, start, host, port, ready)
    except KeyboardInterrupt:  # the usual end
        click.echo("the studio is closed", err=True)
    return DONE


def _place(place: str) -> tuple[Path, str | None]:
    """The folder, and the file of it that is opened first."""
    path = Path(place)
    if path.is_dir():
        return path, None
    if path.suffix not in (".story", ".world"):
        raise click.UsageError(f"{place}: no folder, story or world")
    if not path.parent.is_dir():
        raise click.UsageError(f"{path.parent}: there is no such folder")
    return path.parent, path.name
