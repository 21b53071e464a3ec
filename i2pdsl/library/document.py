"""The file of a compiled library, NAME.i2plib: one JSON document of texts, nothing executable.

    {"format": "i2p-library", "version": 1, "name", "made_with", "hash": "sha256:...",
     "files":    [{"name", "source", "group", "imports": {target: [names] or "standard"}}],
     "patterns": [{"name", "file", "line", "signature", "parameters": [{"name", "kind", "default"}],
                   "result", "documentation", "body", "uses": {name: file or "standard"},
                   "names_of_worlds": [names], "worlds": {world: {"fits", "with" or "because"}},
                   "examples": [{"file", "world", "call"}]}],
     "lets":     [{"name", "file", "line", "result", "body", "uses", "names_of_worlds"}],
     "worlds":   [{"name", "file", "source"}],
     "stories":  [{"file", "world", "length", "search", "source", "calls": {name: call}}],
     "shapes":   [{"shape", "world", "stories": [files]}]}

`hash` is the SHA-256 of the canonical JSON of everything else. The sources are what counts: all
that is said of a pattern is derived from them again when a library is read (library/read.py).
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

from i2pdsl import __version__
from i2pdsl.errors import StoryError, error, whole_file
from i2pdsl.language.statements import read_data
from i2pdsl.resources import write_text
from i2pdsl.untrusted import is_plain_name, json_excess, without_repetition

FORMAT, VERSION = "i2p-library", 1
SUFFIX = ".i2plib"
MADE_WITH = f"i2pdsl {__version__}"
LARGEST = 4 * 2**20  # bytes of a library; the standard one has 50 kB
MOST_CHARACTERS = 200_000  # of patterns, which take seconds to parse; the standard ones have 20,000
MOST_DEFINITIONS = 1000  # patterns and lets
_MOST_IMPORTS = 1000
_STATEMENT = re.compile(r"^[^\W\d]", re.MULTILINE)
_DEEPEST = 12  # brackets in brackets; the format has 6
_LARGEST_NUMBER = 1e300  # of what is drawn

Document = dict[str, Any]


class WrongDocument(Exception):
    """What is wrong with a document, in words."""


def content_hash(document: Document) -> str:
    """The hash of everything in a document but its hash."""
    rest = {key: value for key, value in document.items() if key != "hash"}
    text = json.dumps(rest, ensure_ascii=False, sort_keys=True, separators=(",", ":"))
    return "sha256:" + hashlib.sha256(text.encode("utf-8")).hexdigest()


def with_hash(content: Document) -> Document:
    """A document in the order of the format, with its format, version and hash."""
    head = {"format": FORMAT, "version": VERSION}
    document = {**head, **{key: content[key] for key in _SHAPE if key not in (*head, "hash")}}
    return {**head, "name": document["name"], "made_with": document["made_with"],
            "hash": content_hash(document), **document}  # fmt: skip


def encode(document: Document) -> str:
    """The text of the file: the same document gives the same bytes."""
    return json.dumps(document, ensure_ascii=False, indent=1) + "\n"


def write_document(path: Path, document: Document) -> int:
    """Writes a library, whole or not at all; returns its bytes.

    Raises StoryError where it is larger than what is read, OSError where it cannot be written.
    """
    text = encode(document)
    size = len(text.encode("utf-8"))
    if size > LARGEST:
        message = f"the library has {size:,} bytes; at most {LARGEST:,} are read"
        raise error("library", message, whole_file(str(path)), "split the folder")
    write_text(path, text)
    return size


def read_document(path: Path) -> Document:
    """Reads a library as data: its hash is right and everything has the type that it should have.

    Raises StoryError for anything else.
    """
    try:
        data = read_data(path, LARGEST)
    except StoryError as problem:
        if problem.diagnostics[0].code != "too-long":
            raise
        message = f"the library is too large: at most {LARGEST:,} bytes are read"
        raise wrong_library(path, message) from None
    try:
        return decode(data)
    except WrongDocument as problem:
        raise wrong_library(path, str(problem)) from None


def wrong_library(path: Path, message: str) -> StoryError:
    """The error for a library that cannot be used."""
    later = "made by a later version" in message
    hint = "update i2pdsl" if later else "compile it again: `i2p compile FOLDER -o LIBRARY`"
    return error("library", message, whole_file(str(path)), hint)


def decode(data: bytes) -> Document:
    """The document in a file's bytes. Raises WrongDocument."""
    document = decode_json(data, "the library")
    _check_version(document)
    try:
        found = content_hash(document)
    except UnicodeEncodeError:
        raise WrongDocument("the library is damaged: it holds half a character") from None
    _check_type(document, _SHAPE, "the library")
    if found != document["hash"]:
        message = "its content does not have the hash that it states"
        raise WrongDocument(f"the library is damaged: {message}")
    _check_names(document)
    return document


def decode_json(data: bytes, what: str) -> Any:
    """The JSON in the bytes of `what`, strictly. Raises WrongDocument."""
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError as problem:
        raise WrongDocument(f"{what} is damaged: byte {problem.start:,} is not UTF-8") from None
    if not text.strip():
        raise WrongDocument(f"{what} is empty")
    if json_excess(text, _DEEPEST):
        raise WrongDocument(f"{what} is damaged: nested too deep")
    try:
        return json.loads(text, object_pairs_hook=without_repetition, parse_constant=_no_json)
    except json.JSONDecodeError as problem:
        is_cut = problem.pos >= len(text.rstrip()) - 1 or problem.msg.startswith("Unterminated")
        cut = " (is its end missing?)" if is_cut else ""
        message = f"{what} is damaged: no JSON from line {problem.lineno} on{cut}"
        raise WrongDocument(message) from None
    except (ValueError, RecursionError):  # a number of thousands of digits
        raise WrongDocument(f"{what} is damaged: this is not its JSON") from None


def _no_json(word: str) -> Any:
    raise ValueError(f"{word} is no JSON")


def _check_version(document: Any) -> None:
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise WrongDocument("this is not a compiled library")
    version = document.get("version")
    if not isinstance(version, int) or isinstance(version, bool) or version < 1:
        raise WrongDocument("the library is damaged: its version is no number from 1 on")
    if version > VERSION:
        raise WrongDocument(
            f"made by a later version of i2pdsl (format {version}); this one reads format {VERSION}"
        )


# What a document looks like: a type, [what a list holds], {key: what it holds}, {str: what every
# value holds}, a function that says what is wrong, or (one or the other, ...).


def _name(value: Any) -> str | None:
    return None if isinstance(value, str) and value.isidentifier() else "is no name"


def _path(value: Any) -> str | None:
    """Names of files inside the library: never one that leads out of it."""
    if not isinstance(value, str) or not 0 < len(value) <= 500:
        return "is no file's name"
    if not all(map(is_plain_name, value.split("/"))):
        return "leads out of the library or is no file's name"
    return None


def _own_name(value: Any) -> str | None:
    """Of the library: what its file is called, without the suffix."""
    return None if is_plain_name(value) else "cannot be that of a file"


def _group(value: Any) -> str | None:
    """Of files that are no own ones; empty for those that are."""
    return None if value == "" else _path(value)


def is_stored_name(name: str) -> bool:
    """Whether a file can have this name in a library."""
    return _path(name) is None


def _count(value: Any) -> str | None:
    whole = isinstance(value, int) and not isinstance(value, bool)
    return None if whole and 0 < value <= 10**9 else "is no number from 1 on"


def finite(value: Any) -> str | None:
    """For shapes: a number that can be drawn."""
    plain = isinstance(value, int | float) and not isinstance(value, bool)
    return None if plain and abs(value) <= _LARGEST_NUMBER else "is no number"


_DEFINITION = {
    "name": _name, "file": _path, "line": _count, "result": str, "body": str,
    "uses": {_name: _path}, "names_of_worlds": [_name],
}  # fmt: skip
_SHAPE: dict[Any, Any] = {
    "format": str,
    "version": _count,
    "name": _own_name,
    "made_with": str,
    "hash": str,
    "files": [{"name": _path, "source": str, "group": _group, "imports": {str: ([_path], str)}}],
    "patterns": [
        {
            **_DEFINITION,
            "signature": str,
            "parameters": [{"name": _name, "kind": str, "default": (str, None)}],
            "documentation": str,
            "worlds": {_path: ({"fits": bool, "with": str}, {"fits": bool, "because": str})},
            "examples": [{"file": _path, "world": _path, "call": str}],
        }
    ],
    "lets": [_DEFINITION],
    "worlds": [{"name": _path, "file": _path, "source": str}],
    "stories": [
        {"file": _path, "world": _path, "length": _count, "search": str, "source": str,
         "calls": {_name: str}}
    ],
    "shapes": [{"shape": str, "world": _path, "stories": [_path]}],
}  # fmt: skip


def _check_type(value: Any, shape: Any, place: str) -> None:
    problem = mismatch(value, shape, place)
    if problem is not None:
        raise WrongDocument(f"the library is damaged: {problem}")


def mismatch(value: Any, shape: Any, place: str) -> str | None:
    """What is wrong with a value that should have a shape, or None."""
    match shape:
        case None:
            return None if value is None else f"{place} is not null"
        case type():
            return None if type(value) is shape else f"{place} is not {_WORDS[shape]}"
        case tuple():
            wrong = [mismatch(value, option, place) for option in shape]
            return None if None in wrong else wrong[0]
        case list():
            if not isinstance(value, list):
                return f"{place} is not a list"
            inner = (mismatch(v, shape[0], f"{place}[{i}]") for i, v in enumerate(value))
            return next((problem for problem in inner if problem), None)
        case dict():
            return _mismatch_of_record(value, shape, place)
        case _:
            problem = shape(value)
            return f"{place} {problem}" if problem else None


_WORDS = {str: "a text", bool: "true or false"}


def _mismatch_of_record(value: Any, shape: dict[Any, Any], place: str) -> str | None:
    if not isinstance(value, dict):
        return f"{place} is not a record"
    keys = list(shape)
    if not isinstance(keys[0], str):  # names that anything can have
        named: Callable[[Any], str | None] | type = keys[0]
        for key, item in value.items():
            problem = mismatch(key, named, f"a key of {place}")
            problem = problem or mismatch(item, shape[named], f"{place}.{key[:40]}")
            if problem:
                return problem
        return None
    for key in keys:
        if key not in value:
            return f"{place} has no `{key}`"
    for key, item in value.items():
        if key not in shape:
            return f"{place} has an unknown `{key[:40]}`"
        problem = mismatch(item, shape[key], f"{place}.{key}" if place != "the library" else key)
        if problem:
            return problem
    return None


def _check_names(document: Document) -> None:
    """Every file that is spoken of is there, once, and there is not too much of anything."""
    names = [file["name"] for file in document["files"]]
    if len(set(names)) < len(names):
        raise WrongDocument("the library is damaged: two of its files have one name")
    for file in document["files"]:
        for target, found in file["imports"].items():
            if found != "standard" and (isinstance(found, str) or not set(found) <= set(names)):
                message = f"the import `{target[:40]}` leads to no file of it"
                raise WrongDocument(f"the library is damaged: {message}")
    definitions = len(document["patterns"]) + len(document["lets"])
    excess = too_much([file["source"] for file in document["files"]], definitions)
    if excess:
        raise WrongDocument(f"the library is too large: {excess}")


def too_much(sources: list[str], definitions: int) -> str | None:
    """What there is more of than is read, or None: what is read must be read soon."""
    characters = sum(len(source) for source in sources)
    if characters > MOST_CHARACTERS:
        return f"{characters:,} characters of patterns, at most {MOST_CHARACTERS:,} are read"
    statements = sum(len(_STATEMENT.findall(source)) for source in sources)
    count = max(definitions, statements - _MOST_IMPORTS)
    if count > MOST_DEFINITIONS:
        return f"{count:,} patterns and lets, at most {MOST_DEFINITIONS:,} are read"
    return None
