"""The hypotheses that viewers of a grid world hold, as rows of latents (model.md, "Hypotheses").
No arrays here."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

from i2pdsl.worlds.grid.spec import NO_GOAL, GridSpec
from i2pdsl.worlds.hypotheses import (
    Hypothesis,
    Minded,
    attitudes_of,
    hypotheses_of,
    rationality_of,
    reading_of,
    wants_of,
)


def grid_hypotheses(spec: GridSpec) -> tuple[Hypothesis, ...]:
    """All hypotheses of a grid world, in a fixed order: 34 for the kitchen.

    `merged` counts each distinguishable hypothesis once; `literal` takes the paper's tuple word
    by word, every irrational robot once for each of its goals and attitudes (72 in the kitchen).
    """
    if len(spec.characters) > 1 and spec.settings.hypotheses == "literal":
        return _literal(spec.by_depth)
    return hypotheses_of(spec.by_depth, lambda goal: goal == NO_GOAL)


def _literal(characters: Sequence[Minded]) -> tuple[Hypothesis, ...]:
    """Goals x attitudes x what is taken for goals x rationality, an irrational one being met with
    indifference.

    What plays no part is left out of a row, so that equal rows stand here several times.
    """
    goals = {c.name: wants_of(c) for c in characters}
    attitudes, minded = attitudes_of(characters), {c.name: c for c in characters}
    readings = [(c.name, other) for c in characters for other in c.misreads]
    rows: list[Hypothesis] = []
    for flags in product((True, False), repeat=len(goals)):
        rational = dict(zip(goals, flags, strict=True))
        values = [each.values if rational[each.toward] else (0.0,) for each in attitudes]
        options = (
            product(*goals.values()),
            product(*values),
            product(*(minded[o].goals for _, o in readings)),
        )
        for wanted, rhos, taken in product(*options):
            row: Hypothesis = {rationality_of(name): r for name, r in rational.items()}
            for name, chosen in zip(goals, wanted, strict=True):
                row |= chosen if rational[name] else {}
            cares, reads = zip(attitudes, rhos, strict=True), zip(readings, taken, strict=True)
            row |= {each.latent: rho for each, rho in cares if rational[each.who]}
            row |= {reading_of(*pair): g for pair, g in reads if all(rational[n] for n in pair)}
            rows.append(row)
    return tuple(rows)
