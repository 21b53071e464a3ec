"""Particles drawn anew where few count, and moved: systematic resampling, and Metropolis steps that
leave the posterior as it is (audience/particles.py has the sources).

A sweep proposes to each particle, for each character in turn, another value of one of its latents
and then any mind; in the end, that another character is rational or not.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy

from i2pdsl.audience.particles import (
    Array,
    Swarm,
    SwarmTables,
    effective,
    looked_up,
    picked,
    total,
)

OF_VALUE = OF_MIND = 2  # uniform numbers: for what is proposed, and for whether it is taken


def steps_of(characters: int) -> int:
    """How many uniform numbers a sweep takes of each particle."""
    return characters * (OF_VALUE + OF_MIND) + characters + 2


def after_frame(tables: SwarmTables, swarm: Swarm) -> Swarm:
    """The swarm as the next frame finds it: drawn anew and moved where too few count."""
    xp = swarm.log_weight.__array_namespace__()
    count = effective(swarm.log_weight)
    low = count < tables.least
    chosen = _resampled(tables, swarm)
    moved = rejuvenated(tables, chosen, tables.draws.moves[swarm.seen])
    return swarm._replace(
        minds=xp.where(low[..., None, None], moved.minds, swarm.minds),
        log_weight=xp.where(low[..., None], moved.log_weight, swarm.log_weight),
        since=xp.where(low[..., None], moved.since, swarm.since),
        seen=swarm.seen + 1,
        effective=count,
    )


def _resampled(tables: SwarmTables, swarm: Swarm) -> Swarm:
    """As many particles, each drawn by its weight: systematic resampling."""
    xp = swarm.log_weight.__array_namespace__()
    count = swarm.log_weight.shape[-1]
    ends = xp.cumsum(xp.exp(swarm.log_weight), axis=-1)
    ends = ends / ends[..., -1:]
    points = (xp.arange(count) + tables.draws.offset[swarm.seen][..., None]) / count
    parent = (ends[..., None, :] <= points[..., :, None]).sum(-1)
    parent = xp.clip(parent, 0, count - 1)
    return swarm._replace(
        minds=xp.take_along_axis(swarm.minds, parent[..., None], axis=-2),
        log_weight=xp.zeros_like(swarm.log_weight) - xp.log(xp.asarray(count * 1.0)),
        since=xp.take_along_axis(swarm.since, parent, axis=-1),
    )


def log_target(tables: SwarmTables, swarm: Swarm, minds: Array) -> Array:
    """log of the posterior of hypotheses [..., N, C], each as one that was started from when the
    particle in its place was; up to a constant. -inf for what is no hypothesis."""
    xp = swarm.log_weight.__array_namespace__()
    group = total(tables.flag, minds)
    possible: Any = True
    for c in range(tables.flag.shape[0]):
        possible = possible & tables.possible[group, c, minds[..., c]]
    row = xp.where(possible, looked_up(tables.row, minds), 0)
    found = xp.where(swarm.since == 0, tables.log_weight[row], tables.log_known[row])
    for problem, now, marks in zip(tables.problems, swarm.sums, swarm.marks, strict=True):
        at = xp.where(possible, looked_up(problem, minds), 0)
        count = now.shape[-1]
        flat = marks.reshape(*marks.shape[:-2], -1)
        found = found + picked(now, at)
        if marks.shape[-2] > 1:
            found = found - picked(flat, swarm.since * count + at)
    return xp.where(possible, found, -xp.inf)


def rejuvenated(tables: SwarmTables, swarm: Swarm, uniforms: Array) -> Swarm:
    """Every particle after some Metropolis steps.

    Args:
        uniforms: [..., sweeps, steps_of(C), N].
    """
    xp = swarm.log_weight.__array_namespace__()

    characters, groups = tables.flag.shape[0], tables.sizes.shape[0]

    def step(held: tuple[Array, Array], move: Move, drawn: Array) -> tuple[Array, Array]:
        minds, now = held
        given = [drawn[..., k, :] for k in range(drawn.shape[-2])]
        proposed, ratio = move(minds, given[:-1])
        there = log_target(tables, swarm, proposed)
        goes = xp.log(given[-1]) < there - now + ratio
        return xp.where(goes[..., None], proposed, minds), xp.where(goes, there, now)

    def of_one(held: tuple[Array, Array], given: tuple[Array, Array]) -> Any:
        c, drawn = given
        held = step(held, partial(another_value, tables, c), drawn[..., :OF_VALUE, :])
        return step(held, partial(another_mind, tables, c), drawn[..., OF_VALUE:, :]), None

    def sweep(held: tuple[Array, Array], drawn: Array) -> Any:
        own = characters * (OF_VALUE + OF_MIND)
        each = drawn[..., :own, :].reshape(*drawn.shape[:-2], characters, -1, drawn.shape[-1])
        held = _over(xp, of_one, held, (xp.arange(characters), xp.moveaxis(each, -3, 0)))
        if groups > 1:
            held = step(held, partial(rational_or_not, tables), drawn[..., own:, :])
        return held, None

    held = swarm.minds, log_target(tables, swarm, swarm.minds)
    minds, _ = _over(xp, sweep, held, xp.moveaxis(uniforms, -3, 0))
    return swarm._replace(minds=minds)


def _over(xp: Any, step: Callable[..., Any], held: Any, given: Any) -> Any:
    """What is held after a step for each of what is given, along the first axes."""
    if xp is not numpy:
        import jax

        return jax.lax.scan(step, held, given)[0]
    parts = zip(*given, strict=True) if isinstance(given, tuple) else given
    for part in parts:
        held, _ = step(held, part)
    return held


Move = Callable[[Array, Sequence[Array]], tuple[Array, Array]]
"""A proposal: of hypotheses [..., N, C] and uniform numbers others, and the log of how much more
likely the way back is."""


def another_value(
    tables: SwarmTables, c: int, minds: Array, drawn: Sequence[Array]
) -> tuple[Array, Array]:
    """One latent of one character has another value."""
    xp = tables.flag.__array_namespace__()
    mind = minds[..., c]
    count = tables.near_count[c][mind]
    other = xp.where(count > 0, _one_of(tables.near[c][mind], count, drawn[0]), mind)
    back = tables.near_count[c][other]
    log = lambda n: xp.log(xp.maximum(n, 1) * _one(drawn[0]))
    return _with(minds, c, other), log(count) - log(back)


def another_mind(
    tables: SwarmTables, c: int, minds: Array, drawn: Sequence[Array]
) -> tuple[Array, Array]:
    """One character thinks anything that is possible while the same are rational."""
    group = total(tables.flag, minds)
    fresh = _one_of(tables.options[group, c], tables.sizes[group, c], drawn[0])
    return _with(minds, c, fresh), 0 * drawn[0]


def rational_or_not(
    tables: SwarmTables, minds: Array, drawn: Sequence[Array]
) -> tuple[Array, Array]:
    """One character becomes rational, or irrational, and whoever may think of that thinks anew."""
    xp = tables.flag.__array_namespace__()
    characters, (which, *anew) = tables.flag.shape[0], drawn
    group = total(tables.flag, minds)
    who = xp.minimum(xp.asarray(which * characters, dtype=group.dtype), characters - 1)
    switched = group ^ (1 << who)
    proposed, ratio = minds, 0 * which
    for c in range(characters):
        size, before = tables.sizes[switched, c], tables.sizes[group, c]
        again = tables.redrawn[who, c]
        fresh = _one_of(tables.options[switched, c], size, anew[c])
        proposed = _with(proposed, c, xp.where(again, fresh, minds[..., c]))
        more = xp.log(size * _one(which)) - xp.log(before * _one(which))
        ratio = ratio + xp.where(again, more, 0 * which)
    return proposed, ratio


def _one(like: Array) -> Array:
    """1, of the precision of an array."""
    return like.__array_namespace__().ones((), like.dtype)


def _one_of(options: Array, count: Array, uniform: Array) -> Array:
    """One of the first `count` of the options [..., N, K], evenly."""
    xp = options.__array_namespace__()
    at = xp.minimum(xp.asarray(uniform * count, dtype=count.dtype), xp.maximum(count - 1, 0))
    return xp.take_along_axis(options, at[..., None], axis=-1)[..., 0]


def _with(minds: Array, c: int, mind: Array) -> Array:
    """The same with another mind of one character."""
    xp = minds.__array_namespace__()
    here = xp.arange(minds.shape[-1]) == c
    return xp.where(here, mind[..., None], minds)
