"""`i2p study`: an experiment in one file, on a simulated panel."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from i2pdsl.commands.arguments import Numbers
from i2pdsl.output import DONE, INTERRUPTED, WRONG, check_writable, output, output_json

if TYPE_CHECKING:
    from i2pdsl.progress import Bars
    from i2pdsl.study.films import Films


@click.command()
@click.argument("study", type=click.Path())
@click.option("--out", type=click.Path(file_okay=False), help="Folder; default out/STUDY.")
@click.option("--seeds", type=Numbers("seeds"), help="Other seeds than those of the file.")
@click.option("--workers", type=click.IntRange(1, 1024), default=None, help="Processes.")
@click.option(
    "--kit", type=click.Path(file_okay=False), help="Writes a folder of pages for people instead."
)
@click.option("--each", type=click.IntRange(1, 10_000), help="Films that each of them sees; 40.")
@click.option(
    "--analyse",
    type=click.Path(),
    multiple=True,
    metavar="CSV",
    help="Analyses people's answers instead: a table, or a folder of them; several times.",
)
@click.option("--keep-all", is_flag=True, help="Those count who failed a check or stopped, too.")
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def study(
    study: str,
    out: str | None,
    seeds: list[int] | None,
    workers: int | None,
    kit: str | None,
    each: int | None,
    analyse: tuple[str, ...],
    keep_all: bool,
    as_json: bool,
) -> int:
    """Run a study on a simulated panel of viewers: what share of them sees what its films are to
    show, beside people's figures.

    Its films are made first; what is there already is not made again. With --kit they are for
    people, whose answers --analyse reads.
    """
    from i2pdsl.progress import Bars
    from i2pdsl.study.check import check_study
    from i2pdsl.study.films import Films
    from i2pdsl.study.parse import load_study, with_seeds
    from i2pdsl.sweep.planning import done_here
    from i2pdsl.untrusted import plain_name

    began = time.perf_counter()
    read = load_study(study)
    if seeds is not None:
        read = with_seeds(read, tuple(seeds))
    grounds = check_study(read)
    folder = Path(out) if out is not None else Path("out", plain_name(read.name))
    check_writable(folder)
    films = Films(read, grounds, folder)
    if kit is not None and analyse:
        raise click.UsageError("--kit and --analyse are two things, one after the other")
    if analyse:
        from i2pdsl.commands.people import analysed

        return analysed(films, [Path(place) for place in analyse], folder, keep_all, as_json)
    status = DONE
    with Bars() as bars:
        try:
            if films.missing:
                do = lambda jobs: done_here(jobs, films.folder, workers, bars.watch)
                films.make(do, bars.sweeping)
        except KeyboardInterrupt:
            status = INTERRUPTED
        if kit is not None and status == DONE and not films.wrong:
            from i2pdsl.commands.people import made_kit

            return made_kit(films, Path(kit), each, bars, as_json)
        is_judged = films.made and status == DONE and kit is None
        panels = _judged(films, folder, bars) if is_judged else []
    document = {
        "study": read.name,
        "title": read.title,
        "films": len(read.films),
        "missing": len(read.films) - films.made,
        "panels": [panel for panel, _ in panels],
        "seconds": round(time.perf_counter() - began, 3),
    }
    for place, error in films.wrong.items():
        click.echo(f"{place}: {error}", err=True)
    if kit is not None:
        click.echo("without all films there is no kit", err=True)
    if as_json:
        output_json(document)
    else:
        output("\n".join(words for _, words in panels) or films.in_words)
    if status == INTERRUPTED:
        click.echo(f"interrupted: {films.in_words}", err=True)
        click.echo("the same command goes on from there", err=True)
    return WRONG if films.wrong and status == DONE else status


def _judged(films: Films, folder: Path, bars: Bars) -> list[tuple[dict[str, Any], str]]:
    """What each panel answers, as plain data and in words; written into the folder, too."""
    from i2pdsl.resources import write_text
    from i2pdsl.study.analysis import analyse
    from i2pdsl.study.answers import panel_answers
    from i2pdsl.study.picture import draw_shares
    from i2pdsl.study.report import given_in_words, in_words
    from i2pdsl.tables import as_csv
    from i2pdsl.untrusted import plain_name

    study, found = films.study, []
    for panel in study.panels:
        answers = panel_answers(panel, films, bars.watch, bars.judging)
        shares = analyse(answers)
        name = plain_name(panel.name)
        table, picture = folder / f"answers-{name}.csv", folder / f"{name}.png"
        write_text(table, as_csv(answers.columns(lambda film: films.name(film, folder))))
        draw_shares(study, shares, f"{study.title}: {panel.label}", picture)
        document = {
            "name": panel.name,
            "label": panel.label,
            "viewers": panel.viewers,
            "circular": panel.is_usual,
            "shares": [share.as_json() for share in shares],
            "files": {"answers": str(table), "picture": str(picture)},
        }
        circular = " (circular: whom stories are told to)" if panel.is_usual else ""
        words = (
            f"{study.title}: {panel.label}, {panel.viewers} of them{circular}",
            in_words(study, shares),
            given_in_words(study, shares),
            "".join(f"  {path}\n" for path in (table, picture)),
        )
        found.append((document, "\n\n".join(words)))
    return found
