"""What a story can begin as: told in a sentence, and written in statements with holes.

The holes are the parts that a world may have to give (i2pdsl/beginnings/roles.py): `helper` and
`helped` where one has an attitude toward the other, `goal` and `other`, two places that the helped
one may want; `actor`, who may want `here` or `there`; `light` and `heavy`, of a box.
"""

from __future__ import annotations

from dataclasses import dataclass
from string import Formatter

KINDS = ("map", "plane", "hill")
"""Kinds of worlds as animators call them."""


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


def holes_of(text: str) -> set[str]:
    """The names in the holes of a text."""
    return {hole for _, hole, _, _ in Formatter().parse(text) if hole}


_SEEN = "[touching({helper}, {helped}) @ script[t]]"
_MET = f"wish = (G_{{helped}} = {{goal}}),\n    contact = {_SEEN})"
_ALL_ALONG = (
    "All along they know that {helped} wants {goal} (`wish`), and they see the two side by side "
    "before the turn and after it (`contact`)."
)


def _shape(name: str, told: str, way: str) -> Beginning:
    """A story of a character's fortune."""
    comment = f"{way} Fortune is what {{helped}} can still hope for, and everybody knows that it "
    comment += "wants {goal}. `scale`: how much the shape counts."
    call = f"{name}({{helped}}, G_{{helped}} = {{goal}}, scale = 0.2)"
    known = ("Viewers shall also see what {helped} wants.", "maximize depict(G_{helped} = {goal})")
    lines = ((comment, f"maximize {call}"), known)
    return Beginning(name.replace("_", "-"), told, name, 18, lines)


_ON_MAPS = (
    Beginning(
        "help", "{helper} helps {helped}", "depict", 15,
        (("After every frame viewers shall believe that {helper} helps.",
          "maximize depict({rho} > 0)"),),
    ),
    Beginning(
        "hinder", "{helper} keeps {helped} from what it wants", "depict", 15,
        (("After every frame viewers shall believe that {helper} hinders.",
          "maximize depict({rho} < 0)"),),
    ),
    Beginning(
        "betrayal", "{helper} seems to help {helped}, and turns out to hinder it", "twist", 15,
        (("In the first half viewers shall believe that {helper} helps, in the second that it "
          f"hinders. {_ALL_ALONG}", f"maximize twist({{rho}} > 0, {{rho}} < 0, {_MET}"),),
    ),
    Beginning(
        "misjudged", "{helper} seems to hinder {helped}, and turns out to help it", "twist", 15,
        (("In the first half viewers shall believe that {helper} hinders, in the second that it "
          f"helps. {_ALL_ALONG}", f"maximize twist({{rho}} < 0, {{rho}} > 0, {_MET}"),),
    ),
    Beginning(
        "irony", "{helper} means well, but mistakes what {helped} wants", "irony", 20,
        (("Viewers shall know that {helped} wants {other}; that {helper}, who takes it to want "
          "{goal}, means to help; and that what it does is no help.",
          "maximize irony(G_{helped} = {other}, G_{helped} = {goal}, {rho} > 0, {rho} < 0)"),),
    ),
    Beginning(
        "reveal", "nobody can tell whether {helper} means well, until one moment tells all",
        "reveal", 12,
        (("Up to the middle viewers shall be of two minds about {helper}, then be sure that it "
          f"helps. {_ALL_ALONG}", f"maximize reveal({{rho}} > 0, {_MET}"),),
    ),
    Beginning(
        "foreshadowing", "{helper} seems harmless, a hint makes viewers doubt, and then it hinders",
        "foreshadowing", 16,
        (("Nobody shall expect harm from {helper}; after a quarter of the film a hint is half "
          f"believed; after three quarters it comes true. {_ALL_ALONG}",
          f"maximize foreshadowing({{rho}} < 0, {_MET}"),),
    ),
    Beginning(
        "red-herring", "viewers think that {actor} is after {here}, and it is not", "red_herring",
        16,
        (("For two thirds of the film viewers shall believe that {actor} wants {here}; then they "
          "drop it.", "maximize red_herring(G_{actor} = {here})"),),
    ),
    Beginning(
        "mystery", "everything becomes clear but one thing: what {actor} wants", "mystery", 14,
        (("What {actor} wants shall stay open to the end, and everything else become clear.",
          "maximize mystery(G_{actor})"),),
    ),
    Beginning(
        "legible", "{actor} goes to {here}, and everybody sees early that it will", "legible", 9,
        (("The first picture: {actor} has some way to go.",
          "start distance({actor}, {here}) > 2 and distance({actor}, {there}) > 2"),
         ("The earlier viewers know that {actor} wants {here}, the better.",
          "maximize legible(G_{actor} = {here})")),
    ),
    Beginning(
        "deceptive", "{actor} seems to go to {there}, and ends at {here}: a feint", "deceptive", 14,
        (("The first picture: {actor} has some way to go.",
          "start distance({actor}, {here}) > 2 and distance({actor}, {there}) > 2"),
         ("Viewers shall believe that {actor} wants {there}, while it gets what it wants. `scale`: "
          "how much that counts.",
          "maximize deceptive({actor}, G_{actor} = {here}, G_{actor} = {there}, scale = 0.3)"),
         ("A feint pays late: more scripts are kept side by side, from fewer first pictures.",
          "search beam(starts = 20, width = 30, polish = 0)")),
    ),
    Beginning(
        "surprising", "friend or foe? {helper} makes viewers change their minds again and again",
        "surprising", 14,
        (("What viewers believe of {helper} shall move as far as it can.",
          "maximize surprising({rho} > 0)"),
         ("Sense comes first: without this the two would dance to and fro.", "rationality 3")),
    ),
    Beginning(
        "suspenseful", "each next step may show whether {helper} means harm", "suspenseful", 12,
        (("Viewers shall expect that the next frame will tell them much about {helper}.",
          "maximize suspenseful({rho})"),
         ("To look ahead takes time: fewer first pictures are tried.",
          "search beam(starts = 100, polish = 0)")),
    ),
    _shape("rags_to_riches", "things get better and better for {helped}", "Fortune rises."),
    _shape("riches_to_rags", "things get worse and worse for {helped}", "Fortune falls."),
    _shape("man_in_a_hole", "{helped} gets into trouble, and out of it",
           "Fortune falls and rises."),
    _shape("icarus", "{helped} comes near to {goal}, and is shut out", "Fortune rises and falls."),
    _shape("cinderella", "{helped} rises, falls, and rises for good",
           "Fortune rises, falls and rises."),
    _shape("oedipus", "{helped} falls, hopes again, and falls", "Fortune falls, rises and falls."),
)  # fmt: skip

_TOGETHER = (
    "The two shall be near each other. The number says how much that counts.",
    "minimize sum_t 0.3 * [distance({helped}, {helper}) @ script[t]]",
)
_CALM = (
    "Calm motion: no sudden turns.",
    "minimize sum_t 0.05 * ([acceleration({helped}) @ script[t]] "
    "+ [acceleration({helper}) @ script[t]])",
)
_CALM_ALONE = ("Calm motion: no sudden turns.",
               "minimize sum_t 0.05 * [acceleration({actor}) @ script[t]]")  # fmt: skip
_STRIVES = "0.25 * [heads({helped}, {goal}) @ script[t]]"
_NO_NEARER = "3 * [progress({helped}, {goal}) @ script[t]]"

_ON_PLANES = (
    Beginning(
        "help", "{helper} pushes {helped} to {goal}", "depict", 100,
        (("After every frame viewers shall believe that {helper} helps.",
          "maximize depict({rho} > 0)"),
         ("In the end {helped} shall be there.",
          "maximize 20 * [at({helped}, {goal}) @ script[T]]"), _TOGETHER, _CALM),
    ),
    Beginning(
        "hinder", "{helped} wants to go to {goal}, and {helper} keeps it away", "depict",
        100,
        (("After every frame viewers shall believe that {helper} hinders, and what {helped} wants.",
          "maximize depict({rho} < 0 and G_{helped} = {goal})"),
         ("It shall not come nearer.", f"minimize sum_t {_NO_NEARER}"),
         ("But it shall strive to.", f"maximize sum_t {_STRIVES}"),
         _TOGETHER, _CALM),
    ),
    Beginning(
        "betrayal", "{helper} seems to help {helped} to {goal}, and turns against it", "twist", 140,
        (("In the first half viewers shall believe that {helper} helps, in the second that it "
          "hinders; and all along that {helped} wants {goal}.",
          "maximize twist({rho} > 0 and G_{helped} = {goal}, {rho} < 0 and G_{helped} = {goal})"),
         ("After the turn {helped} shall come no nearer.",
          f"minimize sum_{{{{t in T/2..T}}}} {_NO_NEARER}"),
         ("But it shall strive to.", f"maximize sum_{{{{t in T/2..T}}}} {_STRIVES}"),
         _TOGETHER, _CALM),
    ),
    Beginning(
        "legible", "{actor} goes to {here}, and everybody sees early that it will", "legible", 60,
        (("The earlier viewers know that {actor} wants {here}, the better.",
          "maximize legible(G_{actor} = {here})"),
         ("In the end it shall be there.", "maximize 10 * [at({actor}, {here}) @ script[T]]"),
         _CALM_ALONE),
    ),
    Beginning(
        "deceptive", "{actor} seems to go to {there}, and ends at {here}: a feint", "deceptive", 64,
        (("Viewers shall believe that {actor} wants {there}, while it gets what it wants. `scale`: "
          "how much that counts.",
          "maximize deceptive({actor}, G_{actor} = {here}, G_{actor} = {there}, scale = 3)"),),
    ),
)  # fmt: skip

_ON_HILLS = (
    Beginning(
        "mime", "the box is light, and the hopper moves as if it were heavy", "depict", 350,
        (("After every frame viewers shall believe that the box is heavy, and that the hopper does "
          "its best.", "maximize depict(weight = {heavy} and will = eager)"),
         ("Its muscles shall work, up to a half of what they can, and the rope be stretched.",
          "maximize sum_t (0.2 * min([effort(hopper) @ script[t]], 1.3)\n"
          "    - 0.1 * [effort(hopper) @ script[t]] + 0.3 * [taut(hopper) @ script[t]])"),
         ("It shall move as viewers imagine such a hopper: without this it trembles.",
          "naturalness 1.3"),
         ("How the search looks: 50 frames at a time, 60 steps for each.",
          "search descend(seeds = 4, window = 50, overlap = 0, lookahead = 0, steps = 60)")),
        "(weight = {light}, lazy = 0.1)",
    ),
    Beginning(
        "stumble", "the hopper stumbles half way, and recovers", "", 400,
        (("From frame 160 to 240 things shall look bad for the hopper, else good.",
          "maximize sum_t (if 160 <= t <= 240 then -1 else 1)\n"
          "    * E[V(hopper) | script[:t], weight = {heavy}]"),
         ("It shall stumble, and not fall.",
          "minimize sum_t 50000 * [fallen(hopper) @ script[t]]")),
        "(weight = {heavy})",
    ),
)  # fmt: skip

BEGINNINGS = {"map": _ON_MAPS, "plane": _ON_PLANES, "hill": _ON_HILLS}
"""The beginnings in each kind of world; the first is the usual one."""
