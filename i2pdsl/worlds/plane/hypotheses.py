"""What viewers hold possible of the characters of a plane, after the grid's (model.md,
"Hypotheses"). No arrays here."""

from __future__ import annotations

from itertools import product

from i2pdsl.worlds.hypotheses import ATTITUDE, Hypothesis, goal_of, rationality_of
from i2pdsl.worlds.plane.spec import NO_GOAL, PlaneSpec


def plane_hypotheses(spec: PlaneSpec) -> tuple[Hypothesis, ...]:
    """All hypotheses, in a fixed order; each distinguishable one once.

    Goals x goals x attitudes where both are rational; beside one that moves at random nobody has
    an attitude.
    """
    if len(spec.characters) == 1:
        (one,) = spec.characters
        goal, rational = goal_of(one.name), rationality_of(one.name)
        alone: list[Hypothesis] = [{goal: g, rational: True} for g in one.goals]
        return (*alone, {rational: False})
    second = spec.social or spec.characters[1]
    first = next(c for c in spec.characters if c.name != second.name)
    g1, r1 = goal_of(first.name), rationality_of(first.name)
    g2, r2 = goal_of(second.name), rationality_of(second.name)
    rows: list[Hypothesis] = []
    for goal1, goal2, rho in product(first.goals, second.goals, second.attitude or (None,)):
        if rho == 0 and goal2 == NO_GOAL and second.goals != (NO_GOAL,):
            continue
        row: Hypothesis = {g1: goal1, g2: goal2, r1: True, r2: True}
        if rho is not None:
            row[ATTITUDE] = rho
        rows.append(row)
    indifferent: Hypothesis = {ATTITUDE: 0.0} if second.attitude else {}
    rows += [{g2: g, **indifferent, r1: False, r2: True} for g in second.goals]
    rows += [{g1: g, r1: True, r2: False} for g in first.goals]
    rows.append({r1: False, r2: False})
    return tuple(rows)
