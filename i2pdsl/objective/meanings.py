"""What each form of language/forms.py means for what viewers believe."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

from i2pdsl.audience import queries
from i2pdsl.audience.filter import Switching
from i2pdsl.audience.holding import Holding, HoldingTables, way_of
from i2pdsl.language import typed as ty
from i2pdsl.objective.belief import holding_tables
from i2pdsl.objective.frame import View
from i2pdsl.worlds.world import World

Array = Any


class OfHeld(NamedTuple):
    """A quantity that is known of particles or points, not of rows.

    Attributes:
        of: of who is asked o-th, given what knows his particles or points, [..., N].
        whose: the characters whose values it is about.
    """

    of: Callable[[int, Any], Array]
    whose: frozenset[int]


class Asked(NamedTuple):
    """A form as it is asked at one moment, or at many along leading axes.

    Attributes:
        about: an event [H], a partition as one-hot [H, V] (None for the whole hypothesis), a
            quantity broadcastable to [..., O, H] (OfHeld where hypotheses cannot be listed
            and it is about values), or a character's number.
        mask: the conditions, [H].
        views: the moment that it is conditioned on; of a divergence two. Already of `viewers`.
        viewers: the observers who are asked, where not all are.
    """

    world: World
    tables: Any
    about: Array
    mask: Array
    views: tuple[View, ...]
    viewers: ty.Viewers | None = None

    @property
    def log_belief(self) -> Array:
        """log P(H | the given frames), [..., O, H]."""
        return self.views[0].log_belief

    @property
    def share(self) -> queries.Share | None:
        """The same as probabilities, where it is held so."""
        return self.views[0].share

    @property
    def forgetting(self) -> Array:
        """Of those who are asked, [O] or [O, H]."""
        every = self.world.forgetting(self.tables)
        return every if self.viewers is None else every[slice(*self.viewers)]

    @property
    def switching(self) -> tuple[Switching | None, ...]:
        """How they think that goals change, of each who acts."""
        every = self.world.switching(self.tables)
        if self.viewers is None:
            return every
        some = slice(*self.viewers)
        return tuple(None if each is None else each.of(some) for each in every)

    def ahead(self) -> tuple[Array, Array, int]:
        """What can come next, as those who are asked expect it: the probability of each next frame,
        [..., n_1, n_2, ..., O], the belief after it, [..., n_1, n_2, ..., O, H], and how many act
        in it."""
        found = self.world.turns(self.tables, self.views[0].state)
        some = slice(None) if self.viewers is None else slice(*self.viewers)
        rows = tuple(row[..., some, :] for row in found.log_rows)
        if self.world.lists_hypotheses:
            given = self.mask, self.forgetting, self.switching
            log_weight, belief = queries.ahead(self.log_belief, rows, *given)
        else:
            found_of = [
                way_of(each).ahead(each, held, tuple(row[..., o, :] for row in rows), self.mask)
                for o, (each, held) in enumerate(self.holdings(0))
            ]
            xp = self.log_belief.__array_namespace__()
            log_weight = xp.stack([weight for weight, _ in found_of], axis=-1)
            belief = xp.stack([after for _, after in found_of], axis=-2)
        outcome = (found.chance * found.valid).reshape(belief.shape[:-2])
        weight = log_weight.__array_namespace__().exp(log_weight) * outcome[..., None]
        return weight, belief, len(rows)

    @property
    def counts(self) -> Array | None:
        """How many particles each of those who are asked holds, [O]; infinity of one who holds all
        hypotheses. None where nobody holds particles."""
        given = self.world.holdings(self.tables)
        counts = [math.inf if each is None else way_of(each).stands_on(each) for each in given]
        if not any(map(math.isfinite, counts)):
            return None
        xp = self.log_belief.__array_namespace__()
        found = xp.asarray(counts, dtype=self.log_belief.dtype)
        return found if self.viewers is None else found[slice(*self.viewers)]

    def holdings(self, view: int) -> list[tuple[HoldingTables, Holding]]:
        """What those who are asked hold at a moment, where hypotheses cannot be listed."""
        given = holding_tables(self.world, self.tables, self.viewers)
        return list(zip(given, self.views[view].holdings, strict=True))

    def mean(self, each: list[Array]) -> Array:
        """The mean of what is found of each of those who are asked."""
        return self.log_belief.__array_namespace__().stack(each, axis=-1).mean(-1)


def _surprise(asked: Asked) -> Array:
    frame = asked.views[0].frame
    if frame is None:  # nothing has happened before the first frame
        return asked.log_belief.__array_namespace__().zeros(())
    return queries.surprise(frame.log_expecting, frame.log_rows, asked.mask)


def _suspense(asked: Asked) -> Array:
    return queries.suspense(*asked.ahead(), asked.about, asked.mask)


def _next(asked: Asked) -> Array:
    weight, _, turns = asked.ahead()
    actions = asked.world.branch_actions(asked.about)
    return queries.prediction(weight, turns, asked.about, actions)


def _expectation(asked: Asked) -> Array:
    if not isinstance(asked.about, OfHeld):
        return queries.expectation(asked.log_belief, asked.about, asked.mask, asked.share)
    mask, about = asked.mask, asked.about
    return asked.mean(
        [
            way_of(each).expectation(each, held, mask, partial(about.of, o), about.whose)
            for o, (each, held) in enumerate(asked.holdings(0))
        ]
    )


def _of_everything(form: Callable[..., Array] | None) -> Callable[..., Array]:
    """A form about all hypotheses; who cannot tell is not asked (language/beliefs.py)."""
    assert form is not None
    return form


def _entropy(asked: Asked) -> Array:
    if asked.about is None and not asked.world.lists_hypotheses:
        return asked.mean(
            [
                _of_everything(way_of(t).entropy)(t, held, asked.mask)
                for t, held in asked.holdings(0)
            ]
        )
    given = asked.about, asked.mask, asked.share, asked.counts
    return queries.entropy(asked.log_belief, *given)


def _divergence(asked: Asked) -> Array:
    if asked.about is None and not asked.world.lists_hypotheses:
        pairs = zip(asked.holdings(0), asked.holdings(1), strict=True)
        return asked.mean(
            [
                _of_everything(way_of(t).divergence)(t, one, two, asked.mask)
                for (t, one), (_, two) in pairs
            ]
        )
    return queries.divergence(asked.log_belief, asked.views[1].log_belief, asked.about, asked.mask)


NUMBERS: dict[str, Callable[[Asked], Array]] = {
    "P": lambda a: queries.probability(a.log_belief, a.about, a.mask, a.share),
    "E": _expectation,
    "KL": _divergence,
    "entropy": _entropy,
    "surprise": _surprise,
    "suspense": _suspense,
}
"""The forms that are numbers: the observers' mean, [...]."""

TABLES: dict[str, Callable[[Asked], Array]] = {
    "P": lambda a: queries.marginal(a.log_belief, a.about, a.mask, a.share).mean(-2),
    "next": _next,
}
"""The forms that are tables, with a last axis of values."""
