"""What viewers believe, held in one way or another: of all hypotheses, as logs or probabilities, or
of particles or factors."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from i2pdsl.audience.filter import (
    LEAST,
    Switching,
    log_of,
    spread_of,
    update,
    updated_share,
)
from i2pdsl.audience.holding import Holding, HoldingTables, way_of
from i2pdsl.audience.product import Product
from i2pdsl.audience.queries import each_expects, ratio
from i2pdsl.language.story import default_assumption
from i2pdsl.worlds.world import ByProblem, World

Array = Any


class Belief(NamedTuple):
    """log P(H), [..., O, H]; P(H), where it is held so; what those hold who hold particles or
    factors instead; and P(H) as the product that it was found by, if it was."""

    log: Array
    share: Array | None = None
    holdings: tuple[Holding, ...] = ()
    product: Product | None = None

    def shown(self, tables: Sequence[HoldingTables | None]) -> Belief:
        """The belief with that of particles, or factors, in the place of each who holds some."""
        if not self.holdings:
            return self
        pairs = zip(_of_tables(tables), self.holdings, strict=True)
        xp = self.log.__array_namespace__()
        if self.share is not None:  # where everybody holds some
            beliefs = [way_of(each).belief(each, held) for each, held in pairs]
            share = xp.stack(xp.broadcast_arrays(*beliefs), axis=-2)
            return self._replace(log=log_of(share), share=share)
        logs = (way_of(each).log_belief(each, held) for each, held in pairs)
        own = {o: next(logs) for o, each in enumerate(tables) if each is not None}
        of = [own.get(o, self.log[..., o, :]) for o in range(len(tables))]
        return self._replace(log=xp.stack(xp.broadcast_arrays(*of), axis=-2))

    def seeing(
        self, world: World, tables: Any, u: int, row: Array, known: ByProblem | None = None
    ) -> Belief:
        """Once the u-th action of a frame was observed; see filter.update, holding.Way.

        Args:
            known: the row by problems, where it is known so.
        """
        given = world.holdings(tables)
        listed = self
        if world.lists_hypotheses:
            chain = world.forgetting(tables), world.switching(tables)[u]
            listed = self.after(row, *chain, known)
        if not self.holdings:
            return listed
        which = [o for o, each in enumerate(given) if each is not None]
        holdings = tuple(
            way_of(each).seen_by(each, held, u, row[..., o, :])
            for o, each, held in zip(which, _of_tables(given), self.holdings, strict=True)
        )
        return listed._replace(holdings=holdings).shown(given)

    def likely(self, world: World, tables: Any, u: int, row: Array) -> Array:
        """log P(what is observed u-th | row), [..., O, H]: the mean of what each row stands for."""
        if world.lists_hypotheses:
            return row
        of = zip(_of_tables(world.holdings(tables)), self.holdings, strict=True)
        doubts = self.share is not None
        found = [
            way_of(each).likely(each, held, u, row[..., o, :], doubts)
            for o, (each, held) in enumerate(of)
        ]
        return row.__array_namespace__().stack(found, axis=-2)

    def over(self, tables: Sequence[HoldingTables | None]) -> Belief:
        """The belief when a frame is over: particles are drawn anew where few count."""
        pairs = zip(_of_tables(tables), self.holdings, strict=True)
        return self._replace(holdings=tuple(way_of(each).over(each, held) for each, held in pairs))

    def after(
        self,
        row: Array,
        forgetting: Array,
        switching: Switching | None,
        known: ByProblem | None = None,
    ) -> Belief:
        """Once an action was observed; see filter.update."""
        if self.share is None:
            return Belief(update(self.log, row, forgetting, switching))
        xp, product = self.share.__array_namespace__(), None
        if known is None:
            share = updated_share(self.share, row, forgetting)
        else:  # of some problems, not of all hypotheses
            likely = xp.maximum(known.rows, math.exp(LEAST))
            spread = spread_of(forgetting, self.share.shape[-1])
            product = Product(self.share, likely, known.hypotheses, spread)
            share = product.multiplied()
        return Belief(xp.log(share), share, (), product)

    def regret(
        self, world: World, tables: Any, u: int, regret: Array, known: ByProblem | None = None
    ) -> Array:
        """What is expected of max_a log P(a | H) - log P(observed | H), once that was observed and
        where everybody is rational, [..., O].

        Args:
            known: the same by problems, where it is known so.
        """
        xp = self.log.__array_namespace__()
        rational = xp.asarray(default_assumption(world.vocabulary))
        if known is not None and self.product is not None:
            of_problems = self.product.by_problem(xp.where(rational, 1.0, 0.0))
            return ratio((of_problems * known.log_rows).sum(-1), of_problems.sum(-1))
        if world.lists_hypotheses:
            return each_expects(self.log, regret, rational, self.share)
        of = zip(_of_tables(world.holdings(tables)), self.holdings, strict=True)
        doubts = self.share is not None
        found = [
            way_of(each).mean(each, held, u, regret[..., o, :], rational, doubts)
            for o, (each, held) in enumerate(of)
        ]
        return xp.stack(found, axis=-1)

    def where(self, seen: Array, other: Belief) -> Belief:
        """The belief where something was seen, [...], else the other."""

        def chosen(mine: Array, its: Array) -> Array:
            there = seen.reshape((*seen.shape, *(1,) * (mine.ndim - seen.ndim)))
            return mine.__array_namespace__().where(there, mine, its)

        holdings = zip(self.holdings, other.holdings, strict=True)
        return self.map(chosen, other)._replace(
            holdings=tuple(mine.each(chosen, its) for mine, its in holdings)
        )

    def map(self, change: Callable[..., Array], *others: Belief) -> Belief:
        """The belief with its arrays changed, given those of others; without holdings."""
        parts = zip(self[:2], *(other[:2] for other in others), strict=True)
        log, share = (None if part[0] is None else change(*part) for part in parts)
        return Belief(log, share)


def _of_tables(tables: Sequence[HoldingTables | None]) -> list[HoldingTables]:
    return [each for each in tables if each is not None]


def holding_tables(
    world: World, tables: Any, viewers: tuple[int, int] | None = None
) -> list[HoldingTables]:
    """Of those observers who hold particles or factors; of some of them, where all do."""
    given = world.holdings(tables)
    return _of_tables(given if viewers is None else given[slice(*viewers)])


def first_belief(world: World, tables: Any, share: Array | None = None) -> Belief:
    """What viewers believe before anything moved."""
    given = world.holdings(tables)
    holdings = tuple(way_of(each).begun(each) for each in _of_tables(given))
    return Belief(world.log_prior(tables), share, holdings).shown(given)
