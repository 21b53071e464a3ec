"""A story to begin with, as `i2p new` writes it; nothing is written here."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from i2pdsl.beginnings.table import BEGINNINGS, KINDS
from i2pdsl.beginnings.write import Place, beginning_in, beginnings_in, story_text, template
from i2pdsl.errors import Source, shorten
from i2pdsl.studio.folder import Folder
from i2pdsl.studio.palette import standard
from i2pdsl.studio.protocol import USAGE, Refusal
from i2pdsl.untrusted import is_plain_name
from i2pdsl.worlds.find import builtin_worlds, find_spec
from i2pdsl.worlds.kinds import parse_world

NEW = "new"
"""Before a kind: a world of its own, as `i2p new --kind` writes one."""
OWN = ("map", "plane")  # kinds whose files say more than their kind


def ways(folder: Folder) -> dict[str, Any]:
    """Ways to begin, and worlds to begin in: built-in ones, those of the folder, and new ones."""
    told: dict[str, str] = {}
    for kind in KINDS:
        roles = _template(kind).roles
        for each in BEGINNINGS[kind]:
            told.setdefault(each.name, each.told.format_map(roles))
    own = [seen.path for seen in folder.files() if seen.kind == "world" and "/" not in seen.path]
    found = [{"name": name, "about": _about(name, None), "own": False} for name in builtin_worlds()]
    found += [
        {"name": Path(path).stem, "about": _about(path, folder.root), "own": True} for path in own
    ]
    found += [
        {"name": f"{NEW} {kind}", "about": f"a {kind} of its own, to be changed", "own": True}
        for kind in OWN
    ]
    beginnings = [{"name": name, "about": about} for name, about in told.items()]
    return {"beginnings": beginnings, "worlds": found}


def _template(kind: str) -> Place:
    """A world to begin with; the hill is always the same."""
    if kind not in OWN:
        spec = find_spec(kind)
        assert spec is not None
        return Place(kind, spec)
    return Place(NEW, parse_world(Source(f"{NEW}.world", template(kind)), NEW))


def _about(name: str, folder: Path | None) -> str:
    spec = find_spec(name, folder)
    return "" if spec is None else spec.documentation.split("\n")[0]


def begun(folder: Folder, name: str, beginning: str | None, world: str) -> dict[str, Any]:
    """The path and text of a new story, and of its world if that is new. Raises StoryError."""
    stem = name.removesuffix(".story")
    if not is_plain_name(stem) or '"' in stem:
        raise Refusal(USAGE, f"no story can be called `{shorten(name)}`")
    path, text_of_world = f"{stem}.story", None
    if folder.place(path).exists():
        raise Refusal(USAGE, f"there is a {path} already: take another name")
    if world.startswith(f"{NEW} "):
        kind = world.removeprefix(f"{NEW} ")
        if kind not in OWN or stem in builtin_worlds():
            raise Refusal(USAGE, f"no world of its own can be called `{shorten(stem)}`")
        text_of_world = template(kind)
        place = Place(stem, parse_world(Source(f"{stem}.world", text_of_world), stem))
    else:
        spec = find_spec(world, folder.root)
        if spec is None:
            raise Refusal(USAGE, f"there is no world `{shorten(world)}`")
        place = Place(world, spec)
    chosen = beginning_in(beginning, place, standard) if beginning else beginnings_in(place)[0]
    told = {"path": path, "text": story_text(path, chosen, place)}
    if text_of_world is None:
        return told
    return {**told, "world": {"path": f"{stem}.world", "text": text_of_world}}
