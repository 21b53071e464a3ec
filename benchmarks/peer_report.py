"""What a run of `peers.py` measures: rows of tables, what was checked, and what all are given."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from peer_arrays import Arrays, Clock, Times

TOLERANCE = 1e-6
OURS, HAND, NUMPY, PLAIN = "i2pdsl", "JAX by hand", "NumPy", "plain Python"
NATURAL, FASTEST = "memo, natural", "memo, fastest"


@dataclass
class Report:
    """Rows of a table, (work, who, times, remark), and what was checked."""

    title: str
    rows: list[tuple[str, str, Times, str]] = field(default_factory=list)
    checks: list[str] = field(default_factory=list)

    def add(self, work: str, who: str, times: Times, remark: str = "") -> None:
        self.rows.append((work, who, times, remark))
        print(f"  {work:<34}{who:<15}{times.cpu:>10.4f} s  {remark}", flush=True)

    def add_all(self, work: str, clocks: dict[str, Clock]) -> None:
        for who, clock in clocks.items():
            self.add(work, who, clock.times)

    def check(self, text: str) -> None:
        self.checks.append(text)
        print(f"  = {text}", flush=True)

    def carry(self, document: str) -> None:
        """Takes memo's rows and checks from the last document, where memo is not measured."""
        table = document.partition(f"### {self.title}\n")[2].partition("\n### ")[0]
        (day,) = re.findall(r"^(\d{4}-\d\d-\d\d);", document, re.M) or ["?"]
        for line in table.splitlines():
            cells = [cell.strip() for cell in line.strip("|").split("|")]
            if len(cells) == 7 and cells[1] in (NATURAL, FASTEST):
                seconds, clock, compiling = (float(cells[n] or 0) for n in (2, 4, 5))
                remark = cells[6] or f"measured {day}"
                self.rows.append((cells[0], cells[1], Times(seconds, clock, compiling, 0), remark))
            elif line.startswith("- ") and "memo" in line:
                self.checks.append(line.removeprefix("- "))

    def markdown(self) -> str:
        lines = [
            f"### {self.title}\n",
            "| work | in | seconds | of ours | clock | compiling | |",
            "|---|---|---|---|---|---|---|",
        ]
        ours = {work: times.cpu for work, who, times, _ in self.rows if who == OURS}
        for work, who, t, remark in self.rows:
            ratio = f"{t.cpu / ours[work]:.2g}" if who != OURS and ours.get(work) else ""
            compiling = f"{t.compile_cpu:.1f}" if t.compile_cpu >= 0.05 else ""
            cells = (work, who, f"{t.cpu:.3g}", ratio, f"{t.wall:.3g}", compiling, remark)
            lines.append("| " + " | ".join(cells) + " |")
        return "\n".join([*lines, "", *(f"- {check}" for check in self.checks), ""])


@dataclass(frozen=True)
class Given:
    """A world, planned by us, as all of them get it."""

    story: Any
    world: Any
    arrays: Arrays
    order: np.ndarray  # where each of their problems stands in our tables
    starts: np.ndarray
    length: int
    scripts: list[Any]

    @property
    def offspring(self) -> int:
        from i2pdsl.search.pool import IN_ALL_FRAMES, OFFSPRING

        return max(OFFSPRING, IN_ALL_FRAMES // self.length)

    @property
    def turns(self) -> tuple[np.ndarray, np.ndarray]:
        """The starts [N] and actions [N, T] of the scripts."""
        paths = [script.trajectory for script in self.scripts]
        starts = np.array([path.states[0] for path in paths], np.int32)
        return starts, np.array([path.actions for path in paths], np.int32)


def values_of(a: Arrays, plan: Any, order: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """V of both from our continuations."""
    found = []
    for after, home, w, q in (
        (a.weak_next, a.weak_home.T, plan[0], a.success),
        (a.strong_next, a.strong_home[a.strong_goal].T, plan[1][:, order], 1.0),
    ):
        best = np.full(w.shape, -np.inf)
        for action, states in enumerate(after):
            np.maximum(best, a.cost[action] + a.gamma * (q * w[states] + (1 - q) * w), out=best)
        found.append(home + best)
    return found[0], found[1]
