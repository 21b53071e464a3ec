"""Which films a participant sees, and in which order: lists that are dealt before anybody comes, so
that pages need not know what condition a film belongs to."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from typing import TypeVar

import numpy as np

CHECK = -1  # in a list: the attention check
CHECK_EVERY = 50  # films to one of them, at most

C = TypeVar("C", bound=Hashable)


def dealt(
    cells: Mapping[C, Sequence[Sequence[int]]], each: int, lists: int, seed: int
) -> list[list[int]]:
    """Lists of what participants see.

    Within a list every cell is shown as often as any other, or once more, and they take turns: each
    stretch of as many films as there are cells has one of each, in random order. From any list to
    the next all of a cell's films are shown once before one is shown again. A film that can be
    shown in several ways (a pair either way round) is shown in each of them as often as in the
    others, or once more, within a list and a cell.

    Args:
        cells: what is shown of each (condition and method), each in the ways in which it can be
            shown; all differ.
        each: how many of them make a list.
    """
    rng = np.random.default_rng(seed)
    names = list(cells)
    decks: dict[C, list[int]] = {name: [] for name in names}
    found, turn = [], 0
    for _ in range(lists):
        count = {name: each // len(names) for name in names}
        for extra in range(each % len(names)):
            count[names[(turn + extra) % len(names)]] += 1
        turn = (turn + each % len(names)) % len(names)
        hands = {name: _hand(decks[name], cells[name], count[name], rng) for name in names}
        found.append(_with_checks(_in_turns(list(hands.values()), rng), rng))
    return found


def _hand(
    deck: list[int], films: Sequence[Sequence[int]], count: int, rng: np.random.Generator
) -> list[int]:
    """Takes so many different films from a deck, which is shuffled anew when it is empty."""
    hand: list[int] = []
    while len(hand) < count:
        if not deck:
            fresh = rng.permutation(len(films)).tolist()
            deck.extend([f for f in fresh if f in hand] + [f for f in fresh if f not in hand])
        hand.append(deck.pop())
    ways = len(films[0])
    first = rng.integers(ways)
    way = rng.permutation((first + np.arange(count)) % ways)
    return [films[film][int(w)] for film, w in zip(hand, way, strict=True)]


def _in_turns(hands: list[list[int]], rng: np.random.Generator) -> list[int]:
    """One of each hand, then again one of each; those that have fewer sit out a random turn."""
    turns: list[list[int]] = [[] for _ in range(max(map(len, hands)))]
    for hand in hands:
        for turn, film in zip(sorted(rng.permutation(len(turns))[: len(hand)]), hand, strict=True):
            turns[turn].append(film)
    return [turn[k] for turn in turns for k in rng.permutation(len(turn))]


def _with_checks(films: list[int], rng: np.random.Generator) -> list[int]:
    """Each stretch of films has an attention check somewhere in its second half."""
    found: list[int] = []
    for stretch in np.array_split(np.array(films), -(-len(films) // CHECK_EVERY)):
        at = rng.integers(-(-len(stretch) // 2), len(stretch) + 1)
        found += [*stretch[:at].tolist(), CHECK, *stretch[at:].tolist()]
    return found
