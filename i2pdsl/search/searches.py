"""The searches: the one table that names them. JAX is imported when one of them works."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import numpy as np

from i2pdsl.errors import error, whole_file
from i2pdsl.language import typed as ty
from i2pdsl.language.story import Requirement, SearchPlan, TypedStory, default_assumption
from i2pdsl.search.task import Found, Search, Task, draw_more, draw_starts
from i2pdsl.worlds.kinds import kind_of
from i2pdsl.worlds.record import Trajectory, extended, followed

if TYPE_CHECKING:
    from i2pdsl.programs import Program

RESCORED = 64  # of the best scripts in single precision, scored again to choose candidates
RESCORED_FRAMES = 20_000  # of all of them together, if they are long

NEAR = 0.05  # units: bodies so far from where a kept frame has them are where they were

USUAL_PLACES = SearchPlan().starts * SearchPlan().width
# Frames: the searches of shorter stories take less time, and may look longer, up to so many times.
USUAL_LENGTH, MOST_LONGER = 15, 3


class Beam(Search):
    """All that can happen, of worlds whose actions can be listed (search/beam.py)."""

    offers_all = False
    takes_effort = True

    def prepare(self, task: Task) -> Program:
        plan, length = task.story.search, task.story.room
        with task.searching():
            from i2pdsl.search.beam import prepare_beam

            budget = more_places(task)
            given = (task.world, task.objective, length, plan.starts, plan.width, budget)
            return prepare_beam(*given, task.events, task.watch.say).program

    def solve(self, task: Task, seed: int, count: int) -> Found:
        plan, length, watch = task.story.search, task.story.length, task.watch
        objective, allowed = task.objective, task.starts
        with task.searching():
            from i2pdsl.search.beam import More, beam_search

            starts = draw_starts(allowed, plan.starts, seed)
            fresh = draw_more(allowed, starts, task.effort, seed)
            more = More(plan.starts, more_places(task), fresh)
            began = time.perf_counter()
            given = (task.world, objective, task.story.room, starts, plan.width, task.events)
            found = beam_search(*given, watch.searching, watch.say, more)
        watch.add("search", began, found.compile_seconds)
        kept = max(count, min(RESCORED if count > 1 else 8, RESCORED_FRAMES // length))
        best = np.flatnonzero(np.isfinite(found.scores))[:kept]
        paths = followed(task.world, found.starts[best], found.actions[best, -length:])
        return Found(paths, found.finished)

    def onward(self, task: Task, path: Trajectory, frames: int) -> list[tuple[Trajectory, float]]:
        with task.searching():
            from i2pdsl.search.onward import continuations

            given = (task.world, task.objective, task.story.room, path, frames, task.events)
            found = continuations(*given, task.watch.say)
        return [(extended(task.world, path, each.actions), each.score) for each in found]


def more_places(task: Task) -> int:
    """How many scripts side by side a beam search may look at after its first pass.

    In short stories there is time for more, unless each look is costly or the story asks for much.
    """
    plan = task.story.search
    once, longer = plan.starts * plan.width, 1.0
    if not task.objective.looks_around:
        shorter = min(MOST_LONGER, USUAL_LENGTH / task.story.length)
        longer = max(longer, shorter * min(1.0, USUAL_PLACES / once))
    return int(once * (task.effort * (1 + plan.polish * longer) - 1))


class Descend(Search):
    """Along the gradient, of worlds that move smoothly (search/descent.py)."""

    offers_all = True
    takes_effort = False

    def prepare(self, task: Task) -> Program:
        with task.searching():
            from i2pdsl.search.descent import prepare_descent

            given = (task.world, task.objective, task.story.length, task.story.search)
            return prepare_descent(*given, task.watch.say).program

    def solve(self, task: Task, seed: int, count: int) -> Found:
        watch, objective = task.watch, task.objective
        with task.searching():
            from i2pdsl.search.descent import apart, descend

            began = time.perf_counter()
            given = (task.world, objective, task.story.length, task.story.search, seed)
            told = {"start": task.starts[0], "kept": task.kept}
            found = descend(*given, watch.searching, watch.say, **told)
        watch.add("search", began, found.compile_seconds)
        paths = [
            Trajectory(actions.astype(float), states.astype(float))
            for actions, states in zip(found.actions, found.states, strict=True)
        ]
        if task.kept is not None:
            away = apart(task.kept, found.states)
            paths = [paths[i] for i in np.flatnonzero(away <= NEAR + away.min())]
            if watch.say is not None and away.min() > NEAR:
                watch.say(f"in kept frames bodies are up to {away.min():.2g} units elsewhere")
        return Found(paths, found.finished)

    def onward(self, task: Task, path: Trajectory, frames: int) -> list[tuple[Trajectory, float]]:
        with task.searching():
            from i2pdsl.search.onward import descents

            given = (task.world, task.objective, task.story.length, task.story.search, path, frames)
            return descents(*given, task.watch.searching)


class Naive(Search):
    """No audience: the characters do what is best for them (paper, section 2)."""

    offers_all = True
    takes_effort = False

    def prepare(self, task: Task) -> None:
        return None

    def solve(self, task: Task, seed: int, count: int) -> Found:
        kind, story = kind_of(task.world.spec), task.story
        rational = np.array(default_assumption(task.world.vocabulary))
        if story.objective and kind.acts_by_hypothesis:
            event = depicted_event(story.objective)
            if event is None:
                message = "naive planning needs a story that depicts one event"
                hint = "a story such as `maximize depict(rho > 0)`"
                raise error("naive", message, whole_file(story.source.name), hint)
            rational = rational & np.array(event)
            if not rational.any():
                message = "no rational hypothesis fulfils the depicted event"
                raise error("naive", message, whole_file(story.source.name))
        began = time.perf_counter()
        path = kind.naive(task.world, story, task.starts, rational, seed)
        task.watch.add("search", began)
        return Found([path])

    def onward(self, task: Task, path: Trajectory, frames: int) -> list[tuple[Trajectory, float]]:
        return []


def without_requirements(
    task: Task, paths: list[Trajectory]
) -> tuple[np.ndarray, list[tuple[Requirement, ...]]]:
    """What continuations are worth as prefixes of a story whatever it requires, [S], and the
    requirements that each has broken for good. Raises StoryError, KeyboardInterrupt."""
    with task.searching():
        from i2pdsl.search import onward

        return onward.without_requirements(task.story, task.world, task.objective, paths)


def depicted_event(objective: tuple[tuple[int, ty.Typed], ...]) -> ty.Mask | None:
    """The one event whose probability a story of the depict kind asks for, else None."""
    masks = set()
    for sign, expression in objective:
        for node in ty.walk(expression):
            if isinstance(node, ty.Belief) and node.form == "P":
                masks.add((sign, node.about))
            elif not isinstance(node, ty.Reduction | ty.Given | ty.Moment | ty.Feature):
                return None
    if len(masks) != 1:
        return None
    sign, event = masks.pop()
    return event if sign > 0 else tuple(not e for e in event)


SEARCHES: dict[str, Search] = {"beam": Beam(), "descend": Descend(), "naive": Naive()}


def search_of(story: TypedStory, naive: bool = False) -> Search:
    """The search that a story asks for, or the one without an audience."""
    return SEARCHES["naive" if naive else story.search.method]
