"""What an expression may see: moments of a script, one at a time or all at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from i2pdsl.audience.holding import Holding
from i2pdsl.audience.product import Product
from i2pdsl.audience.queries import Share
from i2pdsl.language import typed as ty
from i2pdsl.objective.belief import Belief, first_belief
from i2pdsl.objective.hindsight import Chain, chain_of, hindsight, how_many, may_be_ahead
from i2pdsl.worlds.world import World

Array = Any


class Frame(NamedTuple):
    """One frame. Leading axes are free (candidates, time); O observers, H hypotheses.

    Attributes:
        number: t.
        before, action, state: the state before, what happened, the state at the end.
        log_previous, log_belief: log P(H | script[:t-1]) and log P(H | script[:t]), [..., O, H].
        log_expecting: log P(H) just before each observation, [..., U, O, H].
        log_rows: log P(observation | H) of each, [..., U, O, H].
        regret: how odd what was observed is to each viewer once he saw it, in nats: the sum of
            E[max_a log P(a | H) - log P(observed | H)] over what was observed, where everybody is
            rational: [..., O]; 0 where nobody asks.
        shares: the beliefs as probabilities, where they are held so (search/rollout.py).
        holdings: what those who hold particles or factors hold in the end; () where nobody asks.
    """

    number: Array
    before: Array
    action: Array
    state: Array
    log_previous: Array
    log_belief: Array
    log_expecting: Array
    log_rows: Array
    regret: Array
    shares: Shares | None = None
    holdings: tuple[Holding, ...] = ()

    @property
    def log_afterwards(self) -> Array:
        """log P(H) just after each observation, [..., U, O, H]."""
        xp = self.log_belief.__array_namespace__()
        return xp.concatenate(
            [self.log_expecting[..., 1:, :, :], self.log_belief[..., None, :, :]], axis=-3
        )

    def at(self, index: Any) -> Frame:
        """Some of several frames: `index` is of their leading axes."""
        return self.each(lambda part: part[index])

    @property
    def belief(self) -> Belief:
        """What viewers believe after it."""
        share = None if self.shares is None else self.shares.belief
        return Belief(self.log_belief, share, self.holdings)

    @property
    def share(self) -> Share | None:
        """The same as probabilities, where it is held so; as a product, where that is at hand."""
        if self.shares is None:
            return None
        return self.shares.belief if self.shares.product is None else self.shares.product

    def each(self, change: Callable[..., Array], *others: Frame) -> Frame:
        """The frame with each of its arrays changed, given the same ones of others."""
        parts = zip(self[:-2], *(other[:-2] for other in others), strict=True)
        held = [frame.shares for frame in (self, *others) if frame.shares is not None]
        changed: Any = [change(*part) for part in parts]
        holdings = zip(self.holdings, *(other.holdings for other in others), strict=False)
        return Frame(*changed)._replace(
            shares=held[0].each(change, *held[1:]) if held else None,
            holdings=tuple(held.each(change, *more) for held, *more in holdings),
        )

    def of(self, viewers: ty.Viewers | None) -> Frame:
        """The frame as some of the observers see it; as all of them without."""
        if viewers is None:
            return self
        some = slice(*viewers)
        shares = self.shares
        return self._replace(
            log_previous=self.log_previous[..., some, :],
            log_belief=self.log_belief[..., some, :],
            log_expecting=self.log_expecting[..., some, :],
            log_rows=self.log_rows[..., some, :],
            regret=self.regret[..., some],
            shares=None if shares is None else shares.of(some),
        )


class Shares(NamedTuple):
    """P(H) as `log_previous`, `log_belief` and `log_expecting` of a frame are its logarithms; and
    `belief` as the product that it is, if it is at hand."""

    previous: Array
    belief: Array
    expecting: Array
    product: Product | None = None

    def of(self, viewers: slice) -> Shares:
        """The same of some of the observers."""
        previous, belief, expecting = (part[..., viewers, :] for part in self[:3])
        product = None if self.product is None else self.product.of(viewers)
        return Shares(previous, belief, expecting, product)

    def each(self, change: Callable[..., Array], *others: Shares) -> Shares:
        """The same with each of its arrays changed, given the same ones of others."""
        parts = zip(self[:3], *(other[:3] for other in others), strict=True)
        previous, belief, expecting = (change(*part) for part in parts)
        held = [shares.product for shares in (self, *others) if shares.product is not None]
        product = held[0].each(change, *held[1:]) if held else None
        return Shares(previous, belief, expecting, product)


def observe(
    world: World,
    tables: Any,
    number: Array,
    state: Array,
    action: Array,
    belief: Belief,
    rows: tuple[Array, ...] | None = None,
) -> Frame:
    """The frame that an action makes from a state and a belief: the audience's one step.

    `rows` are the log-likelihoods of the observed actions of an appended turn, if they are known
    already: its regrets count for nothing.
    """
    xp, previous, given = belief.log.__array_namespace__(), belief, world.holdings(tables)
    best: tuple[Array, ...] = ()
    if rows:
        after = world.transition(tables, state, action)
    else:
        after, rows, best = world.outcome(tables, state, action)
    seen, expecting = world.is_observed(action), []
    regret = xp.zeros(belief.log.shape[:-1], belief.log.dtype)
    belief = belief.shown(given)
    shown = []
    for u, row in enumerate(rows):
        expecting.append(belief)
        shown.append(belief.likely(world, tables, u, row))
        belief = belief.seeing(world, tables, u, row).where(seen, belief)
        if best:
            regret = regret + belief.regret(world, tables, u, best[u] - row)
    if belief.holdings:
        belief = belief.over(given).where(seen, belief)
    return Frame(
        number,
        state,
        action,
        after,
        previous.log,
        belief.log,
        xp.stack([each.log for each in expecting], axis=-3),
        xp.stack(shown, axis=-3),
        regret,
        shares_of(previous, belief, expecting),
        belief.holdings,
    )


def shares_of(previous: Belief, belief: Belief, expecting: Sequence[Belief]) -> Shares | None:
    """The beliefs of a frame as probabilities, where they are held so."""
    if previous.share is None or belief.share is None:
        return None
    xp = belief.share.__array_namespace__()
    expected = xp.stack([b.share for b in expecting], axis=-3)
    return Shares(previous.share, belief.share, expected, belief.product)


@dataclass(frozen=True)
class View:
    """A moment as a form sees it.

    `exists` is True where it always does; else an array, and what does not exist counts 0.
    Prefix forms read the belief (`share`: as probabilities, where it is held so) and `state`;
    frame forms read the whole `frame`. `holdings` are what those hold who hold particles or
    factors, where it is at hand.
    """

    log_belief: Array
    state: Array
    frame: Frame | None
    exists: Array | bool = True
    share: Share | None = None
    holdings: tuple[Holding, ...] = ()

    def of(self, viewers: ty.Viewers | None) -> View:
        """The moment as some of the observers see it; as all of them without."""
        if viewers is None:
            return self
        belief = self.log_belief[..., slice(*viewers), :]
        share = self.share
        if share is not None:
            some = slice(*viewers)
            share = share.of(some) if isinstance(share, Product) else share[..., some, :]
        frame = None if self.frame is None else self.frame.of(viewers)
        holdings = self.holdings  # which are asked where everybody holds some
        if len(holdings) == self.log_belief.shape[-2]:
            holdings = holdings[slice(*viewers)]
        return View(belief, self.state, frame, self.exists, share, holdings)


def view_after(frame: Frame, moment: ty.Moment, exists: Array | bool = True) -> View:
    """A frame as seen at its end, or once some of its actions were observed."""
    log_belief, share = frame.log_belief, frame.share
    if moment.seen is not None:
        log_belief = frame.log_expecting[..., moment.seen, :, :]
        if frame.shares is not None:
            share = frame.shares.expecting[..., moment.seen, :, :]
    return View(log_belief, frame.state, frame, exists, share, frame.holdings)


class StepScope:
    """Inside an incremental sum: t is the frame at hand; only t and t - 1 can be reached.

    `accumulated` are the sums that stand inside this one, up to this frame.
    """

    accumulated: Sequence[Array]
    length: int
    held = False

    def __init__(self, world: World, tables: Any, params: Any, frame: Frame, first_state: Array):
        self.world, self.tables, self.params = world, tables, params
        self.t, self.frame, self.first_state = frame.number, frame, first_state
        self.count = frame.number
        self.xp = frame.log_belief.__array_namespace__()

    def view(self, moment: ty.Moment) -> View:
        frame = self.frame
        if moment.offset == 0:
            return view_after(frame, moment)
        if moment.offset == -1:
            share = None if frame.shares is None else frame.shares.previous
            return View(frame.log_previous, frame.before, None, True, share)
        return prior_view(self, state=self.first_state)


class StartScope:
    """t = 0: nothing has moved. Frames do not exist, the prior does."""

    accumulated: Sequence[Array]
    length: int
    held = False

    def __init__(self, world: World, tables: Any, params: Any, state: Array, zero: Array):
        self.world, self.tables, self.params = world, tables, params
        self.t, self.state = zero, state
        self.count = zero
        self.xp = zero.__array_namespace__()

    def view(self, moment: ty.Moment) -> View:
        index = moment.frames[-moment.first] if moment.first is not None else moment.frames[0]
        return prior_view(self, exists=index == 0, state=self.state)


def prior_view(scope: Any, state: Array, exists: Array | bool = True) -> View:
    """The moment before anything moved."""
    belief = first_belief(scope.world, scope.tables)
    return View(belief.log, state, None, exists, holdings=belief.holdings)


class EndScope:
    """At the end of a prefix of n frames, for a single t (or none): `last` and appended frames.

    Reaches the prior, frame T where n = T, and the frames of appended turns. A prefix that is
    `held` to the end (held.py) has its last frame for frame T.
    """

    def __init__(
        self,
        world: World,
        tables: Any,
        params: Any,
        last: Frame,
        first_state: Array,
        length: int,
        suffixes: dict[tuple[ty.Turn, ...], list[tuple[Frame, Array]]],
        t: int | None = None,
        held: bool = False,
    ):
        self.world, self.tables, self.params = world, tables, params
        self.held = held
        self.last, self.length, self.suffixes = last, length, suffixes
        self.first_state = first_state
        self.count, self.end = last.number, last.state
        self.xp = last.log_belief.__array_namespace__()
        self.t = t

    def view(self, moment: ty.Moment) -> View:
        index = moment.frames[0 if moment.first is None else (self.t or 0) - moment.first]
        if index == 0:
            return prior_view(self, state=self.first_state)
        if index > self.length:
            frame, possible = self.suffixes[moment.turns][index - self.length - 1]
            return view_after(frame, moment, possible)
        frame = self.last
        there = self.held or frame.number == self.length
        return view_after(frame, moment, there & (index == self.length))


class HistoryScope:
    """All frames at once: t is an array [n_t], and forms give one number for each t.

    `frames` holds the frames 0..T and then appended ones, along the first axis; frame 0 carries
    the prior as its belief. `count` is the number of frames that exist so far. `chain` is that
    of the viewers, where they are not the world's own.
    """

    def __init__(
        self,
        world: World,
        tables: Any,
        params: Any,
        histories: dict[tuple[ty.Turn, ...], tuple[Frame, Array]],
        count: Array | int,
        length: int,
        times: Array | None,
        chain: Chain | None = None,
    ):
        self.world, self.tables, self.params = world, tables, params
        self.histories, self.count, self.length = histories, count, length
        self.chain = chain or chain_of(world, tables)
        self.t = times
        self.xp = histories[()][0].log_belief.__array_namespace__()

    @property
    def end(self) -> Array:
        """The state in which the script ends so far."""
        return self.histories[()][0].state[self.count]

    def view(self, moment: ty.Moment) -> View:
        frames, _ = self.histories[moment.turns]
        number, exists = self._place(moment)
        return view_after(frames.at(number), moment, exists)

    def hindsight(self, moment: ty.Moment, given: ty.Moment) -> View:
        """A frame as those see it in hindsight who have seen the script up to `given`."""
        turns = max(moment.turns, given.turns, key=len)
        frames, _ = self.histories[turns]
        (at, exists), (last, too) = self._place(moment), self._place(given)
        one = self.xp.ndim(at) == self.xp.ndim(last) == 0
        asked, known = map(self.xp.atleast_1d, (at, how_many(frames, last, given)))
        believed = self.view(given).log_belief.reshape(-1, *frames.log_belief.shape[1:])
        ahead = may_be_ahead(moment, given)
        found = hindsight(self.world, self.chain, frames, asked, known, believed, ahead)
        return View(found[0] if one else found, frames.state[at], None, exists & too)

    def _place(self, moment: ty.Moment) -> tuple[Any, Any]:
        """The number of a frame in its history, and whether it exists, for each t."""
        _, possible = self.histories[moment.turns]
        total = self.length + len(moment.turns)
        if moment.first is None:
            index: Any = moment.frames[0]
            reached: Any = 0 <= index <= total
        else:
            assert self.t is not None
            table = self.xp.asarray(moment.frames, dtype=int)  # of no frames: empty
            index = table[self.xp.clip(self.t - moment.first, 0, len(moment.frames) - 1)]
            reached = (index >= 0) & (index <= total)
        safe = self.xp.clip(self.xp.asarray(index), 0, total)
        exists = reached & ((safe <= self.count) | (safe > self.length)) & possible[safe]
        return safe, exists


class TurnScope:
    """Frames that may be anywhere in a script, side by side: only what is seen in them."""

    t = None

    def __init__(self, world: World, params: Any, before: Array, action: Array, state: Array):
        self.world, self.tables, self.params = world, world.tables, params
        self.before, self.action, self.state = before, action, state
        self.xp = state.__array_namespace__()

    def view(self, moment: ty.Moment) -> View:
        nothing = self.xp.zeros(())
        seen = (self.state, *(nothing,) * 5)
        return View(nothing, self.state, Frame(nothing, self.before, self.action, *seen))
