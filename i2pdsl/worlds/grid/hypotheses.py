"""The hypotheses that viewers of a grid world hold, as rows of latents (model.md, "Hypotheses").
No arrays here."""

from __future__ import annotations

from itertools import product

from i2pdsl.worlds.grid.spec import NO_GOAL, GridSpec
from i2pdsl.worlds.hypotheses import ATTITUDE, Hypothesis, goal_of, of_one, of_two, rationality_of


def grid_hypotheses(spec: GridSpec) -> tuple[Hypothesis, ...]:
    """All hypotheses of a grid world, in a fixed order: 34 for the kitchen.

    `merged` counts each distinguishable hypothesis once; `literal` takes the paper's tuple word
    by word, every irrational robot once for each of its goals and attitudes (72 in the kitchen).
    """
    if len(spec.characters) == 1:
        return of_one(spec.characters[0])
    if spec.settings.hypotheses == "literal":
        return _literal(spec)
    modeller = spec.modeller or spec.characters[1]
    modelled = next(c for c in spec.characters if c.name != modeller.name)
    return of_two(modelled, modeller, lambda goal, rho: rho == 0 and goal == NO_GOAL)


def _literal(spec: GridSpec) -> tuple[Hypothesis, ...]:
    """Goals x attitudes x rationality, an irrational modelled one being met with indifference.

    What plays no part is left out of a row, so that equal rows stand here several times.
    """
    modeller = spec.modeller or spec.characters[1]
    modelled = next(c for c in spec.characters if c.name != modeller.name)
    g1, r1 = goal_of(modelled.name), rationality_of(modelled.name)
    g2, r2 = goal_of(modeller.name), rationality_of(modeller.name)
    rows: list[Hypothesis] = []
    for first, second in product((True, False), (True, False)):
        attitudes: tuple[float | None, ...] = modeller.attitude or (None,)
        if not first and modeller.attitude:
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
