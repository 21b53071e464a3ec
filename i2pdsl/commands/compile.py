"""`i2p compile`: a folder of stories becomes a library of patterns in one file."""

from __future__ import annotations

import time
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from i2pdsl.errors import Diagnostic, StoryError, error, whole_file
from i2pdsl.folders import story_files
from i2pdsl.output import DONE, check_writable, output, output_json, show

if TYPE_CHECKING:
    from i2pdsl.library.pack import Packed


@click.command()
@click.argument("folder", type=click.Path())
@click.option("-o", "--out", "library", required=True, type=click.Path(), help="NAME.i2plib.")
@click.option("--no-programs", is_flag=True, help="Do not compile the stories' searches.")
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def compile(folder: str, library: str, no_programs: bool, as_json: bool) -> int:
    """Check the stories of a folder and pack its patterns into a library."""
    from i2pdsl.language.packed import SUFFIX, write_contents
    from i2pdsl.library.pack import pack
    from i2pdsl.untrusted import is_plain_name

    path = Path(library)
    if path.suffix != SUFFIX or not is_plain_name(path.stem):
        raise click.UsageError(f"a library is called NAME{SUFFIX}, not {path.name}")
    if not Path(folder).is_dir():
        raise error("no-file", "there is no such folder", whole_file(folder))
    check_writable(path.parent)
    began = time.perf_counter()
    packed = pack(Path(folder), story_files(folder), path.stem)
    show(packed.warnings)
    shapes: list[dict[str, Any]] = []
    traced: list[str] = []
    if not no_programs:
        shapes, traced = compile_programs(packed)
    data = write_contents(path, packed.library.contents)
    seconds = time.perf_counter() - began
    stories = len(packed.stories)
    names = list(packed.library.definitions)
    summary = {
        "library": str(path),
        "name": packed.library.name,
        "hash": f"sha256:{sha256(data).hexdigest()}",
        "patterns": names,
        "lets": len(packed.library.lets),
        "stories": stories,
        "shapes": shapes,
        "traced": len(traced),
        "bytes": len(data),
        "seconds": round(seconds, 3),
    }
    if as_json:
        output_json(summary)
        return DONE
    checked = counted(stories, "story", "stories")
    output(f"{path}: {counted(len(names), 'pattern')}, {checked} checked")
    if not no_programs:
        sharing = sum(len(s["stories"]) for s in shapes if len(s["stories"]) > 1)
        shapes_ = counted(len(shapes), "shape")
        output(f"  {shapes_} of search ({sharing} of {stories} stories share one), "
               f"{len(traced)} compiled now")  # fmt: skip
    output(f"  {len(data) / 1000:.1f} kB, {seconds:.1f} s")
    return DONE


def compile_programs(packed: Packed) -> tuple[list[dict[str, Any]], list[str]]:
    """Compiles each shape of search once, into the user's cache.

    Returns: `shape`, `world` and `stories` of each, and the shapes that had to be traced. Raises
    StoryError with the stories that cannot be searched.
    """
    from i2pdsl.progress import Bars
    from i2pdsl.search.searches import search_of
    from i2pdsl.stories import Story

    shapes: dict[str, dict[str, Any]] = {}
    problems: list[Diagnostic] = []
    traced: list[str] = []
    done = 0
    with Bars() as bars:
        try:
            for (path, typed), record in zip(packed.stories, packed.library.stories, strict=True):
                bars.compiling(done, len(packed.stories))
                try:
                    program = search_of(typed).prepare(Story(typed, path.parent).task(bars.watch))
                except StoryError as problem:
                    problems.extend(problem.diagnostics)
                    continue
                if program is not None:
                    new = {"shape": program.shape, "world": record["world"], "stories": []}
                    shapes.setdefault(program.shape, new)["stories"].append(record["file"])
                    traced += [program.shape] if program.is_new else []
                done += 1
        except KeyboardInterrupt:
            bars.say(
                f"interrupted: no library is written; {counted(len(shapes), 'shape')} "
                "of search are in the cache already"
            )
            raise
    if problems:
        raise StoryError(problems)
    return sorted(shapes.values(), key=lambda s: s["stories"]), traced


def counted(count: int, one: str, many: str | None = None) -> str:
    """`1 pattern`, `2 patterns`."""
    return f"{count} {one if count == 1 else many or one + 's'}"
