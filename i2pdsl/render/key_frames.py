"""Which frames of a story a comic strip shows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from i2pdsl.render.mind import Panel, panel_values

CANDIDATES = 400  # of a very long story, only so many frames are considered
EVEN = 0.3  # what uneven key frames cost, where all else is equal
USUAL = 25.0  # frames of a story: courses weigh in a long one as they do in this
SAME = 0.01  # squares of what is seen below which two pictures are alike
ALIKE = 25.0  # what a picture like the one before it costs: more than any belief counts
NEAR = 0.025  # of a story: moments that are closer together are one
MOMENT = 1e3  # what missing a moment that matters as much as 1 costs: more than anything else
PLACE = 1.5  # what the way across the whole picture counts, where a belief from 0 to 1 counts 1
ASIDE = 0.3  # what a belief that the story does not ask about counts beside one that it does
TURN, EDGE = 2.0, 3.0  # how much a turn of what is asked matters, and an event


def key_frames(
    seen: Sequence[np.ndarray],
    believed: Sequence[np.ndarray],
    last: int,
    count: int,
    moments: Mapping[int, float] | None = None,
    glimpses: Mapping[int, float] | None = None,
) -> list[int]:
    """At most `count` of the frames 0..last, first and last among them, that tell the story best.

    Holding each chosen frame until the next one gives a step function; the choice is the one
    nearest to these courses in squares (dynamic programming), even ones before others. Where less
    is to be seen, fewer frames are chosen: a picture like the one before it is shown only where it
    is the end, or a moment that matters.

    Args:
        seen, believed: what is seen and what is believed over time, each [last + 1, ...]; 1 is a
            great change.
        moments: frames that belong to the story, by how much: the greatest are shown for certain.
        glimpses: frames that are worth seeing, in units of the courses' squares.
    """
    if count < 1:
        raise ValueError("a comic needs at least one frame")
    if count == 1 or last == 0:
        return [last]
    moments = _apart({t: w for t, w in (moments or {}).items() if 0 < t < last}, last)
    frames = np.unique(np.linspace(0, last, min(last + 1, CANDIDATES)).astype(int))
    frames = np.unique([*frames, *moments]).astype(int)
    looks = _squares(seen, frames, last)
    apart = looks + _squares(believed, frames, last)
    # [i, j] What it costs to hold frames[i] until frames[j] comes.
    cost = (np.cumsum(np.triu(apart), axis=1) - apart) * USUAL / len(frames)
    gaps = (frames - frames[:, None]) / last
    worth = np.array([(glimpses or {}).get(int(t), 0.0) for t in frames])
    worth += MOMENT * np.array([moments.get(int(t), 0.0) for t in frames])
    alike = (looks < SAME) & (frames < last)  # the end is shown whatever it looks like
    cost = cost + EVEN * gaps**2 + ALIKE * alike - worth
    cost = np.where(gaps > 0, cost, np.inf)
    return [int(frames[k]) for k in _cheapest_path(cost, min(count, len(frames)))]


def _squares(courses: Sequence[np.ndarray], frames: np.ndarray, last: int) -> np.ndarray:
    """[F, F] How far apart two frames are, in squares."""
    flat = [np.nan_to_num(np.asarray(c, float)).reshape(last + 1, -1) for c in courses]
    held = np.concatenate([np.zeros((last + 1, 1)), *flat], axis=1)[frames]
    squares: np.ndarray = ((held[:, None] - held) ** 2).sum(axis=-1)
    return squares


def _apart(moments: Mapping[int, float], last: int) -> dict[int, float]:
    """The moments that are no part of a greater one, nor of the end."""
    found: dict[int, float] = {}
    for t, weight in sorted(moments.items(), key=lambda moment: -moment[1]):
        if all(abs(t - other) >= NEAR * last for other in (last, *found)):
            found[t] = weight
    return found


def evenly(last: int, count: int, first: int = 0) -> list[int]:
    """At most `count` of the frames first..last, as even as can be."""
    return sorted({round(t) for t in np.linspace(first, last, count).tolist()})


def minds(leading: Panel | None, panels: Sequence[Panel]) -> list[np.ndarray]:
    """The courses of what viewers believe, [T + 1] each: first of all of what the story asks."""
    found: list[np.ndarray] = []
    if leading is not None:
        values = np.nan_to_num(np.stack([panel_values(leading, s) for s in leading.series]))
        span = float(values.max() - values.min()) if leading.kind == "value" else 1.0
        found += list(values / max(span, 1e-9))
    known = leading.latent if leading else ""
    others = [p for p in panels if p.latent and p.latent != known]
    return found + [ASIDE * s.values for p in others for s in p.series]


def _cheapest_path(cost: np.ndarray, most: int) -> list[int]:
    """The cheapest way from the first to the last index over at most `most` of them."""
    best = np.full(len(cost), np.inf)
    best[0] = 0.0
    came: list[np.ndarray] = []
    ends = []
    for _ in range(most - 1):
        total = best[:, None] + cost
        came.append(total.argmin(axis=0))
        best = total.min(axis=0)
        ends.append(best[-1])
    path = [len(cost) - 1]
    for before in reversed(came[: int(np.argmin(ends)) + 1]):
        path.append(int(before[path[-1]]))
    return path[::-1]
