"""What viewers of a grid world hold who do not list hypotheses (audience/holding.py)."""

from __future__ import annotations

import numpy as np

from i2pdsl.audience.holding import HoldingTables
from i2pdsl.audience.particles import Index
from i2pdsl.errors import error, whole_file
from i2pdsl.language.story import Particles
from i2pdsl.language.vocabulary import Vocabulary
from i2pdsl.worlds.factors import factor_tables, tree_of
from i2pdsl.worlds.grid.arrays import Tables
from i2pdsl.worlds.grid.hypotheses import minds_of_all, modelled
from i2pdsl.worlds.grid.problems import problems_of_minds, thought_of
from i2pdsl.worlds.grid.spec import GridSpec
from i2pdsl.worlds.hypotheses import parts_of, rationality_of
from i2pdsl.worlds.minds import (
    Rows,
    Seen,
    Space,
    problems_in,
    problems_of_rows,
    rows_of,
    space_of,
    space_of_groups,
    swarm_tables,
)
from i2pdsl.worlds.world import Viewer


def holdings_of(
    spec: GridSpec, words: Vocabulary, viewers: tuple[Viewer, ...], tables: Tables
) -> tuple[HoldingTables | None, ...]:
    """Those of each viewer, None of one who holds all hypotheses as a list; empty where everybody
    does."""
    if not (spec.is_sampled or any(viewer.particles for viewer in viewers)):
        return ()
    space, rows = space_and_rows(spec, words)
    found: list[HoldingTables | None] = []
    for o, viewer in enumerate(viewers):
        if viewer.particles is None and not spec.is_sampled:
            found.append(None)
            continue
        if viewer.spec.settings.switching:
            who = "particles" if viewer.particles else "beliefs by factors"
            message = f"who holds {who} does not think that goals change (`switching`)"
            hint = "leave out `switching`"
            hint += "" if spec.is_sampled else ", or write `bayesian` for `particles`"
            raise error("audience", message, whole_file(spec.name), hint)
        known = np.array(viewer.known or (True,) * len(words.hypotheses))
        if spec.is_sampled:
            problems = problems_in_space(spec, space)
            columns = [np.arange(column.shape[1]) for column in tables.columns]
        else:
            problems, columns = problems_of_rows(rows.index, [c[o] for c in tables.columns])
        forgetting = float(viewer.spec.settings.forgetting)
        prior = np.exp(tables.log_prior[o])
        seen = Seen(prior, known, forgetting, tuple(problems), tuple(columns))
        if viewer.particles is None and words.factors:
            found.append(factor_tables(space, rows, seen, tree_of(space, modelled(spec))))
        else:
            found.append(swarm_tables(space, rows, seen, viewer.particles or Particles()))
    return tuple(found)


def space_and_rows(spec: GridSpec, words: Vocabulary) -> tuple[Space, Rows]:
    """The hypotheses of a world by parts, and how its rows tell them apart."""
    if spec.is_sampled:
        space = space_of_groups(minds_of_all(spec))
        return space, rows_of(space, words.hypotheses, words.kept)
    flags = [rationality_of(c.name) for c in spec.characters]
    space = space_of(words.hypotheses, parts_of(spec.characters), flags)
    return space, rows_of(space, words.hypotheses)


def problems_in_space(spec: GridSpec, space: Space) -> list[Index]:
    """Of each character the number of its problem (problem_keys) under a hypothesis."""
    found = []
    for c, known in zip(spec.characters, problems_of_minds(spec), strict=True):
        numbers = {key: number for number, key in enumerate(dict.fromkeys(known.values()))}
        problems = {minds: numbers[key] for minds, key in known.items()}
        found.append(problems_in(space, thought_of(spec, c), problems))
    return found
