"""Parameters of a request, out of plain data: nothing unknown, nothing of another type, and of
bounded size. Raises Refusal, which says what should be where."""

from __future__ import annotations

import math
from dataclasses import MISSING, fields
from functools import cache
from types import UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

from i2pdsl.studio.protocol import LARGEST_MESSAGE, USAGE, Refusal

LONGEST_TEXT, MOST_ITEMS = 2**20, 10_000  # characters of a text (but uploads), items of a list
LARGEST_NUMBER = 2**31
_PLAIN = {str: "a text", int: "a whole number", float: "a number", bool: "true or false"}


def read(shape: type, given: Any) -> Any:
    """The parameters of a request: a dataclass of protocol.py."""
    return _read(shape, {} if given is None else given, "params")


def _read(shape: Any, given: Any, place: str) -> Any:
    if get_origin(shape) in (Union, UnionType):
        if given is None:
            return None
        (shape,) = (each for each in get_args(shape) if each is not type(None))
    if get_origin(shape) is list:
        _check_size(given, list, "a list", place)
        (item,) = get_args(shape)
        return [_read(item, value, f"{place}[{number}]") for number, value in enumerate(given)]
    if get_origin(shape) is dict:
        _check_size(given, dict, "an object", place)
        _, item = get_args(shape)
        return {key: _read(item, value, f"{place}.{key[:40]}") for key, value in given.items()}
    if shape in _PLAIN:
        return _plain(shape, given, place)
    return _record(shape, given, place)


def _plain(shape: type, given: Any, place: str) -> Any:
    longest = LARGEST_MESSAGE if place.endswith(".data") else LONGEST_TEXT
    if shape is float and type(given) is int:
        given = float(given) if abs(given) < LARGEST_NUMBER else math.inf
    is_one = type(given) is shape
    if shape is str:
        is_one = is_one and len(given) <= longest
    elif shape in (int, float):
        is_one = is_one and math.isfinite(given) and abs(given) < LARGEST_NUMBER
    if not is_one:
        raise _wrong(place, _PLAIN[shape])
    return given


def _record(shape: type, given: Any, place: str) -> Any:
    _check_size(given, dict, "an object", place)
    hints = _hints(shape)
    needed = {each.name for each in fields(shape) if each.default is MISSING}
    for name in given.keys() - hints.keys():
        raise Refusal(USAGE, f"{place} has an unknown `{name[:40]}`")
    for name in needed - given.keys():
        raise Refusal(USAGE, f"{place} has no `{name}`")
    return shape(**{key: _read(hints[key], v, f"{place}.{key}") for key, v in given.items()})


@cache
def _hints(shape: type) -> dict[str, Any]:
    return get_type_hints(shape)


def _check_size(given: Any, kind: type[Any], expected: str, place: str) -> None:
    if type(given) is not kind or len(given) > MOST_ITEMS:
        raise _wrong(place, f"{expected} of at most {MOST_ITEMS:,}")


def _wrong(place: str, expected: str) -> Refusal:
    return Refusal(USAGE, f"{place} should be {expected}")
