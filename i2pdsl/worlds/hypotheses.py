"""The latents that characters have in every kind of world (model.md, "Hypotheses")."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, Protocol

from i2pdsl.language.vocabulary import FactorSizes, Latent

Hypothesis = dict[str, float | str | bool]
"""One possible truth: latent -> value. A latent that plays no part is missing."""

MOST_HYPOTHESES = 4096  # that are listed, and held
ATTITUDE = "rho"  # where only one has an attitude, to one other; else `rho_WHO_TOWARD`


def goal_of(name: str) -> str:
    """The latent that holds a character's goal."""
    return f"G_{name}"


def rationality_of(name: str) -> str:
    """The latent that says whether a character is rational."""
    return f"R_{name}"


def attitude_of(name: str, toward: str) -> str:
    """The latent that holds how much one cares about another, where there are several such."""
    return f"{ATTITUDE}_{name}_{toward}"


def is_attitude(latent: str) -> bool:
    """Whether a latent holds how much somebody cares about another."""
    return latent == ATTITUDE or latent.startswith(f"{ATTITUDE}_")


class Minded(Protocol):
    """A character that may want something, and care about others."""

    @property
    def name(self) -> str: ...

    @property
    def goals(self) -> tuple[str, ...]: ...

    @property
    def attitudes(self) -> tuple[tuple[str, tuple[float, ...]], ...]:
        """Whom it has an attitude to, and how large that may be."""

    @property
    def misreads(self) -> tuple[str, ...]:
        """Of whom it may be wrong about what they want."""

    @property
    def supposes(self) -> tuple[tuple[str, tuple[str, ...]], ...]:
        """The things that it may want without knowing where they are, and the places where it may
        take each to be."""

    @property
    def via(self) -> tuple[str, ...]:
        """Places on one of which it may want to have been before."""


def reading_of(name: str, other: str) -> str:
    """The latent that holds what a character takes another to want, or where it takes a thing to
    be."""
    return f"B_{name}_{other}"


NOWHERE = "none"  # the value of `via_NAME` of who goes straight to its goal


def via_of(name: str) -> str:
    """The latent that holds where a character wants to have been before it is at its goal."""
    return f"via_{name}"


def readings_of(characters: Sequence[Minded]) -> dict[str, dict[str, str]]:
    """For each character who may be wrong, what about (a latent or a thing), and the latent that
    holds what it takes for true."""
    found = {}
    for c in characters:
        wants = {goal_of(other): reading_of(c.name, other) for other in c.misreads}
        places = {thing: reading_of(c.name, thing) for thing, _ in c.supposes}
        if wants or places:
            found[c.name] = wants | places
    return found


@dataclass(frozen=True)
class Attitude:
    """That a character may care about another: helping above 0, hindering below.

    Attributes:
        latent: what holds how much.
        who, toward: the names of the two.
        values: how much it can be where both are rational.
    """

    latent: str
    who: str
    toward: str
    values: tuple[float, ...]


def attitudes_of(characters: Sequence[Minded]) -> tuple[Attitude, ...]:
    """All attitudes of a cast."""
    pairs = [(c.name, toward, values) for c in characters for toward, values in c.attitudes]
    names = [attitude_of(who, toward) for who, toward, _ in pairs]
    latents = names if len(pairs) > 1 else [ATTITUDE]
    return tuple(Attitude(name, *pair) for name, pair in zip(latents, pairs, strict=False))


def parts_of(characters: Sequence[Minded]) -> tuple[frozenset[str], ...]:
    """The latents of each character: what it wants, whom it cares about, what it takes others to
    want or things to be, where it wants to have been, and whether it is rational."""
    cares = attitudes_of(characters)
    return tuple(
        frozenset(
            (
                goal_of(c.name),
                via_of(c.name),
                rationality_of(c.name),
                *(each.latent for each in cares if each.who == c.name),
                *(reading_of(c.name, other) for other in c.misreads),
                *(reading_of(c.name, thing) for thing, _ in c.supposes),
            )
        )
        for c in characters
    )


def latents_of(characters: Sequence[Minded]) -> dict[str, Latent]:
    """What is hidden about characters: attitudes if any has some, goals, and who is rational."""
    found: dict[str, Latent] = {}
    for each in attitudes_of(characters):
        about = f"{each.who}'s attitude toward {each.toward}: helping above 0, hindering below"
        # Beside an irrational partner the attitude is 0, whatever values it can have otherwise.
        forced = () if 0 in each.values else (0.0,)
        values = (*each.values, *forced)
        found[each.latent] = Latent(each.latent, "number", values, about, forced)
    goals = {c.name: c.goals for c in characters}
    for c in characters:
        found[goal_of(c.name)] = Latent(goal_of(c.name), "symbol", c.goals, f"{c.name}'s goal")
    for c in characters:
        for other in c.misreads:
            latent, about = reading_of(c.name, other), f"what {c.name} takes {other} to want"
            found[latent] = Latent(latent, "symbol", goals[other], about)
        for thing, places in c.supposes:
            latent, about = reading_of(c.name, thing), f"where {c.name} takes {thing} to be"
            found[latent] = Latent(latent, "symbol", places, about)
        if c.via:
            latent, about = via_of(c.name), f"where {c.name} wants to have been before"
            found[latent] = Latent(latent, "symbol", (NOWHERE, *c.via), about)
    for c in characters:
        about = f"whether {c.name} acts rationally, or at random"
        rational = rationality_of(c.name)
        found[rational] = Latent(rational, "truth", (True, False), about)
    return found


def hypotheses_of(
    characters: Sequence[Minded], is_nothing: Callable[[str], bool] = lambda goal: False
) -> tuple[Hypothesis, ...]:
    """The hypotheses about a cast, each distinguishable one once, in a fixed order: who is
    rational, and of those all goals and attitudes, and what they take others to want of whom they
    may be wrong. To one that acts at random everybody's attitude is 0.

    Args:
        characters: those who are modelled before those who model them.
        is_nothing: whether one with such a goal is left out where it could care about somebody
            and does not.
    """
    rows: list[Hypothesis] = []
    for reverse in product((True, False), repeat=len(characters)):
        rational = {c.name: r for c, r in zip(characters, reversed(reverse), strict=True)}
        free, fixed, held = _attitudes_where(characters, rational)
        minded = [c for c in characters if rational[c.name]]
        latents = [each.latent for each in free]
        options: list[Sequence[Any]]
        options = [*(wants_of(c) for c in minded), *(each.values for each in free)]
        for c in minded:
            for other in (o for o in minded if o.name in c.misreads):
                latents.append(reading_of(c.name, other.name))
                options.append(other.goals)
        who = {rationality_of(name): r for name, r in rational.items()}
        for chosen in product(*options):
            row: Hypothesis = {}
            for wanted in chosen[: len(minded)]:
                row.update(wanted)
            row.update(who)
            row.update(zip(latents, chosen[len(minded) :], strict=True))
            row.update(fixed)
            if not any(
                is_nothing(str(row[goal_of(name)])) and not any(row[latent] for latent in cares)
                for name, cares in held.items()
            ):
                rows.append(row)
    return tuple(rows)


def wants_of(character: Minded) -> list[Hypothesis]:
    """What a rational character may want, where it then takes that to be, and where it wants to
    have been before."""
    places, name = dict(character.supposes), character.name
    found: list[Hypothesis] = []
    for wanted in character.goals:
        for place in places.get(wanted, (wanted,)):
            row: Hypothesis = {goal_of(name): wanted}
            row |= {reading_of(name, wanted): place} if wanted in places else {}
            ways = [NOWHERE, *(via for via in character.via if via != place)]
            if not character.via or wanted == NOWHERE:
                found.append(row)
            else:
                found += [{**row, via_of(name): via} for via in ways]
    return found


def _attitudes_where(
    characters: Sequence[Minded], rational: dict[str, bool]
) -> tuple[list[Attitude], dict[str, float], dict[str, list[str]]]:
    """The attitudes that can have any value, those that are 0, and the latents of the first of
    each who has such."""
    mine = [each for each in attitudes_of(characters) if rational[each.who]]
    free = [each for each in mine if rational[each.toward]]
    held: dict[str, list[str]] = {}
    for each in free:
        held.setdefault(each.who, []).append(each.latent)
    return free, {each.latent: 0.0 for each in mine if each not in free}, held


def count_at_most(characters: Sequence[Minded], literal: bool = False) -> int:
    """No more than so many hypotheses there are, without listing them; `literal`: each irrational
    one once for each of its goals and attitudes."""
    more = 0 if literal else 1
    cares = math.prod(more + len(each.values) for each in attitudes_of(characters))
    goals = {c.name: more + len(wants_of(c)) for c in characters}
    reads = math.prod(goals[other] for c in characters for other in c.misreads)
    wants = math.prod(goals.values()) * (2 ** len(characters) if literal else 1)
    return cares * reads * wants


Groups = dict[tuple[bool, ...], list[list[Hypothesis]]]
"""Of each set of rational characters (in the order of a cast) the minds of each."""


def minds_of_each(
    characters: Sequence[Minded], is_nothing: Callable[[str], bool] = lambda goal: False
) -> Groups:
    """What `hypotheses_of` combines, without combining it: under each set of rational characters
    every mind of one goes with every mind of the others."""
    found: Groups = {}
    for flags in product((False, True), repeat=len(characters)):
        rational = {c.name: r for c, r in zip(characters, flags, strict=True)}
        found[flags] = [_minds(c, characters, rational, is_nothing) for c in characters]
    return found


def _minds(
    character: Minded,
    characters: Sequence[Minded],
    rational: dict[str, bool],
    is_nothing: Callable[[str], bool],
) -> list[Hypothesis]:
    """The minds of one character where these are rational."""
    flag: Hypothesis = {rationality_of(character.name): rational[character.name]}
    if not rational[character.name]:
        return [flag]
    mine = [each for each in attitudes_of(characters) if each.who == character.name]
    free = [each for each in mine if rational[each.toward]]
    fixed: Hypothesis = {each.latent: 0.0 for each in mine if each not in free}
    goals = {c.name: c.goals for c in characters}
    taken = [other for other in character.misreads if rational[other]]
    names = [each.latent for each in free]
    names += [reading_of(character.name, other) for other in taken]
    options = [*(each.values for each in free), *(goals[other] for other in taken)]
    found: list[Hypothesis] = []
    for wanted in wants_of(character):
        for chosen in product(*options):
            idle = free and is_nothing(str(wanted[goal_of(character.name)]))
            if not idle or any(chosen[: len(free)]):
                held: Any = zip(names, chosen, strict=True)
                found.append(wanted | flag | dict(held) | fixed)
    return found


def told_apart(groups: Groups, kept: frozenset[str]) -> tuple[list[Hypothesis], list[float]]:
    """What some latents may be together, and how many hypotheses have it so."""
    rows: dict[frozenset[tuple[str, Any]], float] = {}
    for minds in groups.values():
        shares = [Counter(_kept_of(m, kept) for m in each) for each in minds]
        for combined in product(*(each.items() for each in shares)):
            row = frozenset().union(*(part for part, _ in combined))
            count = math.prod(float(number) for _, number in combined)
            rows[row] = rows.get(row, 0.0) + count
    order = [latent for each in groups.values() for part in each for m in part for latent in m]
    place = {latent: number for number, latent in enumerate(dict.fromkeys(order))}
    listed = [dict(sorted(row, key=lambda pair: place[pair[0]])) for row in rows]
    return listed, list(rows.values())


def rows_told_apart(groups: Groups, kept: frozenset[str]) -> int:
    """How many rows `told_apart` lists."""
    count = lambda each: len({_kept_of(m, kept) for m in each})
    return sum(math.prod(map(count, minds)) for minds in groups.values())


def factored(groups: Groups, common: Sequence[int], kept: frozenset[str]) -> FactorSizes:
    """How large the factors of hypotheses are: one of some characters of a cast, and one of each
    other beside it, of whom some latents are kept apart (audience/factors.py)."""
    ways, own = 0, [c for c in range(len(next(iter(groups)))) if c not in common]
    minds: dict[int, set[frozenset[tuple[str, Any]]]] = {c: set() for c in own}
    for flags, each in groups.items():
        if all(flags[c] for c in own):
            ways += math.prod(len(each[c]) for c in common)
        for c in own:
            minds[c] |= {frozenset(mind.items()) for mind in each[c]}
    classes = tuple(len({_kept_of(dict(mind), kept) for mind in minds[c]}) for c in own)
    return FactorSizes(ways, tuple(map(len, minds.values())), classes)


def _kept_of(mind: Hypothesis, kept: frozenset[str]) -> frozenset[tuple[str, Any]]:
    """What is kept of a mind."""
    return frozenset((x, v) for x, v in mind.items() if x in kept)
