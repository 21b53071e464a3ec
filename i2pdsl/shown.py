"""What notebooks show instead of a `repr`. Nothing here knows how: who shows a class says so."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

Bundle = tuple[dict[str, Any], dict[str, Any]]
"""Data by MIME type, and metadata."""

_SHOWN: dict[type, Callable[[Any], Bundle]] = {}


class Shown:
    """Something that a notebook shows richly, as soon as there is a way (`shows`)."""

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> Bundle | None:
        how = _SHOWN.get(type(self))
        return None if how is None else how(self)


def shows(kind: type[Shown], how: Callable[[Any], Bundle]) -> None:
    """From now on objects of a class are shown so."""
    _SHOWN[kind] = how
