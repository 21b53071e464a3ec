"""From a typed expression to closures over arrays, and from an objective to a fold over frames.

An objective is a fold: `init` at the start, `step` with each frame, `score` at any time (the
objective of the prefix so far, language.md "Prefixes"). Sums that look at frames t and t - 1 only
are accumulated; a sum that looks elsewhere keeps the history and is taken anew at each score.

Numbers, masks and tables over t are parameters of the compiled program, not constants in it, so
that stories of the same shape share one program.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from i2pdsl.audience import queries
from i2pdsl.language import typed as ty
from i2pdsl.objective.frame import (
    EndScope,
    Frame,
    HistoryScope,
    StartScope,
    StepScope,
    View,
    observe,
)
from i2pdsl.worlds.world import World

Array = Any
Scope = Any
Closure = Callable[[Scope], Array]


class Params(NamedTuple):
    """What a compiled expression is given at run time (H hypotheses, V values of a latent)."""

    numbers: Array  # [n]
    curves: tuple[Array, ...]  # tables over t
    masks: Array  # bool [n, H]
    groups: tuple[Array, ...]  # one-hot [H, V]
    quantities: Array  # [n, H]
    # For each appended turn log P(action | H) in every state, [S, U, O, H]; see `prepare`.
    suffix_rows: tuple[Array, ...] = ()


@dataclass
class Compiler:
    """Turns typed expressions into closures; collects their parameters and their shape."""

    world: World
    length: int
    numbers: list[float] = field(default_factory=list)
    curves: list[tuple[float, ...]] = field(default_factory=list)
    masks: list[ty.Mask] = field(default_factory=list)
    groups: list[ty.Partition] = field(default_factory=list)
    quantities: list[tuple[float, ...]] = field(default_factory=list)
    shape: list[str] = field(default_factory=list)
    on_reduction: Callable[[ty.Reduction], Closure] | None = None

    def params(self) -> Params:
        """The parameters so far, as NumPy arrays of doubles."""
        hypotheses = len(self.world.vocabulary.hypotheses)
        groups = []
        for partition in self.groups:
            one_hot = np.zeros((hypotheses, len(partition.labels)))
            one_hot[np.arange(hypotheses), partition.index] = 1.0
            groups.append(one_hot)
        return Params(
            np.array(self.numbers, dtype=float),
            tuple(np.array(c, dtype=float) for c in self.curves),
            np.array(self.masks, dtype=bool).reshape(-1, hypotheses),
            tuple(groups),
            np.array(self.quantities, dtype=float).reshape(-1, hypotheses),
        )

    # Parameters.

    def mask(self, mask: ty.Mask) -> Closure:
        if mask not in self.masks:
            self.masks.append(mask)
        number = self.masks.index(mask)
        self.shape.append(f"m{number}")
        return lambda scope: scope.params.masks[number]

    def partition(self, partition: ty.Partition | None) -> Closure:
        if partition is None:
            self.shape.append("whole")
            return lambda scope: None
        if partition not in self.groups:
            self.groups.append(partition)
        number = self.groups.index(partition)
        self.shape.append(f"g{number}:{len(partition.labels)}")
        return lambda scope: scope.params.groups[number]

    def moment(self, moment: ty.Moment) -> Callable[[Scope], View]:
        described = moment.offset if moment.offset is not None else moment.frames
        self.shape.append(f"@{moment.first},{described},{moment.turns}")
        return lambda scope: scope.view(moment)

    # Expressions.

    def build(self, node: ty.Typed) -> Closure:
        """The closure of an expression: scope -> number (with the scope's leading axes)."""
        self.shape.append(f"({type(node).__name__}")
        closure: Closure = getattr(self, f"_{type(node).__name__.lower()}")(node)
        self.shape.append(")")
        return closure

    def _constant(self, node: ty.Constant) -> Closure:
        number = len(self.numbers)
        self.numbers.append(float(node.value))
        return lambda scope: scope.params.numbers[number]

    def _timetable(self, node: ty.TimeTable) -> Closure:
        number, first, size = len(self.curves), node.first, len(node.values)
        self.curves.append(node.values)
        self.shape.append(f"{first}:{size}")

        def at(scope: Scope) -> Array:
            index = scope.xp.clip(scope.xp.asarray(scope.t) - first, 0, size - 1)
            return scope.params.curves[number][index]

        return at

    def _perhypothesis(self, node: ty.PerHypothesis) -> Closure:
        number = len(self.quantities)
        self.quantities.append(node.values)
        return lambda scope: scope.params.quantities[number]

    def _apply(self, node: ty.Apply) -> Closure:
        self.shape.append(node.operation)
        parts = [self._aligned(a, node.axes.hypothesis) for a in node.arguments]
        operation = _OPERATIONS[node.operation]
        return lambda scope: operation(scope.xp, *(part(scope) for part in parts))

    def _aligned(self, node: ty.Typed, over_hypotheses: bool) -> Closure:
        """The closure of an operand; one without the hypothesis axis gets it beside one with."""
        closure = self.build(node)
        if not over_hypotheses or node.axes.hypothesis:
            return closure
        return lambda scope: scope.xp.asarray(closure(scope))[..., None, None]

    def _points(self, node: ty.Points) -> Closure:
        at = self.build(node.at)
        xs, ys = np.array(node.xs), np.array(node.ys)
        self.shape.append(f"{node.xs}{node.ys}")

        def interpolated(scope: Scope) -> Array:
            xp, x = scope.xp, at(scope)
            left = xp.clip(xp.searchsorted(xp.asarray(xs), x, side="right") - 1, 0, len(xs) - 2)
            x0, x1 = xp.asarray(xs)[left], xp.asarray(xs)[left + 1]
            share = xp.clip((x - x0) / (x1 - x0), 0.0, 1.0)
            return xp.asarray(ys)[left] * (1 - share) + xp.asarray(ys)[left + 1] * share

        return interpolated

    def _probability(self, node: ty.Probability) -> Closure:
        event, mask = self.mask(node.event), self.mask(node.given.mask)
        return self._belief(
            node.given, lambda s, view: queries.probability(view.belief, event(s), mask(s))
        )

    def _belief(self, given: ty.Given, form: Callable[[Scope, View], Array]) -> Closure:
        """A form about one moment, 0 where the moment does not exist."""
        moment = self.moment(given.moment)

        def value(scope: Scope) -> Array:
            view = moment(scope)
            return _where_exists(scope, view.exists, form(scope, view))

        return value

    def _expectation(self, node: ty.Expectation) -> Closure:
        mask = self.mask(node.given.mask)
        quantity = self._aligned(node.quantity, True)

        def form(scope: Scope, view: View) -> Array:
            inner = _QuantityScope(scope, view.state)
            return queries.expectation(view.belief, quantity(inner), mask(scope))

        return self._belief(node.given, form)

    def _valueat(self, node: ty.ValueAt) -> Closure:
        who = node.who
        self.shape.append(str(who))
        return lambda scope: scope.world.value(scope.tables, who, scope.state)

    def _divergence(self, node: ty.Divergence) -> Closure:
        groups, mask = self.partition(node.partition), self.mask(node.first.mask)
        first, second = self.moment(node.first.moment), self.moment(node.second.moment)

        def value(scope: Scope) -> Array:
            a, b = first(scope), second(scope)
            result = queries.divergence(a.belief, b.belief, groups(scope), mask(scope))
            return _where_exists(scope, b.exists, _where_exists(scope, a.exists, result))

        return value

    def _entropy(self, node: ty.Entropy) -> Closure:
        groups, mask = self.partition(node.partition), self.mask(node.given.mask)
        return self._belief(
            node.given, lambda s, view: queries.entropy(view.belief, groups(s), mask(s))
        )

    def _surprise(self, node: ty.Surprise) -> Closure:
        mask = self.mask(node.given.mask)

        def form(scope: Scope, view: View) -> Array:
            if view.frame is None:
                return scope.xp.zeros(())
            return queries.surprise(view.frame.expecting, view.frame.log_rows, mask(scope))

        return self._belief(node.given, form)

    def _suspense(self, node: ty.Suspense) -> Closure:
        groups, mask = self.partition(node.partition), self.mask(node.given.mask)

        def form(scope: Scope, view: View) -> Array:
            world, tables = scope.world, scope.tables
            ahead = world.turns(tables, view.state)
            return queries.suspense(
                view.belief,
                ahead.log_rows,
                ahead.chance,
                ahead.valid,
                groups(scope),
                mask(scope),
                world.forgetting(tables),
            )

        return self._belief(node.given, form)

    def _distribution(self, node: ty.Distribution) -> Closure:
        groups, mask = self.partition(node.partition), self.mask(node.given.mask)
        moment = self.moment(node.given.moment)

        def value(scope: Scope) -> Array:
            view = moment(scope)
            return queries.marginal(view.belief, groups(scope), mask(scope)).mean(-2)

        return value

    def _feature(self, node: ty.Feature) -> Closure:
        assert node.moment is not None
        name, arguments = node.predicate, self.world_arguments(node)
        self.shape.append(f"{name}{arguments}")
        moment = self.moment(node.moment)

        def value(scope: Scope) -> Array:
            view = moment(scope)
            if view.frame is None:
                return scope.xp.zeros(())
            frame = view.frame
            holds = scope.world.feature(
                scope.tables, name, arguments, frame.state, frame.before, frame.action
            )
            return _where_exists(scope, view.exists, holds * 1.0)

        return value

    def world_arguments(self, node: ty.Feature) -> tuple[Any, ...]:
        """The arguments of a predicate in the world's own numbers."""
        return self.world.feature_arguments(node.predicate, node.arguments)

    def _reduction(self, node: ty.Reduction) -> Closure:
        assert self.on_reduction is not None
        self.shape.append(f"{node.kind}{node.first}..{node.last}")
        return self.on_reduction(node)


class _QuantityScope:
    """The scope of a quantity inside an expectation: it also knows the state."""

    def __init__(self, outer: Scope, state: Array):
        self.world, self.tables, self.params = outer.world, outer.tables, outer.params
        self.t, self.xp, self.state = outer.t, outer.xp, state


def _where_exists(scope: Scope, exists: Array | bool, value: Array) -> Array:
    return value if exists is True else scope.xp.where(exists, value, 0.0)


def _fold(operation: str) -> Callable[..., Array]:
    def apply(xp: Any, first: Array, *rest: Array) -> Array:
        for other in rest:
            first = getattr(xp, operation)(first, other)
        return first

    return apply


def _truth(operation: str) -> Callable[..., Array]:
    def apply(xp: Any, first: Array, *rest: Array) -> Array:
        result = xp.asarray(first) != 0
        for other in rest:
            result = getattr(xp, operation)(result, xp.asarray(other) != 0)
        return result

    return apply


_OPERATIONS: dict[str, Callable[..., Array]] = {
    "add": _fold("add"),
    "multiply": _fold("multiply"),
    "divide": _fold("divide"),
    "power": _fold("power"),
    "min": _fold("minimum"),
    "max": _fold("maximum"),
    "negate": lambda xp, a: -a,
    "and": _truth("logical_and"),
    "or": _truth("logical_or"),
    "not": lambda xp, a: xp.asarray(a) == 0,
    "choose": lambda xp, c, a, b: xp.where(xp.asarray(c) != 0, a, b),
    **{name: _fold(name) for name in ("less", "less_equal", "equal", "not_equal")},
    **{name: _fold(name) for name in ("greater_equal", "greater")},
    **{
        name: (lambda f: lambda xp, a: getattr(xp, f)(a))(name)
        for name in ("sin", "cos", "exp", "log", "sqrt", "abs")
    },
}


# Finished scripts: everything at once.


def evaluate_all(
    compiler: Compiler,
    closure: Closure,
    tables: Any,
    histories: dict[tuple[ty.Turn, ...], tuple[Frame, Array]],
    times: range | None,
    params: Params | None = None,
    count: Array | int | None = None,
) -> Array:
    """The value of a built expression over a whole script, for all t at once."""
    xp = histories[()][0].belief.__array_namespace__()
    scope = HistoryScope(
        compiler.world,
        tables,
        params or compiler.params(),
        histories,
        compiler.length if count is None else count,
        compiler.length,
        None if times is None else xp.arange(times.start, times.stop),
    )
    return closure(scope)


def reduce_over_history(compiler: Compiler) -> Callable[[ty.Reduction], Closure]:
    """How a query takes its sums: over all frames that exist, with t as an axis."""

    def on_reduction(node: ty.Reduction) -> Closure:
        body = compiler.build(node.body)

        def value(scope: HistoryScope) -> Array:
            xp = scope.xp
            times = xp.arange(node.first, node.last + 1)
            inner = HistoryScope(
                scope.world,
                scope.tables,
                scope.params,
                scope.histories,
                scope.count,
                scope.length,
                times,
            )
            terms = xp.broadcast_to(body(inner), times.shape)
            taken = (times <= scope.count) | (times > scope.length)
            return _reduce(xp, node.kind, terms, taken)

        return value

    return on_reduction


def _reduce(xp: Any, kind: str, terms: Array, taken: Array) -> Array:
    """sum, mean, min or max of the terms that are taken; 0 where there are none."""
    some = taken.any()
    if kind in ("sum", "mean"):
        total = xp.where(taken, terms, 0.0).sum()
        return total if kind == "sum" else total / xp.maximum(taken.sum(), 1)
    if kind == "min":
        return xp.where(some, xp.where(taken, terms, xp.inf).min(), 0.0)
    return xp.where(some, xp.where(taken, terms, -xp.inf).max(), 0.0)


# Searches: one frame after the other.


@dataclass(frozen=True)
class Objective:
    """A compiled objective.

    Attributes:
        init: (tables, params, state) -> carry.
        step: (tables, params, carry, frame) -> carry.
        score: (tables, params, carry, frame) -> number; `frame` is the last one so far.
        prepare: (tables, params) -> params, once before a search: what is worth a table.
        params: what this story passes to them.
        shape: a digest; objectives of equal shape share one compiled program.
        keeps_history: whether the carry holds all frames, which costs memory and time.
        has_suffix: whether it scores appended turns.
    """

    init: Callable[..., Any]
    step: Callable[..., Any]
    score: Callable[..., Array]
    prepare: Callable[[Any, Params], Params]
    params: Params
    shape: str
    keeps_history: bool
    has_suffix: bool


def compile_objective(
    world: World,
    length: int,
    terms: list[tuple[float, ty.Typed]],
    plausibility: float,
    chances: tuple[float, ...],
) -> Objective:
    """Compiles weighted expressions to init, step and score.

    Args:
        terms: (weight, expression); the automatic rationality term is one of them.
        plausibility: weight of -(p_hat - p)^2 (paper, "Implementation details").
        chances: the success probability p of each weak character.
    """
    compiler = Compiler(world, length)
    sums: list[_Sum] = []
    history = any(_looks_far(node, length) for _, e in terms for node in ty.walk(e))
    compiler.on_reduction = (
        reduce_over_history(compiler) if history else _incremental(compiler, sums)
    )
    weights = [len(compiler.numbers) + i for i in range(len(terms))]
    compiler.numbers.extend(weight for weight, _ in terms)
    built = [compiler.build(e) for _, e in terms]
    plausible = len(compiler.numbers)
    compiler.numbers.extend((plausibility, *chances))
    compiler.shape.append(f"plausibility{len(chances)}")
    suffixes = _appended(terms)
    return Objective(
        init=_init(world, sums, history, length, len(chances)),
        step=_step(world, sums, history, bool(chances)),
        score=_score(
            world, built, weights, plausible, sums, history, length, suffixes, bool(chances)
        ),
        prepare=_prepare(world, suffixes),
        params=compiler.params(),
        shape=hashlib.sha256("".join((str(length), *compiler.shape)).encode()).hexdigest()[:16],
        keeps_history=history,
        has_suffix=bool(suffixes),
    )


def _appended(terms: list[tuple[float, ty.Typed]]) -> list[tuple[ty.Turn, ...]]:
    found = (n.turns for _, e in terms for n in ty.walk(e) if isinstance(n, ty.Moment) and n.turns)
    return list(dict.fromkeys(found))


def _looks_far(node: object, length: int) -> bool:
    """Whether a form looks at frames that a fold which keeps none cannot reach."""
    match node:
        case ty.Moment(first=None):
            return 0 < node.frames[0] < length
        case ty.Moment():
            return node.offset not in (0, -1)
        case ty.Reduction():
            # A fixed frame inside a sum (the prior excepted) changes terms already taken.
            moments = [n for n in ty.walk(node.body) if isinstance(n, ty.Moment)]
            frames = [
                n.moment if isinstance(n, ty.Feature) else n.given.moment
                for n in ty.walk(node.body)
                if isinstance(n, ty.Feature | ty.Surprise)
            ]
            return any(m.first is None and m.frames[0] != 0 for m in moments) or any(
                m is None or m.offset != 0 for m in frames
            )
        case ty.Feature(moment=ty.Moment(first=None)) | ty.Surprise():
            return False
    return False


@dataclass(frozen=True)
class _Sum:
    """An incremental reduction: its term, and its place in the carry."""

    node: ty.Reduction
    term: Closure
    number: int


def _incremental(compiler: Compiler, sums: list[_Sum]) -> Callable[[ty.Reduction], Closure]:
    def on_reduction(node: ty.Reduction) -> Closure:
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
    n = scope.last.number
    count = xp.clip(n, node.first - 1, min(node.last, scope.length)) - (node.first - 1)
    for t in range(max(scope.length + 1, node.first), node.last + 1):
        total = getattr(xp, _JOIN[node.kind])(total, own.term(scope.at(t)))
        count = count + 1
    if node.kind == "mean":
        return total / xp.maximum(count, 1)
    return total if node.kind == "sum" else xp.where(count > 0, total, 0.0)


class _Carry(NamedTuple):
    """What the fold keeps: sums so far, attempts of weak characters, the start, the history."""

    sums: Array  # [n]
    tried: Array  # [weak characters]
    succeeded: Array
    first_state: Array
    frames: Frame | None  # [T + 1, ...], frame 0 is the start


def _init(
    world: World, sums: list[_Sum], history: bool, length: int, weak: int
) -> Callable[..., _Carry]:
    def init(tables: Any, params: Params, state: Array) -> _Carry:
        prior = world.log_prior(tables)
        xp = prior.__array_namespace__()
        zero = xp.zeros((), dtype=prior.dtype)
        start = StartScope(world, tables, params, state, xp.zeros((), dtype=xp.int32))
        values = []
        for own in sums:
            value = zero + _EMPTY[own.node.kind]
            values.append(zero + own.term(start) if own.node.first == 0 else value)
        frames = None
        if history:
            rows = [xp.zeros_like(row) for row in world.log_rows(tables, state, state * 0)]
            first = _first_frame(xp, state, prior, len(rows))
            frames = Frame(
                *(xp.broadcast_to(part[None], (length + 1, *part.shape)) for part in first)
            )
        return _Carry(
            xp.stack(values) if values else xp.zeros((0,), dtype=prior.dtype),
            xp.zeros((weak,), dtype=prior.dtype),
            xp.zeros((weak,), dtype=prior.dtype),
            state,
            frames,
        )

    return init


def _first_frame(xp: Any, state: Array, prior: Array, observed: int) -> Frame:
    """The start as frame 0: no action, and the prior as its belief."""
    rows = xp.zeros((observed, *prior.shape), dtype=prior.dtype)
    number = xp.zeros((), dtype=xp.int32)
    state = xp.asarray(state)
    return Frame(number, state, xp.zeros_like(state), state, prior, prior, rows, rows)


def _step(world: World, sums: list[_Sum], history: bool, weak: bool) -> Callable[..., _Carry]:
    def step(tables: Any, params: Params, carry: _Carry, frame: Frame) -> _Carry:
        scope = StepScope(world, tables, params, frame)
        scope.first_state = carry.first_state  # type: ignore[attr-defined]
        xp = scope.xp
        values = []
        for own in sums:
            before = carry.sums[own.number]
            term = own.term(scope)
            joined = getattr(xp, _JOIN[own.node.kind])(before, term)
            inside = (own.node.first <= frame.number) & (frame.number <= own.node.last)
            values.append(xp.where(inside, joined, before))
        tried, succeeded = carry.tried, carry.succeeded
        if weak:
            more, won = world.attempts(tables, frame.before, frame.action)
            tried, succeeded = tried + more, succeeded + won
        frames = carry.frames
        if history:
            assert frames is not None
            frames = Frame(
                *(old.at[frame.number].set(new) for old, new in zip(frames, frame, strict=True))
            )
        return carry._replace(
            sums=xp.stack(values) if values else carry.sums,
            tried=tried,
            succeeded=succeeded,
            frames=frames,
        )

    return step


def _score(
    world: World,
    built: list[Closure],
    weights: list[int],
    plausible: int,
    sums: list[_Sum],
    history: bool,
    length: int,
    appended: list[tuple[ty.Turn, ...]],
    weak: bool,
) -> Callable[..., Array]:
    def score(tables: Any, params: Params, carry: _Carry, last: Frame) -> Array:
        xp = last.belief.__array_namespace__()
        suffixes, first = {}, 0
        for turns in appended:
            rows = params.suffix_rows[first : first + len(turns)]
            suffixes[turns] = append_turns(world, tables, turns, last, rows)
            first += len(turns)
        scope: Any
        if history:
            assert carry.frames is not None
            histories: dict[tuple[ty.Turn, ...], tuple[Frame, Array]] = {
                (): (carry.frames, xp.ones((length + 1,), dtype=bool))
            }
            for turns, suffix in suffixes.items():
                histories[turns] = extended(xp, carry.frames, suffix)
            scope = HistoryScope(world, tables, params, histories, last.number, length, None)
        else:
            scope = _FoldScope(world, tables, params, last, carry.first_state, length, suffixes)
            scope.accumulated = carry.sums
        total = xp.zeros((), dtype=last.belief.dtype)
        for number, value in zip(weights, built, strict=True):
            total = total + params.numbers[number] * value(scope)
        if weak:
            p_hat = carry.succeeded / xp.maximum(carry.tried, 1)
            p = params.numbers[plausible + 1 : plausible + 1 + carry.tried.shape[0]]
            miss = xp.where(carry.tried > 0, (p_hat - p) ** 2, 0.0)
            total = total - params.numbers[plausible] * miss.sum()
        return total

    return score


class _FoldScope(EndScope):
    """The end of a prefix whose sums were accumulated."""

    accumulated: Array

    def at(self, t: int) -> EndScope:
        """The same end, looked at from an appended frame t."""
        return EndScope(
            self.world,
            self.tables,
            self.params,
            self.last,
            self.first_state,
            self.length,
            self.suffixes,
            t,
        )


MOST_SUFFIX_BYTES = 400 * 2**20


def _prepare(world: World, appended: list[tuple[ty.Turn, ...]]) -> Callable[[Any, Params], Params]:
    """A search scores an appended turn after every candidate, far more often than there are
    states, so what each hypothesis says of the turn is tabulated, unless the table is too big."""

    def prepare(tables: Any, params: Params) -> Params:
        states = world.all_states(tables)
        turns = [turn for group in appended for turn in group]
        size = 4 * len(states) * world.log_prior(tables).size * len(turns)
        if not turns or size * len(world.vocabulary.characters) > MOST_SUFFIX_BYTES:
            return params
        rows = []
        for turn in turns:
            action, _ = world.act(tables, states, turn)
            found = world.log_rows(tables, states, action)
            rows.append(found[0].__array_namespace__().stack(found, axis=1))
        return params._replace(suffix_rows=tuple(rows))

    return prepare


def append_turns(
    world: World,
    tables: Any,
    turns: tuple[ty.Turn, ...],
    last: Frame,
    rows: tuple[Array, ...] = (),
) -> list[tuple[Frame, Array]]:
    """The frames of appended turns after a frame, and whether each can happen.

    `rows` are the tables of `prepare`, if there are any.
    """
    found = []
    possible: Array = True
    current = last
    for i, turn in enumerate(turns):
        action, allowed = world.act(tables, current.state, turn)
        known = None
        if rows:
            known = tuple(rows[i][current.state, u] for u in range(rows[i].shape[1]))
        number = current.number + 1
        current = observe(world, tables, number, current.state, action, current.belief, known)
        possible = possible & allowed
        found.append((current, possible))
    return found


def extended(xp: Any, frames: Frame, suffix: list[tuple[Frame, Array]]) -> tuple[Frame, Array]:
    """A history [T + 1, ...] with appended frames behind it, and which frames can happen."""
    joined = Frame(
        *(
            xp.concatenate([old, xp.stack([getattr(f, name) for f, _ in suffix])])
            for name, old in frames._asdict().items()
        )
    )
    ok = xp.ones((frames.number.shape[0],), dtype=bool)
    return joined, xp.concatenate([ok, xp.stack([xp.asarray(p) for _, p in suffix])])
