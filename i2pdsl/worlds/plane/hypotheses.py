"""What viewers hold possible of the characters of a plane, after the grid's (model.md,
"Hypotheses"). No arrays here."""

from __future__ import annotations

from i2pdsl.worlds.hypotheses import Hypothesis, hypotheses_of
from i2pdsl.worlds.plane.spec import NO_GOAL, PlaneSpec


def plane_hypotheses(spec: PlaneSpec) -> tuple[Hypothesis, ...]:
    """All hypotheses, in a fixed order."""
    social = spec.social
    in_order = sorted(spec.characters, key=lambda c: c == social)
    always_nothing = social is not None and social.goals == (NO_GOAL,)
    return hypotheses_of(in_order, lambda goal: goal == NO_GOAL and not always_nothing)
