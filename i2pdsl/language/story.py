"""A checked story: what a file of statements comes to, ready to be compiled and searched."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

from i2pdsl.errors import Diagnostic, Source, Span, StoryError, whole_file
from i2pdsl.language import ast
from i2pdsl.language import typed as ty
from i2pdsl.language.parse import parse_tolerantly
from i2pdsl.language.scope import Module
from i2pdsl.language.vocabulary import Settings, Vocabulary, Weights


@dataclass(frozen=True)
class Observer:
    """One simulated viewer: the world's settings replaced, and a prior weight per hypothesis."""

    settings: Settings = ()
    prior: tuple[float, ...] | None = None


@dataclass(frozen=True)
class Requirement:
    """What must hold in the finished script: `require CONDITION`."""

    condition: ty.Typed
    span: Span = field(compare=False)

    @property
    def text(self) -> str:
        """As it was written, in one line."""
        return " ".join(self.span.text.split())

    def missed(self) -> Diagnostic:
        """What is said where the best script that was found does not meet it."""
        message = "no script was found that meets this requirement and as many of the others"
        return Diagnostic("unmet", message, self.span, severity="warning")


@dataclass(frozen=True)
class SearchPlan:
    """How to look for the script: what is given in `search METHOD(...)`.

    Attributes:
        starts, width: of a beam: initial states, and scripts kept for each.
        polish: so many times the work of this first pass goes into searching the best starts again.
        seeds: scripts that a descent improves side by side; the best is the result.
        window: frames that it improves at a time, before it goes on from where they end.
        overlap: share of a window that the next one improves again, from where it will stand.
        lookahead: frames after a window, without changes, that count when it is improved.
        steps, rate: of each window's optimisation.
        bound: the largest change of an actuation; infinite where there is none.
        damping: how much of a state's gradient each frame lets through.
        optimiser: adam, lbfgs or ncg.
        noise: spread of the changes that a descent begins with, or a naive rollout has.
    """

    method: str = "beam"
    starts: int = 500
    width: int = 1
    polish: int = 11
    seeds: int = 8
    window: int = 100
    overlap: float = 0.5
    lookahead: int = 100
    steps: int = 15
    rate: float = 0.1
    bound: float = math.inf
    damping: float = 1.0
    optimiser: str = "adam"
    noise: float = 0.1


@dataclass(frozen=True)
class TypedStory:
    """A story that has no mistakes.

    Attributes:
        world: the world's name as written, and `settings` that the story replaces.
        objective: (sign, expression) pairs that add up; empty for `search naive`.
        weights: of the automatic terms, 0 for those that the world does not have.
        assumption: the mask that every belief is conditioned on.
        observers: one, or several whose beliefs are averaged.
        requirements: what must hold before any objective counts.
    """

    name: str
    source: Source
    world: str
    settings: Settings
    vocabulary: Vocabulary
    length: int
    start: ty.Typed | None
    allow: tuple[tuple[str, str], ...]
    objective: tuple[tuple[int, ty.Typed], ...]
    weights: Weights
    assumption: ty.Mask
    observers: tuple[Observer, ...]
    search: SearchPlan
    module: Module = field(compare=False)
    requirements: tuple[Requirement, ...] = ()
    warnings: tuple[Diagnostic, ...] = ()

    def placed(self, problem: StoryError, kind: type[ast.Node]) -> StoryError:
        """What is wrong with a world or a search, said at the story's statement."""
        span = self.place(kind)
        return StoryError([replace(d, span=span) for d in problem.diagnostics])

    def spans(self, *kinds: type[ast.Node]) -> list[Span]:
        """Where all statements of some kinds stand."""
        program, _ = parse_tolerantly(self.source)
        return [statement.span for kind in kinds for statement in program.of(kind)]

    def place(self, *kinds: type[ast.Node]) -> Span:
        """Where something about the first such statement is said."""
        spans = self.spans(*kinds)
        return spans[0] if spans else whole_file(self.source.name)

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
