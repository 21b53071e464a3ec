"""What viewers believe, held in one way or another: of all hypotheses, as logs or probabilities, or
of particles."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from i2pdsl.audience import particles, renewal
from i2pdsl.audience.filter import Switching, update, updated_share
from i2pdsl.audience.particles import Swarm, SwarmTables
from i2pdsl.audience.queries import each_expects
from i2pdsl.language.story import default_assumption
from i2pdsl.worlds.world import World

Array = Any


class Belief(NamedTuple):
    """log P(H), [..., O, H]; P(H), where it is held so; and the particles of those who hold some
    instead, one swarm for each."""

    log: Array
    share: Array | None = None
    swarms: tuple[Swarm, ...] = ()

    def shown(self, tables: Sequence[SwarmTables | None]) -> Belief:
        """The belief with that of particles in the place of each observer who holds some."""
        if not self.swarms:
            return self
        beliefs = map(particles.belief, _of_swarms(tables), self.swarms)
        own = {o: next(beliefs) for o, each in enumerate(tables) if each is not None}
        xp = self.log.__array_namespace__()
        of = [own.get(o, self.log[..., o, :]) for o in range(len(tables))]
        return self._replace(log=xp.stack(xp.broadcast_arrays(*of), axis=-2))

    def seeing(self, world: World, tables: Any, u: int, row: Array) -> Belief:
        """Once the u-th action of a frame was observed; see filter.update, particles.seen_by."""
        given = world.swarms(tables)
        listed = self
        if world.lists_hypotheses:
            listed = self.after(row, world.forgetting(tables), world.switching(tables)[u])
        if not self.swarms:
            return listed
        which = [o for o, each in enumerate(given) if each is not None]
        swarms = tuple(
            particles.seen_by(each, swarm, u, row[..., o, :])
            for o, each, swarm in zip(which, _of_swarms(given), self.swarms, strict=True)
        )
        return listed._replace(swarms=swarms).shown(given)

    def likely(self, world: World, tables: Any, u: int, row: Array) -> Array:
        """log P(what is observed u-th | row), [..., O, H]: the mean of what each row stands for."""
        if world.lists_hypotheses:
            return row
        of = zip(_of_swarms(world.swarms(tables)), self.swarms, strict=True)
        found = [particles.likely(*each, u, row[..., o, :]) for o, each in enumerate(of)]
        return row.__array_namespace__().stack(found, axis=-2)

    def over(self, tables: Sequence[SwarmTables | None]) -> Belief:
        """The belief when a frame is over: particles are drawn anew where few count."""
        swarms = map(renewal.after_frame, _of_swarms(tables), self.swarms)
        return self._replace(swarms=tuple(swarms))

    def after(self, row: Array, forgetting: Array, switching: Switching | None) -> Belief:
        """Once an action was observed; see filter.update."""
        if self.share is None:
            return Belief(update(self.log, row, forgetting, switching))
        share = updated_share(self.share, row, forgetting)
        return Belief(share.__array_namespace__().log(share), share)

    def regret(self, world: World, tables: Any, u: int, regret: Array) -> Array:
        """What is expected of max_a log P(a | H) - log P(observed | H), once that was observed and
        where everybody is rational, [..., O]."""
        xp = self.log.__array_namespace__()
        rational = xp.asarray(default_assumption(world.vocabulary))
        if world.lists_hypotheses:
            return each_expects(self.log, regret, rational, self.share)
        of = zip(_of_swarms(world.swarms(tables)), self.swarms, strict=True)
        found = [particles.mean(*o, u, regret[..., n, :], rational) for n, o in enumerate(of)]
        return xp.stack(found, axis=-1)

    def where(self, seen: Array, other: Belief) -> Belief:
        """The belief where something was seen, [...], else the other."""

        def chosen(mine: Array, its: Array) -> Array:
            there = seen.reshape((*seen.shape, *(1,) * (mine.ndim - seen.ndim)))
            return mine.__array_namespace__().where(there, mine, its)

        swarms = zip(self.swarms, other.swarms, strict=True)
        return self.map(chosen, other)._replace(
            swarms=tuple(mine.each(chosen, its) for mine, its in swarms)
        )

    def map(self, change: Callable[..., Array], *others: Belief) -> Belief:
        """The belief with its arrays changed, given those of others; without particles."""
        parts = zip(self[:2], *(other[:2] for other in others), strict=True)
        log, share = (None if part[0] is None else change(*part) for part in parts)
        return Belief(log, share)


def _of_swarms(tables: Sequence[SwarmTables | None]) -> list[SwarmTables]:
    return [each for each in tables if each is not None]


def particles_of(
    world: World, tables: Any, viewers: tuple[int, int] | None = None
) -> list[SwarmTables]:
    """Of those observers who hold particles; of some of them, where all do."""
    given = world.swarms(tables)
    return _of_swarms(given if viewers is None else given[slice(*viewers)])


def first_belief(world: World, tables: Any, share: Array | None = None) -> Belief:
    """What viewers believe before anything moved."""
    given = world.swarms(tables)
    swarms = tuple(map(particles.begun, _of_swarms(given)))
    return Belief(world.log_prior(tables), share, swarms).shown(given)
