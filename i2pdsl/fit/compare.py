"""Models of the same judgements beside one another."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from i2pdsl.fit.report import Report


@dataclass(frozen=True)
class Comparison:
    """An audience beside the first: leave-one-out in nats, how much better the first is, with the
    standard error of that, over answers and over people, how many people it explains best, and r
    and RMSE of the means."""

    name: str
    loo: float
    difference: float
    se: float
    se_people: float
    best_for: int
    r: float
    rmse: float


def compared(reports: Mapping[str, Report]) -> tuple[Comparison, ...]:
    """Models of the same judgements, the best first. An audience is better by so many nats as it
    explains answers better that it was not fitted to."""
    best = max(reports, key=lambda name: reports[name].left_out.sum())
    person = reports[best].fitted.study.asked.person
    by_person = np.array([np.bincount(person, report.left_out) for report in reports.values()])
    best_for = np.bincount(by_person.argmax(0), minlength=len(reports))
    found = []
    for number, (name, report) in enumerate(reports.items()):
        apart = reports[best].left_out - report.left_out
        each = np.bincount(person, apart)
        error = lambda x: float(np.sqrt(len(x) * x.var(ddof=1))) if len(x) > 1 else float("nan")
        total = float(report.left_out.sum())
        figures = (total, float(apart.sum()), error(apart), error(each))
        found.append(Comparison(name, *figures, int(best_for[number]), *report.agreement))
    return tuple(sorted(found, key=lambda one: -one.loo))
