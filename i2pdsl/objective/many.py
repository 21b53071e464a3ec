"""Expressions over many finished scripts of one length at once, in NumPy and doubles.

As objective/replay.py with one more axis: frames are [N, T + 1, ...], and a number is
[N, n_t] over `times`. What does not depend on t is [N, 1], so that both can be combined.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from i2pdsl.language import typed as ty
from i2pdsl.objective.appended import append_turns
from i2pdsl.objective.beats import begun, best, through
from i2pdsl.objective.compile import Closure, Compiler
from i2pdsl.objective.frame import Frame, View, view_after
from i2pdsl.objective.hindsight import chain_of, hindsight, how_many, may_be_ahead
from i2pdsl.worlds.world import World

Array = Any
Histories = dict[tuple[ty.Turn, ...], tuple[Frame, np.ndarray]]


class ScriptsScope:
    """All frames of many scripts; see frame.HistoryScope."""

    xp = np

    def __init__(
        self,
        world: World,
        params: Any,
        histories: Histories,
        length: int,
        times: np.ndarray | None,
    ):
        self.world, self.tables, self.params = world, world.tables, params
        self.histories, self.count, self.length, self.t = histories, length, length, times

    def at(self, times: np.ndarray) -> ScriptsScope:
        """The same scripts at other frames."""
        return ScriptsScope(self.world, self.params, self.histories, self.length, times)

    def view(self, moment: ty.Moment) -> View:
        frames, possible = self.histories[moment.turns]
        index, safe = self._place(moment)
        if not np.array_equal(safe, np.arange(possible.shape[1])):
            frames, possible = frames.at(np.s_[:, safe]), possible[:, safe]
        return view_after(frames, moment, (index == safe) & possible)

    def hindsight(self, moment: ty.Moment, given: ty.Moment) -> View:
        """See frame.HistoryScope."""
        turns = max(moment.turns, given.turns, key=len)
        frames = self.histories[turns][0].each(lambda part: np.moveaxis(part, 1, 0))
        (_, at), (_, last) = self._place(moment), self._place(given)
        exists = self.view(moment).exists & self.view(given).exists
        believed = np.moveaxis(self.view(given).log_belief, 1, 0)
        known, ahead = how_many(frames, last, given), may_be_ahead(moment, given)
        chain = chain_of(self.world, self.tables)
        found = hindsight(self.world, chain, frames, at, known, believed, ahead)
        state = np.moveaxis(frames.state[at], 0, 1)
        return View(np.moveaxis(found, 0, 1), state, None, exists)

    def _place(self, moment: ty.Moment) -> tuple[np.ndarray, np.ndarray]:
        """The numbers of frames that are meant, for each t, and those of frames that there are."""
        total = self.length + len(moment.turns)
        frame_numbers = np.asarray(moment.frames, dtype=int)  # of no frames: empty
        if moment.first is None:
            index = frame_numbers[:1]
        else:
            assert self.t is not None
            index = frame_numbers[np.clip(self.t - moment.first, 0, len(frame_numbers) - 1)]
        return index, np.clip(index, 0, total)


def histories(world: World, frames: Frame, expression: ty.Typed) -> Histories:
    """The scripts, and those that an expression appends turns to, with what of them can happen:
    bool [N, T + 1 + turns]."""
    shape = frames.number.shape
    found: Histories = {(): (frames, np.ones(shape, dtype=bool))}
    last = frames.at(np.s_[:, -1])
    for node in ty.walk(expression):
        if isinstance(node, ty.Moment) and node.turns not in found:
            suffix = append_turns(world, world.tables, node.turns, last)
            longer = frames.each(
                lambda part, *more: np.concatenate([part, *(m[:, None] for m in more)], axis=1),
                *(frame for frame, _ in suffix),
            )
            can = [np.broadcast_to(possible, shape[:1])[:, None] for _, possible in suffix]
            found[node.turns] = (
                longer,
                np.concatenate([np.ones(shape, dtype=bool), *can], axis=1),
            )
    return found


def evaluate_many(
    world: World, frames: Frame, expression: ty.Typed, times: range | None
) -> np.ndarray:
    """The value of a checked expression over finished scripts: [N], or [N, n_t] over `times`; of
    a distribution with a last axis of values. NaN where an appended turn cannot happen.

    Args:
        frames: of all of them, as replay.replay_all has them.
    """
    count, length = frames.number.shape[0], frames.number.shape[1] - 1
    compiler = Compiler(world, length)
    compiler.on_reduction = _reductions(compiler)
    closure = compiler.build(expression)
    known = histories(world, frames, expression)
    at = None if times is None else np.arange(times.start, times.stop)
    with np.errstate(all="ignore"):  # log(0) is an answer: -inf
        scope = ScriptsScope(world, compiler.params(), known, length, at)
        value = np.asarray(closure(scope), dtype=float) + 0.0  # -0 is 0
    labels = isinstance(expression, ty.Belief) and bool(expression.labels)
    own = value.shape[-1:] if labels else ()
    shape = (count, 1 if times is None else len(times), *own)
    value = np.broadcast_to(value, shape)
    happens = np.all([possible.all(1) for _, possible in known.values()], axis=0)
    if not happens.all():
        value = np.where(happens.reshape(-1, *(1,) * (value.ndim - 1)), value, np.nan)
    return value[:, 0] if times is None else value


def _reductions(compiler: Compiler) -> Any:
    """How sums over frames are taken: over the last axis, of which one element stays."""

    def on_reduction(node: ty.Reduction | ty.Beats) -> Closure:
        if isinstance(node, ty.Beats):
            return _on_beats(compiler, node)
        body = compiler.build(node.body)
        reduce: Any = getattr(np, node.kind)  # sum, mean, min, max

        def value(scope: ScriptsScope) -> Array:
            times = np.arange(node.first, node.last + 1)
            if not len(times):
                return np.zeros(1)
            terms = np.asarray(body(scope.at(times)))
            if terms.shape[-1:] != times.shape:
                terms = np.broadcast_to(terms, (*terms.shape[:-1], len(times)))
            return reduce(terms, axis=-1, keepdims=True)

        return value

    return on_reduction


def _on_beats(compiler: Compiler, node: ty.Beats) -> Closure:
    parts = [compiler.build(part) for part in node.parts]

    def value(scope: ScriptsScope) -> Array:
        times = np.arange(1, node.last + 1)
        count = len(scope.histories[()][0].number)
        found = (np.asarray(part(scope.at(times))) for part in parts)
        terms = np.stack([np.broadcast_to(part, (count, len(times))) for part in found], axis=-1)
        taken = np.ones(len(times), dtype=bool)
        cells = begun(np, len(parts), node.least, terms.dtype)
        each = [best(through(cells, own, taken, node.least), 0, node.least) for own in terms]
        return np.array(each)[:, None]

    return value
