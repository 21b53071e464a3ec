"""The films that a connection can still ask about."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from itertools import count
from typing import TYPE_CHECKING

from i2pdsl.studio.protocol import USAGE, Refusal

if TYPE_CHECKING:
    from i2pdsl.objective.panel import Judgement
    from i2pdsl.stories import Script, Story

KEPT, WORLDS = 64, 2  # films of a connection, and worlds that they are in: each is large


@dataclass(frozen=True)
class Made:
    """A film that was made.

    Attributes:
        name: what messages call it.
        quality: preview, refined, best, candidate, suggested.
        judgement: what the panel makes of it, if it was asked.
    """

    name: str
    uri: str
    version: int
    seed: int
    quality: str
    story: Story
    script: Script
    judgement: Judgement | None = None


class Films:
    """The last films of a connection, by their names; for any thread."""

    def __init__(self) -> None:
        self._made: dict[str, Made] = {}
        self._numbers = count(1)
        self._changing = threading.Lock()

    def name(self) -> str:
        return f"f{next(self._numbers)}"

    def keep(self, made: Made) -> None:
        with self._changing:
            self._made[made.name] = made
            last = list(self._made.values())[-KEPT:]
            worlds = list({id(film.script.world): None for film in reversed(last)})[:WORLDS]
            self._made = {film.name: film for film in last if id(film.script.world) in worlds}

    def __getitem__(self, name: str) -> Made:
        try:
            return self._made[name]
        except KeyError:
            raise Refusal(USAGE, "this film is no longer at hand: solve again") from None
