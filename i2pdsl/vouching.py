"""Scripts of approximate worlds, held against plans that are nearer to exact ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from i2pdsl.language.story import TypedStory, default_assumption
from i2pdsl.objective.frame import Frame
from i2pdsl.objective.replay import replay_all, replay_many
from i2pdsl.objective.terms import score_script
from i2pdsl.objective.trust import Copied, Trust, apart
from i2pdsl.sampling import rollouts
from i2pdsl.scripts import Script
from i2pdsl.worlds.kind import Approximation, Spec, Watch
from i2pdsl.worlds.kinds import kind_of
from i2pdsl.worlds.ready import ready_world, viewers_of
from i2pdsl.worlds.record import Trajectory
from i2pdsl.worlds.world import Viewer, World

SCRIPTS, FRAMES = 64, 15  # that are looked at in a copy
EXACT_AROUND = "plans that are exact around the script"


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
    """Holds scripts against plans that are nearer to exact ones."""
    kind = kind_of(world.spec)
    paths, own = [s.trajectory for s in scripts], [s.frames for s in scripts]
    found = kind.approximation(world.spec)
    if found is None:
        return Vouched(list(scripts), world, paths, own)
    copied = _copied(found)
    closer, told = None, found.closer_method
    if found.closer is not None:
        closer = ready_world(found.closer, viewers_of(found.closer, story.observers), watch)
    elif scripts:
        part = _around(story, world, scripts, watch)
        if part is not None:
            (closer, paths), told = part, EXACT_AROUND
    if closer is None:
        unknown = Trust(found.method, told, None, None, copied)
        return Vouched([replace(script, trust=unknown) for script in scripts], world, paths, own)
    frames = replay_many(closer, paths)
    pairs = zip(scripts, frames, strict=True)
    held = [_held(story, closer, each, seen, found.method, told, copied) for each, seen in pairs]
    return Vouched(held, closer, paths, frames)


def vouched_alone(story: TypedStory, world: World, script: Script, watch: Watch) -> Script:
    """A script of which nothing is known yet, held against plans that are exact around it, where
    those around all candidates take too long."""
    trust = script.trust
    if trust is None or trust.belief is not None:
        return script
    part = _around(story, world, [script], watch)
    if part is None:
        return script
    closer, paths = part
    (seen,) = replay_many(closer, paths)
    return _held(story, closer, script, seen, trust.method, EXACT_AROUND, trust.copied)


def _around(
    story: TypedStory, world: World, scripts: Sequence[Script], watch: Watch
) -> tuple[World, list[Trajectory]] | None:
    """The part of a world around some scripts, planned exactly, and these in its numbers."""
    shown = [script.shown().trajectory for script in scripts]
    viewers = viewers_of(world.spec, story.observers)
    part = kind_of(world.spec).around(world, viewers, shown, watch)
    if part is None:
        return None
    lengths = [script.length for script in scripts]
    return part[0], [cut(path, n) for path, n in zip(part[1], lengths, strict=True)]


def _held(
    story: TypedStory,
    closer: World,
    script: Script,
    seen: Frame,
    method: str,
    told: str,
    copied: Copied | None,
) -> Script:
    """A script with how far its own viewers are from those in a world planned more exactly."""
    with np.errstate(all="ignore"):
        score = float(score_script(story, closer, seen))
    belief = float(apart(closer.vocabulary, script.assumption, script.frames, seen).max())
    return replace(script, trust=Trust(method, told, belief, score, copied))


def trust_in(spec: Spec) -> Trust | None:
    """What is known of the error of a world without any script; None where its plans are exact."""
    found = kind_of(spec).approximation(spec)
    if found is None:
        return None
    return Trust(found.method, "", None, None, _copied(found))


def _copied(found: Approximation) -> Copied | None:
    if found.copy is None:
        return None
    return Copied(found.told, SCRIPTS, *error_in_copy(*found.copy))


def cut(path: Trajectory, length: int) -> Trajectory:
    """The first frames of a script."""
    return Trajectory(path.actions[:length], path.states[: length + 1])


@lru_cache(maxsize=8)
def error_in_copy(approximate: Spec, exact: Spec) -> tuple[float, float]:
    """The mean and the largest change of belief in a frame between a world that is planned
    approximately and the same planned exactly, along scripts of those who act by exact plans."""
    first, second = (ready_world(spec, (Viewer(spec),)) for spec in (approximate, exact))
    path = rational_scripts(second, SCRIPTS, FRAMES, 0)
    seen = [replay_all(world, path.states, path.actions, regret=False) for world in (first, second)]
    rational = default_assumption(second.vocabulary)
    errors = apart(second.vocabulary, rational, *seen)[:, 1:]
    return float(errors.mean()), float(errors.max())


def rational_scripts(world: World, count: int, length: int, seed: int) -> Trajectory:
    """Scripts of characters who are rational, from anywhere: actions [N, T], states [N, T + 1]."""
    generator = np.random.default_rng(seed)
    starts, rational = world.starts(), np.array(default_assumption(world.vocabulary))
    states = starts[generator.integers(len(starts), size=count)]
    drawn = generator.choice(np.flatnonzero(rational), size=count)
    observations = len(world.switching(world.tables))
    courses = np.broadcast_to(drawn[:, None, None], (count, length + 1, observations))
    luck = generator.random((count, length))
    return rollouts(world, states, np.zeros(count, int), courses, luck)
