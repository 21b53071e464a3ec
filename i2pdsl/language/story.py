"""A checked story: what a file of statements comes to, ready to be compiled and searched."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from itertools import accumulate
from pathlib import Path

from i2pdsl.errors import Diagnostic, Source, Span, StoryError, error, whole_file
from i2pdsl.language import ast
from i2pdsl.language import typed as ty
from i2pdsl.language.parse import parse_tolerantly
from i2pdsl.language.priors import factorises
from i2pdsl.language.scope import Module
from i2pdsl.language.vocabulary import Settings, Vocabulary, Weights


@dataclass(frozen=True)
class Particles:
    """How a viewer holds some hypotheses instead of all: `particles(count = 200)`.

    Attributes:
        count: how many.
        seed: of all that chance decides.
        moves: sweeps of Metropolis steps after they were drawn anew.
        least: the share of them below whose effective number they are drawn anew.
        frames: how many there may be to watch.
    """

    count: int = 200
    seed: int = 0
    moves: int = 4
    least: float = 0.5
    frames: int = 128


@dataclass(frozen=True)
class Observer:
    """One simulated viewer: the world's settings replaced, a prior weight per hypothesis, the
    hypotheses that are left by what he knows, where he knows anything, how much sharper than
    they are he expects choices to be, and the particles that he holds, where he does."""

    settings: Settings = ()
    prior: tuple[float, ...] | None = None
    known: ty.Mask | None = None
    sharpness: float = 1.0
    particles: Particles | None = None


def check_listed(words: Vocabulary, what: str) -> None:
    """Refuses what needs every hypothesis where there are too many of them. Raises StoryError."""
    if words.counts:
        total = math.fsum(words.counts)
        message = f"{what} needs every hypothesis, and there are {total:,.0f} {words.where}"
        raise error("particles", message, whole_file(words.world), "fewer goals or attitudes")


FRAMES_MORE = 16  # that a script may be watched beyond its length: appended turns


def watching(observers: Iterable[Observer], frames: int) -> tuple[Observer, ...]:
    """Observers who are ready for so many frames, and some that are appended."""
    size = -(-(frames + FRAMES_MORE) // FRAMES_MORE) * FRAMES_MORE
    return tuple(
        replace(each, particles=replace(each.particles, frames=size)) if each.particles else each
        for each in observers
    )


def able(observers: Iterable[Observer], words: Vocabulary) -> tuple[Observer, ...]:
    """Observers who hold particles where there are more hypotheses than anybody can hold, neither
    as a list nor by factors."""
    if not words.counts:
        return tuple(observers)
    return tuple(
        o if o.particles or holds_factors(o, words) else replace(o, particles=Particles())
        for o in observers
    )


def holds_factors(observer: Observer, words: Vocabulary) -> bool:
    """Whether what an observer thinks at first, and what he knows, tell nothing of two factors
    together."""
    if not words.factors:
        return False
    prior = observer.prior or words.prior or words.counts
    each = [weight / count for weight, count in zip(prior, words.counts, strict=True)]
    known = [float(k) for k in observer.known or (True,) * len(each)]
    given = words.hypotheses, words.factors
    return factorises(*given, each) and factorises(*given, known)


VIEWERS = "viewers"  # the name of the audience that needs none


@dataclass(frozen=True)
class Audience:
    """Viewers whose beliefs are averaged, and who may have a name.

    Attributes:
        first: how many observers of the story stand before its own.
        span: its statement; None where there is none.
    """

    name: str
    observers: tuple[Observer, ...]
    first: int = 0
    span: Span | None = field(default=None, compare=False)

    @property
    def viewers(self) -> ty.Viewers:
        """Its own among all observers of the story."""
        return self.first, self.first + len(self.observers)

    def can_hold(self, mask: ty.Mask) -> bool:
        """Whether a condition leaves each of its viewers a hypothesis with a prior above 0."""
        priors = (o.prior or (1.0,) * len(mask) for o in self.observers)
        return all(any(m and p > 0 for m, p in zip(mask, prior, strict=True)) for prior in priors)

    def open_to(self, mask: ty.Mask) -> ty.Mask:
        """The hypotheses of a mask that not all of its viewers know to be false."""
        known = [o.known for o in self.observers if o.known is not None]
        if not known or len(known) < len(self.observers):
            return mask
        left = (any(column) for column in zip(*known, strict=True))
        return tuple(m and k for m, k in zip(mask, left, strict=True))


USUAL = Audience(VIEWERS, (Observer(),))


def usual_audience(words: Vocabulary) -> Audience:
    """The audience of a world's stories that name none."""
    own = Audience(VIEWERS, able((Observer(prior=words.prior),), words))
    return own if words.prior else USUAL


def ordered(audiences: Sequence[Audience]) -> tuple[Audience, ...]:
    """Audiences that know how many observers stand before their own."""
    counts = accumulate((len(a.observers) for a in audiences), initial=0)
    return tuple(replace(a, first=n) for a, n in zip(audiences, counts, strict=False))


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
class Pin(Requirement):
    """How a frame must be: `pin script[frame]: CONDITION`, or `... = [TURN]`."""

    frame: int = 0

    def missed(self) -> Diagnostic:
        message = f"no script was found whose frame {self.frame} is so, and that keeps as many"
        return Diagnostic("unmet", f"{message} of the others", self.span, severity="warning")


@dataclass(frozen=True)
class KeptFrames:
    """Frames that shall be as in another script, where actions have no names:
    `pin script[first..last] = "FILE"`; `file` is beside the story."""

    file: str
    frames: range
    span: Span

    def path(self, folder: Path | None) -> Path:
        """Of the other script, given the story's folder."""
        return (folder or Path()) / self.file


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
        audiences: the viewers of all beliefs that name no others, and those that have names.
        requirements: what must hold before any objective counts.
        pins: how single frames must be, as much as the requirements.
        kept: frames that are those of another script.
        lengths: where the search chooses the length, the story of each, from the shortest to this
            one, which is the longest. Their sums over t count as if they had as many frames.
        longest: of such a story the greatest length, else 0.
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
    audiences: tuple[Audience, ...]
    search: SearchPlan
    module: Module = field(compare=False)
    requirements: tuple[Requirement, ...] = ()
    pins: tuple[Pin, ...] = ()
    kept: tuple[KeptFrames, ...] = ()
    lengths: tuple[TypedStory, ...] = field(default=(), compare=False)
    longest: int = 0
    warnings: tuple[Diagnostic, ...] = ()

    @property
    def room(self) -> int:
        """The frames that its program has: the greatest length of a story of several."""
        return self.longest or self.length

    @property
    def frames(self) -> str:
        """How many there are, in words."""
        shortest = f"{self.lengths[0].length} to " if self.lengths else ""
        return f"{shortest}{self.length} frames"

    def of_length(self, length: int) -> TypedStory:
        """The story of a script with so many frames, where the search chooses how many."""
        return next((each for each in self.lengths if each.length == length), self)

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
    def observers(self) -> tuple[Observer, ...]:
        """Those of all audiences, one after the other."""
        every = (observer for audience in self.audiences for observer in audience.observers)
        return watching(every, self.room)

    @property
    def viewers(self) -> ty.Viewers | None:
        """The observers that automatic terms are about; None where there are no others."""
        return self.audiences[0].viewers if len(self.audiences) > 1 else None

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
