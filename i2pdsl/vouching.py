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
        shown = [script.shown().trajectory for script in scripts]
        part = kind.around(world, viewers_of(world.spec, story.observers), shown, watch)
        if part is not None:
            closer, told = part[0], "plans that are exact around the script"
            paths = [cut(p, script.length) for p, script in zip(part[1], scripts, strict=True)]
    if closer is None:
        unknown = Trust(found.method, told, None, None, copied)
        return Vouched([replace(script, trust=unknown) for script in scripts], world, paths, own)
    frames = replay_many(closer, paths)
    held = []
    for script, seen in zip(scripts, frames, strict=True):
        with np.errstate(all="ignore"):
            score = float(score_script(story, closer, seen))
        belief = float(apart(closer.vocabulary, script.assumption, script.frames, seen).max())
        held.append(replace(script, trust=Trust(found.method, told, belief, score, copied)))
    return Vouched(held, closer, paths, frames)


def trust_in(spec: Spec) -> Trust | None:
    """What is known of the error of a world without any script; None where its plans are exact."""
    found = kind_of(spec).approximation(spec)
    if found is None:
        return None
    return Trust(found.method, found.closer_method, None, None, _copied(found))


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
