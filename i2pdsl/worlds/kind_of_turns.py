"""What kinds have in common whose actions have names: worlds/turns.py, which needs arrays, and is
imported where it is used."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from i2pdsl.language.forms import Word
from i2pdsl.language.scope import Module
from i2pdsl.language.vocabulary import Vocabulary
from i2pdsl.worlds.kind import Kind

if TYPE_CHECKING:
    from i2pdsl.worlds.record import Record, Trajectory


class KindOfTurns(Kind):
    """Its turns are typed, told and listed by the names of their actions."""

    def columns(self, words: Vocabulary, record: Record) -> Mapping[str, tuple[list[Any], str]]:
        from i2pdsl.worlds.turns import columns

        return columns(words, record)

    def play(self, words: Vocabulary) -> Word:
        from i2pdsl.worlds.turns import play

        return play(words)

    def played(
        self, world: Any, module: Module, path: Trajectory, typed: str
    ) -> tuple[Trajectory, str]:
        from i2pdsl.worlds.turns import played

        return played(world, module, path, typed)

    def options(self, words: Vocabulary, before: Sequence[str]) -> list[tuple[str, str]]:
        from i2pdsl.worlds.turns import options

        return options(words, before)
