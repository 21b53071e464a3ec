"""What each form of language/forms.py means for what viewers believe."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

from i2pdsl.audience import foresight, queries
from i2pdsl.audience.filter import Switching
from i2pdsl.audience.particles import Swarm, SwarmTables
from i2pdsl.language import typed as ty
from i2pdsl.objective.belief import particles_of
from i2pdsl.objective.frame import View
from i2pdsl.worlds.world import World

Array = Any


class OfParticles(NamedTuple):
    """A quantity that is known of particles, not of rows: `of` is of who is asked o-th, given what
    knows his particles, [..., N]."""

    of: Callable[[int, foresight.Minds], Array]


class Asked(NamedTuple):
    """A form as it is asked at one moment, or at many along leading axes.

    Attributes:
        about: an event [H], a partition as one-hot [H, V] (None for the whole hypothesis), a
            quantity broadcastable to [..., O, H] (OfParticles where hypotheses cannot be listed
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
            each = [
                foresight.ahead(tables, swarm, tuple(row[..., o, :] for row in rows), self.mask)
                for o, (tables, swarm) in enumerate(self.swarms)
            ]
            xp = self.log_belief.__array_namespace__()
            log_weight = xp.stack([weight for weight, _ in each], axis=-1)
            belief = xp.stack([after for _, after in each], axis=-2)
        outcome = (found.chance * found.valid).reshape(belief.shape[:-2])
        weight = log_weight.__array_namespace__().exp(log_weight) * outcome[..., None]
        return weight, belief, len(rows)

    @property
    def counts(self) -> Array | None:
        """How many particles each of those who are asked holds, [O]; infinity of one who holds all
        hypotheses. None where nobody holds particles."""
        given = self.world.swarms(self.tables)
        if not given:
            return None
        counts = [math.inf if each is None else float(len(each.first)) for each in given]
        xp = self.log_belief.__array_namespace__()
        found = xp.asarray(counts, dtype=self.log_belief.dtype)
        return found if self.viewers is None else found[slice(*self.viewers)]

    @property
    def swarms(self) -> list[tuple[SwarmTables, Swarm]]:
        """The particles of those who are asked, where hypotheses cannot be listed."""
        given = particles_of(self.world, self.tables, self.viewers)
        return list(zip(given, self.views[0].swarms, strict=True))


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
    if not isinstance(asked.about, OfParticles):
        return queries.expectation(asked.log_belief, asked.about, asked.mask, asked.share)
    found = [
        foresight.expectation(tables, swarm, asked.mask, partial(asked.about.of, o))
        for o, (tables, swarm) in enumerate(asked.swarms)
    ]
    return asked.log_belief.__array_namespace__().stack(found, axis=-1).mean(-1)


NUMBERS: dict[str, Callable[[Asked], Array]] = {
    "P": lambda a: queries.probability(a.log_belief, a.about, a.mask, a.share),
    "E": _expectation,
    "KL": lambda a: queries.divergence(a.log_belief, a.views[1].log_belief, a.about, a.mask),
    "entropy": lambda a: queries.entropy(a.log_belief, a.about, a.mask, a.share, a.counts),
    "surprise": _surprise,
    "suspense": _suspense,
}
"""The forms that are numbers: the observers' mean, [...]."""

TABLES: dict[str, Callable[[Asked], Array]] = {
    "P": lambda a: queries.marginal(a.log_belief, a.about, a.mask, a.share).mean(-2),
    "next": _next,
}
"""The forms that are tables, with a last axis of values."""
