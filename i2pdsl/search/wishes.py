"""What could be had of each wish of a story, if it were the only one: the same search finds out."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from i2pdsl.language import ast
from i2pdsl.objective.frame import Frame
from i2pdsl.objective.replay import evaluate, replay
from i2pdsl.objective.wishes import Wish, wish
from i2pdsl.search.task import Search, Task

PATIENCE = 60.0  # seconds of a processor
_COMMENT = re.compile(r"#.*")


def wishes_of(
    task: Task, search: Search | None, frames: Frame, seed: int
) -> tuple[tuple[Wish, ...], bool]:
    """What a script reaches of each wish of its story, and what it could; and whether all searches
    came to their end. Ctrl-C ends them early, and the rest of what is possible is unknown.

    All searches together take about as long as the story's own, or PATIENCE if that is less: a
    beam search then polishes less, and has fewer starts where that is not enough. There is none
    where a story has one wish and nothing beside it: what was found is then all that is known
    to be possible.

    Args:
        search: None where nobody looks for what is possible.
        frames: the script, as the story's viewers see it.
    """
    story, finished = task.story, True
    texts = [_on_one_line(span.text) for span in story.spans(ast.Objective)]
    numbers = task.objective.params.numbers[list(task.objective.weights)]
    competes = np.count_nonzero(numbers) > 1
    found = []
    for number, ((sign, value), text) in enumerate(zip(story.objective, texts, strict=True)):
        best: Frame | None = None if competes else frames
        if search is not None and competes and finished:
            try:
                best, finished = _best(_alone(task, number, search), search, seed)
            except KeyboardInterrupt:
                finished = False
        found.append(wish(text, sign, value, task.world, frames, best))
    return tuple(found), finished


def _alone(task: Task, number: int, search: Search) -> Task:
    """The search for one wish, as long as its share of the story's own, or of PATIENCE."""
    parts, plan = len(task.story.objective), task.story.search
    starts, polish = _affordable(task) if search.takes_effort else (plan.starts, plan.polish)
    starts, seeds = max(1, starts // parts), max(1, plan.seeds // parts)
    shorter = replace(plan, starts=starts, seeds=seeds, polish=polish)
    story = replace(task.story, search=shorter)
    return replace(task, story=story, only=number, whole=task.objective)


def _affordable(task: Task) -> tuple[int, int]:
    """So many of a story's starts, and so much of its polish, that its search would take PATIENCE
    at most: all starts, if polishing less will do."""
    from i2pdsl.search.beam import processor_seconds

    plan = task.story.search
    scripts = plan.starts * plan.width * (1 + plan.polish)
    given = task.world, task.objective, task.story.room, scripts, task.events
    passes = (1 + plan.polish) * min(1.0, PATIENCE / processor_seconds(*given))
    if passes < 1:
        return max(1, int(plan.starts * passes)), 0
    return plan.starts, int(passes) - 1


def _best(task: Task, search: Search, seed: int) -> tuple[Frame | None, bool]:
    """The best script for the one wish of a task, None where it has a value in none."""
    assert task.only is not None
    found = search.solve(task, seed, 1)
    sign, value = task.story.objective[task.only]
    best, most = None, -np.inf
    for path in found.paths:
        with np.errstate(all="ignore"):
            frames = replay(task.world, path.states, path.actions)
            worth = sign * float(evaluate(task.world, frames, value, None))
        if worth > most:  # of what is not a number never
            best, most = frames, worth
    return best, found.finished


def _on_one_line(statement: str) -> str:
    return " ".join(_COMMENT.sub("", statement).split())
