"""The kind of world that docs/new-world.md makes, and what its viewers believe in plain Python:
loops and dictionaries, transcribed from the definitions and not from the code."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from documents_for_tests import blocks
from i2pdsl.worlds.kinds import KINDS, Place

PAGE = Path(__file__).parent.parent / "docs" / "new-world.md"
ENDS = {"left": 0, "right": 4}
STEPS = {"west": -1, "east": 1, "stay": 0}  # in the order of the world's actions
LAMP = 2
Belief = dict[str, float]


@contextmanager
def corridor(folder: Path) -> Iterator[Path]:
    """A folder with a corridor, whose kind is in the table meanwhile."""
    for block in blocks(PAGE.read_text(encoding="utf-8")):
        name = block.option("file")
        if name is not None:
            (folder / name).write_text(block.text, encoding="utf-8")
    sys.path.insert(0, str(folder))
    KINDS["corridor"] = Place("corridor_kind", "corridor_drawing")
    try:
        yield folder
    finally:
        del KINDS["corridor"]
        sys.path.remove(str(folder))
        for name in [n for n in sys.modules if n.startswith("corridor_") and "tests" not in n]:
            del sys.modules[name]


def moved(cell: int, action: str) -> int:
    return min(max(cell + STEPS[action], 0), 4)


def policy(cell: int, end: str, beta: float, sharpness: float = 1.0) -> dict[str, float]:
    """What the walker does who wants to be at an end."""
    weights = {a: math.exp(-beta * abs(moved(cell, a) - ENDS[end])) ** sharpness for a in STEPS}
    total = sum(weights.values())
    return {a: w / total for a, w in weights.items()}


@dataclass
class Watched:
    """What viewers believe of a walk from a cell.

    Attributes:
        cells, beliefs: after each of the frames 0..T.
    """

    actions: Sequence[str]
    start: int = LAMP
    beta: float = 2.0
    prior: tuple[float, float] = (0.5, 0.5)
    sharpness: float = 1.0
    forgetting: float = 0.0
    switching: float = 0.0

    def __post_init__(self) -> None:
        self.cells = [self.start]
        self.beliefs: list[Belief] = [dict(zip(ENDS, self.prior, strict=True))]
        for action in self.actions:
            self.beliefs.append(self.after(self.beliefs[-1], self.cells[-1], action))
            self.cells.append(moved(self.cells[-1], action))

    @property
    def last(self) -> int:
        return len(self.actions)

    def likely(self, cell: int, action: str) -> Belief:
        return {end: policy(cell, end, self.beta, self.sharpness)[action] for end in ENDS}

    def expected(self, belief: Belief, cell: int, action: str) -> float:
        """The probability with which viewers expect an action."""
        return sum(belief[end] * p for end, p in self.likely(cell, action).items())

    def after(self, belief: Belief, cell: int, action: str) -> Belief:
        """Bayes' rule, and what is forgotten, and that the goal may have been drawn anew."""
        joint = {end: belief[end] * p for end, p in self.likely(cell, action).items()}
        found = {end: p / sum(joint.values()) for end, p in joint.items()}
        e, g = self.forgetting, self.switching
        found = {end: p * (1 - e) + (1 - p) * e for end, p in found.items()}
        drawn = dict(zip(ENDS, self.prior, strict=True))
        return {end: (1 - g) * p + g * drawn[end] for end, p in found.items()}

    # The forms, each as it is asked at frame t.

    def probability(self, t: int) -> float:
        return self.beliefs[t]["right"]

    def next(self, t: int) -> list[float]:
        return [self.expected(self.beliefs[t], self.cells[t], action) for action in STEPS]

    def value(self, t: int) -> float:
        return sum(p * -abs(self.cells[t] - ENDS[end]) for end, p in self.beliefs[t].items())

    def entropy(self, t: int) -> float:
        return -sum(p * math.log(p) for p in self.beliefs[t].values() if p)

    def divergence(self, t: int) -> float:
        before, now = self.beliefs[t - 1], self.beliefs[t]
        return sum(p * math.log(p / now[end]) for end, p in before.items() if p)

    def surprise(self, t: int) -> float:
        action = self.actions[t - 1]
        return -math.log(self.expected(self.beliefs[t - 1], self.cells[t - 1], action))

    def suspense(self, t: int) -> float:
        belief, cell = self.beliefs[t], self.cells[t]
        outcomes = [
            (self.expected(belief, cell, action), self.after(belief, cell, action))
            for action in STEPS
        ]
        total = 0.0
        for end in ENDS:
            mean = sum(p * after[end] for p, after in outcomes)
            total += sum(p * (after[end] - mean) ** 2 for p, after in outcomes)
        return total

    def film(self, naturalness: float = 0.2, liveliness: float = 0.2) -> float:
        """What the automatic terms take away: for each nat of regret under the belief after an
        action, and for each frame in which nobody moves."""
        cost = 0.0
        for t, action in enumerate(self.actions, 1):
            before = self.cells[t - 1]
            for end, p in self.beliefs[t].items():
                every = policy(before, end, self.beta, self.sharpness)
                cost += naturalness * p * math.log(max(every.values()) / every[action])
            cost += liveliness * (self.cells[t] == before)
        return cost


FORMS: dict[str, Callable[[Watched, int], float | list[float]]] = {
    "P": Watched.probability,
    "next": Watched.next,
    "E": Watched.value,
    "V": Watched.value,
    "KL": Watched.divergence,
    "entropy": Watched.entropy,
    "surprise": Watched.surprise,
    "suspense": Watched.suspense,
}
"""Every form of language/forms.py, of the corridor's event, latent or character."""
