"""A checked story: what a file of statements comes to, ready to be compiled and searched."""

from __future__ import annotations

from dataclasses import dataclass, field

from i2pdsl.errors import Diagnostic, Source
from i2pdsl.language import ast
from i2pdsl.language import typed as ty
from i2pdsl.language.scope import Module
from i2pdsl.language.vocabulary import Vocabulary


@dataclass(frozen=True)
class Observer:
    """One simulated viewer: the world's settings replaced, and a prior weight per hypothesis."""

    settings: tuple[tuple[str, float | str], ...] = ()
    prior: tuple[float, ...] | None = None


@dataclass(frozen=True)
class SearchPlan:
    """How to look for the script."""

    method: str = "beam"
    starts: int = 500
    width: int = 1


@dataclass(frozen=True)
class TypedStory:
    """A story that has no mistakes.

    Attributes:
        world: the world's name as written, and `settings` that the story replaces.
        objective: (sign, expression) pairs that add up; empty for `search naive`.
        assumption: the mask that every belief is conditioned on.
        observers: one, or several whose beliefs are averaged.
    """

    name: str
    source: Source
    world: str
    settings: tuple[tuple[str, float | str], ...]
    vocabulary: Vocabulary
    length: int
    start: ty.Typed | None
    allow: tuple[tuple[str, str], ...]
    objective: tuple[tuple[int, ty.Typed], ...]
    rationality: float
    plausibility: float
    assumption: ty.Mask
    observers: tuple[Observer, ...]
    search: SearchPlan
    module: Module = field(compare=False)
    warnings: tuple[Diagnostic, ...] = ()

    @property
    def everyone_rational(self) -> ty.Mask:
        """The event of the automatic rationality term."""
        return default_assumption(self.vocabulary)


@dataclass(frozen=True)
class Library:
    """A file of patterns and lets only."""

    source: Source
    program: ast.Program
    module: Module
    warnings: tuple[Diagnostic, ...] = ()


def default_assumption(vocabulary: Vocabulary) -> ty.Mask:
    """Every character is rational."""
    return tuple(
        all(row.get(latent) for latent in vocabulary.rational.values())
        for row in vocabulary.hypotheses
    )
