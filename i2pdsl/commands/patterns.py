"""`i2p patterns`: what patterns there are, and an illustrated catalogue of them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from i2pdsl.folders import story_files
from i2pdsl.output import DONE, INTERRUPTED, check_writable, output, output_json, show

if TYPE_CHECKING:
    from i2pdsl.library.description import PatternLibrary


@click.command()
@click.argument("library", required=False, type=click.Path())
@click.option("--page", type=click.Path(file_okay=False), help="Write a catalogue to this folder.")
@click.option(
    "--world", "worlds", multiple=True, help="Of the catalogue's examples; kitchen and hill."
)
@click.option(
    "--seeds",
    type=click.IntRange(1, 100),
    default=3,
    help="Of which the catalogue shows the best; default 3.",
)
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def patterns(
    library: str | None, page: str | None, worlds: tuple[str, ...], seeds: int, as_json: bool
) -> int:
    """List the standard patterns, or those of a library (.i2plib, a file or a folder)."""
    opened, place = open_library(library, with_stories=page is not None)
    if page is not None:
        return catalogue(opened, Path(page), list(worlds or catalogued()), seeds, as_json)
    from i2pdsl.library.examples import gallery_files
    from i2pdsl.library.fits import NOT_TRIED, was_tried

    pictures = {path.stem: str(path) for path in gallery_files(place)}
    found = [described(p, place, pictures) for p in opened.patterns]
    untried = [p["name"] for p in opened.patterns if not was_tried(p)]
    if untried:
        message = f"it is not known of {len(untried)} of them which worlds they fit: {NOT_TRIED}"
        click.echo(message, err=True)
    if as_json:
        output_json(found)
        return DONE
    for number, pattern in enumerate(found):
        if number:
            output("")
        output(pattern["signature"])
        for line in in_words(pattern, pattern["name"] not in untried):
            output(f"    {line}")
    if not pictures:
        click.echo("no pictures yet: `i2p patterns --page FOLDER` draws a catalogue", err=True)
    return DONE


def catalogued() -> list[str]:
    """The worlds of a catalogue's examples, if none is named."""
    from i2pdsl.worlds.kinds import KINDS, kind_named

    return [world for name in KINDS for world in kind_named(name).catalogued]


def open_library(library: str | None, with_stories: bool) -> tuple[PatternLibrary, Path]:
    """The library, and the file or folder that it is. Raises StoryError.

    The standard patterns are packed from their files, with their stories if they are asked for.
    """
    from i2pdsl.language.imports import read_library
    from i2pdsl.language.packed import SUFFIX
    from i2pdsl.library.description import PatternLibrary
    from i2pdsl.library.pack import pack
    from i2pdsl.resources import data_folder
    from i2pdsl.untrusted import plain_name

    if library is not None and library.endswith(SUFFIX):
        place = Path(library)
        return PatternLibrary(plain_name(place.stem), read_library(place)), place
    stories = data_folder("stories")
    place = Path(library) if library is not None else stories / "patterns"
    if library is None and with_stories:
        return pack(stories, story_files(str(stories)), "standard").library, stories
    folder = place if place.is_dir() else place.parent
    name = "standard" if library is None else plain_name(place.resolve().stem)
    packed = pack(folder, story_files(str(place)), name)
    show(packed.warnings)
    return packed.library, place


def described(pattern: dict[str, Any], place: Path, pictures: dict[str, str]) -> dict[str, Any]:
    """A pattern as plain data; `worlds` are those that it fits."""
    from i2pdsl.library.examples import picture_name

    folder = place if place.is_dir() or place.suffix == ".i2plib" else place.parent
    drawn = {world: picture_name(pattern["name"], world) for world in pattern["worlds"]}
    return {
        "name": pattern["name"],
        "signature": pattern["signature"],
        "documentation": pattern["documentation"],
        "body": pattern["body"],
        "file": str(folder / pattern["file"]),
        "parameters": pattern["parameters"],
        "result": pattern["result"],
        "worlds": [world for world, proof in pattern["worlds"].items() if proof["fits"]],
        "examples": pattern["examples"],
        "pictures": {world: pictures[n] for world, n in drawn.items() if n in pictures},
    }


def in_words(pattern: dict[str, Any], is_tried: bool) -> list[str]:
    """What is said below a pattern's signature."""
    lines = str(pattern["documentation"]).splitlines()
    kinds = [f"{p['name']}: {p['kind']}" for p in pattern["parameters"]]
    lines += [", ".join(kinds)] if kinds else []
    rest = "" if is_tried else "; other worlds were not tried"
    lines.append(f"fits {', '.join(pattern['worlds']) or 'no world that is known here'}{rest}")
    return lines + [f"picture: {path}" for path in pattern["pictures"].values()]


def catalogue(
    library: PatternLibrary, folder: Path, worlds: list[str], seeds: int, as_json: bool
) -> int:
    """Makes the examples that are not there yet; the pages are there from the first on."""
    from i2pdsl.library.catalogue import save_catalogue
    from i2pdsl.library.examples import Gallery, examples_of, make_all
    from i2pdsl.progress import Bars

    check_writable(folder)
    with Bars() as bars:
        gallery = Gallery(folder, library, bars.say, seeds)
        examples = {p["name"]: examples_of(library, p, worlds) for p in library.patterns}
        every = [example for found in examples.values() for example in found]
        there = sum(gallery.kept(example) is not None for example in every)
        shown, failed, finished = make_all(
            gallery,
            every,
            bars,
            lambda shown, failed: save_catalogue(folder, library, examples, shown, failed, seeds),
        )
    page = folder / "index.html"
    for name, why in failed.items():
        click.echo(f"warning: {name} could not be made: {why}", err=True)
    if not finished:
        message = f"interrupted: the page has the {len(shown)} of {len(every)} examples made so far"
        click.echo(message, err=True)
    if as_json:
        output_json(
            {
                "page": str(page),
                "patterns": len(library.patterns),
                "examples": len(shown),
                "made": len(shown) - there,
                "failed": failed,
            }
        )
    else:
        count = len(library.patterns)
        output(f"{page}: {count} pattern{'s' * (count != 1)}, {len(shown)} examples, "
               f"{len(shown) - there} of them made now")  # fmt: skip
    return DONE if finished else INTERRUPTED
