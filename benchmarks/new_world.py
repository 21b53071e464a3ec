"""What somebody waits for who opens or edits a world: on a fresh machine, after any story of the
shape was run before, and again; and what a warm run costs beside a process that only imports JAX
and matplotlib and compiles one function.

    python benchmarks/new_world.py

Seconds of whole processes in this run: on the clock, and of CPU time (user and system, all
threads), which another load on the machine changes less.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BASELINE = "import jax, jax.numpy as jnp, matplotlib.pyplot; jax.jit(lambda x: x + 1)(jnp.ones(3))"

CAST = """
tile a
    symbol = A
tile b
    symbol = B
character mouse
    success = 0.6
    goals = {a, b}
character cat
    goals = {a, b, none}
    pushes = {mouse, crate}
    toward = mouse
    attitude = {-1, 0, 1}
object crate
"""
ROOM = "map\n    A...\n    ....\n    ....\n    ...B\n"
EDITED = "map\n    ...A\n    .#..\n    ....\n    .B..\n"  # 2,730 states instead of 3,360
STORY = "world {name}\nlength 8\nmaximize sum_t P(rho > 0 | script[:t])\n"


def process(arguments: list[str], cache: Path) -> tuple[float, float, str]:
    """Seconds on the clock and of CPU time of a process, and its standard output."""
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    environment = {**os.environ, "I2PDSL_CACHE": str(cache)}
    done = subprocess.run(arguments, env=environment, capture_output=True, text=True, check=True)
    seconds, after = time.perf_counter() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return seconds, cpu, done.stdout


def run(story: Path, cache: Path, *formats: str) -> tuple[float, float, dict[str, float]]:
    """`i2p run`: seconds on the clock, of CPU time, and those of its stages."""
    out = cache.parent / "out"
    command = [sys.executable, "-m", "i2pdsl", "run", str(story), "--out", str(out), "--json"]
    for name in formats:
        command += ["--format", name]
    seconds, cpu, text = process(command, cache)
    return seconds, cpu, json.loads(text)["seconds"]


def row(name: str, seconds: float, cpu: float, more: object = "") -> None:
    print(f"  {name:<52}{seconds:>7.2f} s {cpu:>7.2f} s CPU  {more}", flush=True)


def main() -> None:
    """Prints the figures."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for world, rows in (("room", ROOM), ("edited", EDITED)):
            (folder / f"{world}.world").write_text(rows + CAST, encoding="utf-8")
            (folder / f"{world}.story").write_text(STORY.format(name=world), encoding="utf-8")
        kitchen = (ROOT / "stories/worlds/kitchen.world").read_text(encoding="utf-8")
        (folder / "moved.world").write_text(
            kitchen.replace(".P.........", "P..........", 1), encoding="utf-8"
        )
        helping = (ROOT / "stories/kitchen/help.story").read_text(encoding="utf-8")
        (folder / "moved.story").write_text(
            helping.replace("world kitchen", "world moved"), encoding="utf-8"
        )
        print("a fresh machine: nothing planned, nothing compiled")
        maze = sorted((ROOT / "stories/maze").glob("*.story"))[0]
        row(f"i2p run {maze.name}", *run(maze, folder / "fresh", "png"))
        cache = folder / "cache"
        row("i2p run room.story (3,360 states)", *run(folder / "room.story", cache, "png"))
        row("i2p run help.story", *run(ROOT / "stories/kitchen/help.story", cache, "png"))
        print("a new or edited world of a shape that was run before")
        row("i2p run edited.story (2,730 states)", *run(folder / "edited.story", cache, "png"))
        row(
            "i2p run help.story in a kitchen with a moved tile", *run(folder / "moved.story", cache)
        )
        print("again")
        row("i2p run room.story", *run(folder / "room.story", cache, "png"))
        warm = min(
            (run(ROOT / "stories/kitchen/help.story", cache, "png") for _ in range(5)),
            key=lambda found: found[1],
        )
        row("i2p run help.story", *warm)
        base = min(
            (process([sys.executable, "-c", BASELINE], cache) for _ in range(5)),
            key=lambda found: found[1],
        )
        row("import jax and matplotlib, jit one function", base[0], base[1])
        print(f"  warm run of help.story: {warm[1] / base[1]:.2f} x that in CPU time")


if __name__ == "__main__":
    main()
