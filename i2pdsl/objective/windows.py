"""What a story treats otherwise than the rest of its script: turns that it appends to it, and
stretches of frames."""

from __future__ import annotations

import numpy as np

from i2pdsl.language import typed as ty
from i2pdsl.language.story import TypedStory


def appended_turns(story: TypedStory) -> tuple[ty.Turn, ...]:
    """The longest sequence of turns that a story's objective appends to its script."""
    found: tuple[ty.Turn, ...] = ()
    for _, expression in story.objective:
        for node in ty.walk(expression):
            if isinstance(node, ty.Moment) and len(node.turns) > len(found):
                found = node.turns
    return found


def story_windows(story: TypedStory, length: int) -> tuple[tuple[int, int, str], ...]:
    """The stretches of frames that a story singles out, and what it asks for there: those of a
    script of `length` frames, which may be shorter than what the story says.

    Where something in its objective that depends on t alone has another value than before and
    after, such as the sign of a dip.
    """
    found = []
    for sign, expression in story.objective:
        for node in ty.walk(expression):
            if not isinstance(node, ty.TimeTable) or len(set(node.values)) != 2:
                continue
            inside = np.array(node.values) != node.values[0]
            edges = np.flatnonzero(np.diff(inside)) + 1
            if len(edges) == 2:
                first, end = (int(edge) for edge in edges)
                change = sign * (node.values[first] - node.values[0])
                kind = "dip" if change < 0 else "rise"
                found.append((node.first + first, node.first + end - 1, kind))
    return tuple(
        (first, min(last, length), kind)
        for first, last, kind in dict.fromkeys(found)
        if first < length
    )
