"""What worlds have in common in which nothing happens but what characters do, nothing fails by
chance, and viewers hold all hypotheses; and what they lack, so that nobody asks it: the checker
refuses stories that would need it."""

from __future__ import annotations

from functools import cached_property
from typing import Any, NoReturn

from i2pdsl.audience.holding import HoldingTables
from i2pdsl.worlds.world import Array, Tables, Viewer, on_device


class PlainWorld:
    """A world without events, chance and particles: tables with `log_prior` and `forgetting`."""

    spec: Any
    tables: Any
    weak_chances: tuple[float, ...] = ()
    rows_are_scaled = keeps_doubt = False
    lists_hypotheses = True
    event_slots = 0
    dropped: tuple[int, ...] = ()

    @property
    def name(self) -> str:
        return str(self.spec.name)

    @cached_property
    def search_tables(self) -> Tables:
        return on_device(self.tables)

    def log_prior(self, tables: Tables) -> Array:
        return tables.log_prior

    def forgetting(self, tables: Tables) -> Array:
        return tables.forgetting

    def holdings(self, tables: Tables) -> tuple[HoldingTables | None, ...]:
        return ()

    def holding(self, viewers: tuple[Viewer, ...]) -> NoReturn:
        raise NotImplementedError("nobody holds particles")

    def events(self, allowed: tuple[tuple[str, str], ...]) -> tuple[int, ...]:
        return ()

    def small(self, about: frozenset[int]) -> None:
        return None

    def row(self, tables: Tables, rows: Array, state: Array) -> NoReturn:
        raise NotImplementedError("no part of it is looked at alone")

    def drops(self, tables: Tables, state: Array) -> NoReturn:
        raise NotImplementedError("nothing happens but what characters do")

    def attempts(self, tables: Tables, state: Array, action: Array) -> NoReturn:
        raise NotImplementedError("nobody's actions fail by chance")
