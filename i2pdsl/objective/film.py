"""What viewers see in single frames, whatever a story asks: the automatic terms that the paper's
two do not cover. Sums over frames, kept as a fold keeps them; NumPy and JAX arrays alike.

naturalness  - sum_t sum_u E[max_a log P(a | H) - log P(a_u | H) | what they saw, a_u included]:
             nobody does what no hypothesis that viewers hold would make sensible. The belief is
             the one after the action, so that a turn costs little, and everybody is taken for
             rational, as a random character does nothing wrong.
luck         - max(0, C - FREE), where C is the greatest cumulative sum of log-likelihood ratios of
             the attempts of a weak character between a chance whose odds are ODDS times better (or
             worse) and its own (Page 1954, Continuous inspection schemes, Biometrika 41, 100-115).
             So a run counts wherever it stands, and two failures cost nothing.
liveliness   - the number of frames in which nothing changes that a viewer can see; of bodies that
             move smoothly, the sum of how still each frame is (World.stillness).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from i2pdsl.language import typed as ty
from i2pdsl.language.vocabulary import Weights
from i2pdsl.objective.frame import Frame
from i2pdsl.worlds.world import World

Array = Any

ODDS = 6.0
FREE = math.log(4)  # nats; of a chance of .6: two failures in a row, or three successes


class Film(NamedTuple):
    """What the terms have come to; W weak characters.

    Attributes:
        regret: nats so far, []. still: how still all frames so far were, [].
        tried, succeeded: attempts of each weak character, [W].
        streaks: the cumulative sum of each for better and for worse luck, now: [2, W].
        luck: the greatest of them so far, [W].
    """

    regret: Array
    still: Array
    tried: Array
    succeeded: Array
    streaks: Array
    luck: Array


def no_film(xp: Any, weak: int, dtype: Any) -> Film:
    """Before the first frame."""
    none = xp.zeros((), dtype=dtype)
    each = xp.zeros((weak,), dtype=dtype)
    return Film(none, none, each, each, xp.zeros((2, weak), dtype=dtype), each)


class Seen(NamedTuple):
    """What there is to see in a frame, or in many along leading axes; as in Film, of it alone."""

    regret: Array
    still: Array
    tried: Array
    succeeded: Array


def seen(
    world: World, tables: Any, frame: Frame, viewers: ty.Viewers | None, sensible: bool = True
) -> Seen:
    """What there is to see in a frame, or in several side by side. `viewers` are those observers
    to whom it must make sense, where not all are; `sensible`: whether it must at all."""
    xp = frame.log_belief.__array_namespace__()
    regret = frame.of(viewers).regret.mean(-1)
    if not sensible:
        regret = xp.zeros_like(regret)
    still = world.stillness(tables, frame.before, frame.state)
    if world.weak_chances:
        return Seen(regret, still, *world.attempts(tables, frame.before, frame.action))
    nobody = xp.zeros((*still.shape, 0), dtype=bool)
    return Seen(regret, still, nobody, nobody)


def see(
    world: World,
    tables: Any,
    chances: Array,
    film: Film,
    frame: Frame,
    viewers: ty.Viewers | None,
    sensible: bool,
) -> Film:
    """One frame further. `chances` are the success probabilities of the weak, [W]."""
    now = seen(world, tables, frame, viewers, sensible)
    film = film._replace(
        regret=film.regret + now.regret,
        still=film.still + now.still,
        tried=film.tried + now.tried,
        succeeded=film.succeeded + now.succeeded,
    )
    return _luckier(film, _log_ratios(chances, now))


def _log_ratios(chances: Array, now: Seen) -> Array:
    """Of what became of each attempt, by how much likelier better and worse odds make it, in nats:
    [2, ..., W], 0 where there was none."""
    xp = chances.__array_namespace__()
    failed = now.tried & ~now.succeeded
    found = []
    for odds in (ODDS, 1 / ODDS):
        other = odds * chances / (1 - chances + odds * chances)
        of_success, of_failure = xp.log(other / chances), xp.log((1 - other) / (1 - chances))
        found.append(xp.where(now.succeeded, of_success, xp.where(failed, of_failure, 0.0)))
    return xp.stack(found)


def _luckier(film: Film, log_ratios: Array) -> Film:
    """How long luck has lasted, one frame further: `log_ratios` are [2, W]."""
    xp = film.regret.__array_namespace__()
    streaks = xp.maximum(film.streaks + log_ratios, 0.0)
    return film._replace(streaks=streaks, luck=xp.maximum(film.luck, streaks.max(0)))


class Costs(NamedTuple):
    """The terms before they are weighed; none is positive."""

    plausibility: Array
    naturalness: Array
    luck: Array
    liveliness: Array


def costs(chances: Array, film: Film) -> Costs:
    """What the frames so far cost. plausibility is -(p_hat - p)^2 of each weak character, where
    p_hat is the share of attempts that succeeded; 0 for one who made none (paper, section 3.2)."""
    xp = film.regret.__array_namespace__()
    p_hat = film.succeeded / xp.maximum(film.tried, 1)
    miss = xp.where(film.tried > 0, (p_hat - chances) ** 2, 0.0)
    luck = xp.maximum(film.luck - FREE, 0.0)
    return Costs(-miss.sum(-1), -film.regret, -luck.sum(-1), -film.still)


def film_of(world: World, frames: Frame, viewers: ty.Viewers | None = None) -> Film:
    """What the automatic terms come to over a finished script, in doubles."""
    chances = np.array(world.weak_chances)
    every = seen(world, world.tables, frames.at(np.s_[1:]), viewers)
    film = no_film(np, len(chances), float)._replace(
        **{name: part.sum(0) for name, part in every._asdict().items()}
    )
    for log_ratios in np.moveaxis(_log_ratios(chances, every), 1, 0):
        film = _luckier(film, log_ratios)
    return film


def weighed(weights: Weights, costs: Costs) -> Array:
    """The costs as a story weighs them."""
    return (
        weights.plausibility * costs.plausibility
        + weights.naturalness * costs.naturalness
        + weights.luck * costs.luck
        + weights.liveliness * costs.liveliness
    )
