"""What a story may say of its search: the one table of methods (search/searches.py searches)."""

from __future__ import annotations

from dataclasses import dataclass

from i2pdsl.language.story import SearchPlan
from i2pdsl.language.vocabulary import Setting, Vocabulary, between, whole

LONGEST_STORY = 100_000
MOST_LENGTHS = 24  # that a search chooses from: each is searched


@dataclass(frozen=True)
class Method:
    """A method of search, in a story `search NAME(...)`.

    Attributes:
        listed: its settings in worlds whose actions can be listed; None where it needs others.
        continuous: its settings in worlds of continuous actions, or None.
        has_audience: whether beliefs decide; a story of another needs no objective.
        chooses_length: whether it can search several lengths.
    """

    listed: tuple[Setting, ...] | None = None
    continuous: tuple[Setting, ...] | None = None
    has_audience: bool = True
    chooses_length: bool = False

    def settings(self, enumerable: bool | None) -> tuple[Setting, ...] | None:
        """Its settings in a world whose actions can be listed, or cannot; None where it cannot
        search there. All of them where nobody knows which world it is."""
        if enumerable is None:
            return self.listed if self.listed is not None else self.continuous
        return self.listed if enumerable else self.continuous


_USUAL = SearchPlan()
_NOISE = between("noise", _USUAL.noise, "spread of chance changes of the actuation", 0.0, 10.0)
METHODS = {
    "beam": Method(
        listed=(
            whole("starts", _USUAL.starts, "initial states that are tried", 1, 1_000_000),
            whole("width", _USUAL.width, "scripts kept for each start", 1, 10_000),
            whole("polish", _USUAL.polish, "so many times their work improves the best", 0, 1000),
        ),
        chooses_length=True,
    ),
    "descend": Method(
        continuous=(
            whole("seeds", _USUAL.seeds, "scripts improved side by side", 1, 1000),
            whole("window", _USUAL.window, "frames improved at a time", 1, LONGEST_STORY),
            between(
                "overlap", _USUAL.overlap, "share that the next window improves again", 0, 0.95
            ),
            whole(
                "lookahead", _USUAL.lookahead, "frames after it that count too", 0, LONGEST_STORY
            ),
            whole("steps", _USUAL.steps, "steps of the optimiser in a window", 1, 100_000),
            between("rate", _USUAL.rate, "step size of `adam`", 1e-6, 100.0),
            between("bound", _USUAL.bound, "the largest change of an actuation", 1e-3, 100.0),
            between("damping", _USUAL.damping, "share of the gradient that a frame lets by", 0, 1),
            Setting(
                "optimiser", _USUAL.optimiser, "where there is no bound", ("adam", "lbfgs", "ncg")
            ),
            _NOISE,
        ),
    ),
    # A listed world has no continuous actuation that noise could change.
    "naive": Method(listed=(), continuous=(_NOISE,), has_audience=False),
}


def usual_method(world: Vocabulary) -> str:
    """The method of a story that names none."""
    fit = (name for name, m in METHODS.items() if m.settings(world.enumerable) is not None)
    return next(fit)


def has_audience(method: str) -> bool:
    """Whether beliefs decide what a search of that name finds; so it is taken where none has it."""
    return method not in METHODS or METHODS[method].has_audience
