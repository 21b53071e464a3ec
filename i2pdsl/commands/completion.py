"""`i2p completion`: how shells complete `i2p`."""

from __future__ import annotations

import click


@click.command()
@click.argument("shell", type=click.Choice(["bash", "zsh", "fish"]))
def completion(shell: str) -> None:
    """Print the completion script of a shell: eval "$(i2p completion bash)"."""
    from click.shell_completion import get_completion_class

    kind = get_completion_class(shell)
    assert kind is not None
    from i2pdsl.commands.program import program

    click.echo(kind(program, {}, "i2p", "_I2P_COMPLETE").source())
