"""How far what viewers believe may be from what they would, if a world's plans were exact and they
held all hypotheses."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from i2pdsl.audience.queries import conditioned
from i2pdsl.errors import Diagnostic, Span
from i2pdsl.language import typed as ty
from i2pdsl.language.vocabulary import Vocabulary
from i2pdsl.objective.frame import Frame
from i2pdsl.worlds.hypotheses import Hypothesis, is_attitude

_LARGER = (("at_once", "additive"), ("count", "particles"))  # what makes a method better
DOUBTFUL = 0.1  # a change of a probability above which a script is not trusted


@dataclass(frozen=True)
class Copied:
    """The error in a small copy of a world, which can be planned exactly.

    Attributes:
        told: how small it is, in words.
        scripts: so many were looked at, of characters who act by exact plans.
        mean, worst: the change of belief (`apart`) in a frame, over all frames of all of them.
    """

    told: str
    scripts: int
    mean: float
    worst: float

    def in_words(self) -> str:
        found = f"{self.told} "
        found += f"beliefs are off by {self.mean:.2g} on average, by {self.worst:.2g} at most"
        return found


@dataclass(frozen=True)
class Trust:
    """What is known of the error of an approximate world, or of viewers who hold particles, in a
    script.

    Attributes:
        method: how the world is planned, and what viewers hold, in words.
        closer: what is nearer to exact, by which the script was judged too; or why it was not;
            empty where there is no script.
        belief: the largest change of belief in a frame by that; None where there is none.
        score: the script's objective by it; None where it is not a story that is asked about.
        copied: the error in a small copy; None where there is none.
        answer: the largest change of the answer to a question; None where there is none.
    """

    method: str
    closer: str
    belief: float | None
    score: float | None
    copied: Copied | None
    answer: float | None = None

    @property
    def is_trusted(self) -> bool | None:
        """Whether beliefs are about those by plans nearer to exact ones; None where that is not
        known."""
        return None if self.belief is None else self.belief <= DOUBTFUL

    def warnings(self, place: Span) -> tuple[Diagnostic, ...]:
        """A warning, where beliefs are far from those by plans nearer to exact ones."""
        if self.is_trusted is not False:
            return ()
        message = f"do not trust this script: by {self.closer} beliefs differ by {self.belief:.2g}"
        larger = " or ".join(f"`{name}`" for name, word in _LARGER if word in self.method)
        hint = f"look for another: `--seeds 0-9`; or make {larger} larger"
        return (Diagnostic("untrusted", message, place, hint, severity="warning"),)

    def as_json(self) -> dict[str, Any]:
        """What `i2p run --json` tells, or of a question `i2p query --json`."""
        copied = self.copied
        told = {
            "method": self.method,
            "closer": self.closer,
            "belief": self.belief,
            "score": _finite(self.score),
            "trusted": self.is_trusted,
            "copy": copied and asdict(copied),
        }
        return told if self.answer is None else {**told, "answer": _finite(self.answer)}

    def in_words(self) -> str:
        """What is known, in a line."""
        if not self.closer:
            found = self.method
        elif self.belief is None:
            found = f"{self.method}; whether to trust that is not known: {self.closer}"
        else:
            within = f"beliefs within {self.belief:.2g} of those by {self.closer}"
            if self.answer is not None:
                within = f"by {self.closer} this is off by {self.answer:.2g}, "
                within += f"beliefs by {self.belief:.2g}"
            found = f"{self.method}; {within}"
        return f"{found}; in {self.copied.in_words()}" if self.copied is not None else found


def _finite(number: float | None) -> float | None:
    """JSON has no infinity."""
    return number if number is not None and math.isfinite(number) else None


def apart(
    words: Vocabulary,
    assumption: Sequence[bool],
    one: Frame,
    other: Frame,
    audiences: Sequence[ty.Viewers] = (),
) -> np.ndarray:
    """How much the beliefs of two audiences of one world differ after each frame: the largest
    difference between the probabilities that they give to a value of a latent (of an attitude: to
    its sign). Of observers the mean is taken, of several audiences the largest of their
    differences. [...], the leading axes of the frames."""
    told = [_told(row) for row in words.hypotheses]
    events = sorted({event for row in told for event in row}, key=repr)
    groups = np.array([[event in row for event in events] for row in told], dtype=float)
    mask = np.array(assumption)
    first, second = (conditioned(f.log_belief, mask) @ groups for f in (one, other))
    each = first - second  # [..., O, events]
    spans = audiences or ((0, each.shape[-2]),)
    found = np.stack([np.abs(each[..., a:b, :].mean(-2)).max(-1) for a, b in spans], axis=-1)
    furthest: np.ndarray = found.max(-1)
    return furthest


def _told(row: Hypothesis) -> set[tuple[str, Any]]:
    """What a hypothesis says of each latent."""
    return {(name, np.sign(x) if is_attitude(name) else x) for name, x in row.items()}


def off_by(one: np.ndarray, other: np.ndarray) -> float:
    """The largest difference between two answers to a question; where both are infinite or
    undefined alike there is none."""
    one, other = np.broadcast_arrays(one, other)
    with np.errstate(invalid="ignore"):
        found = np.where((one == other) | (np.isnan(one) & np.isnan(other)), 0.0, one - other)
    found = np.abs(np.where(np.isnan(found), np.inf, found))
    return float(found.max(initial=0.0))
