"""A first story in a world that was drawn for another tool. No JAX."""

from __future__ import annotations

from i2pdsl.beginnings.write import Place, story_text
from i2pdsl.errors import Source
from i2pdsl.worlds.beginnings import Beginning
from i2pdsl.worlds.kind import Imported
from i2pdsl.worlds.kinds import parse_world


def first_story(found: Imported, name: str, title: str) -> str:
    """Somebody is on its way, and viewers see to what; else they see that it does something."""
    who, goals = found.who, found.goals
    told, line = f"{who} does something", f"maximize depict(R_{who})"
    about = f"Viewers shall see that {who} does not act at random."
    if len(goals) > 1:
        told = f"{who} goes to {goals[0]}, and everybody sees early that it will"
        about = f"The earlier viewers know that {who} wants {goals[0]}, the better."
        line = f"maximize legible(G_{who} = {goals[0]})"
    elif goals:
        told = f"{who} goes to {goals[0]}"
        about = f"After every frame viewers shall believe that {who} wants {goals[0]}."
        line = f"maximize depict(G_{who} = {goals[0]})"
    beginning = Beginning("imported", told, "", found.length, ((about, line),))
    return story_text(title, beginning, Place(name, parse_world(Source(title, found.text), name)))
