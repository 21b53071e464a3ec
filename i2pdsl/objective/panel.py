"""A panel of viewers whom a script was not made for, and what they make of it.

Who optimises a script for one simulated viewer also optimises it for that viewer's oddities. So
candidates are judged by others too: how sharply characters seem to prefer what is best for them,
how fast viewers forget, and what they thought before anything moved, differs from the story's own
audience. What is asked of them is the same: the story's objective, of their beliefs. Where a story
names audiences, each member of the panel stands for all of them, changed alike: they stay as
different from each other as they were, and know what they know.

The panel is the same for all scripts and seeds of a story, so that its figures can be compared. It
needs no planning: nobody in it believes in another level 0, for which a world would have to be
solved again (for the kitchen half a minute). A wide panel has each of its members a second time, as
one who does (in planes: by the other observer); on the hill that would need other controllers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from i2pdsl.language.check import TypedStory
from i2pdsl.objective.frame import Frame
from i2pdsl.objective.replay import replay_many
from i2pdsl.objective.terms import score_script
from i2pdsl.worlds.kind import Watch
from i2pdsl.worlds.kinds import kind_of
from i2pdsl.worlds.ready import ready_world, viewers_of
from i2pdsl.worlds.record import Trajectory
from i2pdsl.worlds.world import World, forgetting_of

MEMBERS = 8
SHARPER = 2.0  # times as sharp as to the story's viewers choices seem to the panel, or 1 / so sharp
DOUBT = 0.7  # standard deviation of the logarithm of what priors are multiplied by


@dataclass(frozen=True)
class Member:
    """A viewer of the panel, or several where the story's audience is an average: the world as
    such viewers see it, and how much sharper than the story's they expect choices to be. Who
    imagines the world otherwise sees nothing as the story's viewers do."""

    world: World
    sharpness: float
    imagines_otherwise: bool = False

    def watch(self, paths: Sequence[Trajectory], known: Sequence[Frame]) -> list[Frame]:
        """What this member makes of each of some scripts of one length. `known` is what the
        story's viewers make of them."""
        rows = None
        if self.world.rows_are_scaled and not self.imagines_otherwise:
            rows = [tuple(self.sharpness * np.moveaxis(k.log_rows[1:], 1, 0)) for k in known]
        return replay_many(self.world, paths, rows)


@dataclass(frozen=True)
class Judgement:
    """What a panel makes of a script: the mean of the story's objective over its members, and the
    worst. Minus infinity where it has no finite value for some member."""

    mean: float
    worst: float


def imagined_otherwise(story: TypedStory, world: World, watch: Watch) -> World | None:
    """A story's world for viewers like its own but for one thing (Kind.imagined_otherwise); None
    where there is none. Planned, if it is not in the cache: raises KeyboardInterrupt."""
    kind = kind_of(world.spec)
    spec = kind.imagined_otherwise(world.spec)
    if spec is None:
        return None
    viewers = (
        replace(viewer, spec=kind.imagined_otherwise(viewer.spec))
        for viewer in viewers_of(world.spec, story.observers)
    )
    return ready_world(spec, tuple(viewers), watch)


def panel(story: TypedStory, world: World, other: World | None = None) -> tuple[Member, ...]:
    """The panel of a story: each of three ways to differ is spread evenly over the members.

    Forgetting grows by up to 1/T an observation: who forgets most has lost most of what was seen
    at the beginning when the story ends. With another world (`imagined_otherwise`) the panel is
    wide: as many members again live in that.
    """
    generator = np.random.default_rng(0)
    sharpness = generator.permutation(np.geomspace(1 / SHARPER, SHARPER, MEMBERS))
    share = generator.permutation(np.linspace(0, 1, MEMBERS))
    own, prior = world.forgetting(world.tables), world.log_prior(world.tables)
    found = []
    for sharp, more in zip(sharpness.tolist(), share, strict=True):
        doubted = prior + DOUBT * generator.normal(size=prior.shape[-1])
        doubted = doubted - np.log(np.exp(doubted).sum(-1, keepdims=True))
        forgetting = forgetting_of(story.observers, own + (1 - own) * more / story.length)
        told = sharp, forgetting, doubted
        found.append(Member(world.with_audience(*told), sharp))
        if other is not None:
            found.append(Member(other.with_audience(*told), sharp, True))
    return tuple(found)


def judge(
    story: TypedStory,
    members: tuple[Member, ...],
    paths: Sequence[Trajectory],
    known: Sequence[Frame],
) -> list[Judgement]:
    """The panel's judgement of each of some scripts of one length; `known` is what the story's own
    viewers make of them."""
    scores = np.empty((len(paths), len(members)))
    with np.errstate(all="ignore"):
        for place, member in enumerate(members):
            for number, frames in enumerate(member.watch(paths, known)):
                scores[number, place] = score_script(story, member.world, frames)
    return [
        Judgement(float(row.mean()), float(row.min()))
        if np.isfinite(row).all()
        else Judgement(-np.inf, -np.inf)
        for row in scores
    ]
