"""How long everything takes for the default kitchen, stage by stage, and what it is measured
against: a process that only imports JAX and matplotlib (other ways to do the work: peers.py).

    python benchmarks/kitchen.py [--quick]

All times are seconds of wall clock in this run; run it on a quiet machine.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
STORIES = ROOT / "stories" / "kitchen"
BASELINE = "import jax, jax.numpy as jnp, matplotlib.pyplot; jax.jit(lambda x: x + 1)(jnp.ones(3))"


def clock(work: Callable[[], Any], repeats: int = 1) -> float:
    """The shortest of several runs."""
    best = float("inf")
    for _ in range(repeats):
        began = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - began)
    return best


def row(name: str, seconds: float, more: str = "") -> None:
    print(f"  {name:<44}{seconds:>9.3f} s  {more}", flush=True)


def process(arguments: list[str], cache: Path) -> tuple[float, float, str]:
    """Seconds and peak memory (GiB) of a process, and its standard output."""
    measured = (
        "import resource, runpy, sys, time; sys.argv = sys.argv[1:];"
        "code = 0\n"
        "try: runpy.run_module('i2pdsl', run_name='__main__')\n"
        "except SystemExit as e: code = e.code or 0\n"
        "print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, file=sys.stderr)\n"
        "sys.exit(code)"
    )
    began = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", measured, "i2p", *arguments],
        env={**os.environ, "I2PDSL_CACHE": str(cache)},
        capture_output=True,
        text=True,
        check=True,
    )
    seconds = time.perf_counter() - began
    return seconds, int(done.stderr.split()[-1]) / 2**20, done.stdout


def processes(cache: Path, out: Path) -> None:
    print("whole processes")
    baseline = clock(lambda: subprocess.run([sys.executable, "-c", BASELINE], check=True), 3)
    row("import jax and matplotlib, jit one function", baseline, "the baseline")
    seconds, memory, text = process(["plan", "kitchen", "--json"], cache)
    plan = json.loads(text)
    row(
        "i2p plan kitchen, from nothing",
        seconds,
        f"{plan['states']:,} states, {plan['problems']} problems, residual {plan['residual']:.1e}, "
        f"peak {memory:.2f} GiB",
    )
    command = ["run", str(STORIES / "help.story"), "--format", "png", "--out", str(out), "--json"]
    seconds, memory, _ = process(command, cache)
    row("i2p run help.story --format png, first time", seconds, f"peak {memory:.2f} GiB")
    times = [process(command, cache) for _ in range(3)]
    best = min(seconds for seconds, _, _ in times)
    row("i2p run help.story --format png, warm", best, f"{best / baseline:.2f} x the baseline")
    print(f"    of which {json.loads(times[-1][2])['seconds']}")
    check = ["check", str(STORIES / "help.story")]
    row("i2p check help.story", min(process(check, cache)[0] for _ in range(3)))
    query = ["query", str(out / "help" / "script.json"), "P(rho > 0 | script[:t])"]
    row("i2p query script.json", min(process(query, cache)[0] for _ in range(3)))


def searches(cache: Path) -> None:
    print("searches, once planned (all starts; tables in memory)")
    from i2pdsl.objective.starts import allowed_starts
    from i2pdsl.objective.terms import story_objective
    from i2pdsl.search.beam import beam_search
    from i2pdsl.search.task import draw_starts
    from i2pdsl.stories import load

    for path in sorted(STORIES.glob("*.story")):
        story = load(path)
        world, plan = story.world(), story.typed.search
        objective = story_objective(story.typed, world)
        starts = draw_starts(allowed_starts(world, story.typed.start), plan.starts, 0)
        events = world.events(story.typed.allow)
        search = partial(
            beam_search, world, objective, story.typed.length, starts, plan.width, events
        )
        first = search()
        best = clock(search, 3)
        more = f"{plan.starts} starts, width {plan.width}, T = {story.typed.length}"
        row(path.stem, best, f"{more}; compiling took {first.compile_seconds:.2f} s")


def pictures(out: Path) -> None:
    print("pictures of help.story")
    from i2pdsl.render.grid.pictures import GridPictures
    from i2pdsl.stories import Script

    script = Script.load(out / "help" / "script.json")
    for kind in ("png", "svg", "html", "gif", "mp4"):
        work = lambda k=kind: GridPictures(script).save(out / "pictures", (k,))
        row(kind, clock(work, 2))


OPEN = """
map
{rows}
tile red
    cell = (0, 0)
tile blue
    cell = ({last}, {last})
character guest
    success = 0.6
    goals = {{red, blue}}
character host
    goals = {{red, blue, none}}
    pushes = {{guest}}
    toward = guest
    attitude = {{-1, 0, 1}}
"""


def growth(sizes: list[int]) -> None:
    print("growth with the number of states: an open floor, two characters, all problems")
    from i2pdsl.errors import Source
    from i2pdsl.worlds.grid.dynamics import build_dynamics
    from i2pdsl.worlds.grid.parse import parse_world
    from i2pdsl.worlds.grid.planning import solve

    for size in sizes:
        rows = "\n".join("    " + "." * size for _ in range(size))
        source = Source("open.world", OPEN.format(rows=rows, last=size - 1))
        spec = parse_world(source, "open")
        dynamics = build_dynamics(spec)
        last: dict[str, int] = {}

        def report(who: str, sweep: int, residual: float, expected: float | None) -> None:
            last[who] = sweep  # noqa: B023

        solve(spec, dynamics, report=report)  # compiles
        plan = solve(spec, dynamics, report=report)
        sweeps = sum(last.values())
        each = plan.seconds / sweeps / spec.state_count * 1e9
        row(
            f"{size} x {size}: {spec.state_count:,} states",
            plan.seconds,
            f"{sweeps} sweeps, {each:.0f} ns a state and sweep, residual {plan.residual:.1e}",
        )


def main() -> None:
    """Prints the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="small maps only")
    quick = parser.parse_args().quick
    with tempfile.TemporaryDirectory() as folder:
        cache, out = Path(folder) / "cache", Path(folder) / "out"
        processes(cache, out)
        os.environ["I2PDSL_CACHE"] = str(cache)
        searches(cache)
        pictures(out)
        growth([5, 8, 12] if quick else [5, 8, 12, 18, 24, 32])
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    print(f"peak memory of this process: {peak:.2f} GiB")


if __name__ == "__main__":
    main()
