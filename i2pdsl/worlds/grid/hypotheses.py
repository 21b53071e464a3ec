"""The hypotheses that viewers of a grid world hold, as rows of latents (model.md, "Hypotheses").
No arrays here."""

from __future__ import annotations

from itertools import product

from i2pdsl.worlds.grid.spec import NO_GOAL, GridSpec
from i2pdsl.worlds.hypotheses import ATTITUDE, Hypothesis, goal_of, hypotheses_of, rationality_of


def grid_hypotheses(spec: GridSpec) -> tuple[Hypothesis, ...]:
    """All hypotheses of a grid world, in a fixed order: 34 for the kitchen.

    `merged` counts each distinguishable hypothesis once; `literal` takes the paper's tuple word
    by word, every irrational robot once for each of its goals and attitudes (72 in the kitchen).
    """
    if len(spec.characters) == 2 and spec.settings.hypotheses == "literal":
        return _literal(spec)
    return hypotheses_of(spec.by_depth, lambda goal: goal == NO_GOAL)


def _literal(spec: GridSpec) -> tuple[Hypothesis, ...]:
    """Goals x attitudes x rationality, an irrational modelled one being met with indifference.

    What plays no part is left out of a row, so that equal rows stand here several times.
    """
    modelled, modeller = spec.by_depth
    rhos = dict(modeller.attitudes).get(modelled.name, ())
    g1, r1 = goal_of(modelled.name), rationality_of(modelled.name)
    g2, r2 = goal_of(modeller.name), rationality_of(modeller.name)
    rows: list[Hypothesis] = []
    for first, second in product((True, False), (True, False)):
        attitudes: tuple[float | None, ...] = rhos or (None,)
        if not first and rhos:
            attitudes = (0.0,)
        for goal1, goal2, rho in product(modelled.goals, modeller.goals, attitudes):
            row: Hypothesis = {r1: first, r2: second}
            if first:
                row[g1] = goal1
            if second:
                row[g2] = goal2
            if second and rho is not None:
                row[ATTITUDE] = rho
            rows.append(row)
    return tuple(rows)
