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
    goal_of,
    hypotheses_of,
    rationality_of,
    reading_of,
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
    """Goals x attitudes x rationality, an irrational one being met with indifference.

    What plays no part is left out of a row, so that equal rows stand here several times.
    """
    names, attitudes = [c.name for c in characters], attitudes_of(characters)
    every = {c.name: c.goals for c in characters}
    readings = [(c.name, other) for c in characters for other in c.misreads]
    taken = [every[other] for _, other in readings]
    rows: list[Hypothesis] = []
    for flags in product((True, False), repeat=len(names)):
        rational = dict(zip(names, flags, strict=True))
        values = [each.values if rational[each.toward] else (0.0,) for each in attitudes]
        each_way = product(product(*every.values()), product(*values), product(*taken))
        for goals, rhos, seen in each_way:
            row: Hypothesis = {rationality_of(name): rational[name] for name in names}
            wanted, cares = zip(names, goals, strict=True), zip(attitudes, rhos, strict=True)
            row.update((goal_of(name), goal) for name, goal in wanted if rational[name])
            row.update((each.latent, rho) for each, rho in cares if rational[each.who])
            row.update(
                (reading_of(*pair), goal)
                for pair, goal in zip(readings, seen, strict=True)
                if all(rational[name] for name in pair)
            )
            rows.append(row)
    return tuple(rows)
