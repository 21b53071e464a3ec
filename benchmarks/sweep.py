"""Sweeps with one and with two workers, and with one that is killed in the middle.

    python benchmarks/sweep.py [SEEDS]

Jobs for each second on the clock, from the first result on: before it, processes start, import and
compile. With N processors a worker more helps as far as a search alone leaves them idle.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

STORY = """world maze
length 6
search beam(starts = 100, polish = 1)
maximize sum_t P(rho > 0 | script[:t])
"""


def sweep(folder: Path, seeds: int, workers: int, kill: bool = False) -> tuple[float, float, int]:
    """Seconds until the first result and from there to the last, and how many there are."""
    command = [sys.executable, "-m", "i2pdsl", "sweep", str(folder / "help.story"), "--seeds"]
    out = folder / f"out-{workers}-{kill}"
    command += [f"0-{seeds - 1}", "--workers", str(workers), "--out", str(out)]
    began = time.perf_counter()
    with subprocess.Popen(command, stdout=subprocess.DEVNULL) as running:
        while not any(out.rglob("result.json")):
            time.sleep(0.02)
        first = time.perf_counter()
        if kill:
            children = Path(f"/proc/{running.pid}/task/{running.pid}/children").read_text().split()
            os.kill(int(children[-1]), signal.SIGKILL)
    return first - began, time.perf_counter() - first, len(list(out.rglob("result.json")))


def main(seeds: int) -> None:
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        (folder / "help.story").write_text(STORY, encoding="utf-8")
        sweep(folder, 1, 1)  # the world is planned, the program compiled and kept
        (folder / "out-1-False").rename(folder / "before")
        rates = []
        for workers in (1, 2):
            start, seconds, count = sweep(folder, seeds, workers)
            rates.append((count - 1) / seconds)
            told = f"{start:.1f} s until the first of {count} results, then {rates[-1]:.2f} jobs/s"
            print(f"{workers} worker{'s' * (workers > 1)}: {told}")
        print(f"ratio: {rates[1] / rates[0]:.2f}")
        _, seconds, count = sweep(folder, seeds, 2, kill=True)
        print(f"2 workers, one killed at the first result: {count} of {seeds} results", end="")
        print(f" after {seconds:.1f} s more, {seeds - count} lost")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 24)
