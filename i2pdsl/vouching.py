"""Scripts of approximate worlds, held against plans that are nearer to exact ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
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


def vouched(
    story: TypedStory, world: World, scripts: Sequence[Script], watch: Watch
) -> tuple[World, list[Script], list[Frame]]:
    """The world by which scripts shall be judged, the scripts with what is known of their error,
    and what viewers in that world make of them. Where plans are exact, or nothing nearer to them
    fits, it is the scripts' own world."""
    found = kind_of(world.spec).approximation(world.spec)
    if found is None:
        return world, list(scripts), [script.frames for script in scripts]
    copied = None
    if found.copy is not None:
        copied = Copied(found.told, SCRIPTS, *error_in_copy(*found.copy))
    if found.closer is None:
        unknown = Trust(found.method, found.closer_method, None, None, copied)
        known = [replace(script, trust=unknown) for script in scripts]
        return world, known, [script.frames for script in scripts]
    closer = ready_world(found.closer, viewers_of(found.closer, story.observers), watch)
    frames = replay_many(closer, [script.trajectory for script in scripts])
    held = [
        replace(script, trust=_held(story, found, closer, script, seen, copied))
        for script, seen in zip(scripts, frames, strict=True)
    ]
    return closer, held, frames


def _held(
    story: TypedStory,
    found: Approximation,
    closer: World,
    script: Script,
    seen: Frame,
    copied: Copied | None,
) -> Trust:
    with np.errstate(all="ignore"):
        score = float(score_script(story, closer, seen))
    belief = float(apart(closer.vocabulary, script.assumption, script.frames, seen).max())
    return Trust(found.method, found.closer_method, belief, score, copied)


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
