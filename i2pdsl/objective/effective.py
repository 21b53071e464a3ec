"""How many particles count, of viewers who hold some hypotheses instead of all."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from i2pdsl.audience.particles import Swarm
from i2pdsl.errors import Diagnostic, whole_file
from i2pdsl.language.story import VIEWERS, Audience
from i2pdsl.objective.frame import Frame

FEW = 20  # effective particles: a probability of .5 is then off by .11, in root mean square


@dataclass(frozen=True)
class Effective:
    """The particles of one viewer along a script.

    Attributes:
        audience: whose they are.
        count, seed: as they were asked for.
        least, frame: the smallest effective sample size, and after which frame that was.
    """

    audience: str
    count: int
    seed: int
    least: float
    frame: int

    @property
    def words(self) -> str:
        whose = "" if self.audience == VIEWERS else f" of {self.audience}"
        return (
            f"{self.count:,} particles{whose}, at least {self.least:.3g} of them effective "
            f"(frame {self.frame})"
        )

    def warning(self) -> Diagnostic | None:
        """What is said where few count."""
        if self.least >= FEW:
            return None
        hint = f"ask again with more: `particles(count = {10 * self.count})`, or another `seed`"
        message = f"beliefs are rough: {self.words}"
        return Diagnostic("particles", message, whole_file("audience"), hint, severity="warning")


def effective_of(audiences: Sequence[Audience], frames: Frame) -> tuple[Effective, ...]:
    """Of each viewer who holds particles, along all frames of a script."""
    holders = [(a.name, o.particles) for a in audiences for o in a.observers if o.particles]
    found = []
    swarms = [held for held in frames.holdings if isinstance(held, Swarm)]
    for (name, plan), swarm in zip(holders, swarms, strict=True):
        counts = np.asarray(swarm.effective)
        frame = int(counts.argmin())
        found.append(Effective(name, plan.count, plan.seed, float(counts[frame]), frame))
    return tuple(found)
