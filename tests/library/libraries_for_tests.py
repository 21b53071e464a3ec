"""A small folder of patterns and stories, as a storyteller might keep it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from i2pdsl.library.document import content_hash, encode

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


def forge(document: dict[str, Any], path: Path) -> None:
    """Writes a document with the hash that its content has."""
    forged = {**document, "hash": content_hash(document)}
    path.write_text(encode(forged), encoding="utf-8")


def copied(document: dict[str, Any]) -> dict[str, Any]:
    return json.loads(json.dumps(document))
