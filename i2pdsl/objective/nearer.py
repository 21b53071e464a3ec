"""What scripts of approximate worlds are held against: plans that are nearer to exact ones, and
viewers who hold other particles, and more of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from i2pdsl.language.story import Observer, Particles, default_assumption
from i2pdsl.objective.replay import replay_all
from i2pdsl.objective.rollouts import rollouts
from i2pdsl.objective.trust import Copied, Trust, apart
from i2pdsl.worlds.kind import Approximation, Spec, Watch
from i2pdsl.worlds.kinds import kind_of
from i2pdsl.worlds.ready import ready_world, viewers_of, watched
from i2pdsl.worlds.record import Trajectory
from i2pdsl.worlds.world import Viewer, World

SCRIPTS, FRAMES = 64, 15  # that are looked at in a copy
EXACT_AROUND = "plans that are exact around the script"
TIMES_MORE, MANY = 4, 4_000  # particles of the others: so many times more, up to so many


@dataclass(frozen=True)
class Standard:
    """What scripts of a world are held against whose plans, or whose viewers, are approximate.

    Attributes:
        method: how they are so, in words.
        told: what is nearer to exact, in words; or why nothing is.
        copied: the error of plans in a small copy; None where there is none.
        world: nearer to exact; None where nothing is.
        paths: the scripts in its numbers.
        plans: whether its plans are other ones, and not its viewers alone.
        whole: whether scripts may lead anywhere in it.
    """

    method: str
    told: str
    copied: Copied | None = None
    world: World | None = None
    paths: tuple[Trajectory, ...] = ()
    plans: bool = False
    whole: bool = True

    @property
    def unknown(self) -> Trust:
        """What is known of a script that is held against nothing."""
        return Trust(self.method, self.told, None, None, self.copied)


def standard(
    world: World,
    observers: tuple[Observer, ...],
    paths: Sequence[Trajectory],
    lengths: Sequence[int],
    watch: Watch,
) -> Standard | None:
    """What scripts of one world are held against; None where that is exact.

    Args:
        paths: the scripts with what is appended to them.
        lengths: how many frames each has without that.
    """
    spec, kind = world.spec, kind_of(world.spec)
    plans = kind.approximation(spec)
    held = [o.particles for o in observers if o.particles is not None]
    others = tuple(map(_with_others, observers))
    about = f"; {_in_words(held)}" if held else ""
    beside = f", and {_in_words([p for o in others if (p := o.particles)])}" if held else ""
    own = tuple(cut(path, n) for path, n in zip(paths, lengths, strict=True))
    if plans is None:
        if not held:
            return None
        return Standard(
            about.removeprefix("; "),
            f"{beside.removeprefix(', and ')} of another seed",
            None,
            world.holding(viewers_of(spec, others)),
            own,
        )
    method, copied = plans.method + about, copied_of(plans, watch)
    beside += " of another seed" * bool(held)
    if plans.closer is not None:
        closer = ready_world(plans.closer, viewers_of(plans.closer, others), watch)
        return Standard(method, plans.closer_method + beside, copied, closer, own, True)
    part = kind.around(world, viewers_of(spec, others), paths, watch) if paths else None
    if part is None:
        told = plans.closer_method
        if paths:
            told += ", and plans exact around the script take too long or too much memory"
        return Standard(method, told, copied)
    kept = tuple(cut(path, n) for path, n in zip(part[1], lengths, strict=True))
    return Standard(method, EXACT_AROUND + beside, copied, part[0], kept, True, False)


def _with_others(observer: Observer) -> Observer:
    """One who holds other particles, and more; or himself."""
    plan = observer.particles
    if plan is None:
        return observer
    count = max(plan.count, min(TIMES_MORE * plan.count, MANY))
    return replace(observer, particles=replace(plan, count=count, seed=plan.seed + 1))


def _in_words(held: Sequence[Particles]) -> str:
    counts = sorted({plan.count for plan in held})
    return f"{' or '.join(f'{count:,}' for count in counts)} particles"


def cut(path: Trajectory, length: int) -> Trajectory:
    """The first frames of a script."""
    return Trajectory(path.actions[:length], path.states[: length + 1])


def trust_in(spec: Spec, watch: Watch) -> Trust | None:
    """What is known of the error of a world without any script; None where its plans are exact."""
    found = kind_of(spec).approximation(spec)
    return None if found is None else Trust(found.method, "", None, None, copied_of(found, watch))


def copied_of(found: Approximation, watch: Watch) -> Copied | None:
    """The error in a world's small copy."""
    if found.copy is None:
        return None
    with watched(watch):
        return Copied(found.told, SCRIPTS, *error_in_copy(*found.copy))


@lru_cache(maxsize=8)
def error_in_copy(approximate: Spec, exact: Spec) -> tuple[float, float]:
    """The mean and the largest change of belief in a frame between a world that is planned
    approximately and the same planned exactly, along scripts of those who act by exact plans."""
    first, second = (ready_world(spec, (Viewer(spec),)) for spec in (approximate, exact))
    path = rational_scripts(second, SCRIPTS, FRAMES, 0)
    one, other = (
        replay_all(world, path.states, path.actions, regret=False) for world in (first, second)
    )
    rational = default_assumption(second.vocabulary)
    errors = apart(second.vocabulary, rational, one, other)[:, 1:]
    return float(errors.mean()), float(errors.max())


def rational_scripts(world: World, count: int, length: int, seed: int) -> Trajectory:
    """Scripts of characters who are rational, from anywhere: actions [N, T], states [N, T + 1]."""
    generator = np.random.default_rng(seed)
    starts, rational = world.starts(), np.array(default_assumption(world.vocabulary))
    states = starts[generator.integers(len(starts), size=count)]
    drawn = generator.choice(np.flatnonzero(rational), size=count)
    acting = world.acting(drawn, generator)
    courses = np.broadcast_to(acting[:, None], (count, length, acting.shape[-1]))
    luck = generator.random((count, length))
    return rollouts(world, states, np.zeros(count, int), courses, luck)
