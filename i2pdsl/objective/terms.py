"""The terms of a story's objective: the writer's, and the automatic ones (paper, section 3.2)."""

from __future__ import annotations

import numpy as np

from i2pdsl.language import typed as ty
from i2pdsl.language.check import TypedStory
from i2pdsl.objective.fold import Objective, compile_objective
from i2pdsl.objective.frame import Frame
from i2pdsl.objective.replay import evaluate
from i2pdsl.objective.requirements import violations
from i2pdsl.worlds.world import World


def all_terms(story: TypedStory) -> list[tuple[float, ty.Typed]]:
    """The writer's expressions with their signs, and sum_t P(everyone rational | script[:t]).

    The rationality term is conditioned on nothing, not even on the assumption.
    """
    terms = [(float(sign), expression) for sign, expression in story.objective]
    if story.vocabulary.has_rationality and story.rationality != 0:
        times = tuple(range(1, story.length + 1))
        nothing = (True,) * len(story.vocabulary.hypotheses)
        given = ty.Given(ty.Moment((), times, 1), nothing)
        rational = ty.Belief("P", story.everyone_rational, (given,))
        terms.append((story.rationality, ty.Reduction("sum", 1, story.length, rational)))
    return terms


def plausibility_weight(story: TypedStory) -> float:
    """The weight of -(p_hat - p)^2, 0 where nobody in the world is weak."""
    return story.plausibility if story.vocabulary.has_plausibility else 0.0


def story_objective(story: TypedStory, world: World) -> Objective:
    """The compiled objective of a story, automatic terms and broken requirements included."""
    weight = plausibility_weight(story)
    chances = world.weak_chances if weight else ()
    terms = all_terms(story) + violations(story, world)
    return compile_objective(world, story.length, terms, weight, chances)


def score_script(story: TypedStory, world: World, frames: Frame) -> float:
    """The objective of a finished script, in doubles."""
    total = sum(
        weight * float(evaluate(world, frames, expression, None))
        for weight, expression in all_terms(story)
    )
    return total + plausibility_weight(story) * implausibility(world, frames)


def implausibility(world: World, frames: Frame) -> float:
    """-(p_hat - p)^2 of each weak character, p_hat being the share of attempts that succeeded.

    0 for one who made no attempt.
    """
    if not world.weak_chances:
        return 0.0
    tried, succeeded = world.attempts(world.tables, frames.before[1:], frames.action[1:])
    attempts = tried.sum(0)
    p_hat = succeeded.sum(0) / np.maximum(attempts, 1)
    return -float(np.where(attempts > 0, (p_hat - world.weak_chances) ** 2, 0.0).sum())
