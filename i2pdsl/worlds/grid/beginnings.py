"""What stories on maps begin as."""

from __future__ import annotations

from importlib.resources import files

from i2pdsl.worlds.beginnings import Beginning, Beginnings

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


_WAYS = (
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

_MORE = (
    ("what must be seen", "require eventually [touching({helper}, {helped})]"),
    ("the first picture: the two begin apart", "start distance({helper}, {helped}) > 2"),
    ("it costs more that nothing moves (0.2 without this line)", "liveliness 0.5"),
    ("viewers who forget", "audience bayesian(forgetting = 0.05)"),
)

BEGINNINGS = Beginnings("map", _WAYS, _MORE, template=files("i2pdsl.worlds.grid") / "first.world")
