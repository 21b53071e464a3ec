"""The terms of a story's objective: the writer's, and the automatic ones (paper, section 3.2, and
objective/film.py)."""

from __future__ import annotations

import numpy as np

from i2pdsl.language import typed as ty
from i2pdsl.language.check import TypedStory
from i2pdsl.objective.film import costs, film_of, weighed
from i2pdsl.objective.fold import Objective, compile_objective
from i2pdsl.objective.frame import Frame
from i2pdsl.objective.late import later, pins_later
from i2pdsl.objective.pins import pinned
from i2pdsl.objective.replay import evaluate
from i2pdsl.objective.requirements import violations
from i2pdsl.worlds.world import World


def all_terms(story: TypedStory) -> list[tuple[float, ty.Typed]]:
    """The writer's expressions with their signs, and sum_t P(everyone rational | script[:t]).

    The rationality term is conditioned on nothing, not even on the assumption; it asks the audience
    that needs no name.
    """
    terms = [(float(sign), expression) for sign, expression in story.objective]
    if story.weights.rationality:
        times = tuple(range(1, story.length + 1))
        nothing = (True,) * len(story.vocabulary.hypotheses)
        given = ty.Given(ty.Moment((), times, 1), nothing)
        rational = ty.Belief("P", story.everyone_rational, (given,), viewers=story.viewers)
        summed = ty.Reduction("sum", 1, story.length, rational)
        terms.append((story.weights.rationality, summed))
    return terms


def story_objective(story: TypedStory, world: World) -> Objective:
    """The compiled objective of a story, automatic terms and broken requirements included.

    Of a story of several lengths it has the shape of the longest one's (late.py).
    """
    terms = all_terms(story) + violations(story, world)
    pins, before = pinned(story, world), None
    if story.longest:
        before = story.longest - story.length
        terms = [(weight, later(expression, before)) for weight, expression in terms]
        pins = pins_later(pins, before)
    given = (story.weights, story.viewers, pins, before)
    return compile_objective(world, story.room, terms, *given)


def score_script(story: TypedStory, world: World, frames: Frame) -> float:
    """The objective of a finished script, in doubles."""
    terms = all_terms(story)
    total = sum((w * float(evaluate(world, frames, e, None)) for w, e in terms), 0.0)
    if story.weights.sees_frames:
        chances = np.array(world.weak_chances)
        total += float(
            weighed(story.weights, costs(chances, film_of(world, frames, story.viewers)))
        )
    return total
