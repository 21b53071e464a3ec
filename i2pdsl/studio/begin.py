"""A story to begin with, as `i2p new` writes it; nothing is written here."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from i2pdsl.beginnings.table import table
from i2pdsl.beginnings.write import Place, beginning_in, new_world, story_text
from i2pdsl.errors import shorten
from i2pdsl.studio.folder import Folder
from i2pdsl.studio.palette import standard
from i2pdsl.studio.protocol import USAGE, Refusal
from i2pdsl.untrusted import is_plain_name
from i2pdsl.worlds.beginnings import Beginnings
from i2pdsl.worlds.find import builtin_worlds, find_spec

NEW = "new"
"""Before a kind: a world of its own, as `i2p new --kind` writes one."""


def ways(folder: Folder) -> dict[str, Any]:
    """Ways to begin, and worlds to begin in: built-in ones, those of the folder, and new ones."""
    told: dict[str, str] = {}
    known = table()
    for kind in known.values():
        roles = _example(kind).roles
        for each in kind.ways:
            told.setdefault(each.name, each.told.format_map(roles))
    own = [seen.path for seen in folder.files() if seen.kind == "world" and "/" not in seen.path]
    found = [{"name": name, "about": _about(name, None), "own": False} for name in builtin_worlds()]
    found += [
        {"name": Path(path).stem, "about": _about(path, folder.root), "own": True} for path in own
    ]
    found += [
        {"name": f"{NEW} {kind}", "about": f"a {kind} of its own, to be changed", "own": True}
        for kind in known
        if known[kind].template is not None
    ]
    beginnings = [{"name": name, "about": about} for name, about in told.items()]
    return {"beginnings": beginnings, "worlds": found}


def _example(kind: Beginnings) -> Place:
    """A world to begin in: one of its own, or else the one that there is."""
    if kind.template is not None:
        return new_world(kind.template, NEW)[0]
    spec = find_spec(kind.world)
    assert spec is not None
    return Place(kind.world, spec)


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
        kind = table().get(world.removeprefix(f"{NEW} "))
        template = None if kind is None else kind.template
        if template is None or stem in builtin_worlds():
            raise Refusal(USAGE, f"no world of its own can be called `{shorten(stem)}`")
        place, text_of_world = new_world(template, stem)
    else:
        spec = find_spec(world, folder.root)
        if spec is None:
            raise Refusal(USAGE, f"there is no world `{shorten(world)}`")
        place = Place(world, spec)
    chosen = beginning_in(beginning or None, place, standard)
    told = {"path": path, "text": story_text(path, chosen, place)}
    if text_of_world is None:
        return told
    return {**told, "world": {"path": f"{stem}.world", "text": text_of_world}}
