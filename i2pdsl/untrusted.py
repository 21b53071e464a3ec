"""What comes out of files that anyone may have written: names, bytes and JSON, before they are
believed. Nothing here trusts its argument."""

from __future__ import annotations

import errno
import hashlib
import json
import os
import re
import stat
import unicodedata
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any

_LONGEST_NAME = 200  # bytes; file systems take 255, and suffixes are added
_DEVICES = re.compile(r"(?:CON|PRN|AUX|NUL|CONIN\$|CONOUT\$|(?:COM|LPT)[0-9])(?:\..*)?", re.I)
_KINDS = {
    stat.S_IFDIR: "it is a folder",
    stat.S_IFIFO: "it is a pipe, not a file",
    stat.S_IFSOCK: "it is a socket, not a file",
    stat.S_IFCHR: "it is a device, not a file",
    stat.S_IFBLK: "it is a device, not a file",
}
# A text is matched whole, also one that is never closed, and without going back.
_TEXT = re.compile(r'"[^"\\]*+(?:\\.[^"\\]*+)*+"?', re.DOTALL)
_BRACKET = re.compile(r"[\[\]{}]")


# Names.


def is_plain_name(name: object) -> bool:
    """Whether a text can be the name of a file on every machine, and leads nowhere else.

    The one rule for names that come out of files: up to 200 bytes of printable characters, none of
    them `/`, `\\` or `:` (nor what Unicode holds to be the same as a slash), with no dot or space
    at an end, and no name of a device of Windows.
    """
    if not isinstance(name, str) or not name or not name.isprintable():
        return False
    same = unicodedata.normalize("NFKC", name)
    return (
        len(name.encode("utf-8")) <= _LONGEST_NAME
        and not set(name) & set("/\\:")
        and not set(same) & set("/\\")
        and name == name.strip(" .")
        and same.strip(" .") != ""
        and _DEVICES.fullmatch(same) is None
    )


def plain_name(text: str) -> str:
    """The name of a file for any text: the text itself if it is a plain name, else what can be kept
    of it with a digest of all, so that two texts do not share one."""
    if is_plain_name(text):
        return text
    kept = "".join(c for c in text[:40] if c.isascii() and (c.isalnum() or c in "-_"))
    digest = hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()[:12]
    return f"{kept or 'named'}-{digest}"


def below(folder: Path, *names: str) -> Path:
    """A place inside a folder, for writing.

    Raises OSError where a name is none, or a link leads out of the folder. A link at the last name
    is no way out: a file that is written whole takes the link's place (resources.atomic_path).
    """
    path = folder.joinpath(*names)
    if not all(map(is_plain_name, names)):
        raise OSError(errno.EINVAL, "this is no name for a file", str(path))
    if not path.parent.resolve().is_relative_to(folder.resolve()):
        raise OSError(errno.EPERM, f"a link leads out of {folder}", str(path))
    return path


# Bytes.


def read_bytes(path: Path | str, largest: int) -> bytes:
    """The content of a regular file of at most `largest` bytes.

    Raises OSError, whose `strerror` says what is wrong: there is no such file (FileNotFoundError,
    also for what no file can be called), it cannot be read, it is a folder, a pipe or a device, or
    it is larger (EFBIG). Nothing is waited for.
    """
    name = os.fspath(path)
    try:
        # Opening a device can do something, and opening a pipe waits for its other end.
        _check_regular(os.stat(name), name, largest)
        flags = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
        with open(os.open(name, flags), "rb") as file:
            _check_regular(os.fstat(file.fileno()), name, largest)  # it may be another by now
            data = file.read(largest + 1)
    except ValueError:  # NUL, or half a character
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), name) from None
    if len(data) > largest:
        raise _too_large(f"more than {largest:,}", name, largest)
    return data


def _check_regular(found: os.stat_result, name: str, largest: int) -> None:
    if not stat.S_ISREG(found.st_mode):
        what = _KINDS.get(stat.S_IFMT(found.st_mode), "it is no file")
        raise OSError(errno.EINVAL, what, name)
    if found.st_size > largest:
        raise _too_large(f"{found.st_size:,}", name, largest)


def _too_large(size: str, name: str, largest: int) -> OSError:
    return OSError(errno.EFBIG, f"it has {size} bytes; at most {largest:,} are read", name)


# JSON.


class WrongData(Exception):
    """What is wrong with data, in words."""


class RepeatedKeyError(ValueError):
    """An object has one key twice; the key is the exception's text."""


def without_repetition(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """For `json.loads(object_pairs_hook=...)`: a key that is given twice is a mistake."""
    found = dict(pairs)
    if len(found) < len(pairs):
        counts = Counter(key for key, _ in pairs)
        raise RepeatedKeyError(next(key for key, count in counts.items() if count > 1))
    return found


def json_excess(text: str, deepest: int, most: int = 5_000_000) -> str | None:
    """What there is more of in a JSON text than is read, before it is: `nested too deeply`, or
    more than `most` lists and objects. None where it is all right."""
    bare = _TEXT.sub("", text)
    if bare.count("[") + bare.count("{") > most:
        return f"of more than {most:,} parts"
    depth = 0
    for bracket in _BRACKET.findall(bare):
        depth += 1 if bracket in "[{" else -1
        if depth > deepest:
            return "nested too deeply"
    return None


def decode_json(data: bytes, what: str, deepest: int) -> Any:
    """The JSON in the bytes of `what`, strictly. Raises WrongData."""
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError as problem:
        raise WrongData(f"{what} is damaged: byte {problem.start:,} is not UTF-8") from None
    if not text.strip():
        raise WrongData(f"{what} is empty")
    if json_excess(text, deepest):
        raise WrongData(f"{what} is damaged: nested too deep")
    try:
        return json.loads(text, object_pairs_hook=without_repetition, parse_constant=_no_json)
    except json.JSONDecodeError as problem:
        is_cut = problem.pos >= len(text.rstrip()) - 1 or problem.msg.startswith("Unterminated")
        cut = " (is its end missing?)" if is_cut else ""
        message = f"{what} is damaged: no JSON from line {problem.lineno} on{cut}"
        raise WrongData(message) from None
    except (ValueError, RecursionError):  # a number of thousands of digits
        raise WrongData(f"{what} is damaged: this is not its JSON") from None


def _no_json(word: str) -> Any:
    raise ValueError(f"{word} is no JSON")


_WORDS = {str: "a text", int: "a whole number", bool: "true or false"}


def mismatch(value: Any, shape: Any, place: str) -> str | None:
    """What is wrong with a value that should have a shape, or None.

    A shape is a type, [what a list holds], {key: what it holds} for a record, {what a key is: what
    every value is} with a type or a function for the key, a function that says what is wrong, or
    (one or the other, ...).
    """
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
            return _first((v, shape[0], f"{place}[{i}]") for i, v in enumerate(value))
        case dict():
            if not isinstance(value, dict):
                return f"{place} is not a record"
            if not all(isinstance(key, str) for key in shape):
                ((key_shape, item_shape),) = shape.items()
                keys = _first((key, key_shape, f"a key of {place}") for key in value)
                return keys or _first(
                    (v, item_shape, f"{place}.{k[:40]}") for k, v in value.items()
                )
            for key in sorted(shape.keys() ^ value.keys()):
                wrong_key = "has no" if key in shape else "has an unknown"
                return f"{place} {wrong_key} `{key[:40]}`"
            return _first((v, shape[k], f"{place}.{k}") for k, v in value.items())
        case _:
            problem = shape(value)
            return f"{place} {problem}" if problem else None


def _first(parts: Iterable[tuple[Any, Any, str]]) -> str | None:
    return next((wrong for part in parts if (wrong := mismatch(*part))), None)
