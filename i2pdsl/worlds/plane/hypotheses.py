"""What viewers hold possible of the characters of a plane, after the grid's (model.md,
"Hypotheses"). No arrays here."""

from __future__ import annotations

from i2pdsl.worlds.hypotheses import Hypothesis, of_one, of_two
from i2pdsl.worlds.plane.spec import NO_GOAL, PlaneSpec


def plane_hypotheses(spec: PlaneSpec) -> tuple[Hypothesis, ...]:
    """All hypotheses, in a fixed order."""
    if len(spec.characters) == 1:
        return of_one(spec.characters[0])
    second = spec.social or spec.characters[1]
    first = next(c for c in spec.characters if c.name != second.name)
    always_nothing = second.goals == (NO_GOAL,)
    return of_two(
        first, second, lambda goal, rho: rho == 0 and goal == NO_GOAL and not always_nothing
    )
