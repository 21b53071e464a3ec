"""How a kind of world is drawn: one object in its folder below render/, which worlds/kinds.py
names."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from i2pdsl.errors import StoryError, error, whole_file
from i2pdsl.explain import as_story
from i2pdsl.language.story import TypedStory
from i2pdsl.objective.subjects import Claims
from i2pdsl.render.alone import Alone
from i2pdsl.render.characters import Ink
from i2pdsl.render.files import PictureFiles
from i2pdsl.render.focus import Sentence
from i2pdsl.scripts import Script
from i2pdsl.worlds.kinds import kind_of

Point = tuple[float, float]
"""A place in a film's picture, in units of its `viewBox`."""


@dataclass(frozen=True)
class Spot:
    """Where somebody can be put by hand: as stories write it behind `at(who, ...)`, and in the
    picture its middle and its outline."""

    place: str
    at: Point
    shape: tuple[Point, ...]


@dataclass(frozen=True)
class Room:
    """Where somebody can be put who can be put between spots, too.

    Attributes:
        reached: what can be reached in time, as boxes (x, y, width, height) in the picture; None
            where that is not known.
        along: the direction of the one way that there is, as (dx, dy); None where all are open.
    """

    reached: tuple[tuple[float, float, float, float], ...] | None = None
    along: Point | None = None


@dataclass(frozen=True)
class Seen:
    """Who is where in a film: in frames 0..T, None where it is absent."""

    name: str
    at: tuple[Point | None, ...]


class Drawing(ABC):
    """One kind's drawing.

    Attributes:
        files: what draws one script.
        strip_tells: whether a comic strip alone tells a story, without its page.
    """

    files: ClassVar[type[PictureFiles]]
    strip_tells: ClassVar[bool] = True

    @abstractmethod
    def pictures(self, scripts: Sequence[Script], title: str | None = None) -> PictureFiles:
        """What draws one script, or several side by side. Raises StoryError."""

    def sheet(self, scripts: Sequence[Script], title: str) -> PictureFiles:
        """What draws candidates of one story side by side: its comic and its page."""
        return self.pictures(scripts, title)

    def page_script(self) -> str:
        """The module, below `render`, that moves its films in pages (render/film_page.py); empty
        where it has none."""
        return ""

    def alone(self, scripts: Sequence[Script], places: int) -> list[Alone]:
        """Films without a word about them, that can stand beside each other at one scale.

        Args:
            places: how many of them may stand on one page.

        Raises StoryError where the kind has none.
        """
        world = scripts[0].world.spec
        message = f"films in worlds like {world.name} cannot be shown on a page of their own"
        raise error("pictures", message, whole_file(scripts[0].record.where))

    @abstractmethod
    def in_characters(self, world: Any, state: Any, ink: Ink) -> str:
        """Where everybody is, for a terminal."""

    def sentence(self, spec: Any) -> Sentence:
        """What says an event about a world in words; here as the language writes it."""
        words = kind_of(spec).vocabulary(spec)

        def said(event: Claims, condition: Claims) -> tuple[str, str]:
            told = " if ".join(as_story(words, found) for found in (event, condition) if found)
            return told, told

        return said

    def deeds(self, script: Script) -> list[dict[str, str]]:
        """For each of the frames 1..T what everybody does in it, in words; nothing where bodies
        move."""
        return [{} for _ in range(script.length)]

    def empty_stage(self, spec: Any) -> str:
        """The stage with nobody on it, as SVG in the same units as films; empty where there is
        none without a story."""
        return ""

    def units(self, spec: Any) -> tuple[Point, Point] | None:
        """How points of the empty stage are places of a file: (a, b) and (c, d), so that (x, y) is
        (a x + b, c y + d); None where places are not told by numbers."""
        return None

    def spots(self, spec: Any) -> list[Spot]:
        """Where characters and objects can be put by hand; nowhere where stories have no words
        for it."""
        return []

    def seen(self, script: Script) -> list[Seen]:
        """Who can be taken hold of, and where they are in the film; nobody where stories have no
        words for places."""
        return []

    def held(self, spec: Any) -> tuple[str, ...]:
        """Their names, without a film: those of whom stories can say `at(...)`."""
        words = kind_of(spec).vocabulary(spec)
        if "at" not in words.predicates:
            return ()
        everybody = words.predicates["at"].parameters[0] == "thing"
        return (*words.characters, *(words.things if everybody else ()))

    def room(self, world: Any, story: TypedStory, frame: int, who: str) -> Room | None:
        """Where somebody can be put in a frame besides spots, if what else is pinned of it is kept;
        None where spots are all that there is."""
        return None

    def said_of(self, script: Script, frame: int, who: str, at: Point) -> str:
        """What stories say of somebody who is put at a point in a frame of a film.

        Raises StoryError where it cannot be.
        """
        message = f"in worlds like {script.world.name} only places can be chosen"
        raise error("pin", message, whole_file(script.record.where))


def one_by_one(scripts: Sequence[Script]) -> StoryError:
    """That these scripts are not drawn side by side."""
    message = "these scripts cannot be drawn side by side"
    return error("pictures", message, whole_file(scripts[1].record.where), "draw them one by one")
