"""A prefix as if nothing more happened: viewers go on believing what they believe, and see what
they see, until the end of the story. What a search may hope for of a script that is not whole."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from i2pdsl.language import typed as ty
from i2pdsl.objective.frame import Frame, Shares, View, prior_view
from i2pdsl.worlds.world import World

Array = Any


class HeldScope:
    """The frames `times` [n_t] after the last one, all alike, with a first axis of length 1.

    `accumulated` are the sums that stand inside this one, up to the last frame that is there.
    """

    accumulated: Sequence[Array]
    length: int
    held = False

    def __init__(
        self, world: World, tables: Any, params: Any, last: Frame, first_state: Array, times: Array
    ):
        self.world, self.tables, self.params = world, tables, params
        self.first_state, self.t = first_state, times
        self.count = times
        self.xp = last.log_belief.__array_namespace__()
        self.frame = still(world, last).at(None)

    def view(self, moment: ty.Moment) -> View:
        if moment.first is None:
            return prior_view(self, state=self.first_state)
        frame = self.frame
        return View(frame.log_belief, frame.state, frame, True, frame.share, frame.holdings)


def still(world: World, last: Frame) -> Frame:
    """A frame after another in which nothing happens, as in an event without effect."""
    shares, xp = last.shares, last.log_belief.__array_namespace__()
    each = lambda belief: xp.broadcast_to(belief, last.log_expecting.shape)
    if shares is not None:
        shares = Shares(shares.belief, shares.belief, each(shares.belief), shares.product)
    return last._replace(
        before=last.state,
        action=last.action * 0 + world.turn_count,
        log_previous=last.log_belief,
        log_expecting=each(last.log_belief),
        log_rows=xp.zeros_like(last.log_rows),
        regret=xp.zeros_like(last.regret),
        shares=shares,
    )


def held_history(world: World, frames: Frame, last: Frame) -> Frame:
    """A history [T + 1, ...] whose frames after the last one are held."""
    xp = last.log_belief.__array_namespace__()
    numbers = xp.arange(frames.number.shape[0])
    after = numbers > last.number
    hold = still(world, last)._replace(number=last.number)

    def part(old: Array, new: Array) -> Array:
        shape = (-1, *(1,) * (old.ndim - 1))
        return xp.where(after.reshape(shape), new, old)

    return frames.each(part, hold)
