"""What notebooks show instead of a `repr`, and what a story is changed by there. Nothing here knows
how: who shows a class says so."""

from __future__ import annotations

TYPE_CHECKING = False  # as typing's, which takes time to import
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

Bundle = tuple[dict[str, "Any"], dict[str, "Any"]]
"""Data by MIME type, and metadata."""

_SHOWN: dict[type, Callable[[Any], Bundle]] = {}
_later: Callable[[], object] | None = None
_desk: Callable[[Any], Any] | None = None


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


def desks_are(made: Callable[[Any], Any]) -> None:
    """What makes the widget by which a story is changed in a notebook. Raises ImportError."""
    global _desk
    _desk = made


def desk_of(story: Any) -> Any:
    """That widget. Raises ImportError where it cannot be."""
    if _desk is None:
        raise ImportError("nobody makes widgets")
    return _desk(story)
