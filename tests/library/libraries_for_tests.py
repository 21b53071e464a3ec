"""A small folder of patterns and stories, as a storyteller might keep it."""

from __future__ import annotations

import hashlib
import io
import json
import warnings
import zipfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from i2pdsl.library.description import PatternLibrary
from i2pdsl.library.pack import pack

MOODS = """\
let middle = T/2
# Viewers are kept in the dark.
# Use it for a question.
pattern dark(event, share = 0.8) =
    sum_t (if t <= share * T then -abs(P(event | script[:t]) - 0.5) else P(event | script[:t]))

pattern both(first, second) = dark(first) + after(second, from = middle)
"""
TURNS = """\
import "../../common.story"
import twist

# One thing until a frame, the other after it.
pattern after(event, from) = slow_depict(event) + twist(not event, event, turn = from)

pattern pink_mind(level) = sum_t P(G_cheese = pink and rho > level | script[:t])
"""
COMMON = """\
pattern slow_depict(event) = sum_t slowness * P(event | script[:t])
let slowness = t/T
"""
STORY = """\
# The cheese's wish is a secret.
world kitchen
length 5
import moods

maximize dark(G_cheese = pink, share = 0.5)

# expect mean_t P(G_cheese = pink | script[:t]) >= 0.4
"""
YARD = """\
map
    R....
    ..#..
    ....G

tile red
    symbol = R
    color = "#cc4444"
tile green
    symbol = G
    color = "#44aa55"

character cart
    goals = {red, green}
"""


def make_folder(place: Path) -> Path:
    """moods/ with two files of patterns, a story in a folder, and a file that is beside it."""
    folder = place / "moods"
    (folder / "deep").mkdir(parents=True)
    (folder / "moods.story").write_text(MOODS, encoding="utf-8")
    (folder / "deep" / "turns.story").write_text(TURNS, encoding="utf-8")
    (folder / "secret.story").write_text(STORY, encoding="utf-8")
    (place / "common.story").write_text(COMMON, encoding="utf-8")
    return folder


def files_of(folder: Path) -> list[Path]:
    return sorted([*folder.rglob("*.story"), *folder.rglob("*.world")])


def packed(folder: Path, name: str = "moods") -> PatternLibrary:
    return pack(folder, files_of(folder), name).library


class Forgery:
    """A library that can be changed: its manifest, and its other files.

    Args:
        data: of a library that is right.
    """

    def __init__(self, data: bytes):
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            self.files = {name: archive.read(name) for name in archive.namelist()}
        self.manifest: dict[str, Any] = json.loads(self.files.pop("manifest.json"))

    def record(self, name: str) -> dict[str, Any]:
        """What the manifest says of a file."""
        kinds = ("patterns", "outside", "stories", "worlds")
        return next(r for kind in kinds for r in self.manifest[kind] if r["file"] == name)

    def text(self, name: str, text: str) -> None:
        """Gives a file another text, and the hash that this has."""
        self.files[name] = text.encode("utf-8")
        self.record(name)["sha256"] = hashlib.sha256(self.files[name]).hexdigest()

    def add(self, kind: str, name: str, text: str, **more: Any) -> None:
        self.manifest[kind].append({"file": name, "sha256": "", "imports": {}, "world": ""} | more)
        self.text(name, text)

    def rename(self, name: str, new: str) -> None:
        """A file gets another name, wherever one is."""
        self.files[new] = self.files.pop(name)
        self.record(name)["file"] = new
        for kind in ("patterns", "outside", "stories"):
            for record in self.manifest[kind]:
                for found in record["imports"].values():
                    if isinstance(found, list) and name in found:
                        found[found.index(name)] = new

    def zipped(self, method: int = zipfile.ZIP_STORED) -> bytes:
        members = {"manifest.json": json.dumps(self.manifest).encode(), **self.files}
        return zipped(members.items(), method)


def zipped(members: Iterable[tuple[str, bytes]], method: int = zipfile.ZIP_STORED) -> bytes:
    buffer = io.BytesIO()
    with warnings.catch_warnings(), zipfile.ZipFile(buffer, "w", method) as archive:
        warnings.simplefilter("ignore")  # two of one name
        for name, data in members:
            archive.writestr(zipfile.ZipInfo(name), data, method)
    return buffer.getvalue()
