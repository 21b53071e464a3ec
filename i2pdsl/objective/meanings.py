"""What each form of language/forms.py means for what viewers believe."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from i2pdsl.audience import queries
from i2pdsl.audience.filter import Switching
from i2pdsl.language import typed as ty
from i2pdsl.objective.frame import View
from i2pdsl.worlds.world import Branches, World

Array = Any


class Asked(NamedTuple):
    """A form as it is asked at one moment, or at many along leading axes.

    Attributes:
        about: an event [H], a partition as one-hot [H, V] (None for the whole hypothesis), a
            quantity broadcastable to [..., O, H], or a character's number.
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
    def share(self) -> Array | None:
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

    def ahead(self) -> Branches:
        """What can come next, as those who are asked see it."""
        found = self.world.turns(self.tables, self.views[0].state)
        if self.viewers is None:
            return found
        rows = (row[..., slice(*self.viewers), :] for row in found.log_rows)
        return found._replace(log_rows=tuple(rows))


def _surprise(asked: Asked) -> Array:
    frame = asked.views[0].frame
    if frame is None:  # nothing has happened before the first frame
        return asked.log_belief.__array_namespace__().zeros(())
    return queries.surprise(frame.log_expecting, frame.log_rows, asked.mask)


def _suspense(asked: Asked) -> Array:
    ahead = asked.ahead()
    return queries.suspense(
        asked.log_belief,
        ahead.log_rows,
        ahead.chance,
        ahead.valid,
        asked.about,
        asked.mask,
        asked.forgetting,
        asked.switching,
    )


def _next(asked: Asked) -> Array:
    ahead = asked.ahead()
    return queries.prediction(
        asked.log_belief,
        ahead.log_rows,
        ahead.chance,
        ahead.valid,
        asked.about,
        asked.world.branch_actions(asked.about),
        asked.mask,
        asked.forgetting,
        asked.switching,
    )


NUMBERS: dict[str, Callable[[Asked], Array]] = {
    "P": lambda a: queries.probability(a.log_belief, a.about, a.mask, a.share),
    "E": lambda a: queries.expectation(a.log_belief, a.about, a.mask, a.share),
    "KL": lambda a: queries.divergence(a.log_belief, a.views[1].log_belief, a.about, a.mask),
    "entropy": lambda a: queries.entropy(a.log_belief, a.about, a.mask, a.share),
    "surprise": _surprise,
    "suspense": _suspense,
}
"""The forms that are numbers: the observers' mean, [...]."""

TABLES: dict[str, Callable[[Asked], Array]] = {
    "P": lambda a: queries.marginal(a.log_belief, a.about, a.mask, a.share).mean(-2),
    "next": _next,
}
"""The forms that are tables, with a last axis of values."""
