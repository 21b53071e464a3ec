"""`i2p run`: makes stories."""

from __future__ import annotations

from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from i2pdsl.commands.arguments import Assignment, Formats, Numbers
from i2pdsl.commands.inputs import load_stories
from i2pdsl.commands.pictures import draw, film_options
from i2pdsl.errors import StoryError, display_width, harmless, padded
from i2pdsl.output import (
    DONE,
    INTERRUPTED,
    WRONG,
    check_writable,
    in_words,
    output,
    output_json,
    show,
)
from i2pdsl.render.files import FORMATS, FilmLook

if TYPE_CHECKING:
    from i2pdsl.objective.panel import Judgement
    from i2pdsl.objective.wishes import Wish
    from i2pdsl.results import Choice
    from i2pdsl.stories import Script, Story

WIDE, FEW = 60, 8  # columns of a wish, and frames, that are shown of it


@click.command()
@click.argument("stories", nargs=-1, required=True, type=click.Path())
@click.option(
    "--seed",
    type=click.IntRange(0),
    default=None,
    help="Of the initial states, or a descent's first changes; default 0.",
)
@click.option("--seeds", type=Numbers("seeds"), default=None, help="Several seeds: 0-19 or 1,4,7.")
@click.option(
    "--out", type=click.Path(file_okay=False), default="out", help="Folder; default out/."
)
@click.option("--set", "settings", type=Assignment(), multiple=True, help="Replace a value.")
@click.option("--format", "formats", type=Formats(), default="png,html", help=", ".join(FORMATS))
@click.option(
    "--candidates", type=click.IntRange(1, 100), default=1, help="So many different scripts."
)
@click.option(
    "--effort",
    type=click.IntRange(1, 1000),
    default=1,
    help="About so many times the search's usual time; never a lower score. Default 1.",
)
@click.option(
    "--choose",
    type=click.Choice(["panel", "wide", "score"]),
    default="panel",
    help="Who puts candidates in order: other viewers than the story's, or its objective.",
)
@click.option("--keep", type=click.Path(), default=None, help="A script to keep frames of.")
@click.option(
    "--frames", type=Numbers("frames"), default=None, help="Those that --keep keeps: 1-5,9."
)
@click.option("--naive", is_flag=True, help="No audience: the characters do what is best for them.")
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
@film_options
def run(
    stories: tuple[str, ...],
    seed: int | None,
    seeds: list[int] | None,
    out: str,
    settings: tuple[tuple[str, str], ...],
    formats: tuple[str, ...],
    candidates: int,
    effort: int,
    choose: Choice,
    keep: str | None,
    frames: list[int] | None,
    naive: bool,
    as_json: bool,
    look: FilmLook,
) -> int:
    """Make stories: find the script, write it and its pictures."""
    if seed is not None and seeds is not None:
        raise click.UsageError("give --seed or --seeds, not both")
    chosen = seeds if seeds is not None else [seed or 0]
    several = len(stories) > 1 or len(chosen) > 1 or seeds is not None
    if (keep is None) != (frames is None):
        raise click.UsageError("--keep SCRIPT and --frames 1-5,9 belong together")
    loaded = load_stories(stories, settings)
    if keep is not None:
        loaded = [keeping(story, keep, frames or []) for story in loaded]
    folders = [Path(out) / folder_name(story.typed.name) for story in loaded]
    for folder in folders:
        if folders.count(folder) > 1:
            message = f"two stories would go into {folder}; run them with different --out"
            raise click.UsageError(message)
        check_writable(folder)
    results: list[dict[str, Any]] = []
    status, complete = DONE, 0
    for story, folder in zip(loaded, folders, strict=True):
        show(story.warnings)
        for number in chosen:
            place = folder / f"seed-{number}" if len(chosen) > 1 else folder
            try:
                result, ended = make(
                    story, number, place, formats, candidates, choose, naive, effort, look
                )
            except StoryError as problem:
                show(problem.diagnostics)
                status = WRONG
                break
            except OSError as problem:  # the disk is full
                click.echo(f"error: {in_words(problem)}", err=True)
                status = WRONG
                break
            except KeyboardInterrupt:
                click.echo(f"interrupted: nothing was found yet for {story.typed.name}", err=True)
                status = INTERRUPTED
                break
            results.append(result)
            if not as_json:
                report(result)
            status = max(status, ended)
            if ended == INTERRUPTED:
                break
            complete += 1
        if status == INTERRUPTED:
            break
    if status == INTERRUPTED and complete:
        count = len(loaded) * len(chosen)
        click.echo(f"interrupted: {complete} of {count} scripts are finished and kept", err=True)
    if as_json and (several or results):
        output_json(results if several else results[0])
    return status


def folder_name(name: str) -> str:
    """The name of a story, which is that of its file, as that of a folder: never one that leads
    elsewhere."""
    return name if name.strip(".") else "story"


def make(
    story: Story,
    seed: int,
    folder: Path,
    formats: tuple[str, ...],
    candidates: int,
    choose: Choice,
    naive: bool,
    effort: int,
    look: FilmLook,
) -> tuple[dict[str, Any], int]:
    """Solves one story and draws it; returns the document of `--json`, and the exit status.

    Raises KeyboardInterrupt if it is interrupted before anything was found.
    """
    import time

    from i2pdsl.progress import Bars

    with Bars() as bars:
        found = story.solve(seed, candidates, naive, bars.watch, choose, effort)
        chosen = found.candidates[:candidates]  # a descent found more
        parts: list[dict[str, Any]] = []
        for script, judgement in zip(chosen, found.judgements, strict=False):
            number = len(parts) + 1
            place = folder if number == 1 else folder / f"candidate-{number}"
            parts.append({**candidate(script, judgement, place), "files": {}})
            if story.typed.requirements or story.typed.pins:
                parts[-1]["unmet"] = [requirement.text for requirement in script.unmet]
        wishes: tuple[Wish, ...] = ()
        finished = found.finished
        if found.finished:
            with bars.within("what is possible"):
                wishes, finished = story.wishes(found.script, seed, naive, bars.watch)
    status = DONE if finished else INTERRUPTED
    if not found.finished:
        click.echo("interrupted: the best of what was searched so far is kept", err=True)
    elif not finished:
        click.echo("interrupted: the script is kept, not all that is possible is known", err=True)
    if len(chosen) < candidates:
        count = len(chosen)
        alike = " that differ visibly" if story.typed.vocabulary.enumerable else ""
        click.echo(f"{count} script{'s' * (count != 1)} found{alike}", err=True)
    show([requirement.missed() for requirement in found.unmet])
    show([*story.doubts(found.script), *found.script.few_particles])
    if found.script.trust is not None:
        click.echo(found.script.trust.in_words(), err=True)
    if wishes:
        click.echo(wishes_in_words(wishes), err=True)
    chosen = (replace(chosen[0], wishes=wishes), *chosen[1:])
    seconds = {"plan": 0.0, "compile": 0.0, "search": 0.0, "render": 0.0, **bars.watch.seconds}
    began = time.perf_counter()
    try:
        for number, (script, part) in enumerate(zip(chosen, parts, strict=True), 1):
            place = Path(part["script"]).parent
            title = story.typed.name + (f", candidate {number}" if candidates > 1 else "")
            status = max(status, draw([script], place, formats, part["files"], title, look))
    except KeyboardInterrupt:
        click.echo("interrupted: the script is kept, not all its pictures are drawn", err=True)
        status = INTERRUPTED
    seconds["render"] = time.perf_counter() - began
    document: dict[str, Any] = {
        "story": story.typed.name,
        "seed": seed,
        **{name: value for name, value in parts[0].items() if name != "panel"},
        "seconds": {name: round(value, 4) for name, value in seconds.items()},
        "candidates": parts,
        "wishes": [asdict(each) for each in wishes],
    }
    return document, status


def keeping(story: Story, path: str, frames: list[int]) -> Story:
    """A story with frames of a script file pinned. Raises StoryError."""
    from i2pdsl.progress import Bars
    from i2pdsl.stories import Script

    with Bars() as bars:
        script = Script.load(path, bars.watch)
    show(script.warnings)
    return story.keeping(script, frames)


def candidate(script: Script, judgement: Judgement, folder: Path) -> dict[str, Any]:
    """Writes a candidate's script into a folder; what `--json` tells of it."""
    told: dict[str, Any] = {
        "score": script.score,
        "script": str(script.save(folder / "script.json")),
        "panel": {"mean": judgement.mean, "worst": judgement.worst},
        "still": script.still,
        **({"trust": script.trust.as_json()} if script.trust is not None else {}),
    }
    if script.particles:
        told["particles"] = [asdict(each) for each in script.particles]
    return told


def wishes_in_words(wishes: tuple[Wish, ...]) -> str:
    """A short table: what was reached, what was possible, and the frames that hurt."""
    rows = [("wish", "reached", "possible", "frames that hurt it")]
    for each in wishes:
        possible = "unknown" if each.possible is None else f"{each.possible:.5g}"
        few = [str(t) for t in each.frames[:FEW]] + ["..."] * (len(each.frames) > FEW)
        source = harmless(each.source)
        source = source if len(source) <= WIDE else source[: WIDE - 1] + "…"
        rows.append((source, f"{each.reached:.5g}", possible, ", ".join(few) or "none"))
    widths = [max(map(display_width, column)) for column in zip(*rows, strict=True)]
    return "\n".join(
        "  ".join(padded(cell, width, right=0 < i < 3) for i, (cell, width) in cells).rstrip()
        for cells in (enumerate(zip(row, widths, strict=True)) for row in rows)
    )


def report(result: dict[str, Any]) -> None:
    """A result for people: where everything is."""
    from i2pdsl.objective.effective import Effective

    for part in result["candidates"]:
        score = "unknown" if part["score"] is None else f"{part['score']:.6g}"
        mean, worst = part["panel"]["mean"], part["panel"]["worst"]
        told = f"panel {mean:.6g} (worst {worst:.6g}), still {100 * part['still']:.0f} %"
        output(f"{result['story']} (seed {result['seed']}): score {score}, {told}")
        for each in part.get("particles", ()):
            output(f"  {Effective(**each).words}")
        for path in (part["script"], *part["files"].values()):
            output(f"  {path}")
