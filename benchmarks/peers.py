"""What people would use otherwise, on the same work: plain Python as in the paper's pseudo-code,
NumPy, JAX by hand for one objective, memo, and this library. One run, all in turn, ratios.

    python benchmarks/peers.py [--memo PYTHON] [--world nook|kitchen] [--write]

Works: planning (the problems of both characters to one Bellman residual), what viewers believe of a
script and of many, and the search (the same starts, frames and objective). That all do the same
work is checked in the run, and said below the tables. Times are seconds of processors, the best of
several runs, since the clock counts what others do on the machine as well.

PYTHON is an interpreter (3.12 or newer) that has `memo-lang`; without one its rows are those of the
last run that had one.
`--write` puts the tables into docs/benchmarks.md.
"""

from __future__ import annotations

import argparse
import os
import platform
import re
import resource
import subprocess
import sys
import tempfile
import time
from importlib.metadata import version
from pathlib import Path

import numpy as np
from peer_arrays import Arrays, Times, arrays_of, clocked
from peer_beliefs import beliefs
from peer_planning import planning
from peer_report import HAND, OURS, TOLERANCE, Given, Report, values_of
from peer_searches import searches
from peer_with_memo import with_memo

ROOT = Path(__file__).resolve().parent.parent
DOCUMENT = ROOT / "docs" / "benchmarks.md"
WORLDS = (("nook", 8, 56), ("kitchen", 15, 500))  # with frames and starts
STORY = """world {world}
length {length}
search beam(starts = {starts}, polish = 0)
rationality 1
plausibility 1
naturalness 0
luck 0
liveliness 0
maximize sum_t P(rho > 0 | script[:t])
"""


def measure(name: str, length: int, count: int, scripts: int, folder: Path, memo: str) -> Report:
    import jax
    import peer_jax
    import peer_numpy

    from i2pdsl.computing import computing
    from i2pdsl.objective.starts import allowed_starts
    from i2pdsl.search.task import draw_starts
    from i2pdsl.stories import load

    path = folder / f"{name}.story"
    path.write_text(STORY.format(world=name, length=length, starts=count), encoding="utf-8")
    story = load(path)
    small = name != "kitchen"
    with computing():
        world = story.world()
        starts = draw_starts(allowed_starts(world, story.typed.start), count, 0)
        told = story.sample(scripts).scripts
    a, order = arrays_of(world)
    given = Given(story, world, a, order, starts, length, list(told))
    size = f"{len(world.dynamics.cells):,} states, {len(a.rational)} hypotheses"
    print(f"{name}: {size}, {len(starts)} starts, {length} frames")
    report = Report(f"{name.capitalize()}: {size}, {len(starts)} starts, {length} frames")
    jax.config.update("jax_enable_x64", True)  # for what is written by hand; ours sets its own
    planning(report, given, small)
    values = values_of(a, world.tables.continuation, order)
    clocks = clocked({HAND: lambda: jax.block_until_ready(peer_jax.policies(a, *values))}, 1)
    from i2pdsl.worlds.grid.arrays import padded
    from i2pdsl.worlds.grid.world import with_policies
    from i2pdsl.worlds.world import on_device

    states = len(world.dynamics.cells)
    ours_made = lambda: jax.block_until_ready(
        with_policies(on_device(padded(world.tables)), states)
    )
    with computing():
        clocks[OURS] = clocked({OURS: ours_made}, 1)[OURS]
    report.add_all("tables for beliefs and search", clocks)
    weak = peer_numpy.softmax(a, peer_numpy.q_weak(a, values[0]))
    strong = peer_numpy.softmax(a, peer_numpy.q_strong(a, weak, values[1]))
    single = lambda x: x.astype(np.float32) if x.dtype.kind == "f" else x
    a32, weak32, strong32 = jax.device_put(jax.tree.map(single, (a, weak, strong)))
    policies = (a32, (weak, strong), (weak32, strong32))
    ours = beliefs(report, given, policies, small)
    searches(report, given, policies, small)
    if memo:
        with_memo(report, given, policies, memo, values, ours)
    return report


def process(report: Report, work: str, who: str, command: list[str], remark: str = "") -> None:
    """A row of a whole process."""
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run(command, check=True, capture_output=True)
    wall = time.perf_counter() - began
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    report.add(work, who, Times(cpu, wall, 0, 0), remark)


def processes(folder: Path) -> Report:
    """The stories of the tables above, from nothing."""
    from i2pdsl.stories import load

    report = Report("Whole processes: a greedy search, from nothing")
    os.environ["I2PDSL_CACHE"] = str(folder / "nothing")
    for world, length, count in WORLDS:
        story, out = folder / f"{world}.story", folder / "out"
        if not story.exists():
            continue
        ours = [sys.executable, "-m", "i2pdsl", "run", str(story), "--out", str(out)]
        ours += ["--choose", "score", "--format", "png"]
        work = f"{world}, nothing in any cache"
        process(report, work, OURS, ours, "and a script file, a comic, curves")
        arrays_of(load(story).world())[0].save(folder / "arrays.npz")
        hand = [sys.executable, __file__, "--by-hand", str(folder / "arrays.npz")]
        hand += ["--size", str(count), str(length)]
        process(report, work, HAND, hand, "actions only; states come from a file")
        process(report, f"{world}, planned, programs compiled", OURS, ours)
    return report


def by_hand(path: Path, count: int, length: int) -> None:
    """All of it in JAX by hand, as a program that does nothing else."""
    import jax
    import peer_jax

    jax.config.update("jax_enable_x64", True)
    a = Arrays.load(path)
    weak, strong, _ = peer_jax.planned(a, TOLERANCE)
    weak, strong = peer_jax.policies(a, weak, strong)
    single = lambda x: x.astype(np.float32) if x.dtype.kind == "f" else x
    states = a.weak_next.shape[1]
    starts = np.random.default_rng(0).choice(states, size=count, replace=False)
    given = jax.device_put((jax.tree.map(single, a), weak, strong))
    scores, actions = peer_jax.search(*given, starts, length, 1, 8)
    print(scores.max(), actions[scores.argmax()].tolist())


def machine() -> str:
    model = platform.processor()
    if Path("/proc/cpuinfo").exists():
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
        model = re.findall(r"model name\s*: (.*)", text)[0]
    packages = ", ".join(f"{name} {version(name)}" for name in ("i2pdsl", "jax", "numpy"))
    return (
        f"{time.strftime('%Y-%m-%d', time.gmtime())}; {model}, {os.cpu_count()} processors; "
        f"Python {platform.python_version()}, {packages}."
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--memo", default="", metavar="PYTHON")
    parser.add_argument("--world", choices=[world for world, _, _ in WORLDS])
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--by-hand", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--size", type=int, nargs=2, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.by_hand:
        by_hand(given.by_hand, *given.size)
        return
    sys.path[:0] = [str(ROOT / "tests")]
    from search_objectives import NOOK

    reports = []
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        os.environ["I2PDSL_CACHE"] = str(folder / "cache")
        (folder / "nook.world").write_text(NOOK, encoding="utf-8")
        for world, length, count in WORLDS:
            if given.world in (None, world):
                reports.append(measure(world, length, count, 1000, folder, given.memo))
        reports.append(processes(folder))
    document = DOCUMENT.read_text(encoding="utf-8")
    if not given.memo:
        for report in reports:
            report.carry(document)
    text = "\n".join([machine(), "", *(report.markdown() for report in reports)])
    if given.write:
        put = lambda _: f"<!-- measured: peers -->\n{text}<!-- end -->"
        document = re.sub(r"<!-- measured: peers -->\n.*?<!-- end -->", put, document, flags=re.S)
        DOCUMENT.write_text(document, encoding="utf-8")
    else:
        print(text)


if __name__ == "__main__":
    main()
