"""`i2p fit`: the audience that people's judgements speak of."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from i2pdsl.output import DONE, INTERRUPTED, WRONG, check_writable, output, output_json

if TYPE_CHECKING:
    from i2pdsl.fit.compare import Comparison
    from i2pdsl.fit.judgements import Choice, Pair
    from i2pdsl.fit.questions import Study, Value
    from i2pdsl.fit.report import Report

_VARYING = "plan, prior, sharpness, forgetting, lapse, noise, bias, slope"


@click.command()
@click.argument("table", type=click.Path())
@click.option("-o", "--out", metavar="AUDIENCE.toml", help="Where to write the audience.")
@click.option("--question", metavar="EXPR", help="What was asked, where the table does not say.")
@click.option(
    "--choice",
    "choices",
    multiple=True,
    metavar="NAME:LABEL=EXPR;...",
    help="A question of the table that is answered by a label, and what each label claims.",
)
@click.option(
    "--pair",
    "pairs",
    multiple=True,
    metavar="NAME:EXPR",
    help="A question about two films, of which the one is chosen where EXPR is more.",
)
@click.option("--assume", metavar="CONDITION", help="What beliefs are conditioned on, or nothing.")
@click.option(
    "--scale", type=click.FloatRange(0, min_open=True), default=1.0, help="Of answers: 1, or 100."
)
@click.option(
    "--grid",
    multiple=True,
    metavar="NAME=V1,V2",
    help="A setting of how characters plan, and the values that are tried.",
)
@click.option("--fix", multiple=True, metavar="NAME=VALUE", help="A parameter that is not fitted.")
@click.option(
    "--against",
    multiple=True,
    metavar="NAME=VALUE",
    help="Another audience to compare with, in which this is fixed.",
)
@click.option(
    "--cue",
    "cues",
    multiple=True,
    metavar="EXPR",
    help="Something that can be counted in a script: a baseline without planning.",
)
@click.option("--vary", default=None, metavar="NAMES", help=f"In what people differ: {_VARYING}.")
@click.option(
    "--viewers", type=click.IntRange(1, 64), default=4, help="Of the audience's file, at most; 4."
)
@click.option("--chains", type=click.IntRange(1, 64), default=4, help="4 by default.")
@click.option("--draws", type=click.IntRange(20, 100_000), default=400, help="Of each chain; 400.")
@click.option(
    "--warmup", type=click.IntRange(20, 100_000), default=400, help="Draws before those; 400."
)
@click.option("--seed", type=click.IntRange(0), default=0, help="Of the chains; 0.")
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def fit(
    table: str,
    out: str | None,
    question: str | None,
    choices: tuple[str, ...],
    pairs: tuple[str, ...],
    assume: str | None,
    scale: float,
    grid: tuple[str, ...],
    fix: tuple[str, ...],
    against: tuple[str, ...],
    cues: tuple[str, ...],
    vary: str | None,
    viewers: int,
    chains: int,
    draws: int,
    warmup: int,
    seed: int,
    as_json: bool,
) -> int:
    """Fit an audience to people's judgements: how sharply they expect characters to choose, what
    they forget, what they thought before, and how they answer."""
    from i2pdsl.computing import computing
    from i2pdsl.fit.judgements import read_judgements, repeated
    from i2pdsl.progress import Bars

    meant: list[tuple[str, Choice | Pair]] = [*map(_choice, choices), *map(_pair, pairs)]
    named = dict(meant)
    if len(named) < len(meant):
        raise click.BadParameter("a name is given twice", param_hint="--choice, --pair")
    tried = dict(_numbers(text, "--grid") for text in grid)
    fixed = dict(_value(text, "--fix") for text in fix)
    others = {text: dict([_value(text, "--against")]) for text in against}
    varies = _varying(vary)
    if out is not None:
        if Path(out).suffix != ".toml":
            raise click.BadParameter(f"{out!r} does not end in .toml", param_hint="--out")
        check_writable(Path(out).parent)
    judgements = read_judgements(table, scale, question, named)
    if again := repeated(judgements):
        click.echo(f"warning: {again}", err=True)
    with Bars("fitting") as bars:
        from i2pdsl.fit.fit import fit as fitted_to
        from i2pdsl.fit.fit import fit_cues
        from i2pdsl.fit.questions import study
        from i2pdsl.fit.settings import settings_of

        def asked(reshaping: Mapping[str, Value]) -> Study:
            folder = Path(table).parent
            return study(judgements, folder, scale, named, bars.watch, reshaping, assume)

        people = asked({})
        parameters, settings, reshaping = settings_of(people, fixed, tried)
        changed = {
            text: settings_of(people, {**fixed, **other}, {}) for text, other in others.items()
        }
        people = asked(reshaping) if reshaping else people
        with computing(bars.say):
            from i2pdsl.fit.compare import compared
            from i2pdsl.fit.report import Report

            told: dict[str, Any] = {"chains": chains, "warmup": warmup, "draws": draws}
            told |= {"seed": seed, "report": bars.fitting}
            audience = {**told, "varies": varies, "watch": bars.watch}
            found = fitted_to(people, tried, parameters, settings, **audience)
            report = Report(found)
            reports = {"this audience": report}
            for text, (own, of_world, shape) in changed.items():
                rest = {name: values for name, values in tried.items() if name not in of_world}
                those = people if shape == reshaping else asked(shape)
                reports[text] = Report(fitted_to(those, rest, own, of_world, **audience))
            if cues:
                reports["cues"] = Report(fit_cues(people, cues, **told))
            comparison = compared(reports) if len(reports) > 1 else ()
            files = {} if out is None else _written(report, Path(out), table, viewers)
            document = report.as_json()
            document["comparison"] = [vars(each) for each in comparison]
    if as_json:
        output_json(document | {"files": files})
    else:
        output(in_words(report, comparison, files))
    if report.is_thin:
        click.echo(f"warning: {report.is_thin}", err=True)
    for problem in report.disagreements:
        click.echo(f"the chains have not converged: {problem}", err=True)
    if report.disagreements:
        click.echo("more draws (`--warmup`, `--draws`), or fewer parameters (`--fix`)", err=True)
    if not found.draws.finished:
        click.echo("interrupted: the draws so far were used", err=True)
        return INTERRUPTED
    return WRONG if report.disagreements else DONE


def _written(report: Report, out: Path, table: str, viewers: int) -> dict[str, str]:
    """Writes the audience, the draws and the picture."""
    from i2pdsl.fit.audience import people
    from i2pdsl.fit.picture import draw_agreement
    from i2pdsl.language.people import written
    from i2pdsl.resources import write_text

    r, rmse = report.agreement
    figures = {"r": r, "rmse": rmse, "people": len(report.fitted.study.people)}
    told = f"Viewers fitted to the judgements in {Path(table).name} by `i2p fit`."
    write_text(out, written(people(report, viewers), figures, told))
    files = {"audience": str(out), "draws": str(out.with_suffix(".nc"))}
    report.save(Path(files["draws"]))
    files["picture"] = str(out.with_suffix(".png"))
    draw_agreement(report, Path(files["picture"]))
    return files


def in_words(report: Report, comparison: tuple[Comparison, ...], files: dict[str, str]) -> str:
    """The report as people read it."""
    study = report.fitted.study
    r, rmse = report.agreement
    width = max(map(len, report.estimates))
    lines = [f"{'':{width}}      mean   5 %     95 %     R-hat  effective draws"]
    for name, each in report.estimates.items():
        figures = f"{each.mean:9.4g} {each.low:8.4g} {each.high:8.4g}"
        lines.append(f"{name:{width}} {figures} {each.rhat:7.3f} {each.ess:8.0f}")
    loo, checks = report.loo, report.predictive
    lines += [
        "",
        f"{len(study.asked.answer):,} answers of {len(study.people):,} people "
        f"to {len(study.labels):,} questions about scripts",
        f"leave one answer out: {loo['loo']:.5g} nats (standard error {loo['se']:.3g}; "
        f"{100 * loo['bad']:.3g} % of answers are too influential to be sure)",
    ]
    lines.append(f"means of the model and of people: r = {r:.4f}, RMSE = {rmse:.4g}")
    if checks:
        lines.append(
            f"answers within the model's 90 % intervals: {100 * checks['within_90']:.3g} %; at an "
            f"end of the slider {100 * checks['at_ends_people']:.3g} %, of the model "
            f"{100 * checks['at_ends_model']:.3g} %"
        )
    lines += _table(comparison)
    lines += [f"{name}: {path}" for name, path in files.items()]
    return "\n".join(lines)


def _table(comparison: tuple[Comparison, ...]) -> list[str]:
    if not comparison:
        return []
    width = max(len(one.name) for one in comparison)
    lines = [
        "",
        f"{'':{width}} leave one out  worse by  error  (over people)  best for       r     RMSE",
    ]
    for one in comparison:
        figures = f"{one.loo:13.5g} {one.difference:9.4g} {one.se:6.3g} {one.se_people:14.3g}"
        lines.append(f"{one.name:{width}} {figures} {one.best_for:9} {one.r:7.3f} {one.rmse:8.4g}")
    return [*lines, ""]


def _choice(text: str) -> tuple[str, Choice]:
    from i2pdsl.fit.judgements import Choice

    name, colon, rest = text.partition(":")
    options = [part.partition("=") for part in rest.split(";") if part.strip()]
    named = {label.strip(): expression.strip() for label, _, expression in options}
    if not colon or len(named) < 2 or not all(named.values()) or len(named) < len(options):
        message = f"{text!r} is not NAME:LABEL=EXPR;LABEL=EXPR"
        raise click.BadParameter(message, param_hint="--choice")
    return name.strip(), Choice(named)


def _pair(text: str) -> tuple[str, Pair]:
    from i2pdsl.fit.judgements import Pair

    name, _, expression = (part.strip() for part in text.partition(":"))
    if not name or not expression:
        raise click.BadParameter(f"{text!r} is not NAME:EXPR", param_hint="--pair")
    return name, Pair(expression)


def _numbers(text: str, option: str) -> tuple[str, Sequence[float]]:
    name, equals, rest = text.partition("=")
    try:
        values = [float(part) for part in rest.split(",")]
    except ValueError:
        values = []
    if not equals or not values:
        raise click.BadParameter(f"{text!r} is not NAME=V1,V2", param_hint=option)
    return name.strip(), values


def _value(text: str, option: str) -> tuple[str, Value]:
    """A number, or a word: `level0=costs`."""
    name, equals, rest = (part.strip() for part in text.partition("="))
    if not equals or not rest or "," in rest:
        raise click.BadParameter(f"{text!r} is not NAME=VALUE", param_hint=option)
    try:
        return name, float(rest)
    except ValueError:
        return name, rest


def _varying(text: str | None) -> tuple[str, ...] | None:
    if text is None:
        return None
    known = _VARYING.split(", ")
    names = tuple(name.strip() for name in text.split(",") if name.strip())
    for name in names:
        if name not in known and names != ("nothing",):
            raise click.BadParameter(f"{name!r} is none of {_VARYING}", param_hint="--vary")
    return names
