"""The hypotheses that viewers of a grid world hold, as rows of latents (model.md, "Hypotheses").
No arrays here."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from itertools import product

from i2pdsl.errors import error, whole_file
from i2pdsl.language.vocabulary import FactorSizes
from i2pdsl.worlds.grid.spec import NO_GOAL, GridSpec
from i2pdsl.worlds.hypotheses import (
    MOST_HYPOTHESES,
    Groups,
    Hypothesis,
    Minded,
    attitudes_of,
    factored,
    hypotheses_of,
    latents_of,
    minds_of_each,
    parts_of,
    rationality_of,
    reading_of,
    rows_told_apart,
    told_apart,
    wants_of,
)

MOST_POINTS = 4 * MOST_HYPOTHESES  # at which a question may look
ROOM = 128  # rows, if the latents that must be kept apart leave room for others


def grid_hypotheses(spec: GridSpec) -> tuple[Hypothesis, ...]:
    """All hypotheses of a grid world, in a fixed order: 34 for the kitchen.

    `merged` counts each distinguishable hypothesis once; `literal` takes the paper's tuple word
    by word, every irrational robot once for each of its goals and attitudes (72 in the kitchen).
    """
    if spec.is_sampled:
        return apart(spec)[0]
    if len(spec.characters) > 1 and spec.settings.hypotheses == "literal":
        return _literal(spec.by_depth)
    return hypotheses_of(spec.by_depth, lambda goal: goal == NO_GOAL)


@lru_cache(maxsize=16)
def apart(spec: GridSpec) -> tuple[tuple[Hypothesis, ...], tuple[float, ...], frozenset[str]]:
    """Where there are too many: what the latents that are kept apart may be together, how many
    hypotheses have it so, and these latents. They are who is rational, those that a story names,
    those of which the world's file has a prior, and as many others as there is room for.

    Raises StoryError where those that must be kept may be too much together.
    """
    groups = minds_of_all(spec)
    kept = frozenset(rationality_of(c.name) for c in spec.characters)
    kept |= {name for name, _ in spec.shares} | set(spec.settings.asked.split())
    count = rows_told_apart(groups, kept)
    if count > MOST_HYPOTHESES:
        named = ", ".join(sorted(set(spec.settings.asked.split())))
        message = f"there are {count:,} ways how {named} may be together"
        hint = f"a story of this world asks about fewer latents: at most {MOST_HYPOTHESES:,} ways"
        raise error("too-large", message, whole_file(f"{spec.name}.world"), hint)
    for latent in latents_of(spec.characters):
        if rows_told_apart(groups, kept | {latent}) <= ROOM:
            kept |= {latent}
    rows, counts = told_apart(groups, kept)
    return tuple(rows), tuple(counts), kept


def minds_of_all(spec: GridSpec) -> Groups:
    """Of each set of rational characters, in the order of acting, what each may think."""
    return minds_of_each(spec.characters, lambda goal: goal == NO_GOAL)


def modelled(spec: GridSpec) -> tuple[int, ...]:
    """The numbers of those whom others model."""
    names = {name for c in spec.characters for name in c.models}
    return tuple(n for n, c in enumerate(spec.characters) if c.name in names)


def factor_sizes(spec: GridSpec) -> FactorSizes:
    """How large the factors of hypotheses are that are too many to be listed."""
    return factored(minds_of_all(spec), modelled(spec), apart(spec)[2])


@lru_cache(maxsize=16)
def factors(spec: GridSpec) -> tuple[frozenset[str], ...]:
    """Where hypotheses are too many to be listed, but few enough by factors, the latents of those
    whom others model, and of each other character; else empty."""
    common, sizes = modelled(spec), factor_sizes(spec)
    if sizes.probabilities > MOST_HYPOTHESES or sizes.points() > MOST_POINTS:
        return ()
    parts = parts_of(spec.characters)
    first = frozenset().union(*(parts[n] for n in common))
    return (first, *(part for n, part in enumerate(parts) if n not in common))


def hypothesis_count(spec: GridSpec) -> int:
    """How many there are."""
    if not spec.is_sampled:
        return len(grid_hypotheses(spec))
    return sum(math.prod(map(len, each)) for each in minds_of_all(spec).values())


def _literal(characters: Sequence[Minded]) -> tuple[Hypothesis, ...]:
    """Goals x attitudes x what is taken for goals x rationality, an irrational one being met with
    indifference.

    What plays no part is left out of a row, so that equal rows stand here several times.
    """
    goals = {c.name: wants_of(c) for c in characters}
    attitudes, minded = attitudes_of(characters), {c.name: c for c in characters}
    readings = [(c.name, other) for c in characters for other in c.misreads]
    rows: list[Hypothesis] = []
    for flags in product((True, False), repeat=len(goals)):
        rational = dict(zip(goals, flags, strict=True))
        values = [each.values if rational[each.toward] else (0.0,) for each in attitudes]
        options = (
            product(*goals.values()),
            product(*values),
            product(*(minded[o].goals for _, o in readings)),
        )
        for wanted, rhos, taken in product(*options):
            row: Hypothesis = {rationality_of(name): r for name, r in rational.items()}
            for name, chosen in zip(goals, wanted, strict=True):
                row |= chosen if rational[name] else {}
            cares, reads = zip(attitudes, rhos, strict=True), zip(readings, taken, strict=True)
            row |= {each.latent: rho for each, rho in cares if rational[each.who]}
            row |= {reading_of(*pair): g for pair, g in reads if all(rational[n] for n in pair)}
            rows.append(row)
    return tuple(rows)
