"""Scripts that a search found, held against what is nearer to exact plans and exact viewers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from i2pdsl.language.story import TypedStory
from i2pdsl.objective.frame import Frame
from i2pdsl.objective.nearer import Standard, standard
from i2pdsl.objective.replay import replay_many
from i2pdsl.objective.terms import score_script
from i2pdsl.scripts import Script
from i2pdsl.worlds.kind import Watch
from i2pdsl.worlds.record import Trajectory
from i2pdsl.worlds.world import World


@dataclass(frozen=True)
class Vouched:
    """Scripts and how they are to be judged.

    Attributes:
        scripts: with what is known of their error.
        world: by which they are judged: their own, where plans are exact or nothing nearer to
            that is at hand.
        paths: the scripts in its numbers.
        frames: what the story's viewers make of them there.
    """

    scripts: list[Script]
    world: World
    paths: list[Trajectory]
    frames: list[Frame]

    def in_world(self, world: World) -> Vouched:
        """The same, to be judged in the scripts' own world."""
        paths, frames = [s.trajectory for s in self.scripts], [s.frames for s in self.scripts]
        return Vouched(self.scripts, world, paths, frames)


def vouched(story: TypedStory, world: World, scripts: Sequence[Script], watch: Watch) -> Vouched:
    """Holds scripts against plans that are nearer to exact ones, and viewers who hold more."""
    own = Vouched(list(scripts), world, [], []).in_world(world)
    found = _standard(story, world, scripts, watch)
    if found is None:
        return own
    if found.world is None:
        return replace(own, scripts=[replace(each, trust=found.unknown) for each in scripts])
    frames = replay_many(found.world, found.paths)
    held = [_held(story, found, *pair) for pair in zip(scripts, frames, strict=True)]
    if not found.plans:  # the panel has viewers of its own
        return replace(own, scripts=held)
    return Vouched(held, found.world, list(found.paths), frames)


def vouched_alone(story: TypedStory, world: World, script: Script, watch: Watch) -> Script:
    """A script of which nothing is known yet, held against plans that are exact around it, where
    those around all candidates take too long."""
    trust = script.trust
    if trust is None or trust.belief is not None:
        return script
    found = _standard(story, world, [script], watch)
    if found is None or found.world is None:
        return script
    (seen,) = replay_many(found.world, found.paths)
    return _held(story, found, script, seen)


def _standard(
    story: TypedStory, world: World, scripts: Sequence[Script], watch: Watch
) -> Standard | None:
    shown = [script.shown().trajectory for script in scripts]
    return standard(world, story.observers, shown, [s.length for s in scripts], watch)


def _held(story: TypedStory, found: Standard, script: Script, seen: Frame) -> Script:
    """A script with how far its own viewers are from those in a world that is nearer to exact."""
    assert found.world is not None
    with np.errstate(all="ignore"):
        score = float(score_script(story, found.world, seen))
    return script.held_against(found, seen, score)
