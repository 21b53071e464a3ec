"""From an objective to a fold over frames: `init` at the start, `step` with each frame, `score`
at any time (the objective of the prefix so far, language.md "Prefixes").

Sums that look at frames t and t - 1 only are accumulated; a sum that looks elsewhere keeps the
history and is taken anew at each score.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from i2pdsl.audience.holding import Holding
from i2pdsl.language import typed as ty
from i2pdsl.language.vocabulary import Weights
from i2pdsl.objective.appended import append_turns, with_suffix
from i2pdsl.objective.beats import begun, best, further, through
from i2pdsl.objective.belief import first_belief
from i2pdsl.objective.compile import Closure, Compiler, Params, reduce_over_history, terms_of
from i2pdsl.objective.film import Film, costs, no_film, see, weighed
from i2pdsl.objective.frame import EndScope, Frame, HistoryScope, StartScope, StepScope
from i2pdsl.objective.held import HeldScope, held_history
from i2pdsl.objective.looks import asks_holdings, looks_around, looks_back, looks_far
from i2pdsl.objective.pins import Pins, broken, still_to_break
from i2pdsl.objective.requirements import VIOLATION
from i2pdsl.worlds.world import World

Array = Any


@dataclass(frozen=True)
class Objective:
    """A compiled objective.

    Attributes:
        init: (tables, params, state) -> carry.
        step: (tables, params, carry, frame) -> carry.
        score: (tables, params, carry, frame) -> number; `frame` is the last one so far.
        promise: of the same, the score if nothing more happened until the end: viewers go on
            believing what they believe, and see what they see. At the end it is the score.
        params: what this story passes to them.
        shape: a digest; objectives of equal shape share one compiled program.
        keeps_history: whether the carry holds all frames, which costs memory and time.
        looks_around: whether it asks what else may happen after a frame, as `suspense` does.
        suffix_turns: the appended turns that it scores.
        weights: where the weights of all terms stand in `params.numbers`, the writer's first.
    """

    init: Callable[..., Any]
    step: Callable[..., Any]
    score: Callable[..., Array]
    promise: Callable[..., Array]
    params: Params
    shape: str
    keeps_history: bool
    looks_around: bool
    suffix_turns: tuple[ty.Turn, ...]
    weights: tuple[int, ...]

    def alone(self, *terms: int) -> Objective:
        """Some of its terms without the others; it has the same compiled program."""
        numbers = self.params.numbers.copy()
        numbers[[place for i, place in enumerate(self.weights) if i not in terms]] = 0.0
        return replace(self, params=self.params._replace(numbers=numbers))


def compile_objective(
    world: World,
    length: int,
    terms: list[tuple[float, ty.Typed]],
    weights: Weights,
    viewers: ty.Viewers | None = None,
    pins: Pins | None = None,
    before: int | None = None,
) -> Objective:
    """Compiles weighted expressions to init, step and score.

    Args:
        terms: (weight, expression); the automatic rationality term is one of them.
        weights: of the automatic terms that look at frames (film.py).
        viewers: the observers that those are about, where not all are.
        pins: each frame that is not as it is pinned costs VIOLATION.
        before: frames before the story begins, where others of its kind begin earlier (late.py).
    """
    compiler = Compiler(world, length)
    sums: list[_Sum] = []
    beats: list[_Beats] = []
    nodes = [node for _, e in terms for node in ty.walk(e)]
    holds = not world.lists_hypotheses and any(map(asks_holdings, nodes))
    history = any(looks_far(node, length) or (holds and looks_back(node)) for node in nodes)
    compiler.on_reduction = (
        reduce_over_history(compiler) if history else _incremental(compiler, sums, beats)
    )
    places = [len(compiler.numbers) + i for i in range(len(terms))]
    compiler.numbers.extend(weight for weight, _ in terms)
    built = [compiler.build(e) for _, e in terms]
    seen = None
    if weights.sees_frames:
        sensible = bool(weights.naturalness)  # regret takes as long as a question
        seen = _Seen(len(compiler.numbers), len(world.weak_chances), viewers, sensible)
        compiler.numbers.extend((*weights, *world.weak_chances))
    compiler.shape += [
        str(seen),
        "" if pins is None else "pinned",
        "" if before is None else "late",
    ]
    suffixes = _appended(terms)
    value = partial(_score, world, built, places, sums, history, length, suffixes, seen)
    return Objective(
        init=_init(world, sums, beats, history, length, seen, pins is not None, holds),
        step=_step(world, sums, beats, history, length, seen, holds),
        score=value(held=False),
        promise=value(held=True),
        params=compiler.params()._replace(
            pins=pins, before=None if before is None else np.int32(before)
        ),
        shape=hashlib.sha256("".join((str(length), *compiler.shape)).encode()).hexdigest()[:16],
        keeps_history=history,
        looks_around=any(map(looks_around, (e for _, e in terms))),
        suffix_turns=tuple(turn for group in suffixes for turn in group),
        weights=(*places, *(seen.places if seen is not None else ())),
    )


def _appended(terms: list[tuple[float, ty.Typed]]) -> list[tuple[ty.Turn, ...]]:
    found = (n.turns for _, e in terms for n in ty.walk(e) if isinstance(n, ty.Moment) and n.turns)
    return list(dict.fromkeys(found))


@dataclass(frozen=True)
class _Sum:
    """An incremental reduction: its term, and its place in the carry."""

    node: ty.Reduction
    term: Closure
    number: int


@dataclass(frozen=True)
class _Beats:
    """Incremental beats: their terms, and their place in the carry."""

    node: ty.Beats
    terms: list[Closure]
    number: int


def _incremental(
    compiler: Compiler, sums: list[_Sum], beats: list[_Beats]
) -> Callable[[ty.Reduction | ty.Beats], Closure]:
    def on_beats(node: ty.Beats) -> Closure:
        own = _Beats(node, [compiler.build(part) for part in node.parts], len(beats))
        beats.append(own)

        def value(scope: Any) -> Array:
            cells, left = scope.beats[own.number], node.last - scope.count
            if scope.held:
                times = scope.xp.arange(1, node.last + 1)
                terms = terms_of(own.terms, _held(scope, times), times)
                cells = through(cells, terms, times > scope.last.number, node.least)
                left = 0
            return best(cells, left, node.least)

        return value

    def on_reduction(node: ty.Reduction | ty.Beats) -> Closure:
        if isinstance(node, ty.Beats):
            return on_beats(node)
        term = compiler.build(node.body)
        own = _Sum(node, term, len(sums))
        sums.append(own)

        def value(scope: EndScope) -> Array:
            return _total(scope, own)

        return value

    return on_reduction


_EMPTY = {"sum": 0.0, "mean": 0.0, "min": np.inf, "max": -np.inf}
_JOIN = {"sum": "add", "mean": "add", "min": "minimum", "max": "maximum"}


def _total(scope: Any, own: _Sum) -> Array:
    """The reduction over the frames so far, and over the appended ones that it reaches."""
    xp, node = scope.xp, own.node
    total = scope.accumulated[own.number]
    count = scope.count
    if scope.held:
        total, count = _joined_held(scope, own, total), scope.length
    none: Any = node.first - 1  # how many frames there are before the first one
    if scope.params.before is not None and node.first <= 1:
        none = scope.params.before
    count = xp.clip(count, none, min(node.last, scope.length)) - none
    for t in range(max(scope.length + 1, node.first), node.last + 1):
        total = getattr(xp, _JOIN[node.kind])(total, own.term(scope.at(t)))
        count = count + 1
    if node.kind == "mean":
        return total / xp.maximum(count, 1)
    return total if node.kind == "sum" else xp.where(count > 0, total, 0.0)


@dataclass(frozen=True)
class _Seen:
    """Where the parameters of the terms that look at frames stand, of so many weak characters; the
    observers that they are about, where not all are; and whether regret counts."""

    first: int
    weak: int
    viewers: ty.Viewers | None
    sensible: bool

    @property
    def places(self) -> range:
        return range(self.first, self.first + len(Weights._fields))

    def weights(self, params: Params) -> Weights:
        return Weights(*(params.numbers[place] for place in self.places))

    def chances(self, params: Params) -> Array:
        first = self.places.stop
        return params.numbers[first : first + self.weak]


def _joined_held(scope: Any, own: _Sum, total: Array) -> Array:
    """A total with the terms of the frames that are yet to come, were they like the last one."""
    xp, node = scope.xp, own.node
    times = xp.arange(max(1, node.first), min(node.last, scope.length) + 1)
    if not times.shape[0]:
        return total
    terms = xp.broadcast_to(own.term(_held(scope, times)), times.shape)
    terms = xp.where(times > scope.last.number, terms, _EMPTY[node.kind])
    whole = {"min": xp.min, "max": xp.max}.get(node.kind, xp.sum)(terms)
    joined: Array = getattr(xp, _JOIN[node.kind])(total, whole)
    return joined


def _held(scope: Any, times: Array) -> HeldScope:
    """The frames that are yet to come, were they like the last one."""
    held = HeldScope(scope.world, scope.tables, scope.params, scope.last, scope.first_state, times)
    held.accumulated, held.length = scope.accumulated, scope.length
    return held


class _Carry(NamedTuple):
    """What the fold keeps: sums so far, what was seen in frames, the start, the history."""

    sums: Array  # [n]
    film: Film | None
    beats: tuple[Array, ...]
    first_state: Array
    frames: Frame | None  # [T + 1, ...], frame 0 is the start
    broken: Array | None = None  # pins so far


def _init(
    world: World,
    sums: list[_Sum],
    beats: list[_Beats],
    history: bool,
    length: int,
    seen: _Seen | None,
    pinned: bool,
    holds: bool,
) -> Callable[..., _Carry]:
    def init(tables: Any, params: Params, state: Array) -> _Carry:
        belief = first_belief(world, tables)
        prior, holdings = belief.log, belief.holdings
        xp = prior.__array_namespace__()
        zero = xp.zeros((), dtype=prior.dtype)
        zero_frames = xp.zeros((), dtype=xp.int32) + (0 if params.before is None else params.before)
        start = StartScope(world, tables, params, state, zero_frames)
        values: list[Array] = []
        start.accumulated, start.length = values, length
        for own in sums:
            value = zero + _EMPTY[own.node.kind]
            values.append(zero + own.term(start) if own.node.first == 0 else value)
        frames = None
        if history:
            action = world.no_action(state)
            rows = world.log_rows(tables, state, action, state)
            first = _first_frame(xp, state, action, prior, len(rows))
            first = first._replace(holdings=_remembered(holdings) if holds else ())
            frames = first.each(lambda part: xp.broadcast_to(part[None], (length + 1, *part.shape)))
        return _Carry(
            xp.stack(values) if values else xp.zeros((0,), dtype=prior.dtype),
            None if seen is None else no_film(xp, seen.weak, prior.dtype),
            tuple(begun(xp, len(b.terms), b.node.least, prior.dtype) for b in beats),
            state,
            frames,
            xp.zeros((), dtype=xp.int32) if pinned else None,
        )

    return init


def _remembered(holdings: tuple[Holding, ...]) -> tuple[Holding, ...]:
    """What is held without what only the next step needs."""
    return tuple(held.remembered for held in holdings)


def _first_frame(xp: Any, state: Array, action: Array, prior: Array, observed: int) -> Frame:
    """The start as frame 0: no action, and the prior as its belief."""
    rows = xp.zeros((observed, *prior.shape), dtype=prior.dtype)
    number = xp.zeros((), dtype=xp.int32)
    state = xp.asarray(state)
    regret = xp.zeros(prior.shape[:-1], dtype=prior.dtype)
    return Frame(number, state, xp.asarray(action), state, prior, prior, rows, rows, regret)


def _step(
    world: World,
    sums: list[_Sum],
    beats: list[_Beats],
    history: bool,
    length: int,
    seen: _Seen | None,
    holds: bool,
) -> Callable[..., _Carry]:
    def step(tables: Any, params: Params, carry: _Carry, frame: Frame) -> _Carry:
        scope = StepScope(world, tables, params, frame, carry.first_state)
        xp = scope.xp
        values: list[Array] = []
        scope.accumulated, scope.length = values, length
        for own in sums:
            before = carry.sums[own.number]
            term = own.term(scope)
            joined = getattr(xp, _JOIN[own.node.kind])(before, term)
            inside = (own.node.first <= frame.number) & (frame.number <= own.node.last)
            values.append(xp.where(inside, joined, before))
        film = carry.film
        if seen is not None:
            assert film is not None
            chances = seen.chances(params)
            film = see(world, tables, chances, film, frame, seen.viewers, seen.sensible)
        frames = carry.frames
        if history:
            assert frames is not None
            kept = frame._replace(holdings=_remembered(frame.holdings) if holds else ())
            frames = frames.each(lambda old, new: old.at[frame.number].set(new), kept)
        return carry._replace(
            sums=xp.stack(values) if values else carry.sums,
            film=film,
            beats=tuple(
                further(carry.beats[b.number], _stacked(xp, b.terms, scope), b.node.least)
                for b in beats
            ),
            frames=frames,
            broken=None if params.pins is None else carry.broken + broken(params.pins, frame),
        )

    return step


def _stacked(xp: Any, terms: list[Closure], scope: StepScope) -> Array:
    """What the frame at hand is worth in each beat, [n]."""
    return xp.stack([xp.asarray(term(scope)) for term in terms])


def _score(
    world: World,
    built: list[Closure],
    places: list[int],
    sums: list[_Sum],
    history: bool,
    length: int,
    appended: list[tuple[ty.Turn, ...]],
    seen: _Seen | None,
    held: bool,
) -> Callable[..., Array]:
    def score(tables: Any, params: Params, carry: _Carry, last: Frame) -> Array:
        xp = last.log_belief.__array_namespace__()
        suffixes, first = {}, 0
        for turns in appended:
            rows = params.suffix_rows[first : first + len(turns)]
            suffixes[turns] = append_turns(world, tables, turns, last, rows)
            first += len(turns)
        scope: Any
        if history:
            assert carry.frames is not None
            frames = held_history(world, carry.frames, last) if held else carry.frames
            histories: dict[tuple[ty.Turn, ...], tuple[Frame, Array]] = {
                (): (frames, xp.ones((length + 1,), dtype=bool))
            }
            for turns, suffix in suffixes.items():
                histories[turns] = with_suffix(xp, frames, suffix)
            count = length if held else last.number
            scope = HistoryScope(world, tables, params, histories, count, length, None)
        else:
            given = (world, tables, params, last, carry.first_state, length, suffixes)
            scope = _FoldScope(*given, held=held)
            scope.accumulated, scope.beats = carry.sums, carry.beats
        total = xp.zeros((), dtype=last.log_belief.dtype)
        for number, value in zip(places, built, strict=True):
            total = total + params.numbers[number] * value(scope)
        if seen is not None:
            assert carry.film is not None
            total = total + weighed(seen.weights(params), costs(seen.chances(params), carry.film))
        if params.pins is not None:
            ahead = still_to_break(params.pins, last.number, last.state)
            total = total - VIOLATION * (carry.broken + ahead)
        return total

    return score


class _FoldScope(EndScope):
    """The end of a prefix whose sums were accumulated."""

    accumulated: Array
    beats: tuple[Array, ...]

    def at(self, t: int) -> EndScope:
        """The same end, looked at from an appended frame t."""
        scope = _FoldScope(
            self.world,
            self.tables,
            self.params,
            self.last,
            self.first_state,
            self.length,
            self.suffixes,
            t,
            self.held,
        )
        scope.accumulated, scope.beats = self.accumulated, self.beats
        return scope
