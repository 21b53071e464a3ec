"""Stories of several lengths in one compiled program.

A story of L frames is searched as one of N, the greatest length: it begins N - L frames late, and
ends with all the others. So its last frame has the same number as theirs, and what it asks of frame
t is asked of frame N - L + t. What differs between lengths are then numbers, which are parameters
of a program: tables over t, and how many frames there are `before`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np

from i2pdsl.language import typed as ty
from i2pdsl.objective.pins import Pins


def later(node: Any, before: int, shifted: bool = False) -> Any:
    """An expression about a story as one about a story that begins `before` frames later. Frame 0,
    the first picture, keeps its number.

    Args:
        shifted: whether the sum around it begins later; otherwise it begins where all do, with
            frames that do not exist.
    """
    if isinstance(node, tuple):
        return tuple(later(part, before, shifted) for part in node)
    if not is_dataclass(node) or not hasattr(node, "axes"):
        return node
    match node:
        case ty.TimeTable(first=first, values=values):
            if shifted:
                return ty.TimeTable(first + before, values)
            return ty.TimeTable(first, (values[0],) * before + values)
        case ty.Moment(first=None):
            return replace(node, frames=_moved(node.frames, before))
        case ty.Moment(first=int(first), frames=frames) if shifted:
            return replace(node, first=first + before, frames=_moved(frames, before))
        case ty.Moment(first=int(first), frames=frames, offset=int(offset)):
            start = first + offset
            return replace(node, frames=range(start, start + len(frames) + before))
        case ty.Moment(frames=frames):
            moved = _moved(frames, before)
            return replace(node, frames=(moved[0],) * before + moved)
        case ty.Reduction(first=first, last=last):
            shifts = first > 1
            body = later(node.body, before, shifts)
            return replace(node, first=first + before * shifts, last=last + before, body=body)
        case ty.Beats(last=last):
            return replace(node, parts=later(node.parts, before), last=last + before)
        case ty.When(last=last):
            return ty.When(later(node.body, before), last + before, before)
        case ty.FrameCount():
            return ty.FrameCount(before)
    parts = {f.name: later(getattr(node, f.name), before, shifted) for f in fields(node)}
    kind: Any = type(node)
    return kind(**parts)


def _moved(frames: Sequence[int], before: int) -> tuple[int, ...]:
    return tuple(frame + before if frame > 0 else 0 for frame in frames)


def pins_later(pins: Pins | None, before: int) -> Pins | None:
    """The tables of pinned frames of a story that begins later."""
    if pins is None:
        return None
    return pins._replace(rows=np.pad(pins.rows, ((0, 0), (before, 0))))
