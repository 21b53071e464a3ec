"""`i2p sample`: scripts of characters who act under hypotheses, and how well these are inferred."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from i2pdsl.commands.arguments import Assignment
from i2pdsl.commands.inputs import load_story
from i2pdsl.errors import display_width, padded
from i2pdsl.output import check_writable, output, output_json, show

if TYPE_CHECKING:
    from i2pdsl.sampling import Confusion

MOST = 100_000


@click.command()
@click.argument("story", type=click.Path())
@click.option("--given", default=None, help="A condition on the hypotheses that are drawn.")
@click.option("--assume", default=None, help="Another assumption; 'nothing' drops it.")
@click.option(
    "-n", "count", type=click.IntRange(1, MOST), default=100, help="Scripts; default 100."
)
@click.option("--seed", type=click.IntRange(0), default=0, help="Of all that is drawn.")
@click.option("--set", "settings", type=Assignment(), multiple=True, help="Replace a value.")
@click.option("--out", type=click.Path(file_okay=False), help="Default out/STORY/samples.")
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def sample(
    story: str,
    given: str | None,
    assume: str | None,
    count: int,
    seed: int,
    settings: tuple[tuple[str, str], ...],
    out: str | None,
    as_json: bool,
) -> None:
    """Let the characters act under hypotheses that are drawn, and tell how well they are inferred.

    Writes the scripts and samples.csv, a row for each.
    """
    from i2pdsl.progress import Bars
    from i2pdsl.resources import write_text
    from i2pdsl.tables import as_csv
    from i2pdsl.untrusted import plain_name

    told = load_story(story, settings)
    folder = Path("out") / plain_name(told.typed.name) / "samples" if out is None else Path(out)
    check_writable(folder)
    show(told.warnings)
    with Bars() as bars:
        found = told.sample(count, given, seed, assume, bars.watch)
        digits = len(str(count - 1))
        names = [f"{number:0{digits}}.json" for number in range(count)]
        for number, (script, name) in enumerate(zip(found.scripts, names, strict=True), 1):
            script.save(folder / name)
            bars.saving(number, count)
    table = folder / "samples.csv"
    write_text(table, as_csv({**found.columns(), "script": names}))
    confusions = {latent: found.confusion(latent) for latent in found.latents}
    if not as_json:
        output("\n\n".join(in_words(latent, each) for latent, each in confusions.items()))
        output(f"\n{count} scripts of {told.typed.name} (seed {seed})\n  {table}")
        return
    matrices = {
        latent: {
            "drawn": list(each.drawn),
            "believed": list(each.believed),
            "counts": each.counts.tolist(),
            "right": each.right,
        }
        for latent, each in confusions.items()
    }
    about = {"story": told.typed.name, "seed": seed, "given": given, "n": count}
    output_json({**about, "table": str(table), "confusion": matrices})


def in_words(latent: str, confusion: Confusion) -> str:
    """A confusion matrix, with what its rows and columns are."""
    heads = (latent, *confusion.believed)
    rows = [
        (name, *map(str, counts))
        for name, counts in zip(confusion.drawn, confusion.counts, strict=True)
    ]
    widths = [max(map(display_width, column)) for column in zip(heads, *rows, strict=True)]
    lines = [
        "  ".join(
            padded(cell, width, right=i > 0)
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        )
        for row in (heads, *rows)
    ]
    told = "rows: the truth that was drawn; columns: what is most believed at the end"
    return "\n".join(
        (told, *lines, f"most believed at the end is the truth in {confusion.right:.1%}")
    )
