"""What a search found, as scripts from the best to the worst: fewer broken requirements first."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from i2pdsl.errors import error, whole_file
from i2pdsl.language.story import Requirement
from i2pdsl.objective.frame import Frame
from i2pdsl.objective.panel import Judgement, imagined_otherwise, judge, panel
from i2pdsl.objective.replay import replay_many
from i2pdsl.objective.terms import score_script
from i2pdsl.scripts import Script, script_of
from i2pdsl.search.candidates import SHORTLIST, TOLERANCE, faults, select_different
from i2pdsl.search.task import Found, Search, Task
from i2pdsl.shown import Shown
from i2pdsl.vouching import vouched, vouched_alone
from i2pdsl.worlds.record import Trajectory

IN_FULL = 3  # lengths of a story of several that are searched as much as a story of one

Choice = Literal["panel", "wide", "score"]
"""Who puts candidates in their order: viewers whom they were not made for, more of such, or the
objective."""


@dataclass(frozen=True)
class Result(Shown):
    """What a search found.

    Attributes:
        candidates: scripts that differ visibly, best first.
        judgements: what the panel makes of each (objective/panel.py).
        finished: false where the search was interrupted.
        seconds: time of each stage: plan, compile, search.
    """

    candidates: tuple[Script, ...]
    judgements: tuple[Judgement, ...]
    finished: bool
    seconds: dict[str, float]

    @property
    def script(self) -> Script:
        """The best script."""
        return self.candidates[0]

    @property
    def score(self) -> float:
        """Its objective, automatic terms included."""
        return self.script.score or 0.0

    @property
    def unmet(self) -> tuple[Requirement, ...]:
        """The requirements that the best script does not meet."""
        return self.script.unmet

    def __repr__(self) -> str:
        return f"<Result: {len(self.candidates)} found, the best {self.script!r}>"


def chosen(
    task: Task, search: Search, seed: int, count: int, choose: Choice
) -> tuple[list[Script], list[Judgement], bool]:
    """The best scripts that a search finds, `count` of them or all that it offers; what the panel
    makes of each; and whether it came to its end. Raises StoryError, KeyboardInterrupt.

    The panel helps to choose among the best SHORTLIST that differ visibly: half of the votes are
    the story's own audience's, half the panel's (docs/stories.md has both). Those that are no films
    (search/candidates.py), or that the story's audience finds much worse than the best, come last.
    """
    by_panel = choose != "score"
    wanted = max(count, SHORTLIST) if by_panel else count
    found = search.solve(task, seed, wanted)
    began = time.perf_counter()
    scripts = ranked(task, found, seed)
    if not search.offers_all:
        paths = [script.trajectory.states for script in scripts]
        scripts = [scripts[i] for i in select_different(task.world, paths, wanted)]
    task.watch.add("search", began)
    held = vouched(task.story, task.world, scripts, task.watch)
    if choose == "wide":
        other = imagined_otherwise(task.story, task.world, task.watch)
        held = held.in_world(task.world)  # where the others live, too
    else:
        other = None
    began = time.perf_counter()
    members = panel(task.story, held.world, other)
    judgements = judge(task.story, members, held.paths, held.frames)
    judged = list(zip(held.scripts, judgements, strict=True))
    if by_panel:
        best = max(_worth(script) for script in held.scripts)
        judged.sort(key=lambda each: _place(best, *each))
    kept = judged if search.offers_all else judged[:count]
    best_script, judgement = kept[0]
    kept[0] = vouched_alone(task.story, task.world, best_script, task.watch), judgement
    task.watch.add("search", began)
    return [script for script, _ in kept], [judgement for _, judgement in kept], found.finished


def chosen_of_lengths(
    tasks: list[Task], search: Search, seed: int, count: int, choose: Choice
) -> tuple[list[Script], list[Judgement], bool]:
    """As `chosen`, of a story in several lengths: a first pass over all of them says which
    IN_FULL are searched in full, and their scripts are compared."""
    first: list[tuple[int, float, int]] = []
    for number, task in enumerate(tasks):
        plan = replace(task.story.search, polish=0)
        story = replace(task.story, search=plan)
        brief = replace(task, story=story, whole=task.objective, effort=1)
        best, *_ = ranked(brief, search.solve(brief, seed, 1), seed)
        first.append((*_by_score(best), number))
    found: list[tuple[Script, Judgement]] = []
    finished = True
    for _, _, number in sorted(first)[:IN_FULL]:
        if finished:
            scripts, judgements, finished = chosen(tasks[number], search, seed, count, choose)
            found += zip(scripts, judgements, strict=True)
    best_score = max(_worth(script) for script, _ in found)
    by_score = lambda each: _by_score(each[0])
    by_panel = lambda each: _place(best_score, *each)
    kept = sorted(found, key=by_score if choose == "score" else by_panel)[:count]
    return [script for script, _ in kept], [judgement for _, judgement in kept], finished


def best_of(results: Sequence[Result]) -> Result:
    """Of what a story's search found with several seeds, that whose script the panel puts first: it
    is the same panel for all."""
    best = max(_worth(found.script) for found in results)
    return min(results, key=lambda found: _place(best, found.script, found.judgements[0]))


def _place(best: float, script: Script, judgement: Judgement) -> tuple[int, int, float, float]:
    """Where a script stands among the candidates, of which the best has a score of `best`."""
    score = _worth(script)
    lacks = faults(script.world, script.trajectory.states)
    lacks += int(score < best - TOLERANCE * abs(best))
    return len(script.unmet), lacks, -(score + judgement.mean), -judgement.worst


def _worth(script: Script) -> float:
    """The score, by plans nearer to exact ones if there are such; minus infinity where it is not a
    number."""
    trust = script.trust
    score = script.score if trust is None or trust.score is None else trust.score
    return -np.inf if score is None or np.isnan(score) else score


def _by_score(script: Script) -> tuple[int, float]:
    """Where a script stands by the story's own objective: first what it breaks, then its score."""
    return len(script.unmet), -_worth(script)


def ranked(task: Task, found: Found, seed: int) -> list[Script]:
    """Scripts from what a search found, best first. Raises StoryError where none has a value."""
    whole = whole_file(task.story.source.name)
    finite = [path for path in found.paths if np.isfinite(path.states).all()]
    dropped = len(found.paths) - len(finite)
    if dropped and task.watch.say is not None:
        task.watch.say(f"{dropped} scripts are dropped: their motion is not finite")
    if dropped and not finite:
        message = "the motion is not finite: this world is too rough for the simulator's steps"
        raise error("motion", message, whole)
    every = zip(finite, replay_many(task.world, finite), strict=True)
    scripts = [_scored(task, path, frames, seed) for path, frames in every]
    if not any(s.score is not None and np.isfinite(s.score) for s in scripts):
        message = "the objective has no finite value for any script that was found"
        raise error("objective", message, whole, "look for a logarithm of 0 or a division by 0")
    return sorted(scripts, key=_by_score)


def _scored(task: Task, path: Trajectory, frames: Frame, seed: int) -> Script:
    with np.errstate(all="ignore"):
        score = score_script(task.story, task.world, frames)
    source = task.story.source
    about = {"name": task.story.name, "file": source.name, "source": source.text, "seed": seed}
    return script_of(task.story, task.world, path, frames, about, score)
