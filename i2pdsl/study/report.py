"""What a panel answered, in words and as files."""

from __future__ import annotations

from collections.abc import Sequence

from i2pdsl.study.analysis import Share
from i2pdsl.study.spec import Study

_HEADS = ("films", "match", "95 %", "people", "against", "difference", "95 %", "p")


def in_words(study: Study, shares: Sequence[Share]) -> str:
    """A table with a row for each group and method, and below it what else was answered."""
    groups = {group.name: group.label for group in study.groups}
    methods = {method.name: method.label for method in study.methods}
    rows = [("", *_HEADS)]
    for each in shares:
        name = groups[each.group]
        if len(study.methods) > 1:
            name = f"{name}, {methods[each.method]}"
        people = "" if each.people is None else percent(each.people)
        row = (name, str(each.films), percent(each.share), ends(each.low, each.high), people)
        versus = each.comparison
        if versus is None:
            rows.append((*row, "", "", "", ""))
        else:
            told = (
                f"{100 * versus.difference:+.0f}",
                ends(versus.low, versus.high),
                f"{versus.p:.2g}",
            )
            rows.append((*row, versus.against, *told))
    return aligned(rows)


def given_in_words(study: Study, shares: Sequence[Share]) -> str:
    """Which answers were given: a row for each group and method."""
    names = list(shares[0].given) if shares else []
    rows = [("", *names)]
    for each in shares:
        name = each.group if len(study.methods) == 1 else f"{each.group}, {each.method}"
        cells = (f"{v:.1f}" if n == "mean" else percent(v) for n, v in each.given.items())
        rows.append((name, *cells))
    return aligned(rows)


def percent(share: float) -> str:
    """A share for people."""
    return f"{100 * share:.0f} %"


def ends(low: float, high: float) -> str:
    """An interval of shares, in percent."""
    return f"{100 * low:.0f} to {100 * high:.0f}"


def aligned(rows: Sequence[tuple[str, ...]]) -> str:
    """A table: names to the left, figures to the right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = (
        "  ".join(
            cell.rjust(width) if number else cell.ljust(width)
            for number, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    )
    return "\n".join(lines)
