"""What viewers who have seen so much of a script hold of an earlier frame: forward-backward
smoothing over their hidden chain (Baum, Petrie, Soules and Weiss 1970, DOI
10.1214/aoms/1177697196). A frame that they have not seen yet is forecast.

The observations of a script are counted from 0, U in each frame. After frame k, k U of them are
known. NumPy and JAX arrays alike.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from i2pdsl.audience.filter import Switching, earlier, later, log_sum
from i2pdsl.language import typed as ty
from i2pdsl.worlds.world import World

if TYPE_CHECKING:
    from i2pdsl.objective.frame import Frame

Array = Any


class Chain(NamedTuple):
    """What becomes of a hypothesis after each observation of a frame (audience/filter.py)."""

    forgetting: Array
    switching: tuple[Switching | None, ...]


def hindsight(
    world: World, chain: Chain, frames: Frame, at: Array, known: Array, believed: Array, ahead: bool
) -> Array:
    """log P(H after frame k | the first p observations), [n, ..., O, H].

    Args:
        frames: of one script or more, [F + 1, ...], frame 0 being the start. Those that are not
            there have another number than their place.
        at: the frames k, [n] or [1].
        known: how many observations are known, p, [n] or [1].
        believed: the belief then, [n, ..., O, H] or [1, ..., O, H].
        ahead: whether any k may not have been seen whole.
    """
    xp = frames.log_belief.__array_namespace__()
    observations = frames.log_rows.shape[-3]
    leading = (-1,) + (1,) * (frames.log_belief.ndim - 1)
    asked, known = (xp.reshape(each, leading) for each in (at * observations, known))
    places = xp.arange(len(frames.number))
    there = frames.number == places.reshape(-1, *(1,) * (frames.number.ndim - 1))
    observed = (world.is_observed(frames.action) & there)[..., None, None]
    steps = tuple(part[1:] for part in (places, frames.log_rows, observed))

    def back(carry: tuple[Array, Array], frame: Any) -> tuple[tuple[Array, Array], None]:
        (message, found), (number, rows, seen) = carry, frame
        for u in reversed(range(observations)):
            which = (number - 1) * observations + u
            before = rows[..., u, :, :] + earlier(message, chain.forgetting, chain.switching[u])
            message = xp.where((which < known) & seen, before, message)
            found = xp.where(which == asked, message, found)
        return (message, found), None

    def onward(belief: Array, frame: Any) -> tuple[Array, None]:
        number, _, seen = frame
        for u in range(observations):
            which = (number - 1) * observations + u
            passes = (which >= known) & (which < asked) & seen
            after = later(belief, chain.forgetting, chain.switching[u])
            belief = xp.where(passes, after, belief)
        return belief, None

    filtered = frames.log_belief[at]
    shape = np.broadcast_shapes(filtered.shape, believed.shape)
    nothing = xp.zeros_like(believed), xp.zeros(shape, filtered.dtype)
    _, found = _over(xp, back, nothing, steps, reverse=True)
    joint = filtered + found
    smoothed = joint - log_sum(joint)[..., None]
    if not ahead:
        return smoothed
    forecast = _over(xp, onward, xp.broadcast_to(believed, shape), steps, reverse=False)
    return xp.where(asked > known, forecast, smoothed)


def chain_of(world: World, tables: Any) -> Chain:
    """What the viewers of a world hold of it."""
    return Chain(world.forgetting(tables), world.switching(tables))


def how_many(frames: Frame, number: Array, moment: ty.Moment) -> Array:
    """How many observations are known at a moment, that of frame `number`."""
    observations = frames.log_rows.shape[-3]
    missing = 0 if moment.seen is None else observations - moment.seen
    return number * observations - missing


def may_be_ahead(moment: ty.Moment, given: ty.Moment) -> bool:
    """Whether a frame is asked for that has not been seen whole, at any t."""
    if moment.first is None or given.first is None or moment.first != given.first:
        last, first = max(moment.frames, default=0), min(given.frames, default=0)
        pairs = [(last, first)]
    else:
        pairs = list(zip(moment.frames, given.frames, strict=False))
    return any(k > n or (k == n and given.seen is not None) for k, n in pairs)


def _over(xp: Any, step: Callable[..., Any], carry: Any, steps: Any, reverse: bool) -> Any:
    """What is left of the carry after all frames, from the last one or from the first."""
    if xp is not np:
        import jax

        return jax.lax.scan(step, carry, steps, reverse=reverse)[0]
    for frame in _rows(steps, reverse):
        carry, _ = step(carry, frame)
    return carry


def _rows(steps: Any, reverse: bool) -> Iterator[Any]:
    count = len(steps[0])
    for number in reversed(range(count)) if reverse else range(count):
        yield tuple(part[number] for part in steps)
