"""In what order a search looks: all starts, all of them with wider beams, then the best of them
with still wider ones.

All is a matter of budget: whoever spends more gets the same blocks in the same order, and some
after them, so that more effort never makes a score worse.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

# All starts again, so many times as wide: what one pass reaches from a start says little of what a
# wider beam reaches from it.
AGAIN = 10
ROUND = 4  # blocks that are chosen by the same order of the starts, so that they can run at once


@dataclass(frozen=True)
class Block:
    """Beams that are searched together.

    Attributes:
        starts: [G] numbers of the starts.
        width: scripts kept for each.
        alike: of them, so many may stand in one state.
        ahead: whether prefixes are judged by what they promise.
    """

    starts: np.ndarray
    width: int
    alike: int
    ahead: bool


@dataclass
class Kind:
    """A kind of block: beams so many times as wide as in the first pass, or wider once all starts
    have had theirs; `variety` keeps those in one state down to two."""

    factor: int
    variety: bool
    ahead: bool
    fresh: bool = False
    done: set[int] = field(default_factory=set)


def usual_kinds() -> list[Kind]:
    """What is tried in turn, some of them twice as often; the usual effort is two blocks on the
    kitchen, and sixty in a world of 56 first pictures. Every one is the best for some objective
    (docs/search.md)."""
    hopeful = Kind(16, variety=True, ahead=True)
    varied = Kind(16, variety=True, ahead=False)
    wide = Kind(64, variety=False, ahead=True)
    return [
        hopeful,
        Kind(32, variety=False, ahead=False),
        wide,
        varied,
        hopeful,
        Kind(1, variety=False, ahead=False, fresh=True),
        wide,
        varied,
    ]


def rounds(
    count: int, width: int, places: int, budget: int, scores: np.ndarray
) -> Iterator[list[Block]]:
    """The blocks of a search, a round at a time.

    Args:
        count: of the starts of the first pass; those from `count` on are fresh, for later.
        width: of the first pass.
        places: that a block has, at least `width`.
        budget: scripts that may be searched after the first pass.
        scores: [N], the best of each start so far, -inf where there is none; read for each round,
            after the blocks of those before were searched.
    """
    first = np.arange(count)
    yield _pass(first, width, places)
    wide = min(AGAIN * width, places)
    if wide > width:
        order = first[np.argsort(-scores[first], kind="stable")]
        again = _pass(order, wide, places)[: _affordable(budget, places)]
        if again:
            yield again
        budget -= len(again) * places
    kinds, fresh, turn = usual_kinds(), count, 0
    while (left := min(ROUND, _affordable(budget, places))) and kinds:
        blocks: list[Block] = []
        known = np.setdiff1d(np.flatnonzero(scores > -np.inf), np.arange(fresh, len(scores)))
        order = known[np.argsort(-scores[known], kind="stable")]
        while len(blocks) < left and kinds:
            kind = kinds[turn % len(kinds)]
            turn += 1
            if kind.fresh:
                chosen = np.arange(fresh, min(fresh + places // width, len(scores)))
                fresh += len(chosen)
                block = Block(chosen, width, width, kind.ahead) if len(chosen) else None
            else:
                block = _next(kind, order, width, places)
            if block is None:
                kinds.remove(kind)
            else:
                blocks.append(block)
        if blocks:
            yield blocks
        budget -= len(blocks) * places


def _affordable(budget: int, places: int) -> int:
    """Blocks for a budget, the last one begun."""
    return max(0, -(-budget // places))


def _pass(starts: np.ndarray, width: int, places: int) -> list[Block]:
    size = places // width
    return [Block(starts[i : i + size], width, width, False) for i in range(0, len(starts), size)]


def _next(kind: Kind, order: np.ndarray, width: int, places: int) -> Block | None:
    """The next block of a kind: the best starts that had none yet; None where all had."""
    while len(order):
        # With few starts there is room for wider beams.
        wide = max(min(kind.factor * width, places), places // len(order))
        left = [int(s) for s in order if int(s) not in kind.done][: places // wide]
        if left:
            kind.done.update(left)
            return Block(np.array(left), wide, 2 if kind.variety else wide, kind.ahead)
        if wide >= places:
            return None
        kind.factor *= 2
        kind.done.clear()
    return None
