"""`i2p query`: one question to a finished script, or many to many."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from i2pdsl.commands.inputs import script_or_story
from i2pdsl.commands.tables import write_table
from i2pdsl.errors import whole_file
from i2pdsl.folders import script_files
from i2pdsl.output import DONE, output, output_json, show

if TYPE_CHECKING:
    from i2pdsl.questions import Askable, Table

HOW = 'give a script and a question: i2p query SCRIPT "P(...)"; of several scripts, --ask "P(...)"'


@click.command()
@click.argument("sources", metavar="SCRIPT... [EXPRESSION]", nargs=-1, type=click.Path())
@click.option("--ask", "questions", multiple=True, help="A question to all scripts: a table.")
@click.option("--assume", default=None, help="Another assumption; 'nothing' drops it.")
@click.option(
    "--audience", "audiences", multiple=True, help="Other viewers; with --ask also several."
)
@click.option("--seed", type=click.IntRange(0), default=0, help="Where a story is given.")
@click.option("--out", type=click.Path(dir_okay=False), help="Where the table goes: .csv or .json.")
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def query(
    sources: tuple[str, ...],
    questions: tuple[str, ...],
    assume: str | None,
    audiences: tuple[str, ...],
    seed: int,
    out: str | None,
    as_json: bool,
) -> int:
    """Evaluate an expression over a finished script, or over a story that is solved first.

    With --ask, all questions are asked of all SCRIPTs (folders hold scripts, too) before all
    audiences, and the answers are one table.
    """
    audiences = tuple(map(_quoted, audiences))
    if questions and sources:
        return _table(sources, questions, assume, audiences, seed, out, as_json)
    is_one = len(sources) == 2 and len(audiences) < 2 and out is None
    if not is_one or Path(sources[0]).is_dir():
        raise click.UsageError(HOW)
    source, expression = sources
    script, status = script_or_story(source, seed)
    from i2pdsl.progress import Bars

    with Bars() as bars:
        if audiences:
            script = script.seen_by(audiences[0], bars.watch)
        checked = script.check(expression, assume)
        answer = script.answer(checked, bars.watch)
        trust = answer.trust
    show(checked.warnings)
    if trust is not None:
        show(trust.warnings(whole_file("query")))
    if as_json:
        document = {"expr": expression, "t": answer.t, "value": answer.as_json()}
        if script.particles:
            document["particles"] = [asdict(each) for each in script.particles]
        if trust is not None:
            document["trust"] = trust.as_json()
        output_json(document)
    else:
        output(answer.in_words())
        for each in script.particles:
            output(each.words)
        if trust is not None:
            click.echo(trust.in_words(), err=True)
    return status


def _quoted(audience: str) -> str:
    """An audience as a story names it: a file's name stands in quotes there, which shells take."""
    return f'"{audience}"' if audience.endswith(".toml") else audience


def _table(
    sources: tuple[str, ...],
    questions: tuple[str, ...],
    assume: str | None,
    audiences: tuple[str, ...],
    seed: int,
    out: str | None,
    as_json: bool,
) -> int:
    from i2pdsl.progress import Bars
    from i2pdsl.questions import query as ask

    status = DONE
    scripts: dict[str, Askable] = {}
    for source in sources:
        if source.endswith(".story"):
            scripts[source], ended = script_or_story(source, seed)
            status = max(status, ended)
        else:
            scripts |= {str(path): path for path in script_files(source)}
    with Bars() as bars:
        found = ask(scripts, questions, audiences or None, assume, bars.watch)
        # The table first: what there is to know of its error takes longer.
        write_table(_columns(found), None if out is None else Path(out), as_json)
        trusts = found.trust()
    show(found.warnings)
    for trust in trusts:
        click.echo(trust.in_words(), err=True)
    return status


def _columns(table: Table) -> dict[str, list[Any]]:
    """The columns of a table as plain lists, with None for no frame."""
    from i2pdsl.questions import NO_FRAME

    assert table.dtype.names is not None
    found = {name: table[name].tolist() for name in table.dtype.names}
    found["t"] = [None if t == NO_FRAME else t for t in found["t"]]
    return found
