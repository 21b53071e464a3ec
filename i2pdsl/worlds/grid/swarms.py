"""The particles of a grid world's viewers (audience/particles.py)."""

from __future__ import annotations

import numpy as np

from i2pdsl.audience.particles import SwarmTables
from i2pdsl.errors import error, whole_file
from i2pdsl.language.vocabulary import Vocabulary
from i2pdsl.worlds.grid.arrays import Tables
from i2pdsl.worlds.grid.spec import GridSpec
from i2pdsl.worlds.hypotheses import parts_of, rationality_of
from i2pdsl.worlds.minds import Seen, minds_of, rows_in, space_of, swarm_tables
from i2pdsl.worlds.world import Viewer


def swarms_of(
    spec: GridSpec, words: Vocabulary, viewers: tuple[Viewer, ...], tables: Tables
) -> tuple[SwarmTables | None, ...]:
    """Those of each viewer, None of one who holds all hypotheses; empty where nobody has any."""
    if not any(viewer.particles for viewer in viewers):
        return ()
    flags = [rationality_of(c.name) for c in spec.characters]
    space = space_of(words.hypotheses, parts_of(spec.characters), flags)
    row = rows_in(space, words.hypotheses)
    minds = minds_of(space, row, len(words.hypotheses))
    found: list[SwarmTables | None] = []
    for o, viewer in enumerate(viewers):
        if viewer.particles is None:
            found.append(None)
            continue
        if viewer.spec.settings.switching:
            message = "who holds particles does not think that goals change (`switching`)"
            hint = "leave out `switching`, or write `bayesian` for `particles`"
            raise error("audience", message, whole_file(spec.name), hint)
        known = np.array(viewer.known or (True,) * len(words.hypotheses))
        columns = tuple(column[o] for column in tables.columns)
        forgetting = float(viewer.spec.settings.forgetting)
        seen = Seen(np.exp(tables.log_prior[o]), known, forgetting, columns)
        found.append(swarm_tables(space, row, minds, seen, viewer.particles))
    return tuple(found)
