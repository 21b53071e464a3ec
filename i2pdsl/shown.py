"""What notebooks show instead of a `repr`. Nothing here knows how: who shows a class says so."""

from __future__ import annotations

TYPE_CHECKING = False  # as typing's, which takes time to import
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

Bundle = tuple[dict[str, "Any"], dict[str, "Any"]]
"""Data by MIME type, and metadata."""

_SHOWN: dict[type, Callable[[Any], Bundle]] = {}
_later: Callable[[], object] | None = None


class Shown:
    """Something that a notebook shows richly, if there is a way (`shows`)."""

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> Bundle | None:
        if not _SHOWN and _later is not None:
            _later()
        how = _SHOWN.get(type(self))
        return None if how is None else how(self)


def shows_later(load: Callable[[], object]) -> None:
    """What says how things are shown, once the first of them is to be."""
    global _later
    _later = load


def shows(kind: type[Shown], how: Callable[[Any], Bundle]) -> None:
    """From now on objects of a class are shown so."""
    _SHOWN[kind] = how
