"""From a typed expression to closures over arrays.

Numbers, masks and tables over t are parameters of the compiled program, not constants in it, so
that stories of the same shape share one program.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from i2pdsl.language import typed as ty
from i2pdsl.language.addends import addends, whose
from i2pdsl.language.forms import BY_NAME
from i2pdsl.objective.beats import begun, best, through
from i2pdsl.objective.frame import Frame, HistoryScope, TurnScope, View
from i2pdsl.objective.hindsight import Chain
from i2pdsl.objective.meanings import NUMBERS, TABLES, Asked, OfHeld
from i2pdsl.objective.operations import OPERATIONS
from i2pdsl.objective.reach import Question, frames_until
from i2pdsl.objective.relaxed import Relaxed, least, relaxed
from i2pdsl.worlds.world import World

if TYPE_CHECKING:
    from i2pdsl.objective.pins import Pins

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
    places: tuple[Array, ...]  # numbers of a world's cells, or what is known of them
    # For each appended turn log P(action | H) in every state, [S, U, O, H]; see appended.py.
    suffix_rows: tuple[Array, ...] = ()
    # How far each state is from what a requirement asks for, [S]; see reach.py, relaxed.py.
    reach: tuple[Array | Relaxed, ...] = ()
    pins: Pins | None = None  # of pinned frames; see pins.py
    before: Array | None = None  # frames before the story begins; see late.py


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
    places: list[tuple[int, ...] | np.ndarray] = field(default_factory=list)
    aways: list[ty.Away] = field(default_factory=list)
    shape: list[str] = field(default_factory=list)
    on_reduction: Callable[[ty.Reduction | ty.Beats], Closure] | None = None

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
            tuple(np.array(p, getattr(p, "dtype", np.int32)) for p in self.places),
            reach=tuple(map(self._reach, self.aways)),
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
        self.shape.append(f"@{moment.first},{described},{moment.seen},{moment.turns}")
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
        return lambda scope: scope.of_rows(scope.params.quantities[number])

    def _apply(self, node: ty.Apply) -> Closure:
        self.shape.append(node.operation)
        parts = [self._aligned(a, node.axes.hypothesis) for a in node.arguments]
        operation = OPERATIONS[node.operation]
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

    def _belief(self, node: ty.Belief) -> Closure:
        """A form about beliefs: its meaning, 0 where a moment of it does not exist."""
        if not self.world.lists_hypotheses and BY_NAME[node.form].about == "quantity":
            parts = addends(node.about)
            if len(parts) > 1:
                every = tuple(replace(node, about=part) for part in parts.values())
                return self.build(ty.Apply("add", every))
        self.shape.append(node.form if node.viewers is None else f"{node.form}{node.viewers}")
        viewers, about = node.viewers, self._about(node.about, node.viewers)
        mask = self.mask(node.given[0].mask)
        moments = [self._seen_from(node.moment, given.moment) for given in node.given]
        meaning = (TABLES if node.labels else NUMBERS)[node.form]

        def value(scope: Scope) -> Array:
            views = tuple(moment(scope).of(viewers) for moment in moments)
            subject = about(scope, views[0])
            asked = Asked(scope.world, scope.tables, subject, mask(scope), views, viewers)
            found = meaning(asked)
            for view in () if node.labels else views:
                found = _where_exists(scope, view.exists, found)
            return found

        return value

    def _seen_from(self, moment: ty.Moment | None, given: ty.Moment) -> Callable[[Scope], View]:
        """The last frame that is given, or another one in hindsight."""
        last = self.moment(given)
        if moment is None:
            return last
        then = self.moment(moment)
        self.shape.append("hindsight")
        if self.world.lists_hypotheses:
            return lambda scope: scope.hindsight(moment, given)

        def view(scope: Scope) -> View:  # who forgets nothing asks today's belief of that state
            now, before = last(scope), then(scope)
            return replace(now, state=before.state, exists=now.exists & before.exists)

        return view

    def _about(self, about: Any, viewers: ty.Viewers | None) -> Callable[[Scope, View], Array]:
        """What a form is about: an event [H], a partition [H, V], a quantity [..., O, H] of those
        who are asked, or a character's number."""
        if isinstance(about, int):
            return lambda scope, view: about
        if about is None or isinstance(about, ty.Partition):
            groups = self.partition(about)
            return lambda scope, view: groups(scope)
        if isinstance(about, tuple):
            event = self.mask(about)
            return lambda scope, view: event(scope)
        quantity = self._aligned(about, True)
        asked = whose(about)
        if asked and not self.world.lists_hypotheses:
            first = 0 if viewers is None else viewers[0]

            def of_held(scope: Scope, view: View) -> OfHeld:
                def of(o: int, minds: Any) -> Array:
                    one = (first + o, first + o + 1)
                    found = quantity(_QuantityScope(scope, view.state, one, minds))
                    return scope.xp.asarray(found)[..., 0, :]

                return OfHeld(of, asked)

            return of_held
        return lambda scope, view: quantity(_QuantityScope(scope, view.state, viewers))

    def _valueat(self, node: ty.ValueAt) -> Closure:
        who = node.who
        self.shape.append(str(who))

        def value(scope: _QuantityScope) -> Array:
            found = scope.world.value(scope.tables, who, scope.state)
            found = found if scope.viewers is None else found[..., slice(*scope.viewers), :]
            if scope.minds is None:
                return found
            return scope.minds.of_problems(who, found[..., 0, :])[..., None, :]

        return value

    def _feature(self, node: ty.Feature) -> Closure:
        name = node.predicate
        arguments = [self._argument(a) for a in self.world.feature_arguments(name, node.arguments)]
        self.shape.append(name)

        def asked(scope: Scope, state: Array, before: Array | None, action: Array | None) -> Array:
            given = tuple(a(scope) for a in arguments)
            return scope.world.feature(scope.tables, name, given, state, before, action) * 1.0

        if node.moment is None:  # of a first picture
            return lambda scope: asked(scope, scope.state, None, None)
        moment = self.moment(node.moment)

        def value(scope: Scope) -> Array:
            view = moment(scope)
            if view.frame is None:
                return scope.xp.zeros(())
            frame = view.frame
            holds = asked(scope, frame.state, frame.before, frame.action)
            return _where_exists(scope, view.exists, holds)

        return value

    def _argument(self, argument: Any) -> Closure:
        """An argument of a predicate; of places a parameter: elsewhere on another map."""
        if not isinstance(argument, tuple | np.ndarray):
            self.shape.append(f"{argument},")
            return lambda scope: argument
        number = len(self.places)
        self.places.append(argument)
        self.shape.append(f"place{len(argument)},")
        return lambda scope: scope.params.places[number]

    def _acted(self, node: ty.Acted) -> Closure:
        moment = self.moment(node.moment)
        self.shape.append(str(node.turn))

        def value(scope: Scope) -> Array:
            view = moment(scope)
            assert view.frame is not None  # a frame counts from 1
            before, action = view.frame.before, view.frame.action
            done = scope.world.is_turn(scope.tables, before, action, node.turn)
            return _where_exists(scope, view.exists, done * 1.0)

        return value

    def _when(self, node: ty.When) -> Closure:
        """last + 1 minus the greatest of last + 1 - t over the frames in which it holds."""
        left = ty.TimeTable(1, tuple(float(node.last + 1 - t) for t in range(1, node.last + 1)))
        ahead = ty.Apply("choose", (node.body, left, ty.Constant(0.0)))
        greatest = ty.Reduction("max", 1, node.last, ahead)
        less = ty.Apply("negate", (greatest,))
        return self.build(ty.Apply("add", (ty.Constant(node.last + 1.0 - node.before), less)))

    def _framecount(self, node: ty.FrameCount) -> Closure:
        if node.before is None:
            return lambda scope: scope.count
        before = self.build(ty.Constant(float(node.before)))
        return lambda scope: scope.count - before(scope)

    def _away(self, node: ty.Away) -> Closure:
        if node not in self.aways:
            self.aways.append(node)
        number = self.aways.index(node)
        self.shape.append(str(number))
        if self.world.lists_states:
            return lambda scope: scope.params.reach[number][scope.end]
        known = lambda scope: scope.params.reach[number]
        return lambda scope: least(scope.world, scope.tables, known(scope), scope.end)

    def _reach(self, away: ty.Away) -> np.ndarray | Relaxed:
        """How many frames it takes from each state, [S]; at least, where these are computed."""
        if not self.world.lists_states:
            return relaxed(self.world, away.body, away.events, asked_of)
        of_states = is_of_states(self.world, away.body)
        return frames_until(self.world, away.events, asked_of(self.world, away.body), of_states)

    def _beats(self, node: ty.Beats) -> Closure:
        assert self.on_reduction is not None
        self.shape.append(f"beats{node.least},{node.last}")
        return self.on_reduction(node)

    def _reduction(self, node: ty.Reduction) -> Closure:
        assert self.on_reduction is not None
        self.shape.append(f"{node.kind}{node.first}..{node.last}")
        return self.on_reduction(node)


def asked_of(world: World, condition: ty.Typed) -> Question:
    """A condition on what is seen in a frame, to be asked of any frames side by side."""
    compiler = Compiler(world, 0)
    closure = compiler.build(condition)
    params = compiler.params()

    def asked(before: np.ndarray, action: np.ndarray, after: np.ndarray) -> np.ndarray:
        found: np.ndarray = closure(TurnScope(world, params, before, action, after)) != 0
        return found

    return asked


def late_from(
    world: World,
    conditions: Iterable[tuple[int, ty.Typed]],
    events: tuple[int, ...],
    states: np.ndarray,
) -> np.ndarray:
    """How many conditions of single frames, each with its number, cannot be kept from some states
    [S] on, as far as that is known where states are computed."""
    late = np.zeros(len(states), dtype=int)
    for frame, condition in conditions:
        known = relaxed(world, condition, events, asked_of)
        late += least(world, world.tables, known, states) > frame
    return late


def is_of_states(world: World, condition: ty.Typed) -> bool:
    """Whether it depends on the state at the end of a frame alone."""
    known = world.vocabulary.predicates
    return not any(
        isinstance(n, ty.Acted) or (isinstance(n, ty.Feature) and known[n.predicate].needs_action)
        for n in ty.walk(condition)
    )


class _QuantityScope:
    """The scope of a quantity inside an expectation: it also knows the state, and who is asked; of
    one who is asked alone maybe his particles or points, of which the quantity then is."""

    def __init__(self, outer: Scope, state: Array, viewers: ty.Viewers | None, minds: Any = None):
        self.world, self.tables, self.params = outer.world, outer.tables, outer.params
        self.t, self.xp, self.state, self.viewers = outer.t, outer.xp, state, viewers
        self.minds = minds

    def of_rows(self, values: Array) -> Array:
        """Of what is known of rows, [H]; of particles or points, [..., 1, N]."""
        return values if self.minds is None else self.minds.of_rows(values)[..., None, :]


def _where_exists(scope: Scope, exists: Array | bool, value: Array) -> Array:
    return value if exists is True else scope.xp.where(exists, value, 0.0)


def evaluate_all(
    compiler: Compiler,
    closure: Closure,
    tables: Any,
    histories: dict[tuple[ty.Turn, ...], tuple[Frame, Array]],
    times: range | None,
    params: Params | None = None,
    count: Array | int | None = None,
    chain: Chain | None = None,
) -> Array:
    """The value of a built expression over a whole script, for all t at once. `chain` is of the
    viewers, where they are not the world's own."""
    xp = histories[()][0].log_belief.__array_namespace__()
    scope = HistoryScope(
        compiler.world,
        tables,
        params or compiler.params(),
        histories,
        compiler.length if count is None else count,
        compiler.length,
        None if times is None else xp.arange(times.start, times.stop),
        chain,
    )
    return closure(scope)


def reduce_over_history(compiler: Compiler) -> Callable[[ty.Reduction | ty.Beats], Closure]:
    """How a query takes its sums: over all frames that exist, with t as an axis."""

    def within(scope: HistoryScope, times: Array) -> HistoryScope:
        given = (scope.world, scope.tables, scope.params, scope.histories)
        return HistoryScope(*given, scope.count, scope.length, times, scope.chain)

    def on_beats(node: ty.Beats) -> Closure:
        parts = [compiler.build(part) for part in node.parts]

        def value(scope: HistoryScope) -> Array:
            times = scope.xp.arange(1, node.last + 1)
            terms = terms_of(parts, within(scope, times), times)
            taken = times <= scope.count
            if scope.params.before is not None:
                taken &= times > scope.params.before
            cells = begun(scope.xp, len(parts), node.least, terms.dtype)
            cells = through(cells, terms, taken, node.least)
            return best(cells, node.last - scope.count, node.least)

        return value

    def on_reduction(node: ty.Reduction | ty.Beats) -> Closure:
        if isinstance(node, ty.Beats):
            return on_beats(node)
        body = compiler.build(node.body)

        def value(scope: HistoryScope) -> Array:
            xp = scope.xp
            times = xp.arange(node.first, node.last + 1)
            terms = xp.broadcast_to(body(within(scope, times)), times.shape)
            taken = (times <= scope.count) | (times > scope.length)
            if scope.params.before is not None and node.first <= 1:
                taken &= times > scope.params.before
            return _reduce(xp, node.kind, terms, taken)

        return value

    return on_reduction


def terms_of(parts: list[Closure], scope: Scope, times: Array) -> Array:
    """What each of `times` [T] is worth in each part, [T, n]."""
    xp = scope.xp
    return xp.stack([xp.broadcast_to(part(scope), times.shape) for part in parts], axis=-1)


def _reduce(xp: Any, kind: str, terms: Array, taken: Array) -> Array:
    """sum, mean, min or max of the terms that are taken; 0 where there are none."""
    some = taken.any()
    if kind in ("sum", "mean"):
        total = xp.where(taken, terms, 0.0).sum()
        return total if kind == "sum" else total / xp.maximum(taken.sum(), 1)
    if kind == "min":
        return xp.where(some, xp.where(taken, terms, xp.inf).min(), 0.0)
    return xp.where(some, xp.where(taken, terms, -xp.inf).max(), 0.0)
