"""`i2p train`: trains the controllers of a physics world."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Any

import click

from i2pdsl.commands.arguments import Assignment, complete_world
from i2pdsl.commands.inputs import spec_of
from i2pdsl.computing import computing
from i2pdsl.errors import error, whole_file
from i2pdsl.output import DONE, INTERRUPTED, check_writable, output, output_json


@click.command()
@click.argument("world", shell_complete=complete_world)
@click.option(
    "--seed",
    type=click.IntRange(0, 2**31 - 2),
    default=None,
    help="Default: the world's `controller`.",
)
@click.option("--set", "settings", type=Assignment(), multiple=True, help="Of the world.")
@click.option("--iterations", type=click.IntRange(1), default=None, help="Default 2400.")
@click.option("--out", type=click.Path(file_okay=False), help="Folder; default: the cache.")
@click.option("--restart", is_flag=True, help="Do not go on from an interrupted training.")
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def train(
    world: str,
    seed: int | None,
    settings: tuple[tuple[str, str], ...],
    iterations: int | None,
    out: str | None,
    restart: bool,
    as_json: bool,
) -> int:
    """Train the controllers of a physics world and store them.

    Ctrl-C keeps the best so far; the same command goes on from there.
    """
    from i2pdsl.worlds.kinds import kind_of

    spec = spec_of(world)
    kind = kind_of(spec)
    spec = spec.with_settings(world_settings(spec, settings, kind.training_settings(spec)))
    if out is not None:
        check_writable(Path(out))
    from i2pdsl.progress import Bars

    with Bars() as bars, computing(bars.say):
        try:
            done = kind.train(spec, seed, iterations, out, restart, bars.watch)
        except KeyboardInterrupt:
            bars.say("interrupted before there was anything to keep")
            return INTERRUPTED
    if not done.finished:
        click.echo("interrupted: the best so far is kept; the same command goes on", err=True)
    if as_json:
        output_json(done.document)
    else:
        output(done.words)
    return DONE if done.finished else INTERRUPTED


def world_settings(
    spec: Any, given: tuple[tuple[str, str], ...], usable: tuple[str, ...]
) -> dict[str, Any]:
    """The values of `--set` for a world, of the settings that matter. Raises StoryError."""
    from i2pdsl.errors import did_you_mean
    from i2pdsl.worlds.find import vocabulary_of

    known = vocabulary_of(spec).settings
    found: dict[str, Any] = {}
    for name, text in given:
        where = whole_file(f"--set {name}")
        if name not in known:
            hint = did_you_mean(name, known) or "settings: " + ", ".join(usable)
            raise error("setting", f"`world {spec.name}` has no setting `{name}`", where, hint)
        if name not in usable:
            message = f"training does not depend on `{name}`"
            raise error("setting", message, where, "settings: " + ", ".join(usable))
        value: Any = text
        with suppress(ValueError):
            value = float(text)
        if text.startswith("{") and text.endswith("}"):
            with suppress(ValueError):
                value = tuple(float(part) for part in text[1:-1].split(","))
        if not known[name].holds(value):
            message = f"`{name}` cannot be {text}"
            raise error("setting", message, where, f"it can be: {known[name].possible}")
        found[name] = value
    return found
