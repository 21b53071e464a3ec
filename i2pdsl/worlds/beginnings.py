"""What a story can begin as in a kind of world (`i2p new`): told in a sentence, and written in
statements with holes.

The holes are the parts that a world may have to give (Kind.roles): `helper` and `helped` where one
has an attitude toward the other, `goal` and `other`, two places that the helped one may want;
`actor`, who may want `here` or `there`; and others that a kind has of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from string import Formatter
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from importlib.resources.abc import Traversable

    from i2pdsl.language.vocabulary import Vocabulary
    from i2pdsl.worlds.hypotheses import Minded


@dataclass(frozen=True)
class Beginning:
    """One way to begin.

    Attributes:
        told: what happens, with holes.
        pattern: the standard pattern that it is an example of.
        length: frames.
        lines: each statement with the comment above it, both with holes.
        settings: of the world, as they stand behind its name.
    """

    name: str
    told: str
    pattern: str
    length: int
    lines: tuple[tuple[str, str], ...]
    settings: str = ""

    @property
    def holes(self) -> set[str]:
        """The roles that a world must have."""
        texts = (self.told, self.settings, *(part for line in self.lines for part in line))
        return {hole for text in texts for hole in holes_of(text)}


@dataclass(frozen=True)
class Beginnings:
    """All ways to begin in a kind of world, and the world that comes with them.

    Attributes:
        called: what animators call the kind.
        ways: the first is the usual one.
        more: statements that may be added, each behind the comment about it, with holes.
        template: the text of a world of one's own.
        world: the built-in world to begin in where a file would say no more than its kind.
    """

    called: str = ""
    ways: tuple[Beginning, ...] = ()
    more: tuple[tuple[str, str], ...] = ()
    template: Traversable | None = None
    world: str = ""


def holes_of(text: str) -> set[str]:
    """The names in the holes of a text."""
    return {hole for _, hole, _, _ in Formatter().parse(text) if hole}


def roles_among(
    minds: Sequence[Minded], words: Vocabulary, first: str = "helper"
) -> dict[str, str]:
    """The holes that a world can fill, and with what.

    Args:
        minds: its characters, as far as they may care about each other.
        first: `helper` or `helped`: which of the two is the `actor`, if both want something.
    """
    from i2pdsl.worlds.hypotheses import attitudes_of, goal_of

    places = {
        who: [str(v) for v in words.latents[goal_of(who)].values if v in words.places]
        for who in words.characters
        if goal_of(who) in words.latents
    }
    found: dict[str, str] = {}
    about = next(iter(attitudes_of(minds)), None)
    if about is not None:
        found = {"helper": about.who, "helped": about.toward, "rho": about.latent}
        wanted = places.get(about.toward, [])
        if len(wanted) > 1:
            found["goal"], found["other"] = wanted[:2]
    torn = sorted(
        (who for who in places if len(places[who]) > 1),
        key=lambda who: (who != found.get(first), words.characters.index(who)),
    )
    if torn:
        found["actor"] = torn[0]
        found["here"], found["there"] = places[torn[0]][:2]
    return found
