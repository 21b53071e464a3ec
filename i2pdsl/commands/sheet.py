"""`i2p sheet`: the candidates of a story side by side."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from i2pdsl.commands.arguments import Assignment
from i2pdsl.commands.inputs import load_story
from i2pdsl.commands.pictures import warn
from i2pdsl.commands.run import candidate, folder_name
from i2pdsl.output import DONE, INTERRUPTED, check_writable, output, output_json, show

if TYPE_CHECKING:
    from i2pdsl.objective.panel import Judgement
    from i2pdsl.results import Choice
    from i2pdsl.stories import Script


@click.command()
@click.argument("story", type=click.Path())
@click.option(
    "--candidates", type=click.IntRange(1, 24), default=6, help="At most so many; default 6."
)
@click.option("--seed", type=click.IntRange(0), default=0, help="As for i2p run; default 0.")
@click.option("--out", type=click.Path(file_okay=False), help="Folder; default out/STORY.")
@click.option("--set", "settings", type=Assignment(), multiple=True, help="Replace a value.")
@click.option(
    "--choose",
    type=click.Choice(["panel", "wide", "score"]),
    default="panel",
    help="Who puts candidates in order, as for i2p run.",
)
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def sheet(
    story: str,
    candidates: int,
    seed: int,
    out: str | None,
    settings: tuple[tuple[str, str], ...],
    choose: Choice,
    as_json: bool,
) -> int:
    """Make a story's candidates and draw them side by side: sheet.png, and sheet.html, which plays
    them together."""
    from i2pdsl.progress import Bars

    loaded = load_story(story, settings)
    name = loaded.typed.name
    folder = Path(out) if out is not None else Path("out", folder_name(name))
    check_writable(folder)
    show(loaded.warnings)
    with Bars() as bars:
        found = loaded.solve(seed, candidates, watch=bars.watch, choose=choose)
    status = DONE if found.finished else INTERRUPTED
    if status == INTERRUPTED:
        click.echo("interrupted: the best of what was searched so far is kept", err=True)
    chosen = found.candidates[:candidates]  # a descent found more
    if len(chosen) < candidates:
        click.echo(f"{len(chosen)} script{'s' * (len(chosen) != 1)} found", err=True)
    told: list[dict[str, Any]] = []
    labelled = []
    for number, (script, judgement) in enumerate(zip(chosen, found.judgements, strict=False), 1):
        told.append(candidate(script, judgement, folder / f"candidate-{number}"))
        labelled.append(_labelled(script, label(number, script, judgement)))
    title = f"{name}: candidates, seed {seed}"
    if len(labelled) == 1:
        title = f"{name}, seed {seed}: {labelled[0].record.title}"
    files = _drawn(labelled, folder, title)
    if as_json:
        output_json({"story": name, "seed": seed, "candidates": told, "files": files})
    else:
        for path in files.values():
            output(path)
    return status


def label(number: int, script: Script, judgement: Judgement) -> str:
    """A candidate's number, its score, and what the panel makes of it."""
    score = "unknown" if script.score is None else f"{script.score:.4g}"
    panel = f"panel {judgement.mean:.4g} (worst {judgement.worst:.4g})"
    return f"{number}: score {score}, {panel}"


def _labelled(script: Script, name: str) -> Script:
    """A script that is called otherwise in pictures."""
    record = replace(script.record, story={**script.record.story, "name": name})
    return replace(script, record=record)


def _drawn(scripts: list[Script], folder: Path, title: str) -> dict[str, str]:
    from i2pdsl.render.fonts import noting
    from i2pdsl.render.pictures import drawing_for
    from i2pdsl.render.raster import save_png
    from i2pdsl.resources import write_text

    with noting(warn):
        pictures = drawing_for(scripts[0].world.spec).sheet(scripts, title)
        png, page = folder / "sheet.png", folder / "sheet.html"
        save_png(png, pictures.comic())
        if "html" not in pictures.offered:  # nothing there can be played
            return {"png": str(png)}
        write_text(page, pictures.page())
    return {"png": str(png), "html": str(page)}
