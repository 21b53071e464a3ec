"""An audience that holds some hypotheses, with weights, instead of all: sequential Monte Carlo.

A particle is one joint hypothesis, held as the numbers of its parts: each character's mind (what it
wants, whom it cares about, whether it is rational). Particles are drawn from the prior, weighed by
the probability of each observed action, drawn anew by their weights (systematic resampling) where
their effective number gets low, and then moved by Metropolis steps that leave the posterior as it
is (Chopin 2002, DOI 10.1093/biomet/89.3.539; Del Moral, Doucet and Jasra 2006,
DOI 10.1111/j.1467-9868.2006.00553.x).

The steps need the likelihood of the whole script so far under any hypothesis. The probability of an
action depends on a hypothesis only through the planning problem that who acts solves under it, so a
running sum for each problem is enough: the log-likelihood of a hypothesis is one number of each
character's sums. Who forgets starts anew from any hypothesis now and then; each particle knows when
it did so last (`since`), and the sums at that time are kept.

Nothing here draws a random number: what is drawn depends on the seed, the frame and the particle
only (`Draws`), so scripts are compared by common random numbers, and a script's score is a number.
Leading axes are free (candidates, scripts). N particles, C characters, M minds of one, G sets of
those who are rational, U observed actions in a frame, Q problems of who acts, H rows of hypotheses
that expressions tell apart.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from i2pdsl.audience.filter import log_of, log_sum

Array = Any

FLOOR = 1e-6  # of the prior in every belief: so that any condition has a probability


class Index(NamedTuple):
    """What a joint hypothesis has: `table[sum over c of digits[c, mind of c]]`."""

    digits: Array  # [C, M]
    table: Array  # [X]


class Draws(NamedTuple):
    """What chance decides in each of T frames.

    Attributes:
        offset: where systematic resampling begins, [T].
        moves: uniform numbers of the Metropolis steps, [T, sweeps, renewal.steps_of(C), N].
        jump, fresh: which particles start anew after an observation, and from what: [T, U, N] and
            [T, U, N, C]; U is 0 where nobody forgets.
    """

    offset: Array
    moves: Array
    jump: Array
    fresh: Array


class SwarmTables(NamedTuple):
    """The numbers of one observer's particles.

    Attributes:
        flag: what a mind adds to the number of its group (who is rational), [C, M].
        options, sizes: the minds that are possible in a group, and how many: [G, C, M], [G, C].
        possible: whether a mind is one of them, [G, C, M].
        near, near_count: the minds that differ in one latent, [C, M, D], and how many, [C, M].
        redrawn: whether the minds of d depend on whether c is rational, [C, C].
        row: the row of a hypothesis.
        problems: for each observation the problem that who acts solves.
        columns: for each of them where the world's likelihoods have the problems, [Q].
        log_weight, log_known: of each row the prior as a multiple of an even one, and the same of
            what is started from anew, in logs: [H].
        log_rows: the prior of each row, [H].
        first: the particles at the beginning, [N, C].
        least: the effective number below which they are drawn anew.
        draws: what chance decides.
    """

    flag: Array
    options: Array
    sizes: Array
    possible: Array
    near: Array
    near_count: Array
    redrawn: Array
    row: Index
    problems: tuple[Index, ...]
    columns: tuple[Array, ...]
    log_weight: Array
    log_known: Array
    log_rows: Array
    first: Array
    least: Array
    draws: Draws

    @property
    def forgets(self) -> bool:
        return bool(self.draws.jump.shape[1])

    @property
    def marks(self) -> int:
        """K, after how many observations the sums are kept, the beginning among them."""
        return 1 + int(self.draws.jump.shape[0] * self.draws.jump.shape[1])


class Swarm(NamedTuple):
    """Particles, and what their likelihoods are made of.

    Attributes:
        minds: [..., N, C].
        log_weight: normalised, [..., N].
        since: how many observations there were when it last started anew, [..., N].
        sums: for each observation of a frame the log-likelihood of the script so far in each
            problem of who acts, [..., Q] each.
        marks: what they were after so many observations, [..., K, Q] each; K is 1 where nobody
            forgets.
        seen: how many frames were observed, [...].
        effective: the effective sample size after the last of them, [...].
    """

    minds: Array
    log_weight: Array
    since: Array
    sums: tuple[Array, ...]
    marks: tuple[Array, ...]
    seen: Array
    effective: Array

    def each(self, change: Any, *others: Any) -> Swarm:
        """The swarm with each of its arrays changed, given the same ones of others; without what
        one of them does not remember."""
        together = (self, *others)
        plain = (change(*(getattr(s, name) for s in together)) for name in _PLAIN)
        held: Any = dict(zip(_PLAIN, plain, strict=True))
        for name in ("sums", "marks"):
            parts = zip(*(getattr(s, name) for s in together), strict=False)
            held[name] = tuple(change(*part) for part in parts)
        return Swarm(**held)

    @property
    def remembered(self) -> Swarm:
        """The particles without what only their next step needs."""
        return self._replace(sums=(), marks=())


_PLAIN = ("minds", "log_weight", "since", "seen", "effective")


def begun(tables: SwarmTables) -> Swarm:
    """The particles before anything moved."""
    first = tables.first
    xp = first.__array_namespace__()
    count, dtype = first.shape[0], tables.log_rows.dtype
    sizes = [len(column) for column in tables.columns]
    return Swarm(
        first,
        xp.zeros((count,), dtype) - xp.log(xp.asarray(count, dtype=dtype)),
        xp.zeros((count,), dtype=xp.int32),
        tuple(xp.zeros((size,), dtype) for size in sizes),
        tuple(xp.zeros((tables.marks, size), dtype) for size in sizes),
        xp.zeros((), dtype=xp.int32),
        xp.asarray(count, dtype=dtype),
    )


def effective(log_weight: Array) -> Array:
    """The effective sample size, 1 / sum of squared weights, [...] of [..., N]."""
    xp = log_weight.__array_namespace__()
    return xp.exp(2 * log_sum(log_weight) - log_sum(2 * log_weight))


def looked_up(index: Index, minds: Array) -> Array:
    """What an index has of particles, [..., N]."""
    return index.table[total(index.digits, minds)]


def total(digits: Array, minds: Array) -> Array:
    """The sum over characters of [C, M] at their minds, [..., N]."""
    return sum(digits[c][minds[..., c]] for c in range(digits.shape[0]))


def picked(values: Array, at: Array) -> Array:
    """values [..., Q] at the places [..., N], whose leading axes may be fewer."""
    if at.ndim == 1:
        return values[..., at]
    xp = values.__array_namespace__()
    lead = xp.broadcast_shapes(values.shape[:-1], at.shape[:-1])
    values = xp.broadcast_to(values, (*lead, values.shape[-1]))
    return xp.take_along_axis(values, xp.broadcast_to(at, (*lead, at.shape[-1])), axis=-1)


def belief(tables: SwarmTables, swarm: Swarm) -> Array:
    """P of each row: the particles' weights, and FLOOR of the prior. [..., H]."""
    share = _shares(tables, swarm)
    return (1 - FLOOR) * share + FLOOR * share.__array_namespace__().exp(tables.log_rows)


def belief_of(tables: SwarmTables, minds: Array, log_weight: Array) -> Array:
    """log P of each row by particles [..., N, C] with several weights [..., K, N]: [..., K, H]."""
    xp = log_weight.__array_namespace__()
    share = xp.exp(log_weight) @ _in_rows(tables, minds, log_weight.dtype)
    return log_of(share)


def _in_rows(tables: SwarmTables, minds: Array, dtype: Any) -> Array:
    """Which row each particle is in, one-hot [..., N, H]."""
    row = looked_up(tables.row, minds)
    xp = row.__array_namespace__()
    return xp.asarray(row[..., None] == xp.arange(len(tables.log_rows)), dtype=dtype)


def _shares(tables: SwarmTables, swarm: Swarm, times: Array | None = None) -> Array:
    """The sum of the weights, or of so many times each, in each row: [..., H]."""
    xp = swarm.log_weight.__array_namespace__()
    weights = xp.exp(swarm.log_weight)
    there = _in_rows(tables, swarm.minds, weights.dtype)
    weights = weights if times is None else weights * times
    return (weights[..., None, :] @ there)[..., 0, :]


def likely(tables: SwarmTables, swarm: Swarm, u: int, row: Array) -> Array:
    """log P(what is observed u-th | row) of each row, [..., H]: the log of the mean over its
    particles, or over all where it has none.

    Args:
        row: the world's log-likelihoods of it, [..., Q'].
    """
    xp = row.__array_namespace__()
    own = xp.exp(of_each(tables, swarm, u, row))
    share, held = _shares(tables, swarm), _shares(tables, swarm, own)
    every = (xp.exp(swarm.log_weight) * own).sum(-1)[..., None]
    mean = xp.where(share > 0, held / xp.where(share > 0, share, 1.0), every)
    return log_of(mean)


def mean(tables: SwarmTables, swarm: Swarm, u: int, values: Array, within: Array) -> Array:
    """The expectation of what is known of each problem of who acts u-th, [..., Q'], within some
    rows [H]; of all where no particle is there. [...]."""
    xp = values.__array_namespace__()
    own = of_each(tables, swarm, u, values)
    weights = xp.exp(swarm.log_weight)
    weights = weights * or_all(within[looked_up(tables.row, swarm.minds)] & (weights > 0))
    found: Array = (weights * own).sum(-1) / weights.sum(-1)
    return found


def or_all(some: Array) -> Array:
    """Some of the particles, [..., N]; all where there are none: a condition that nobody's particle
    fulfils leaves viewers with what they believe without it."""
    return some | ~some.any(-1, keepdims=True)


def of_each(tables: SwarmTables, swarm: Swarm, u: int, values: Array) -> Array:
    """Of what is known of the problems of who acts u-th, [..., Q'], each particle's, [..., N]."""
    return picked(values[..., tables.columns[u]], looked_up(tables.problems[u], swarm.minds))


def seen_by(tables: SwarmTables, swarm: Swarm, u: int, row: Array) -> Swarm:
    """The swarm once an action was observed, the u-th of a frame.

    Args:
        row: the world's log-likelihoods of it, [..., Q'].
    """
    xp = swarm.log_weight.__array_namespace__()
    likely = row[..., tables.columns[u]]
    joint = swarm.log_weight + picked(likely, looked_up(tables.problems[u], swarm.minds))
    sums = list(swarm.sums)
    sums[u] = sums[u] + likely
    swarm = swarm._replace(log_weight=joint - log_sum(joint)[..., None], sums=tuple(sums))
    if not tables.forgets:
        return swarm
    number = swarm.seen * len(tables.columns) + u + 1
    jump, fresh = tables.draws.jump[swarm.seen, u], tables.draws.fresh[swarm.seen, u]
    return swarm._replace(
        minds=xp.where(jump[..., None], fresh, swarm.minds),
        since=xp.where(jump, xp.asarray(number)[..., None], swarm.since),
        marks=tuple(map(lambda m, s: _marked(xp, m, s, number), swarm.marks, swarm.sums)),
    )


def _marked(xp: Any, marks: Array, sums: Array, number: Array) -> Array:
    """The sums at one more time, [..., K, Q]."""
    here = xp.arange(marks.shape[-2]) == xp.asarray(number)[..., None]
    return xp.where(here[..., None], sums[..., None, :], marks)
