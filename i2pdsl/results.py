"""What a search found, as scripts from the best to the worst: fewer broken requirements first."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from i2pdsl.errors import error, whole_file
from i2pdsl.language.story import Requirement
from i2pdsl.objective.replay import replay
from i2pdsl.objective.terms import score_script
from i2pdsl.scripts import Script, script_of
from i2pdsl.search.task import Found, Task
from i2pdsl.shown import Shown
from i2pdsl.worlds.record import Trajectory


@dataclass(frozen=True)
class Result(Shown):
    """What a search found.

    Attributes:
        candidates: scripts that differ visibly, best first.
        finished: false where the search was interrupted.
        seconds: time of each stage: plan, compile, search.
    """

    candidates: tuple[Script, ...]
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
    scripts = [_scored(task, path, seed) for path in finite]
    if not any(s.score is not None and np.isfinite(s.score) for s in scripts):
        message = "the objective has no finite value for any script that was found"
        raise error("objective", message, whole, "look for a logarithm of 0 or a division by 0")
    worth = lambda s: -np.inf if s.score is None or np.isnan(s.score) else s.score
    return sorted(scripts, key=lambda s: (len(s.unmet), -worth(s)))


def _scored(task: Task, path: Trajectory, seed: int) -> Script:
    frames = replay(task.world, path.states, path.actions)
    with np.errstate(all="ignore"):
        score = score_script(task.story, task.world, frames)
    source = task.story.source
    about = {"name": task.story.name, "file": source.name, "source": source.text, "seed": seed}
    return script_of(task.story, task.world, path, frames, about, score)
