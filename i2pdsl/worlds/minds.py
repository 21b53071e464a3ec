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

from i2pdsl.audience.particles import Draws, Index, SwarmTables, steps_of
from i2pdsl.language.story import Particles
from i2pdsl.language.vocabulary import Value

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


def rows_in(space: Space, rows: Sequence[Row]) -> Index:
    """The number of the row that each joint hypothesis of listed ones is."""
    sizes = [len(part) for part in space.parts]
    strides = np.cumprod([1, *sizes[:0:-1]])[::-1].astype(int)
    digits = np.zeros((len(sizes), max(sizes)), int)
    for c, size in enumerate(sizes):
        digits[c, :size] = np.arange(size) * strides[c]
    if len(sizes) == 1:
        return Index(digits, np.arange(len(rows)))
    numbers = [{frozenset(m.items()): n for n, m in enumerate(part)} for part in space.parts]
    names = [frozenset().union(*part) for part in space.parts]
    table = np.full(math.prod(sizes), -1)
    for h, row in enumerate(rows):
        own = [frozenset((x, v) for x, v in row.items() if x in latents) for latents in names]
        at = sum(number[m] * s for number, m, s in zip(numbers, own, strides, strict=True))
        table[at] = h
    return Index(digits, table)


def minds_of(space: Space, index: Index, rows: int) -> np.ndarray:
    """The minds of each row of listed hypotheses, [H, C]."""
    sizes = [len(part) for part in space.parts]
    found = np.zeros((rows, len(sizes)), int)
    there = np.flatnonzero(index.table >= 0)
    found[index.table[there]] = np.stack(np.unravel_index(there, sizes), axis=-1)
    return found


@dataclass(frozen=True)
class Seen:
    """How one observer sees hypotheses.

    Attributes:
        prior: of each row, [H].
        known: the rows that he thinks possible at all, [H].
        forgetting: the share of belief that is reassigned after each observed action.
        columns: of each observation of a frame what the world's likelihoods of it depend on: the
            problem of each row, [H].
    """

    prior: np.ndarray
    known: np.ndarray
    forgetting: float
    columns: tuple[np.ndarray, ...]


def swarm_tables(
    space: Space, row: Index, minds: np.ndarray, seen: Seen, plan: Particles
) -> SwarmTables:
    """The numbers of an observer who holds so many particles.

    Args:
        minds: of each row, [H, C].
    """
    even = np.full(len(minds), 1 / len(minds))
    problems, columns = [], []
    for column in seen.columns:
        _, first, number = np.unique(column, return_index=True, return_inverse=True)
        problems.append(Index(row.digits, number[np.maximum(row.table, 0)]))
        columns.append(first)
    near, near_count = _near(space)
    sizes = space.possible.sum(-1)
    options = np.argsort(~space.possible, axis=-1, kind="stable")
    anew = seen.known / seen.known.sum()
    again = 0.0
    if seen.known.sum() > 1:
        again = seen.forgetting * seen.known.sum() / (seen.known.sum() - 1)
    with np.errstate(divide="ignore"):
        return SwarmTables(
            flag=space.flag,
            options=options,
            sizes=sizes,
            possible=space.possible,
            near=near,
            near_count=near_count,
            redrawn=_redrawn(space),
            row=row,
            problems=tuple(problems),
            columns=tuple(columns),
            log_weight=np.log(seen.prior / even),
            log_known=np.log(np.where(seen.known, 1.0, 0.0)),
            log_rows=np.log(seen.prior),
            first=minds[_spread(seen.prior, plan.count, _generator(plan.seed, 0))],
            least=np.array(plan.least * plan.count),
            draws=_draws(space, minds, anew, again, len(seen.columns), plan),
        )


def _generator(seed: int, frame: int) -> np.random.Generator:
    return np.random.Generator(np.random.Philox(key=np.array([seed, frame], np.uint64)))


def _spread(prior: np.ndarray, count: int, generator: np.random.Generator) -> np.ndarray:
    """So many rows drawn systematically from a distribution over them, [N]."""
    ends = np.cumsum(prior)
    points = (np.arange(count) + generator.random()) / count * ends[-1]
    found: np.ndarray = np.minimum(np.searchsorted(ends, points, side="right"), len(prior) - 1)
    return found


def _draws(
    space: Space, minds: np.ndarray, anew: np.ndarray, again: float, observed: int, plan: Particles
) -> Draws:
    """What chance decides in each frame, whatever happens in it."""
    count, characters = plan.count, len(space.parts)
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
            fresh[frame, u] = minds[generator.permutation(rows)]
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
