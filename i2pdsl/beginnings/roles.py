"""Who plays what in a world: the holes of the table of beginnings, filled in. No JAX."""

from __future__ import annotations

from i2pdsl.language.vocabulary import Vocabulary, show_value
from i2pdsl.worlds.hypotheses import attitudes_of, goal_of
from i2pdsl.worlds.kind import Spec

_CALLED = {"grid": "map"}  # kinds of worlds that animators call otherwise


def kind_called(spec: Spec) -> str:
    """A world's kind as animators call it, of table.KINDS."""
    return _CALLED.get(spec.kind, spec.kind)


def roles_of(spec: Spec, words: Vocabulary) -> dict[str, str]:
    """The holes (table.py) that a world can fill, and with what."""
    places = {
        who: [str(v) for v in words.latents[goal_of(who)].values if v in words.places]
        for who in words.characters
        if goal_of(who) in words.latents
    }
    found: dict[str, str] = {}
    about = next(iter(attitudes_of(getattr(spec, "characters", ()))), None)  # of maps and planes
    if about is not None:
        found = {"helper": about.who, "helped": about.toward, "rho": about.latent}
        if len(places[about.toward]) > 1:
            found["goal"], found["other"] = places[about.toward][:2]
    # The fortune of who has an attitude is mostly the other's: in a plane, where nothing else keeps
    # it to its goal, it would never get there.
    first = found.get("helped" if spec.kind == "plane" else "helper")
    torn = sorted(
        (who for who in places if len(places[who]) > 1),
        key=lambda who: (who != first, words.characters.index(who)),
    )
    if torn:
        found["actor"] = torn[0]
        found["here"], found["there"] = places[torn[0]][:2]
    if "weight" in words.latents:
        weights = [v for v in words.latents["weight"].values if isinstance(v, float)]
        found["light"], found["heavy"] = show_value(min(weights)), show_value(max(weights))
    return found
