"""What could come next: the best continuations of a script that is there already."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from i2pdsl.language.story import Requirement, SearchPlan, TypedStory
from i2pdsl.objective.compile import Params
from i2pdsl.objective.fold import Objective
from i2pdsl.objective.terms import all_terms
from i2pdsl.programs import compiled_program
from i2pdsl.search.beam import prepared
from i2pdsl.search.descent import descend
from i2pdsl.search.pool import Rule, grown
from i2pdsl.search.rollout import prefix_scores, retraced
from i2pdsl.worlds.record import Trajectory
from i2pdsl.worlds.world import World

Array = Any

WIDTH = 32  # of the beam: so many continuations are compared
MISSED = 1e-3  # of the score: a requirement that costs less is kept


@dataclass(frozen=True)
class Continuation:
    """Frames that could follow: actions [k], and the objective of the script with them."""

    actions: np.ndarray
    score: float


def continuations(
    world: World,
    objective: Objective,
    length: int,
    path: Trajectory,
    frames: int,
    events: tuple[int, ...],
    say: Callable[[str], None] | None = None,
) -> list[Continuation]:
    """The best `frames` that could follow a script, best first: one for each first turn.

    Args:
        objective: of a script of `length` frames, which is at least len(path.actions) + frames.
        events: the allowed events, as numbers of `world.events`.
        say: is told of damaged caches.
    """
    tables, params = world.search_tables, prepared(world, objective, say)
    done = len(path.actions)
    actions = np.zeros(length, np.int32)
    states = np.zeros(length + 1, np.int32)
    actions[:done], states[: done + 1] = path.actions, path.states
    given = (tables, params, actions, states, np.int32(done))
    layout = world.program_key(objective.suffix_turns)
    key = ("onward", objective.shape, layout, length, frames, events)
    search = partial(_search, world, objective, frames, events)
    program = compiled_program(key, search, given, (0, 0), say, brief=True)
    found, worth = (np.asarray(x) for x in program.run(*given))
    best: dict[int, Continuation] = {}
    for i in np.argsort(-worth, kind="stable"):
        if np.isfinite(worth[i]):
            best.setdefault(int(found[i, 0]), Continuation(found[i], float(worth[i])))
    return list(best.values())


def descents(
    world: World,
    objective: Objective,
    length: int,
    plan: SearchPlan,
    path: Trajectory,
    frames: int,
    report: Callable[[int, int], None] | None = None,
) -> list[tuple[Trajectory, float]]:
    """A script of the hill with so many frames more, one way for each seed, best first.

    Returns: each longer script, and what it is worth as a prefix of a story of `length` frames.
    """
    found = descend(world, objective, length, plan, 0, report, so_far=path, frames=frames)
    tables, params = world.search_tables, prepared(world, objective)
    paths = Trajectory(found.actions, found.states)
    worth = prefix_scores(world, objective, length, tables, params, paths)
    kept = [i for i in np.argsort(-worth) if np.isfinite(worth[i])]
    exactly = lambda a: a.astype(float)
    return [
        (Trajectory(exactly(found.actions[i]), exactly(found.states[i])), float(worth[i]))
        for i in kept
    ]


def without_requirements(
    story: TypedStory, world: World, objective: Objective, paths: Sequence[Trajectory]
) -> tuple[np.ndarray, list[tuple[Requirement, ...]]]:
    """What scripts of one length are worth as prefixes of a story whatever it requires, [S], and
    the requirements that each has broken for good; where bodies move, those that it misses so far.

    Args:
        objective: the story's (terms.story_objective), whose compiled program serves here too.
    """
    first, many = len(all_terms(story)), len(story.requirements)
    others = [i for i in range(len(objective.weights)) if not first <= i < first + many]
    stacked = Trajectory(
        np.stack([path.actions for path in paths]), np.stack([path.states for path in paths])
    )

    def worth(*terms: int) -> np.ndarray:
        some = objective.alone(*terms)
        tables, params = world.search_tables, prepared(world, some)
        return prefix_scores(world, some, story.length, tables, params, stacked)

    broken = [worth(first + i) < -MISSED for i in range(many)]
    told = [
        tuple(r for r, each in zip(story.requirements, broken, strict=True) if each[number])
        for number in range(len(paths))
    ]
    return worth(*others), told


def _search(
    world: World,
    objective: Objective,
    frames: int,
    events: tuple[int, ...],
    tables: Any,
    params: Params,
    actions: Array,
    states: Array,
    number: Array,
) -> tuple[Array, Array]:
    """The actions [W, frames] and scores [W] of a beam from where the script ends."""
    node = retraced(world, objective, tables, params, actions, states, number)
    # A script of no value so far (a logarithm of 0) may get one.
    node = node._replace(score=jnp.zeros_like(node.score))
    copies = jax.tree.map(lambda x: jnp.broadcast_to(x, (WIDTH, *jnp.shape(x))), node)
    rule = Rule(jnp.int32(WIDTH), jnp.int32(WIDTH), jnp.bool_(False))
    worth, found = grown(world, objective, frames, events, tables, params, copies, rule)
    return found, worth
