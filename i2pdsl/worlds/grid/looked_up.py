"""What a search looks up again and again, found before it: all policies, or who solves which
problem."""

from __future__ import annotations

from typing import Any

import numpy as np

from i2pdsl.worlds.grid.arrays import Problems, Tables, state_count
from i2pdsl.worlds.grid.policy import log_policy

Array = Any

MOST_POLICY_BYTES = 600 * 2**20
POLICIES_AT_ONCE = 2048  # states: all sizes of tables are multiples of it (arrays.padded)
FEW_POLICIES = 10**7  # numbers that are there sooner if a slower program makes them

# Sums over problems (audience/product.py) save a likelihood and a logarithm for each hypothesis:
# measured, of no more problems, and where each stands for some hypotheses.
MOST_PROBLEMS, EACH_STANDS_FOR = 64, 2


def by_problem(tables: Tables, most: int | None = None) -> tuple[Problems, ...]:
    """The problems of each character, as each observer sees them, if none knows of more than so
    many; by default, of so many as save something. Empty where the last has more: before it acts,
    branches are few."""
    if most is None:
        most = min(MOST_PROBLEMS, tables.log_prior.shape[-1] // EACH_STANDS_FOR)
    found = []
    for column, beta in zip(tables.columns, tables.sharpness, strict=True):
        irrational = len(beta)
        own = [np.union1d(row, [irrational]) for row in column]
        count = max(map(len, own))
        if count > most:
            own, count = [], 0
        columns = np.full((len(column), count), irrational)
        hypotheses = np.zeros((*columns.shape, column.shape[-1]))
        for o, problems in enumerate(own):
            columns[o, : len(problems)] = problems
            hypotheses[o, : len(problems)] = column[o] == problems[:, None]
        found.append(Problems(columns, hypotheses))
    return tuple(found) if found[-1].columns.size else ()


def with_policies(tables: Tables, count: int) -> Tables:
    """The tables of a search with all policies, which it looks up far more often than there are
    listed states; as they are where that takes too much memory.

    Args:
        count: how many states there are in fact.
    """
    from i2pdsl.programs import compiled_program

    states = state_count(tables)
    sizes = [
        len(after) * column.size
        for after, column in zip(tables.successor, tables.columns, strict=True)
    ]
    if 4 * states * sum(sizes) > MOST_POLICY_BYTES:
        return tables

    def tabulated(tables: Tables, parts: Array) -> tuple[Array, ...]:
        from jax import lax, numpy

        def policies(who: int) -> Array:
            def with_part(part: Array, table: Array) -> Array:
                first = part * POLICIES_AT_ONCE
                some = first + numpy.arange(POLICIES_AT_ONCE, dtype=np.int32)
                policy = log_policy(tables, who, some)
                return lax.dynamic_update_slice_in_dim(table, policy, first, axis=0)

            shape = (states, len(tables.successor[who]), *tables.columns[who].shape)
            return lax.fori_loop(0, parts, with_part, numpy.zeros(shape, tables.gamma.dtype))

        return tuple(map(policies, range(len(sizes))))

    brief = states * sum(sizes) < FEW_POLICIES
    given = (tables, np.int32(-(-count // POLICIES_AT_ONCE)))
    program = compiled_program(("policies",), tabulated, given, (0,) * len(sizes), brief=brief)
    return tables._replace(policies=program.run(*given))
