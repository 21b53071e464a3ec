"""Studies with people: `i2p study --kit` and `i2p study --analyse`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from i2pdsl.output import DONE, WRONG, check_writable, output, output_json

if TYPE_CHECKING:
    from collections.abc import Sequence

    from i2pdsl.progress import Bars
    from i2pdsl.study.films import Films


def made_kit(films: Films, folder: Path, each: int | None, bars: Bars, as_json: bool) -> int:
    """Writes the pages for people."""
    from i2pdsl.study.kit import write_kit
    from i2pdsl.study.practice import practice_scripts

    check_writable(folder)
    scripts = {film: films.path(film) for film in films.study.films}
    there = {film: path for film, path in scripts.items() if path is not None}
    practice = practice_scripts(films, bars.watch)
    kit = write_kit(folder, films.study, there, practice, each)
    page = kit.public / "index.html"
    if as_json:
        output_json(
            {
                "kit": str(kit.folder),
                "page": str(page),
                "films": kit.films,
                "each": kit.each,
                "lists": kit.lists,
            }
        )
    else:
        output(
            f"{kit.films} films, of which each participant sees {kit.each} "
            f"{'pairs' if films.study.pairs else ''}".rstrip()
        )
        output(f"  {page}\n  {kit.folder / 'README.txt'} says what to do with it")
    return DONE


def analysed(
    films: Films, places: Sequence[Path], folder: Path, keep_all: bool, as_json: bool
) -> int:
    """Reads people's answers and tells what they come to; writes the table and the picture."""
    from i2pdsl.computing import computing
    from i2pdsl.resources import write_text
    from i2pdsl.study import analyse as people
    from i2pdsl.study.analysis import analyse
    from i2pdsl.study.people import collect, tables_in
    from i2pdsl.study.picture import draw_shares
    from i2pdsl.tables import as_csv

    study = films.study
    own = {path.resolve(): film for film in study.films if (path := films.path(film))}
    known = lambda path: own.get(path.resolve())
    collected = collect(study, tables_in(places), known, keep_all, films.grounds)
    shares = analyse(collected.answers)
    p = people.p_by_people(collected.answers, shares)
    model = None
    if people.mixed_matters(collected.answers):
        with computing():
            model = people.mixed(collected.answers, shares)
    table, picture = folder / "answers.csv", folder / "people.png"
    write_text(table, as_csv(people.joined(collected, folder)))
    count = len(collected.answers.participants)
    draw_shares(study, shares, f"{study.title}: {count} people", picture)
    if as_json:
        files = {"answers": str(table), "picture": str(picture)}
        output_json(people.as_json(collected, shares, p, model) | {"files": files})
    else:
        output(people.told(collected, shares, p, model))
        output(f"\n  {table}\n  {picture}")
    if model is not None and not model.has_converged:
        told = f"R-hat {model.rhat:.3f}, {model.ess:.0f} effective draws"
        click.echo(f"the mixed-effects model has not converged: {told}", err=True)
        return WRONG
    return DONE
