"""The commands of `i2p`, each a module beside this one, and what is said of what goes wrong."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from importlib import import_module

import click

from i2pdsl.computing import NoComputing
from i2pdsl.errors import StoryError
from i2pdsl.output import (
    DONE,
    INTERRUPTED,
    USAGE,
    WRONG,
    forget_output,
    in_words,
    show,
)

COMMANDS = (
    "new",
    "run",
    "render",
    "sheet",
    "check",
    "fmt",
    "query",
    "script",
    "sample",
    "sweep",
    "explain",
    "fit",
    "study",
    "repl",
    "studio",
    "worlds",
    "patterns",
    "compile",
    "extract",
    "plan",
    "train",
    "lsp",
    "completion",
)


def run_command(arguments: list[str] | None = None) -> int:
    """Runs one command; returns the exit status."""
    if "_I2P_COMPLETE" in os.environ:
        program.main(prog_name="i2p")  # a shell asks how the line may go on; exits
    arguments = sys.argv[1:] if arguments is None else arguments
    try:
        with program.make_context("i2p", list(arguments)) as context:
            result = program.invoke(context)
        return result if isinstance(result, int) else DONE
    except click.exceptions.Exit as leaving:
        return leaving.exit_code
    except StoryError as problem:
        show(problem.diagnostics)
        return WRONG
    except (click.Abort, KeyboardInterrupt):
        with suppress(OSError):
            click.echo("interrupted", err=True)
        return INTERRUPTED
    except click.ClickException as problem:
        problem.show()
        return USAGE
    except NoComputing as problem:
        click.echo(f"error: {problem}", err=True)
        return WRONG
    except BrokenPipeError:
        forget_output()  # whoever read our output has had enough
        return DONE
    except (OSError, MemoryError) as problem:
        forget_output()
        with suppress(OSError):
            click.echo(f"error: {in_words(problem)}", err=True)
        return WRONG


class Commands(click.Group):
    """The commands, each imported when it is asked for."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        return command_named(cmd_name) if cmd_name in COMMANDS else None


def command_named(name: str) -> click.Command:
    """A command: the function of the same name in the module of the same name."""
    return getattr(import_module(f"i2pdsl.commands.{name}"), name)


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="i2pdsl", prog_name="i2p")
def program() -> None:
    """Stories told to a simulated audience, by inverse inverse planning."""
