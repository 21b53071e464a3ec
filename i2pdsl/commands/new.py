"""`i2p new`: a story and a world to begin with."""

from __future__ import annotations

import shlex
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from i2pdsl.commands.arguments import KindOfWorld, complete_world
from i2pdsl.errors import harmless
from i2pdsl.output import check_writable, output, output_json

if TYPE_CHECKING:
    from i2pdsl.beginnings.write import Place


def complete_pattern(ctx: Any, param: Any, incomplete: str) -> list[str]:
    """Shell completion: the ways to begin."""
    from i2pdsl.beginnings.table import table

    names = dict.fromkeys(b.name for each in table().values() for b in each.ways)
    return [name for name in names if name.startswith(incomplete)]


@click.command()
@click.argument("story", required=False, default="my.story", type=click.Path(dir_okay=False))
@click.option(
    "--pattern",
    default=None,
    shell_complete=complete_pattern,
    help="What it tells: betrayal, irony, legible, ... or a standard pattern; default help.",
)
@click.option("--kind", type=KindOfWorld(), default=None, help="Of the world that is written.")
@click.option(
    "--world",
    default=None,
    shell_complete=complete_world,
    help="A world that there is already; then none is written.",
)
@click.option("--length", type=click.IntRange(1, 100_000), default=None, help="Frames.")
@click.option(
    "--list", "only_list", is_flag=True, help="Tell the ways to begin, and write nothing."
)
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def new(
    story: str,
    pattern: str | None,
    kind: str | None,
    world: str | None,
    length: int | None,
    only_list: bool,
    as_json: bool,
) -> None:
    """Write a story, and a world of its own, to begin with. Nothing is ever overwritten."""
    if only_list:
        tell_beginnings(kind, as_json)
        return
    if kind is not None and world is not None:
        raise click.UsageError("--world names a world that has its kind: leave out --kind")
    from i2pdsl.beginnings.write import story_text
    from i2pdsl.resources import write_text

    path = story_path(story)
    place, text_of_world = place_of(path, pattern, kind, world)
    world_path = path.with_suffix(".world")
    files = [path] if text_of_world is None else [world_path, path]
    for file in files:
        if file.exists() or file.is_symlink():
            raise taken(file, path)
    text = story_text(str(path), chosen(pattern, place), place, length)
    check_writable(path.parent)
    try:
        if text_of_world is not None:
            write_text(world_path, text_of_world, new=True)
        try:
            write_text(path, text, new=True)
        except BaseException:
            if text_of_world is not None:
                with suppress(OSError):
                    world_path.unlink()
            raise
    except FileExistsError as problem:
        raise taken(Path(str(problem.filename)), path) from None
    if as_json:
        written = None if text_of_world is None else str(world_path)
        output_json({"story": str(path), "world": place.name, "world_file": written})
        return
    for file in reversed(files):
        output(str(file))
    named = shlex.quote(str(path))
    click.echo(harmless(f"next: i2p run {named}; then change what you like"), err=True)


def story_path(name: str) -> Path:
    """The path that a story's name means. Raises StoryError where no file should be called so."""
    from i2pdsl.errors import error, shorten, whole_file
    from i2pdsl.untrusted import is_plain_name

    path = Path(name)
    if path.suffix != ".story":
        path = path.with_name(f"{path.name}.story") if path.name else path
    if path.suffix != ".story" or not is_plain_name(path.stem) or Path(name).suffix == ".world":
        hint = "a story is called NAME.story; its world NAME.world comes along"
        message = f"no story can be called `{shorten(path.name or name)}`"
        raise error("name", message, whole_file(shorten(name)), hint)
    return path


def place_of(
    path: Path, pattern: str | None, kind: str | None, world: str | None
) -> tuple[Place, str | None]:
    """The world of a new story, and its text where it is new too. Raises StoryError."""
    from i2pdsl.beginnings.table import table
    from i2pdsl.beginnings.write import Place, kind_of_beginning, named, new_world
    from i2pdsl.errors import did_you_mean, error, shorten, whole_file
    from i2pdsl.language.check import known_worlds
    from i2pdsl.worlds.find import builtin_worlds, find_spec

    found = named(pattern, kind) if pattern is not None else None
    known = table()
    kind = kind or (kind_of_beginning(found) if found is not None else next(iter(known)))
    template = known[kind].template
    if world is None and template is not None:
        if path.stem in builtin_worlds() or '"' in path.stem:
            message = f"its world would be called `{path.stem}`"
            message += (
                " as one that is built in" if '"' not in path.stem else ", which nothing can name"
            )
            hint = "take another name, or name a world: --world kitchen"
            raise error("name", message, whole_file(str(path)), hint)
        return new_world(template, path.stem)
    name = known[kind].world if world is None else world
    spec = find_spec(name, path.parent)
    if spec is None:
        near = did_you_mean(name.removesuffix(".world"), known_worlds(path.parent))
        message = f"there is no world `{shorten(name)}`"
        raise error("no-world", message, whole_file(f"--world {shorten(name)}"), near)
    return Place(name, spec), None


def chosen(pattern: str | None, place: Place) -> Any:
    """What the story begins as. Raises StoryError."""
    from i2pdsl.beginnings.write import beginning_in
    from i2pdsl.commands.patterns import open_library

    return beginning_in(pattern, place, lambda: open_library(None, with_stories=False)[0])


def taken(file: Path, story: Path) -> Exception:
    """The mistake that a file is there already, with a name that is free."""
    from i2pdsl.errors import error, whole_file

    stem = story.stem
    names = (story.with_name(f"{stem}-{number}.story") for number in range(2, 1000))
    free = next(n for n in names if not n.exists() and not n.with_suffix(".world").exists())
    message = "there is such a file already, and nothing is overwritten"
    return error("taken", message, whole_file(str(file)), f"a name that is free: {free}")


def tell_beginnings(kind: str | None, as_json: bool) -> None:
    """Lists the ways to begin, told in the worlds that are written for them."""
    from i2pdsl.beginnings.table import table

    rows: list[dict[str, str]] = []
    known = table()
    for of_kind in (kind,) if kind else known:
        roles = place_of(Path("my.story"), None, of_kind, None)[0].roles
        rows += [
            {"name": b.name, "kind": of_kind, "pattern": b.pattern, "told": b.told.format(**roles)}
            for b in known[of_kind].ways
        ]
    if as_json:
        output_json(rows)
        return
    for number, row in enumerate(rows):
        if not number or rows[number - 1]["kind"] != row["kind"]:
            output(f"--kind {row['kind']}")
        output(f"  {row['name']:<15} {row['told']}")
    output("and every pattern that `i2p patterns` tells of")
