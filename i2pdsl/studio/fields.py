"""What can be set in the blocks of a world's file, and by what it is chosen on the page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from i2pdsl.language.vocabulary import Vocabulary
from i2pdsl.worlds.blocks import Syntax
from i2pdsl.worlds.drawings import builtin_sprites

COLORS = ("color", "floor", "wall", "frame")
PLACES = ("at", "cell")
YES = ("may_be_absent", "closed", "diagonals")
NUMBERS = ("success", "radius", "speed", "mass", "width", "height", "count", "goal")


def fields(
    syntax: Syntax, words: Vocabulary, blocks: Sequence[dict[str, Any]]
) -> dict[str, list[dict[str, Any]]]:
    """For each block what can be set in it: `kind` is color, place, number, set (some of the
    choices), one (of them) or text."""
    named = lambda *whats: [each["name"] for each in blocks if each["what"] in whats]
    places, who = named("tile", "place"), named("character")
    of_others = ("approach", "avoid") if words.size is not None and len(who) > 1 else ()
    choices = {
        "goals": [*places, *of_others, "none"],
        "toward": who,
        "models": who,
        "pushes": [*named("object"), *who],
        "pulls": [*named("object"), *who],
        "carries": named("object"),
        "opened_by": named("object"),
        "via": named("tile"),
        "misreads": who,
        "puts_down": named("object"),
        "drops": named("object"),
        "sprite": list(builtin_sprites()),
        "wall_sprite": list(builtin_sprites()),
        **{key: ["yes", "no"] for key in YES},
    }
    sets = {"goals", "pushes", "pulls", "carries", "puts_down", "opened_by", "via", "misreads"}
    sets |= {"drops"}

    def field(key: str) -> dict[str, Any]:
        setting = words.settings.get(key)
        kind, offered = "text", choices.get(key, [])
        if key in COLORS:
            kind = "color"
        elif key in PLACES:
            kind = "place"
        elif offered:
            kind = "set" if key in sets else "one"
        elif setting is not None and setting.choices:
            kind, offered = "one", list(setting.choices)
        elif key in NUMBERS or (setting is not None and isinstance(setting.default, float | int)):
            kind = "number"
        about = setting.documentation if setting is not None else ""
        return {"key": key, "kind": kind, "choices": offered, "about": about}

    return {what: [field(key) for key in keys] for what, keys in syntax.keys.items()}
