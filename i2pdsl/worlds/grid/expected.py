"""What all viewers expect of the characters: their plans side by side, in one set of tables."""

from __future__ import annotations

import numpy as np

from i2pdsl.worlds.grid.arrays import Against, Tables
from i2pdsl.worlds.grid.packed import States
from i2pdsl.worlds.grid.planning import Plan
from i2pdsl.worlds.grid.problems import (
    answering,
    costs,
    expectations,
    ground,
    on_goal,
    problem_of,
    state_tables,
)
from i2pdsl.worlds.grid.spec import GridSpec
from i2pdsl.worlds.grid.vocabulary import grid_vocabulary
from i2pdsl.worlds.hypotheses import rationality_of
from i2pdsl.worlds.world import Viewer, forgetting_of, log_priors, switching_of


def expected(
    spec: GridSpec, dynamics: States, viewers: tuple[Viewer, ...], plans: list[Plan]
) -> Tables:
    """The tables of viewers and their plans, without what those hold who do not list hypotheses."""
    words = grid_vocabulary(spec)
    rows = words.hypotheses
    # Viewers who expect the same plan to be followed more or less sharply have it once each.
    seen_as = [(id(p), v.sharpness) for v, p in zip(viewers, plans, strict=True)]
    places = {each: number for number, each in enumerate(dict.fromkeys(seen_as))}
    distinct = [plans[seen_as.index(each)] for each in places]
    offsets = [
        np.cumsum([0, *(len(p.keys[who]) for p in distinct)]) for who in range(len(spec.characters))
    ]
    continuation, columns, sharpness, goals = [], [], [], []
    for who, c in enumerate(spec.characters):
        continuation.append(
            distinct[0].continuation[who]
            if len(distinct) == 1
            else np.concatenate([p.continuation[who] for p in distinct], axis=1)
        )
        keys = [key for p in distinct for key in p.keys[who]]
        goals.append(on_goal(spec, dynamics, who, keys))
        beta = np.empty(len(keys))
        most = len(plans[0].keys[who]) + 1 if spec.is_sampled else len(rows)
        column = np.full((len(viewers), most), len(keys))
        for o, (viewer, plan) in enumerate(zip(viewers, plans, strict=True)):
            first = offsets[who][places[seen_as[o]]]
            sharp = viewer.sharpness * viewer.spec.settings.beta
            beta[first : first + len(plan.keys[who])] = sharp
            if spec.is_sampled:  # the likelihoods are of problems, of which particles have one each
                column[o, :-1] = first + np.arange(most - 1)
            for h, row in enumerate(() if spec.is_sampled else rows):
                if row[rationality_of(c.name)]:
                    key = problem_of(viewer.spec, c, row)
                    column[o, h] = first + plan.keys[who].index(key)
        columns.append(column)
        sharpness.append(beta)
    nowhere = np.full((spec.place_count - len(dynamics.coordinates), 2), -9)
    coordinates = np.vstack([dynamics.coordinates, nowhere])
    log_prior = log_priors(viewers, words)
    return Tables(
        **state_tables(dynamics),
        coordinates=coordinates,
        absent=np.array(dynamics.absent),
        success=np.array([c.success for c in spec.characters]),
        cost=costs(spec),
        ground=ground(spec, dynamics),
        gamma=np.array(spec.settings.gamma),
        reward=np.array(spec.settings.goal),
        continuation=tuple(continuation),
        columns=tuple(columns),
        sharpness=tuple(sharpness),
        goals=tuple(goals),
        log_prior=log_prior,
        forgetting=forgetting_of(viewers, [v.spec.settings.forgetting for v in viewers]),
        switching=switching_of(viewers, words, log_prior),
        layer=np.array(dynamics.state_count) if spec.settings.horizon else None,
        against=_against(viewers, plans, distinct, offsets) if spec.together else None,
        terms=distinct[0].terms,
    )


def _against(
    viewers: tuple[Viewer, ...],
    plans: list[Plan],
    distinct: list[Plan],
    offsets: list[np.ndarray],
) -> tuple[tuple[Against, ...], ...]:
    """What the characters of all plans expect of each other, side by side as their problems."""
    specs = [viewers[[id(p) for p in plans].index(id(plan))].spec for plan in distinct]
    each = [expectations(spec, plan.keys) for spec, plan in zip(specs, distinct, strict=True)]
    return tuple(
        tuple(
            _beside([plan[who][number] for plan in each], offsets[other])
            for number, other in enumerate(answering(specs[0], who))
        )
        for who in range(len(offsets))
    )


def _beside(parts: list[Against], offsets: np.ndarray) -> Against:
    """What a character expects of another in the problems of all plans.

    Args:
        offsets: the first of the other's problems of each plan.
    """
    problem = [
        part.problem + first
        for part, first in zip(parts, offsets, strict=False)
        if part.problem is not None
    ]
    beside = lambda name: np.concatenate([getattr(part, name) for part in parts], axis=-1)
    return Against(
        beside("fixed"),
        np.concatenate(problem) if problem else None,
        beside("known"),
        beside("beta"),
        beside("rho"),
        parts[0].success,
    )
