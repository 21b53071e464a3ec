"""The numbers of particle audiences (audience/particles.py), made of a world's hypotheses.

Under all hypotheses in which the same characters are rational, what each of them wants and whom it
cares about can be combined in every way: joint hypotheses are so many products, one for each set of
rational characters. Where a world's are not so, a joint hypothesis is one part as a whole.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from i2pdsl.audience.particles import Draws, Index, SwarmTables
from i2pdsl.audience.renewal import steps_of
from i2pdsl.language.story import Particles
from i2pdsl.language.vocabulary import Value
from i2pdsl.worlds.hypotheses import Groups

Row = Mapping[str, Value]
MOST_PRODUCT = 4_000_000  # combinations of minds, possible or not, of which each has its row


@dataclass(frozen=True)
class Space:
    """Joint hypotheses by parts.

    Attributes:
        parts: the minds of each character, as the values of its own latents: C of them.
        possible: which minds there are where so many are rational, [G, C, M]. The number of a
            group has a bit for each part that is rational.
        rational: of each mind whether it is a rational one, [C, M]; False where nothing depends on
            that (one part as a whole).
    """

    parts: tuple[tuple[Row, ...], ...]
    possible: np.ndarray
    rational: np.ndarray

    @cached_property
    def counts(self) -> np.ndarray:
        """How many joint hypotheses each group has, [G], in doubles."""
        found: np.ndarray = self.possible.sum(-1).astype(float).prod(-1)
        return found

    @property
    def count(self) -> float:
        return float(self.counts.sum())

    @property
    def flag(self) -> np.ndarray:
        """What a mind adds to the number of its group, [C, M]."""
        bits = 1 << np.arange(len(self.parts))
        return np.where(self.rational, bits[:, None], 0)


def space_of(rows: Sequence[Row], parts: Sequence[frozenset[str]], flags: Sequence[str]) -> Space:
    """The space of listed hypotheses.

    Args:
        parts: the latents of each character.
        flags: of each of them the latent that says whether it is rational.
    """
    split = lambda row: tuple(
        frozenset((x, v) for x, v in row.items() if x in part) for part in parts
    )
    known = frozenset().union(*parts)
    minds: list[dict[Any, int]] = [{} for _ in parts]
    held: dict[tuple[bool, ...], set[tuple[int, ...]]] = {}
    for row in rows:
        own = split(row)
        numbers = tuple(m.setdefault(each, len(m)) for m, each in zip(minds, own, strict=True))
        held.setdefault(tuple(bool(row[f]) for f in flags), set()).add(numbers)
    most = max(map(len, minds))
    possible = np.zeros((2 ** len(parts), len(parts), most), bool)
    for rational, members in held.items():
        group = sum(r << c for c, r in enumerate(rational))
        for numbers in members:
            possible[group, np.arange(len(parts)), list(numbers)] = True
    told = np.zeros((len(parts), most), bool)
    for c, (each, flag) in enumerate(zip(minds, flags, strict=True)):
        told[c, : len(each)] = [(flag, True) in mind for mind in each]
    space = Space(tuple(tuple(map(dict, each)) for each in minds), possible, told)
    whole = all(known >= row.keys() for row in rows) and sum(map(len, held.values())) == len(rows)
    if whole and space.count == len(rows) and math.prod(map(len, minds)) <= MOST_PRODUCT:
        return space
    alone = np.ones((1, 1, len(rows)), bool)
    return Space((tuple(rows),), alone, np.zeros((1, len(rows)), bool))


def space_of_groups(groups: Groups) -> Space:
    """The space of hypotheses that are not listed, of the minds in each group."""
    parts = len(next(iter(groups)))
    numbers: list[dict[Any, int]] = [{} for _ in range(parts)]
    for minds in groups.values():
        for known, each in zip(numbers, minds, strict=True):
            for mind in each:
                known.setdefault(frozenset(mind.items()), len(known))
    most = max(map(len, numbers))
    possible = np.zeros((2**parts, parts, most), bool)
    told = np.zeros((parts, most), bool)
    for flags, minds in groups.items():
        group = sum(flag << c for c, flag in enumerate(flags))
        for c, (known, each) in enumerate(zip(numbers, minds, strict=True)):
            places = [known[frozenset(mind.items())] for mind in each]
            possible[group, c, places] = True
            told[c, places] = flags[c]
    return Space(tuple(tuple(map(dict, known)) for known in numbers), possible, told)


@dataclass(frozen=True)
class Rows:
    """What expressions tell apart: a row stands for all hypotheses in which some latents are so.

    Attributes:
        index: the row of a hypothesis.
        counts: how many hypotheses each stands for, [H].
        members: for each row and part the minds that it may be.
    """

    index: Index
    counts: np.ndarray
    members: tuple[tuple[np.ndarray, ...], ...]

    def drawn(self, rows: np.ndarray, generator: np.random.Generator) -> np.ndarray:
        """Hypotheses of rows, evenly among those that each stands for: [N, C] of [N]."""
        uniform = generator.random((len(rows), len(self.members[0])))
        minds, first, size = self._side_by_side
        found: np.ndarray = minds[first[rows] + (uniform * size[rows]).astype(int)]
        return found

    @cached_property
    def _side_by_side(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """All members one after the other, and where those of a row and part begin and how many
        they are, [H, C] each."""
        size = np.array([[len(minds) for minds in each] for each in self.members])
        minds = np.concatenate([minds for each in self.members for minds in each])
        return minds, np.cumsum(size).reshape(size.shape) - size, size


def rows_of(space: Space, rows: Sequence[Row], kept: frozenset[str] | None = None) -> Rows:
    """How listed rows are told apart: by the values of all latents, or of those that are kept."""
    if len(space.parts) == 1 and kept is None:
        numbers = np.arange(len(rows))
        each = tuple((numbers[n : n + 1],) for n in range(len(rows)))
        return Rows(Index(numbers[None], numbers), np.ones(len(rows)), each)
    told = lambda mind: frozenset((x, v) for x, v in mind.items() if kept is None or x in kept)
    classes: list[dict[Any, int]] = []
    of_minds = np.zeros((len(space.parts), space.possible.shape[-1]), int)
    for c, part in enumerate(space.parts):
        known: dict[Any, int] = {}
        for number, mind in enumerate(part):
            of_minds[c, number] = known.setdefault(told(mind), len(known))
        classes.append(known)
    index = _index(of_minds, [len(known) for known in classes])
    names = [frozenset().union(*part) for part in space.parts]
    members = []
    for number, row in enumerate(rows):
        own = [frozenset((x, v) for x, v in row.items() if x in latents) for latents in names]
        at = [known[mind] for known, mind in zip(classes, own, strict=True)]
        rational = [space.rational[c, of_minds[c].tolist().index(k)] for c, k in enumerate(at)]
        group = sum(int(flag) << c for c, flag in enumerate(rational)) % len(space.possible)
        members.append(
            tuple(
                np.flatnonzero((of_minds[c] == k) & space.possible[group, c])
                for c, k in enumerate(at)
            )
        )
        index.table[_at(index, members[-1])] = number
    counts = np.array([math.prod(map(len, each)) for each in members], float)
    return Rows(index, counts, tuple(members))


def _at(index: Index, members: tuple[np.ndarray, ...]) -> int:
    """Where in its table an index has hypotheses, of which all have the same row."""
    return int(sum(index.digits[c, minds[0]] for c, minds in enumerate(members)))


def _index(numbers: np.ndarray, sizes: Sequence[int]) -> Index:
    """An index by numbers of minds [C, M], each below a size; its table is empty yet (-1)."""
    strides = np.cumprod([1, *sizes[:0:-1]])[::-1].astype(int)
    return Index(numbers * strides[:, None], np.full(math.prod(sizes), -1))


def problems_in(space: Space, about: Sequence[int], problems: Mapping[Any, int]) -> Index:
    """The problem of a hypothesis, by the minds of those whom it is about.

    Args:
        problems: the number of a problem, by such minds (frozensets of their latents); every other
            one is that of who acts at random, the number after these.
    """
    shown = [c in about for c in range(len(space.parts))]
    sizes = [len(part) if there else 1 for part, there in zip(space.parts, shown, strict=True)]
    own = np.where(np.array(shown)[:, None], np.arange(space.possible.shape[-1]), 0)
    own = np.minimum(own, np.array(sizes)[:, None] - 1)
    index = _index(own, sizes)
    numbers = [{frozenset(mind.items()): n for n, mind in enumerate(part)} for part in space.parts]
    index.table[:] = 1 + max(problems.values(), default=-1)
    for minds, problem in problems.items():
        at = sum(
            int(index.digits[c, numbers[c][mind]]) for c, mind in zip(about, minds, strict=True)
        )
        index.table[at] = problem
    return index


@dataclass(frozen=True)
class Seen:
    """How one observer sees hypotheses.

    Attributes:
        prior: of each row, [H].
        known: the rows that he thinks possible at all, [H].
        forgetting: the share of belief that is reassigned after each observed action.
        problems, columns: see SwarmTables.
    """

    prior: np.ndarray
    known: np.ndarray
    forgetting: float
    problems: tuple[Index, ...]
    columns: tuple[np.ndarray, ...]


def problems_of_rows(row: Index, columns: Sequence[np.ndarray]) -> tuple[list[Index], list[Any]]:
    """Where all hypotheses are listed, the problems of who acts, and a row that has each.

    Args:
        columns: for each observation of a frame the problem of each row, [H].
    """
    problems, first = [], []
    for column in columns:
        _, place, number = np.unique(column, return_index=True, return_inverse=True)
        problems.append(Index(row.digits, number[np.maximum(row.table, 0)]))
        first.append(place)
    return problems, first


def swarm_tables(space: Space, rows: Rows, seen: Seen, plan: Particles) -> SwarmTables:
    """The numbers of an observer who holds so many particles."""
    near, near_count = _near(space)
    even = rows.counts / rows.counts.sum()
    held = np.where(seen.known, rows.counts, 0.0)
    again = 0.0
    if held.sum() > 1:
        again = seen.forgetting * held.sum() / (held.sum() - 1)
    start = _generator(plan.seed, 0)
    with np.errstate(divide="ignore"):
        return SwarmTables(
            flag=space.flag,
            options=np.argsort(~space.possible, axis=-1, kind="stable"),
            sizes=space.possible.sum(-1),
            possible=space.possible,
            near=near,
            near_count=near_count,
            redrawn=_redrawn(space),
            row=rows.index,
            problems=seen.problems,
            columns=seen.columns,
            log_weight=np.log(seen.prior / even),
            log_known=np.log(np.where(seen.known, 1.0, 0.0)),
            log_rows=np.log(seen.prior),
            first=rows.drawn(_spread(seen.prior, plan.count, start), start),
            least=np.array(plan.least * plan.count),
            draws=_draws(rows, held / held.sum(), again, len(seen.columns), plan),
        )


def _generator(seed: int, frame: int) -> np.random.Generator:
    return np.random.Generator(np.random.Philox(key=np.array([seed, frame], np.uint64)))


def _spread(prior: np.ndarray, count: int, generator: np.random.Generator) -> np.ndarray:
    """So many rows drawn systematically from a distribution over them, [N]."""
    ends = np.cumsum(prior)
    points = (np.arange(count) + generator.random()) / count * ends[-1]
    found: np.ndarray = np.minimum(np.searchsorted(ends, points, side="right"), len(prior) - 1)
    return found


def _draws(held: Rows, anew: np.ndarray, again: float, observed: int, plan: Particles) -> Draws:
    """What chance decides in each frame, whatever happens in it."""
    count, characters = plan.count, len(held.members[0])
    observed = observed if again > 0 else 0
    offset = np.zeros(plan.frames)
    moves = np.zeros((plan.frames, plan.moves, steps_of(characters), count))
    jump = np.zeros((plan.frames, observed, count), bool)
    fresh = np.zeros((plan.frames, observed, count, characters), int)
    for frame in range(plan.frames):
        generator = _generator(plan.seed, frame + 1)
        offset[frame] = generator.random(dtype=np.float32)
        drawn = generator.random(moves.shape[1:], dtype=np.float32)
        moves[frame] = np.maximum(drawn, np.float32(2**-24))
        for u in range(observed):
            ends = np.floor(np.arange(count + 1) * again + generator.random())
            jump[frame, u] = generator.permutation(np.diff(ends) > 0)
            rows = _spread(anew, count, generator)
            fresh[frame, u] = held.drawn(generator.permutation(rows), generator)
    return Draws(offset, moves, jump, fresh)


def _near(space: Space) -> tuple[np.ndarray, np.ndarray]:
    """The minds that differ from each in one latent alone: [C, M, D], and how many, [C, M]."""
    near: list[list[list[int]]] = []
    for part in space.parts:
        alike: dict[Any, list[int]] = {}
        for number, mind in enumerate(part):
            for latent in mind:
                rest = frozenset((x, v) for x, v in mind.items() if x != latent)
                alike.setdefault((latent, rest), []).append(number)
        found: list[list[int]] = [[] for _ in part]
        for members in alike.values():
            for number in members:
                found[number] += [other for other in members if other != number]
        near.append(found)
    most = max(map(len, near))
    widest = max(1, max(len(each) for part in near for each in part))
    numbers = np.zeros((len(near), most, widest), int)
    count = np.zeros((len(near), most), int)
    for c, found in enumerate(near):
        for number, others in enumerate(found):
            numbers[c, number, : len(others)] = others
            count[c, number] = len(others)
    return numbers, count


def _redrawn(space: Space) -> np.ndarray:
    """Whether the minds of d depend on whether c is rational, [C, C]."""
    parts = len(space.parts)
    found = np.eye(parts, dtype=bool)
    if len(space.possible) == 1:
        return found
    groups = np.arange(len(space.possible))
    for c in range(parts):
        other = space.possible[groups ^ (1 << c)]
        found[c] |= (other != space.possible).any((0, 2))
    return found
