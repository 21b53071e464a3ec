"""A film that says nothing about itself, for people who shall judge it: no title, no belief, no
score, and no pace or mark that tells what its story wants."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

NAME = "A story"


@dataclass(frozen=True)
class Alone:
    """What a page needs to play a film.

    Attributes:
        stages: HTML of the drawing at time 0, as the first film of a page, as the second, ...
        aspect: the stage's width to its height.
        seconds: [T] that each frame lasts at speed 1.
        script: the script, below `render`, that defines `makeStage`.
        data: what that script reads of this film.
        told: T + 1 sentences, what is seen to happen; nothing where bodies move.
    """

    stages: Sequence[str]
    aspect: float
    seconds: Sequence[float]
    script: str
    data: Mapping[str, Any]
    told: Sequence[str] = ()
