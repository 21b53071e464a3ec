"""The latents that characters have in every kind of world (model.md, "Hypotheses")."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import product
from typing import Protocol

from i2pdsl.language.vocabulary import Latent

Hypothesis = dict[str, float | str | bool]
"""One possible truth: latent -> value. A latent that plays no part is missing."""

ATTITUDE = "rho"


def goal_of(name: str) -> str:
    """The latent that holds a character's goal."""
    return f"G_{name}"


def rationality_of(name: str) -> str:
    """The latent that says whether a character is rational."""
    return f"R_{name}"


class Minded(Protocol):
    """A character that may want something, and care about another."""

    @property
    def name(self) -> str: ...

    @property
    def goals(self) -> tuple[str, ...]: ...

    @property
    def attitude(self) -> tuple[float, ...]: ...

    @property
    def toward(self) -> str | None: ...


def latents_of(characters: Sequence[Minded]) -> dict[str, Latent]:
    """What is hidden about characters: an attitude if one has any, goals, and who is rational."""
    found: dict[str, Latent] = {}
    for social in (c for c in characters if c.toward):
        about = f"{social.name}'s attitude toward {social.toward}: helping above 0, hindering below"
        # Beside an irrational partner the attitude is 0, whatever values it can have otherwise.
        values = social.attitude if 0 in social.attitude else (*social.attitude, 0.0)
        found[ATTITUDE] = Latent(ATTITUDE, "number", values, about)
    for c in characters:
        found[goal_of(c.name)] = Latent(goal_of(c.name), "symbol", c.goals, f"{c.name}'s goal")
    for c in characters:
        about = f"whether {c.name} acts rationally, or at random"
        rational = rationality_of(c.name)
        found[rational] = Latent(rational, "truth", (True, False), about)
    return found


def of_one(one: Minded) -> tuple[Hypothesis, ...]:
    """The hypotheses about a character alone: its goals, or that it acts at random."""
    goal, rational = goal_of(one.name), rationality_of(one.name)
    rows: list[Hypothesis] = [{goal: g, rational: True} for g in one.goals]
    return (*rows, {rational: False})


def of_two(
    first: Minded, second: Minded, is_nothing: Callable[[str, float], bool]
) -> tuple[Hypothesis, ...]:
    """The hypotheses about two characters, each distinguishable one once, in a fixed order.

    Goals x goals x attitudes of the second where both are rational; beside one that acts at
    random nobody has an attitude.

    Args:
        is_nothing: whether the second's goal and attitude are left out.
    """
    g1, r1 = goal_of(first.name), rationality_of(first.name)
    g2, r2 = goal_of(second.name), rationality_of(second.name)
    rows: list[Hypothesis] = []
    for goal1, goal2, rho in product(first.goals, second.goals, second.attitude or (None,)):
        if rho is not None and is_nothing(goal2, rho):
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
