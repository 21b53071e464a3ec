"""What who holds particles expects: of the next frame, and of what each particle says.

Where hypotheses cannot be listed, a row of a belief stands for many; what characters will do, and
what they have to hope for, differs between these. So it is asked of the particles themselves. As in
every belief of theirs (particles.belief), FLOOR of the prior is mixed in: that is the particles of
the beginning, which were drawn from it.
"""

from __future__ import annotations

from collections.abc import Callable

from i2pdsl.audience.filter import log_sum
from i2pdsl.audience.particles import (
    FLOOR,
    Array,
    Swarm,
    SwarmTables,
    belief_of,
    looked_up,
    or_all,
    picked,
)


def with_prior(tables: SwarmTables, swarm: Swarm) -> tuple[Array, Array]:
    """The particles, and those of the prior: minds [..., 2 N, C] and log weights [..., 2 N]."""
    xp = swarm.log_weight.__array_namespace__()
    first = xp.broadcast_to(tables.first, swarm.minds.shape)
    even = xp.zeros_like(swarm.log_weight) - xp.log(xp.asarray(first.shape[-2] * 1.0))
    log = lambda share: xp.log(xp.asarray(share, dtype=even.dtype))
    weights = [swarm.log_weight + log(1 - FLOOR), even + log(FLOOR)]
    return xp.concatenate([swarm.minds, first], axis=-2), xp.concatenate(weights, axis=-1)


def ahead(
    tables: SwarmTables, swarm: Swarm, log_rows: tuple[Array, ...], mask: Array
) -> tuple[Array, Array]:
    """log of the probability of what is done next, [..., n_1, n_2, ...], and the belief after it,
    log P of each row [..., n_1, n_2, ..., H]. As `queries.ahead` has it of listed hypotheses.

    Args:
        log_rows: of one observer, of all problems: broadcastable to [..., n_1, n_2, ..., Q'].
        mask: the conditions, [H].
    """
    xp = swarm.log_weight.__array_namespace__()
    minds, log_weight = with_prior(tables, swarm)
    turns = (None,) * len(log_rows)
    lifted = lambda part: part[(..., *turns, slice(None))]
    log_weight, total = lifted(log_weight), xp.zeros((), log_weight.dtype)
    for u, row in enumerate(log_rows):
        inside = or_all(lifted(mask[looked_up(tables.row, minds)]) & (log_weight > -xp.inf))
        likely = _picked(row[..., tables.columns[u]], lifted(looked_up(tables.problems[u], minds)))
        joint = log_weight + likely
        total = total + log_sum(joint, inside) - log_sum(log_weight, inside)
        log_weight = joint - log_sum(joint)[..., None]
        if tables.forgets:
            minds = _anew(tables, swarm, u, minds)
    shape = xp.broadcast_shapes(total.shape, log_weight.shape[:-1])
    flat = xp.broadcast_to(log_weight, (*shape, log_weight.shape[-1]))
    flat = flat.reshape(*shape[: len(shape) - len(turns)], -1, flat.shape[-1])
    after = belief_of(tables, minds, flat)
    return xp.broadcast_to(total, shape), after.reshape(*shape, after.shape[-1])


def _picked(values: Array, at: Array) -> Array:
    """values [..., n_1, ..., Q] at [..., 1, ..., N], each with its own axes."""
    xp = values.__array_namespace__()
    missing = at.ndim - values.ndim
    values = values.reshape(*(1,) * max(missing, 0), *values.shape)
    at = at.reshape(*(1,) * max(-missing, 0), *at.shape)
    lead = xp.broadcast_shapes(values.shape[:-1], at.shape[:-1])
    values = xp.broadcast_to(values, (*lead, values.shape[-1]))
    return xp.take_along_axis(values, xp.broadcast_to(at, (*lead, at.shape[-1])), axis=-1)


def _anew(tables: SwarmTables, swarm: Swarm, u: int, minds: Array) -> Array:
    """The particles once some have begun anew, as they will when the u-th action was seen."""
    xp, count = minds.__array_namespace__(), swarm.log_weight.shape[-1]
    jump, fresh = tables.draws.jump[swarm.seen, u], tables.draws.fresh[swarm.seen, u]
    held = xp.where(jump[..., None], fresh, minds[..., :count, :])
    return xp.concatenate([held, minds[..., count:, :]], axis=-2)


def expectation(
    tables: SwarmTables, swarm: Swarm, mask: Array, quantity: Callable[[Minds], Array]
) -> Array:
    """E[quantity | mask], of a quantity that is known of each particle: [...]."""
    xp = swarm.log_weight.__array_namespace__()
    minds, log_weight = with_prior(tables, swarm)
    weights = xp.exp(log_weight)
    weights = weights * or_all(mask[looked_up(tables.row, minds)] & (weights > 0))
    values = quantity(Minds(tables, minds))
    found: Array = (weights * xp.where(weights > 0, values, 0.0)).sum(-1) / weights.sum(-1)
    return found


class Minds:
    """Particles, to be asked what is known of them."""

    def __init__(self, tables: SwarmTables, minds: Array) -> None:
        self._tables, self._minds = tables, minds

    def of_rows(self, values: Array) -> Array:
        """Of what is known of rows, [H], each particle's, [..., N]."""
        return values[looked_up(self._tables.row, self._minds)]

    def of_problems(self, who: int, values: Array) -> Array:
        """Of what is known of a character's problems, [..., Q'], each particle's, [..., N]."""
        at = looked_up(self._tables.problems[who], self._minds)
        return picked(values[..., self._tables.columns[who]], at)
