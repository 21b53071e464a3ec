"""A listed world ready for its viewers: the World protocol, derived from tables of all states."""

from __future__ import annotations

import hashlib
import inspect
import math
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, NamedTuple, NoReturn, Self

import numpy as np

from i2pdsl.audience.filter import Switching
from i2pdsl.language.typed import Act, Drop, Point, Turn
from i2pdsl.language.vocabulary import STAY, Vocabulary
from i2pdsl.worlds.plain import PlainWorld
from i2pdsl.worlds.world import Array, Branches, Part


class ListedTables(NamedTuple):
    """The numbers of a listed world: S states, A actions of a character, E characters and things,
    N cells, O observers, H hypotheses.

    Attributes:
        coordinates [N, 2]: column and row of each cell.
        cells [S, E]: the cell of each character and then of each thing.
        after: of each character, the state that each of its actions leads to, [S, A].
        log_policy: of each character, log P(action | state, H), [S, A, O, H].
        value: of each character, [S, O, H].
        log_prior [O, H], forgetting [O] or [O, H], switching: of the viewers (worlds/world.py).
    """

    coordinates: Array
    cells: Array
    after: tuple[Array, ...]
    log_policy: tuple[Array, ...]
    value: tuple[Array, ...]
    log_prior: Array
    forgetting: Array
    switching: tuple[Switching, ...]


class Deed(NamedTuple):
    """What a character does in a frame: the states before and after it, and its action's number
    among its own, [...] each."""

    before: Array
    action: Array
    after: Array


@dataclass(frozen=True)
class ListedWorld(PlainWorld):
    """A world in which characters act one after the other, from cell to cell.

    An action of a frame is the number with the digits a_1, a_2, ..., the last the lowest: those of
    the characters in the order of acting.

    Attributes:
        begins [S]: whether a script can begin in a state.
    """

    spec: Any
    vocabulary: Vocabulary
    tables: ListedTables
    begins: np.ndarray
    action_shape = ()
    lists_states = True

    @property
    def counts(self) -> tuple[int, ...]:
        """How many actions each character has."""
        return tuple(after.shape[1] for after in self.tables.after)

    @property
    def turn_count(self) -> int:
        return math.prod(self.counts)

    def program_key(self, turns: tuple[Turn, ...]) -> tuple[Any, ...]:
        return (self.spec.kind, self.counts, _source_of(type(self).__module__))

    # States.

    def starts(self, points: Sequence[Point] = (), parts: Sequence[Part] = ()) -> np.ndarray:
        return np.flatnonzero(self.begins)

    def all_states(self, tables: ListedTables) -> Array:
        return tables.cells.__array_namespace__().arange(len(tables.cells))

    def transition(self, tables: ListedTables, state: Array, action: Array) -> Array:
        return self.deeds(tables, state, action)[-1].after

    def endings(self, tables: ListedTables, state: Array) -> Array:
        place = state
        for after in tables.after:
            place = after[place]
        return place.reshape(*state.shape, self.turn_count)

    def no_action(self, state: Array) -> Array:
        return state * 0

    def is_observed(self, action: Array) -> Array:
        return action >= 0

    def is_still(self, tables: ListedTables, state: Array, after: Array) -> Array:
        return state == after

    def stillness(self, tables: ListedTables, state: Array, after: Array) -> Array:
        return (state == after) * 1.0

    # Turns.

    def deeds(self, tables: ListedTables, state: Array, action: Array) -> list[Deed]:
        """What each character does in a frame."""
        found, below = [], self.turn_count
        for after, count in zip(tables.after, self.counts, strict=True):
            below //= count
            own = action // below % count
            found.append(Deed(state, own, after[state, own]))
            state = found[-1].after
        return found

    def turns(self, tables: ListedTables, state: Array) -> Branches:
        xp, rows, place = tables.cells.__array_namespace__(), [], state
        for later, policy in zip(range(len(self.counts))[::-1], tables.log_policy, strict=True):
            row = policy[place]  # [..., n_1, ..., n_who, O, H], and an axis for each who acts later
            rows.append(row.reshape(*row.shape[:-2], *(1,) * later, *row.shape[-2:]))
            place = tables.after[-1 - later][place]
        ends = place.reshape(*state.shape, self.turn_count)
        return Branches(ends, xp.ones(ends.shape, bool), tuple(rows), xp.ones(ends.shape))

    def branch_actions(self, who: int) -> tuple[int, ...]:
        return tuple(range(self.counts[who]))

    def act(self, tables: ListedTables, state: Array, turn: Turn) -> tuple[Array, Array]:
        code = 0
        for (number, _), count in zip(self._wanted(turn), self.counts, strict=True):
            code = code * count + number
        return state * 0 + code, state == state

    def is_turn(
        self,
        tables: ListedTables,
        before: Array,
        action: Array,
        turn: tuple[Act | None, ...] | Drop,
    ) -> Array:
        deeds, done = self.deeds(tables, before, action), action >= 0
        for number, who in self._wanted(turn):
            done &= deeds[who].action == number
        return done

    def _wanted(self, turn: tuple[Act | None, ...] | Drop) -> Iterator[tuple[int, int]]:
        """The number of the action of each character of whom a turn says one, and of that."""
        assert not isinstance(turn, Drop)  # there are no events
        for who, act in enumerate(turn):
            if act is not None:
                own = self.vocabulary.actions_of(self.vocabulary.characters[who])
                yield own.index(self.vocabulary.actions[act.action]), who

    # What viewers expect.

    def switching(self, tables: ListedTables) -> tuple[Switching | None, ...]:
        return tables.switching or (None,) * len(self.counts)

    def log_rows(
        self, tables: ListedTables, state: Array, action: Array, after: Array
    ) -> tuple[Array, ...]:
        return self.outcome(tables, state, action)[1]

    def best_rows(
        self, tables: ListedTables, state: Array, action: Array, after: Array
    ) -> tuple[Array, ...]:
        return self.outcome(tables, state, action)[2]

    def outcome(
        self, tables: ListedTables, state: Array, action: Array
    ) -> tuple[Array, tuple[Array, ...], tuple[Array, ...]]:
        deeds = self.deeds(tables, state, action)
        each = list(zip(tables.log_policy, deeds, strict=True))
        rows = tuple(policy[deed.before, deed.action] for policy, deed in each)
        return deeds[-1].after, rows, tuple(policy[deed.before].max(-3) for policy, deed in each)

    def alternatives(
        self, tables: ListedTables, state: Array, action: Array, after: Array
    ) -> tuple[tuple[Array, Array], ...]:
        deeds = self.deeds(tables, state, action)
        pairs = zip(tables.log_policy, deeds, strict=True)
        return tuple((policy[deed.before], deed.action) for policy, deed in pairs)

    def acting(self, rows: np.ndarray, generator: np.random.Generator) -> np.ndarray:
        return np.broadcast_to(rows[:, None], (len(rows), len(self.counts)))

    def value(self, tables: ListedTables, who: int, state: Array) -> Array:
        return tables.value[who][state]

    def with_audience(self, sharpness: float, forgetting: Array, log_prior: Array) -> Self:
        told = {
            "log_policy": tuple(log_softmax(sharpness * each) for each in self.tables.log_policy),
            "switching": tuple(each.given(log_prior) for each in self.tables.switching),
            "forgetting": forgetting,
            "log_prior": log_prior,
        }
        return replace(self, tables=self.tables._replace(**told))

    def guesses(
        self, length: int, seeds: int, noise: float, seed: int, state: np.ndarray
    ) -> NoReturn:
        raise NotImplementedError("actions are listed, not descended to")

    # What can be asked.

    def feature_arguments(self, name: str, arguments: tuple[Any, ...]) -> tuple[Any, ...]:
        """Cells by their numbers: arrays of those of a place."""
        numbers = {(c, r): n for n, (c, r) in enumerate(self.tables.coordinates.tolist())}
        return tuple(
            np.array([numbers[cell] for cell in a]) if isinstance(a, tuple) else a
            for a in arguments
        )

    def feature(
        self,
        tables: ListedTables,
        name: str,
        arguments: tuple[Any, ...],
        state: Array,
        before: Array | None = None,
        action: Array | None = None,
    ) -> Array:
        """Whether a predicate holds of a state, or of the frame that led from `before` to it; a
        kind with others of its own asks itself first."""
        cells, (one, *other) = tables.cells, arguments
        if name == "at":
            return (cells[state, one][..., None] == other[0]).any(-1)
        if name == "touching":
            here, there = (tables.coordinates[cells[state, thing]] for thing in arguments)
            return abs(here - there).sum(-1) == 1
        assert before is not None
        assert action is not None
        deed = self.deeds(tables, before, action)[one]
        if name == "idle":
            own = self.vocabulary.actions_of(self.vocabulary.characters[one])
            return deed.action == own.index(STAY)
        return cells[deed.before, one] != cells[deed.after, one]


@cache
def _source_of(module: str) -> str:
    """A digest of the module of a kind's own class, which need not be one of ours, whose sources
    programs.py knows."""
    try:
        text = inspect.getsource(sys.modules[module])
    except (OSError, TypeError):  # typed in
        text = ""
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def log_softmax(scores: np.ndarray) -> np.ndarray:
    """log of probabilities proportional to exp(scores), [S, A, ...] over the actions."""
    scores = scores - scores.max(1, keepdims=True)
    logs: np.ndarray = scores - np.log(np.exp(scores).sum(1, keepdims=True))
    return logs
