"""The latents that characters have in every kind of world (model.md, "Hypotheses")."""

from __future__ import annotations

Hypothesis = dict[str, float | str | bool]
"""One possible truth: latent -> value. A latent that plays no part is missing."""

ATTITUDE = "rho"


def goal_of(name: str) -> str:
    """The latent that holds a character's goal."""
    return f"G_{name}"


def rationality_of(name: str) -> str:
    """The latent that says whether a character is rational."""
    return f"R_{name}"
