"""The protocol between worlds and everything above them: names for the checker, functions of
arrays for the fold. A world keeps its numbers in `tables`, which are passed to every function, so
that one compiled program serves all worlds of the same shape."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np

from i2pdsl.audience.filter import Switching
from i2pdsl.audience.holding import HoldingTables
from i2pdsl.language.story import Particles
from i2pdsl.language.typed import Act, Drop, Point, Turn
from i2pdsl.language.vocabulary import Vocabulary
from i2pdsl.worlds.hypotheses import goal_of, via_of

Array = Any
Tables = Any
Part = tuple[frozenset[int], Callable[[np.ndarray], np.ndarray]]
"""What a `start` asks: the characters and things that it asks about, and whether it holds in states
[S], wherever the others are."""


@dataclass(frozen=True)
class Viewer:
    """One observer of a world: the world as he believes it works, his prior [H] or None, the
    hypotheses [H] that are left by what he knows, or None, how much more strongly than its
    characters do he expects them to prefer what is best for them, and the particles that he holds
    instead of all hypotheses, or None."""

    spec: Any
    prior: tuple[float, ...] | None = None
    known: tuple[bool, ...] | None = None
    sharpness: float = 1.0
    particles: Particles | None = None


class ByProblem(NamedTuple):
    """Likelihoods that are alike under all hypotheses under which who acts solves the same problem.

    Attributes:
        log_rows, rows: log P(action | problem) and P(action | problem), of the problems that each
            observer knows of, broadcastable to [..., n_1, n_2, ..., O, Q].
        hypotheses: those of each problem, one-hot [O, Q, H].
    """

    log_rows: Array
    rows: Array
    hypotheses: Array


class Branches(NamedTuple):
    """All joint turns from a state, K = n_1 * n_2 * ... of them, of so many outcomes for each
    character.

    Attributes:
        state [..., K]: the state after each turn.
        valid [..., K]: false for a second copy (a blocked move that also "fails").
        log_rows: for each observed action, log P(action | H), broadcastable to
            [..., n_1, n_2, ..., O, H].
        chance [..., K]: probability of the outcomes given the actions.
        problems: the same as `log_rows`, of problems; empty where that would save nothing, and None
            for an action of which it would save nothing.
    """

    state: Array
    valid: Array
    log_rows: tuple[Array, ...]
    chance: Array
    problems: tuple[ByProblem | None, ...] = ()


class SmallWorld(NamedTuple):
    """A world with some of the characters and things of a large one, whose S states are listed.
    What these can come to in the large one they can come to in the small one at least as soon.

    Attributes:
        numbers: theirs in the small world, by those in the large one.
        rows [E, M]: what each cell of each in the large one adds to the number of a row of a table.
        row [S]: the row of each of its states.
        size: how many rows there are.
    """

    world: World
    numbers: dict[int, int]
    rows: np.ndarray
    row: np.ndarray
    size: int


class World(Protocol):
    """What the audience, the objective and the searches ask of a world.

    States and actions are arrays with any leading axes (and one of their own where they are
    vectors); O observers, H hypotheses, U observed
    actions in a frame.
    """

    @property
    def name(self) -> str: ...

    @property
    def spec(self) -> Any:
        """The world as data (worlds/kind.py)."""

    @property
    def action_shape(self) -> tuple[int, ...]:
        """The axes of an action: () where actions are numbers."""

    @property
    def rows_are_scaled(self) -> bool:
        """Whether `log_rows` are so many times as large as viewers expect choices to be sharp."""

    @property
    def weak_chances(self) -> tuple[float, ...]:
        """The success probabilities of the weak characters."""

    def starts(self, points: Sequence[Point] = (), parts: Sequence[Part] = ()) -> np.ndarray:
        """All initial states; objective/starts.py leaves those that fulfil a `start`.

        Args:
            points: that the `start` names, where bodies move: anybody may begin there, too.
            parts: what it asks; where states cannot be listed, some of those that fulfil it.
        """

    @property
    def vocabulary(self) -> Vocabulary: ...

    @property
    def tables(self) -> Tables: ...

    @property
    def search_tables(self) -> Tables:
        """The tables as searches take them: in single precision on JAX's device, and of sizes
        that worlds of the same shape share."""

    def program_key(self, turns: tuple[Turn, ...]) -> tuple[Any, ...]:
        """What a program that may append turns depends on besides the sizes of its arrays."""

    def log_prior(self, tables: Tables) -> Array:
        """The belief before anything moved: [O, H]."""

    def forgetting(self, tables: Tables) -> Array:
        """The share of belief that is reassigned after each observed action: [O], or [O, H] as
        `forgetting_of` has it."""

    def switching(self, tables: Tables) -> tuple[Switching | None, ...]:
        """How the goal of who is observed changes, for each observation of a frame; None where
        nobody's does."""

    def holdings(self, tables: Tables) -> tuple[HoldingTables | None, ...]:
        """The particles or factors of each observer, None of one who lists all hypotheses; empty
        where everybody does."""

    def holding(self, viewers: tuple[Viewer, ...]) -> World:
        """The same world before viewers who hold other particles, and are otherwise the same."""

    @property
    def lists_hypotheses(self) -> bool:
        """Whether rows of beliefs are hypotheses. Otherwise each stands for many: all viewers hold
        particles or factors, and the likelihoods of `log_rows` and `turns` are of problems
        (SwarmTables, FactorTables)."""

    def acting(self, rows: np.ndarray, generator: np.random.Generator) -> np.ndarray:
        """The place in `log_rows` by which each who acts does so under the hypothesis of a row, or
        under one that is drawn evenly of those that it stands for: [N, U] of [N]."""

    @property
    def keeps_doubt(self) -> bool:
        """Whether viewers forget so much after each action that nothing they think possible gets
        too improbable for single precision: beliefs may then be held as probabilities."""

    def all_states(self, tables: Tables) -> Array:
        """Every state, [S]."""

    @property
    def lists_states(self) -> bool:
        """Whether there are tables with a row for each state."""

    def small(self, about: frozenset[int]) -> SmallWorld | None:
        """One with some characters and things, where states are computed; None where that is too
        large, too."""

    def row(self, tables: Tables, rows: Array, state: Array) -> Array:
        """The row of a state in a table of a small world, [...]."""

    def act(self, tables: Tables, state: Array, turn: Turn) -> tuple[Array, Array]:
        """An appended turn as an action, and whether it can happen in a state."""

    def is_turn(
        self, tables: Tables, before: Array, action: Array, turn: tuple[Act | None, ...] | Drop
    ) -> Array:
        """Whether an action from a state is a turn, in which of a character with None anything is;
        a move that fails must have been possible."""

    def feature_arguments(self, name: str, arguments: tuple[Any, ...]) -> tuple[Any, ...]:
        """The checker's arguments of a predicate in the world's own numbers."""

    def turns(self, tables: Tables, state: Array) -> Branches:
        """All joint turns from a state."""

    def endings(self, tables: Tables, state: Array) -> Array:
        """The states after each of them, [..., K], without beliefs."""

    @property
    def turn_count(self) -> int:
        """K, how many joint turns there are. Actions from K on are events."""

    @property
    def dropped(self) -> tuple[int, ...]:
        """What falls in each event, as a number among characters and things."""

    @property
    def event_slots(self) -> int:
        """How many actions each event is: one for each place where it can happen."""

    def events(self, allowed: tuple[tuple[str, str], ...]) -> tuple[int, ...]:
        """The numbers of the events that a story allows, each of (event, thing)."""

    def drops(self, tables: Tables, state: Array) -> tuple[Array, Array]:
        """The states after each event in each place, and whether it can happen: [..., events x
        slots]."""

    def guesses(self, length: int, seeds: int, noise: float, seed: int, state: Array) -> Array:
        """What a descent from a state begins with, [seeds, length, *action_shape]."""

    def branch_actions(self, who: int) -> tuple[int, ...]:
        """The action (a number, in the vocabulary's order) of each of the branches of a character
        in `turns`."""

    def no_action(self, state: Array) -> Array:
        """An action of the right shape for frame 0, which has none."""

    def transition(self, tables: Tables, state: Array, action: Array) -> Array:
        """The state after an action; chance outcomes are part of the action."""

    def log_rows(
        self, tables: Tables, state: Array, action: Array, after: Array
    ) -> tuple[Array, ...]:
        """log P(what is observed | H) for each observation of the frame, [..., O, H] each: of
        each character's action in a grid, of the state `after` it where bodies move."""

    def best_rows(
        self, tables: Tables, state: Array, action: Array, after: Array
    ) -> tuple[Array, ...]:
        """max_a log P(a | H) at each observation of the frame, [..., O, H] each: what would have
        been the most sensible."""

    def alternatives(
        self, tables: Tables, state: Array, action: Array, after: Array
    ) -> tuple[tuple[Array, Array], ...]:
        """For each observation of the frame, log P of all that could have been observed, [..., A,
        O, H], and which of it was, [...]: whoever expects choices to be k times as sharp has the
        k-th power of these, normalised. Empty where what is observed is none of so many."""

    def is_still(self, tables: Tables, state: Array, after: Array) -> Array:
        """Whether nothing that a viewer can see has changed, [...]."""

    def stillness(self, tables: Tables, state: Array, after: Array) -> Array:
        """What `liveliness` charges for a frame, [...]: 1 where nothing moves, 0 where something
        does; where bodies move, the less the faster they are, without a jump."""

    def outcome(
        self, tables: Tables, state: Array, action: Array
    ) -> tuple[Array, tuple[Array, ...], tuple[Array, ...]]:
        """`transition`, and `log_rows` and `best_rows` of the state that it leads to."""

    def is_observed(self, action: Array) -> Array:
        """Whether the audience updates its belief in this frame (not by an event)."""

    def value(self, tables: Tables, who: int, state: Array) -> Array:
        """A character's value under each hypothesis: [..., O, H]."""

    def feature(
        self,
        tables: Tables,
        name: str,
        arguments: tuple[Any, ...],
        state: Array,
        before: Array | None,
        action: Array | None,
    ) -> Array:
        """A predicate or quantity of a state or frame."""

    def attempts(self, tables: Tables, state: Array, action: Array) -> tuple[Array, Array]:
        """Which weak characters made an attempt in a frame, and whose succeeded: [..., weak]."""

    def with_audience(self, sharpness: float, forgetting: Array, log_prior: Array) -> World:
        """The world before other viewers, without planning anew: to whom all characters seem to
        prefer their best actions `sharpness` times as much as to the viewers that it has, and
        with `forgetting` and `log_prior` of their own."""


def log_priors(viewers: Sequence[Viewer], words: Vocabulary) -> np.ndarray:
    """log P(H) of each viewer before anything moved, [O, H]: the world's where he has no prior of
    his own."""
    count = len(words.hypotheses)
    usual = words.prior or (1 / count,) * count
    priors = [viewer.prior or usual for viewer in viewers]
    with np.errstate(divide="ignore"):
        logs: np.ndarray = np.log(np.array(priors))
    return logs


def forgetting_of(observers: Sequence[Any], shares: Sequence[float] | np.ndarray) -> np.ndarray:
    """How much each of the observers (or viewers) forgets, [O]; where one of them knows something,
    [O, H]: 0 under the hypotheses that he knows to be false, for he does not forget that.

    Args:
        shares: for each of them, or [O, H].
    """
    shares = np.asarray(shares, float)
    if all(observer.known is None for observer in observers):
        return shares
    known = next(o.known for o in observers if o.known is not None)
    left = np.array([o.known or (True,) * len(known) for o in observers])
    return np.where(left, shares if shares.ndim == 2 else shares[:, None], 0.0)


def switching_of(
    viewers: Sequence[Viewer], words: Vocabulary, log_prior: np.ndarray
) -> tuple[Switching, ...]:
    """How viewers think that goals change after each observation of a frame, which is what the
    characters do one after the other; empty where nobody thinks that they do.

    Hypotheses are in one group that differ in the goal of who acted alone (and in where it takes
    that to be, and in the way to it).

    Args:
        log_prior: of each viewer, [O, H].
    """
    share = np.array([float(viewer.spec.settings.switching) for viewer in viewers])
    if not share.any():
        return ()
    found = []
    for name in words.characters:
        goal, about = goal_of(name), words.readings.get(name, {})
        own = {
            goal,
            via_of(name),
            *(latent for what, latent in about.items() if what in words.things),
        }
        groups: dict[Hashable, list[int]] = {}
        for number, row in enumerate(words.hypotheses):
            rest = frozenset((latent, value) for latent, value in row.items() if latent not in own)
            groups.setdefault(rest if goal in row else number, []).append(number)
        most = max(map(len, groups.values()))
        count = len(words.hypotheses)
        members = [[*group, *[count] * (most - len(group))] for group in groups.values()]
        group = np.empty(count, dtype=int)
        for number, numbers in enumerate(groups.values()):
            group[numbers] = number
        found.append(Switching(share, np.array(members), group, log_prior).given(log_prior))
    return tuple(found)


def on_device(tables: Tables) -> Tables:
    """A tree of NumPy arrays in single precision on JAX's device."""
    import jax

    return jax.device_put(jax.tree.map(single_precision, tables))


def double_precision(array: np.ndarray) -> np.ndarray:
    """Every float as float64; every integer as int32."""
    array = np.asarray(array)
    if array.dtype.kind == "f":
        return array.astype(np.float64, copy=False)
    return single_precision(array)


def single_precision(array: np.ndarray) -> np.ndarray:
    """float64 as float32; every integer as int32."""
    array = np.asarray(array)
    if array.dtype.kind == "f":
        return array.astype(np.float32, copy=False)
    return array.astype(np.int32, copy=False) if array.dtype.kind in "iu" else array
