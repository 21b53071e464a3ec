"""Who plans what in a grid world, and what each expects of the other (model.md, "Kitchen")."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from i2pdsl.errors import error, whole_file
from i2pdsl.worlds.grid.arrays import Against, Tables
from i2pdsl.worlds.grid.dynamics import Dynamics
from i2pdsl.worlds.grid.hypotheses import grid_hypotheses, minds_of_all
from i2pdsl.worlds.grid.packed import States
from i2pdsl.worlds.grid.spec import NO_GOAL, STAY, Character, GridSpec
from i2pdsl.worlds.hypotheses import (
    Hypothesis,
    attitudes_of,
    goal_of,
    rationality_of,
    reading_of,
    via_of,
)


class Key(NamedTuple):
    """A planning problem of a character: what it wants, what it thinks of those it models, and the
    tile where it wants to have been before; empty without one."""

    goal: str
    others: tuple[Modelled, ...] = ()
    via: str = ""


def plain(key: Key) -> list[Any]:
    """A problem as JSON has it, without what plays no part in it."""
    others = [(name, rho, other and plain(other)) for name, rho, other in key.others]
    return [key.goal, others, *([key.via] if key.via else [])]


class Modelled(NamedTuple):
    """Another as one who models it sees it.

    Attributes:
        rho: how much its reward counts; None where no attitude to it is known of.
        key: the problem that it solves; None where it acts at random.
    """

    name: str
    rho: float | None
    key: Key | None


def problem_keys(spec: GridSpec) -> tuple[tuple[Key, ...], ...]:
    """The distinct problems of each character, in the order in which hypotheses name them."""
    if spec.is_sampled:
        return tuple(tuple(dict.fromkeys(each.values())) for each in problems_of_minds(spec))
    rows = grid_hypotheses(spec)
    found = []
    for c in spec.characters:
        keys = (problem_of(spec, c, row) for row in rows if row[rationality_of(c.name)])
        found.append(tuple(dict.fromkeys(keys)))
    return tuple(found)


MOST_WAYS = 100_000  # how those may think on whose minds a character's problem depends

Minds = tuple[frozenset[tuple[str, Any]], ...]
"""One mind of each of some characters."""


def thought_of(spec: GridSpec, character: Character) -> tuple[int, ...]:
    """The numbers of those on whose minds a character's problem depends: itself, those whom it
    models, those whom they model, and so on."""
    names, last = {character.name}, set[str]()
    while names != last:
        last = set(names)
        names |= {name for each in last for name in spec.character(each).models}
    return tuple(n for n, c in enumerate(spec.characters) if c.name in names)


@lru_cache(maxsize=4)
def problems_of_minds(spec: GridSpec) -> tuple[dict[Minds, Key], ...]:
    """For each character the problem that it solves where it is rational, by the minds of those
    who are `thought_of`, without listing the hypotheses."""
    found: list[dict[Minds, Key]] = []
    groups = minds_of_all(spec)
    for who, c in enumerate(spec.characters):
        about, known = thought_of(spec, c), dict[Minds, Key]()
        ways = max(math.prod(len(minds[n]) for n in about) for minds in groups.values())
        if ways > MOST_WAYS:
            names = ", ".join(spec.characters[n].name for n in about)
            message = f"what {c.name} does depends on {ways:,} ways how {names} may think"
            hint = f"at most {MOST_WAYS:,}: who models whom, or has an attitude to it, matters most"
            raise error("too-large", message, whole_file(f"{spec.name}.world"), hint)
        for flags, minds in groups.items():
            if flags[who]:
                for combined in product(*(minds[n] for n in about)):
                    key = tuple(frozenset(mind.items()) for mind in combined)
                    if key not in known:
                        row = {x: v for mind in combined for x, v in mind.items()}
                        known[key] = problem_of(spec, c, row)
        found.append(known)
    return tuple(found)


def problem_of(spec: GridSpec, character: Character, row: Hypothesis) -> Key:
    """The problem that a rational character solves under a hypothesis. Who wants a thing goes to
    where it takes that to be."""
    latents = {
        each.toward: each.latent
        for each in attitudes_of(spec.characters)
        if each.who == character.name
    }
    others = []
    for name in character.models:
        rational, taken = row[rationality_of(name)], row.get(reading_of(character.name, name))
        seen = row if taken is None else row | {goal_of(name): taken}
        key = problem_of(spec, spec.character(name), seen) if rational else None
        rho = float(row[latents[name]]) if name in latents else None
        others.append(Modelled(name, rho, key))
    goal = str(row[goal_of(character.name)])
    place = row[reading_of(character.name, goal)] if goal in dict(character.supposes) else goal
    via = row.get(via_of(character.name), NO_GOAL)
    return Key(str(place), tuple(others), "" if via in (NO_GOAL, place) else str(via))


def costs(spec: GridSpec, who: int | None = None) -> np.ndarray:
    """The reward of each action of a character, or of any, away from the goal: [A]."""
    counts = [len(c.actions) for c in spec.characters]
    cost = np.full(max(counts) if who is None else counts[who], spec.settings.move)
    cost[STAY] = spec.settings.stay
    return cost


def on_goal(spec: GridSpec, dynamics: States, who: int, keys: Sequence[Key]) -> np.ndarray:
    """Whether a character counts as being at its goal in each cell, with each set of its m marks:
    bool [P, 2^m (N + 1)]; never where it is absent, wants nothing, or has not been where it wants
    to have been before."""
    number = {tuple(cell): i for i, cell in enumerate(dynamics.coordinates.tolist())}
    cells = {t.name: [number[c] for c in t.cells] for t in spec.tiles}
    via = spec.characters[who].via
    table = np.zeros((len(keys), 2 ** len(via), len(number) + 1), dtype=bool)
    for i, key in enumerate(keys):
        been = [m for m in range(2 ** len(via)) if not key.via or m >> via.index(key.via) & 1]
        table[i][np.ix_(been, cells.get(key.goal, []))] = True
    return table.reshape(len(keys), table.shape[1] * table.shape[2])


def ground(spec: GridSpec, dynamics: States) -> np.ndarray:
    """What any action on a cell costs besides: [M]; nothing where there is no cell."""
    found = np.zeros(spec.place_count)
    cells = {tuple(cell): i for i, cell in enumerate(dynamics.coordinates.tolist())}
    for tile in spec.tiles:
        found[[cells[cell] for cell in tile.cells]] = tile.cost
    return found


def imagined(spec: GridSpec, other: int) -> np.ndarray:
    """The policy of level 0: [A]."""
    cost = costs(spec, other)
    if spec.settings.level0 == "costs":
        weights = np.exp(spec.settings.beta * (cost - cost.max()))
    else:
        weights = np.ones(len(cost))
    return weights / weights.sum()


def answering(spec: GridSpec, who: int) -> tuple[int, ...]:
    """Those who act between two actions of a character, in their order."""
    count = len(spec.characters)
    return tuple((who + k) % count for k in range(1, count))


def expectations(
    spec: GridSpec, keys: tuple[tuple[Key, ...], ...]
) -> tuple[tuple[Against, ...], ...]:
    """What each character expects of each of those who answer it, in each of its problems."""
    success = tuple(np.array(c.success) if c.is_weak else None for c in spec.characters)
    return tuple(
        tuple(_expected(spec, keys, who, other, success) for other in answering(spec, who))
        for who in range(len(keys))
    )


def _expected(
    spec: GridSpec,
    keys: tuple[tuple[Key, ...], ...],
    who: int,
    other: int,
    success: tuple[np.ndarray | None, ...],
) -> Against:
    """What a character expects of another in each of its problems."""
    seen, problems = choices(spec, keys, who, other), len(keys[who])
    beta = np.full(len(keys[other]), spec.settings.beta)
    if seen is None:
        fixed, nobody = (
            np.repeat(imagined(spec, other)[:, None], problems, axis=1),
            np.zeros(problems),
        )
        return Against(fixed, None, nobody.astype(bool), beta, nobody, success)
    problem, rho = seen
    count = len(spec.characters[other].actions)
    fixed = np.full((count, problems), 1 / count)
    known = problem < len(keys[other])
    return Against(fixed, np.where(known, problem, 0), known, beta, rho, success)


def choices(
    spec: GridSpec, keys: tuple[tuple[Key, ...], ...], who: int, other: int
) -> tuple[np.ndarray, np.ndarray] | None:
    """Of another whom a character models: in each of its problems [P] the number of the other's
    problem, or how many there are where it acts at random, and how much its reward counts. None
    where it is not modelled."""
    name = spec.characters[other].name
    if name not in spec.characters[who].models:
        return None
    seen = [next(m for m in key.others if m.name == name) for key in keys[who]]
    numbers = {key: number for number, key in enumerate(keys[other])}
    problem = [len(numbers) if m.key is None else numbers[m.key] for m in seen]
    return np.array(problem), np.array([m.rho or 0.0 for m in seen])


def _state_tables(dynamics: States) -> dict[str, Any]:
    """The tables of a world's states, by their names."""
    if not isinstance(dynamics, Dynamics):
        nothing = dict.fromkeys(("cells", "lookup", "strides"))
        return nothing | {"spots": dynamics.spots, "successor": (), "packed": dynamics.packed}
    lookup = dynamics.lookup if len(dynamics.lookup) else dynamics.sorted_numbers
    listed = {name: getattr(dynamics, name) for name in ("cells", "strides", "spots", "successor")}
    return listed | {"lookup": lookup}


def rules_of(
    spec: GridSpec,
    dynamics: States,
    keys: tuple[tuple[Key, ...], ...],
    frames: bool,
    against: tuple[tuple[Against, ...], ...] | None = None,
) -> Tables:
    """The tables of a world's rules, without any values.

    Args:
        frames: whether the numbers of states tell the frame.
        against: what those who act together expect of each other, where it is known.
    """
    nothing = np.zeros(0)
    goals = tuple(on_goal(spec, dynamics, who, each) for who, each in enumerate(keys))
    return Tables(
        **_state_tables(dynamics),
        coordinates=dynamics.coordinates,
        absent=np.array(dynamics.absent),
        success=np.array([c.success for c in spec.characters]),
        cost=costs(spec),
        ground=ground(spec, dynamics),
        gamma=np.array(spec.settings.gamma),
        reward=np.array(spec.settings.goal),
        continuation=(),
        columns=(),
        sharpness=(),
        goals=goals,
        log_prior=nothing,
        forgetting=nothing,
        layer=np.array(dynamics.state_count) if frames else None,
        against=against or (expectations(spec, keys) if spec.together else None),
    )
