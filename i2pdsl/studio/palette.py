"""The standard patterns for a palette: with pictures, with what could fill their slots in a world,
and ranked by words.

The ranking is plain: how rare the words are that a pattern's documentation, or the heading of a
story that uses it, shares with what was typed (BM25, Robertson and Zaragoza 2009, DOI
10.1561/1500000019). It proposes, and decides nothing.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from functools import cache
from typing import Any

from i2pdsl.language.vocabulary import Vocabulary
from i2pdsl.library.description import PatternLibrary
from i2pdsl.library.fits import candidates, fit, uses_of
from i2pdsl.library.pack import pack
from i2pdsl.resources import data_folder

MOST_OFFERS = 24
SATURATION, LENGTH_SHARE = 1.2, 0.75  # BM25's k1 and b, as usual
IN_NAME = 3  # what a word of the name counts beside one of the documentation,
IN_STORIES = 0.3  # and one of stories that use it
_WORD = re.compile(r"[a-z]+")
_PARAMETER = re.compile(r"`(\w+)`")
_NOTHING = (
    *("a", "an", "and", "are", "as", "at", "be", "but", "by", "for", "from", "has", "have", "he"),
    *("her", "his", "in", "is", "it", "its", "my", "of", "on", "or", "she", "so", "that", "the"),
    *(
        "their",
        "them",
        "then",
        "they",
        "this",
        "to",
        "was",
        "what",
        "when",
        "where",
        "which",
        "who",
    ),
)
_ENDINGS = ("ingly", "edly", "ings", "ing", "ed", "es", "s", "ly", "e")


@cache
def standard() -> PatternLibrary:
    """The standard library."""
    folder = data_folder("stories") / "patterns"
    return pack(folder, sorted(folder.glob("*.story")), "standard").library


def palette(words: Vocabulary | None, typed: str) -> list[dict[str, Any]]:
    """All patterns, those that fit a world first, best first by what was typed."""
    library = standard()
    found = []
    for pattern in library.patterns:
        fits = words is None or fit(pattern, library.exports, words)["fits"]
        found.append({**_told(pattern, words), "fits": fits, "rank": 0.0})
    said = ranked([each.pop("search") for each in found], typed)
    used = ranked([_examples(each["name"]) for each in found], typed)
    for each, by_itself, by_stories in zip(found, said, used, strict=True):
        each["rank"] = by_itself + IN_STORIES * by_stories
    return sorted(found, key=lambda each: (not each["fits"], -each["rank"]))


def _told(pattern: dict[str, Any], words: Vocabulary | None) -> dict[str, Any]:
    name, about = pattern["name"], " ".join(pattern["documentation"].split())
    file = pattern["file"].rpartition("/")[2].removesuffix(".story")
    return {
        "name": name,
        "about": about,
        "signature": pattern["signature"],
        "picture": _picture(name),
        "file": file,
        "slots": [
            {
                "name": parameter["name"],
                "kind": parameter["kind"],
                "default": parameter["default"],
                "about": _about(parameter["name"], pattern["documentation"]),
                "offers": candidates(parameter["kind"], words)[:MOST_OFFERS] if words else [],
            }
            for parameter in pattern["parameters"]
        ],
        "search": f"{f'{name} ' * IN_NAME} {about}".replace("_", " "),
    }


@cache
def _stories() -> tuple[tuple[str, str], ...]:
    """Of every story that ships with the program, what it says, and its name with its heading."""
    found = []
    for path in sorted(data_folder("stories").glob("*/*.story")):
        if path.parent.name != "patterns":
            text = path.read_text(encoding="utf-8")
            heading = text.partition("\nworld ")[0].replace("#", " ")
            found.append((text, f"{path.stem.replace('-', ' ')} {heading}"))
    return tuple(found)


def _examples(name: str) -> str:
    """What stories that call a pattern are about."""
    call = re.compile(rf"\b{name}\(")
    return " ".join(heading for text, heading in _stories() if call.search(text))


def _picture(name: str) -> str | None:
    """Where the page finds the picture of a pattern's example."""
    folder = data_folder("stories") / "patterns" / "pictures"
    found = sorted(folder.glob(f"{name}-*.png"))
    return f"/patterns/{found[0].name}" if found else None


def _about(parameter: str, documentation: str) -> str:
    """The sentence of a documentation that begins with a parameter."""
    for sentence in re.split(r"(?<=[.;]) ", " ".join(documentation.split())):
        named = _PARAMETER.findall(sentence.partition(":")[0])
        if parameter in named and ":" in sentence:
            return sentence
    return ""


def call(name: str, arguments: dict[str, str], pattern: dict[str, Any]) -> str:
    """A wish that calls a pattern; arguments that are left out keep their default."""
    given, by_name = [], False
    for parameter in pattern["parameters"]:
        value = arguments.get(parameter["name"], "").strip()
        if not value or value == parameter["default"]:
            by_name = True
            continue
        given.append(f"{parameter['name']} = {value}" if by_name else value)
    told = f"{name}({', '.join(given)})" if pattern["parameters"] else name
    return uses_of(pattern["result"])[0].format(told)


def ranked(texts: list[str], typed: str) -> list[float]:
    """How well each text fits what was typed; 0 where they share no word."""
    counts = [Counter(_stems(text)) for text in texts]
    lengths = [sum(count.values()) for count in counts]
    usual = sum(lengths) / max(1, len(lengths))
    asked, ranks = set(_stems(typed)), [0.0] * len(texts)
    for stem in sorted(asked):
        having = sum(stem in count for count in counts)
        rarity = math.log(1 + (len(texts) - having + 0.5) / (having + 0.5))
        for number, count in enumerate(counts):
            often = count[stem]
            long = 1 - LENGTH_SHARE + LENGTH_SHARE * lengths[number] / usual
            ranks[number] += rarity * often * (SATURATION + 1) / (often + SATURATION * long)
    return ranks


def _stems(text: str) -> list[str]:
    """Words without their endings, and without those that say nothing."""
    found = []
    for word in _WORD.findall(text.lower()):
        if word in _NOTHING:
            continue
        ending = next((e for e in _ENDINGS if word.endswith(e) and len(word) - len(e) > 2), "")
        found.append(word.removesuffix(ending))
    return found
