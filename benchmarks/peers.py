"""What people would use otherwise, on the same work: plain Python as in the paper's pseudo-code,
NumPy, JAX by hand for one objective, memo, and this library. One run, all in turn, ratios.

    python benchmarks/peers.py [--memo PYTHON] [--world small|kitchen] [--write]

Works: planning (the problems of both characters to one Bellman residual), what viewers believe of a
script and of many, and the search (the same starts, frames and objective). That all do the same
work is checked in the run, and said below the tables. Times are seconds of processors, the best of
several runs, since the clock counts what others do on the machine as well.

PYTHON is an interpreter (3.12 or newer) that has `memo-lang`; without one its rows are left out.
`--write` puts the tables into docs/benchmarks.md.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import re
import resource
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict, dataclass, field
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from peer_arrays import Arrays, Clock, Task, Times, arrays_of, clocked

ROOT = Path(__file__).resolve().parent.parent
DOCUMENT = ROOT / "docs" / "benchmarks.md"
TOLERANCE = 1e-6
QUESTION = "P(rho > 0 | script[:t])"
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


# ---- Planning ------------------------------------------------------------------------------------


def planning(report: Report, given: Given, small: bool) -> None:
    """All problems of both characters, to a Bellman residual of TOLERANCE."""
    import peer_jax
    import peer_numpy

    from i2pdsl.worlds.grid.planning import solve

    a, spec, dynamics = given.arrays, given.world.spec, given.world.dynamics
    swept: dict[str, int] = {}

    def told(who: str, sweep: int, residual: float, expected: float | None) -> None:
        swept[who] = sweep

    works = {
        OURS: lambda: solve(spec, dynamics, TOLERANCE, told),
        HAND: lambda: peer_jax.planned(a, TOLERANCE),
    }
    if small:
        works[NUMPY] = lambda: peer_numpy.planned(a, TOLERANCE)
    clocks = clocked(works, 5 if small else 1)
    work = "planning"
    values = {OURS: values_of(a, clocks[OURS].result.continuation, given.order)}
    values |= {who: clock.result[:2] for who, clock in clocks.items() if who != OURS}
    for who, clock in clocks.items():
        count = ", ".join(map(str, swept.values())) if who == OURS else _counted(clock.result[2])
        report.add(work, who, clock.times, f"sweeps: {count}")
    if small:
        clock = Clock(partial(_planned_plainly, given))
        clock.run()
        report.add(work, PLAIN, clock.times)
        values[PLAIN] = clock.result
    else:
        sweeps, once = clocks[HAND].result[2], Clock(partial(_numpy_sweeps, a, values[OURS]))
        once.run()
        once.run()
        seconds = sum(s * sum(n) for s, n in zip(once.result[0], sweeps, strict=True))
        remark = "a sweep's time, times the sweeps of JAX by hand"
        report.add(work, NUMPY, Times(seconds, seconds, 0, 0), remark)
    worst = max(max(peer_numpy.residuals(a, *each)) for each in values.values())
    # The strong one faces the policy of values of the weak one that are themselves not exact.
    assert worst <= 3 * TOLERANCE, worst
    far = max(
        float(np.abs(x - y).max())
        for each in values.values()
        for x, y in zip(each, values[OURS], strict=True)
    )
    names = ", ".join(values)
    report.check(
        f"Planning: by one and the same sweep in NumPy, the residual |TV - V| of the values of "
        f"{names} is at most {worst:.1e} in every state and problem; the values differ by at "
        f"most {far:.1e}."
    )


def _counted(sweeps: Any) -> str:
    return ", ".join("+".join(map(str, n)) if isinstance(n, list) else str(n) for n in sweeps)


def _planned_plainly(given: Given) -> tuple[np.ndarray, np.ndarray]:
    """By tests/reference.py, to the same residual."""
    import reference

    world, a = plain_world(given.world.spec), given.arrays
    reference.TOLERANCE = TOLERANCE * float(a.gamma / (1 - a.gamma))
    weak, strong = world.characters
    states = [plain_state(given.world, s) for s in range(len(given.world.dynamics.cells))]
    rows = [{"rho": 0, **row} for row in given.world.vocabulary.hypotheses]

    def values(who: str, of: np.ndarray, count: int) -> np.ndarray:
        chosen = [rows[int(np.flatnonzero(of == p)[0])] for p in range(count)]
        return np.array([[world.value(who, h, s) for h in chosen] for s in states])

    return (
        values(weak, a.weak_of, len(a.weak_home)),
        values(strong, a.strong_of, len(a.rho)),
    )


def plain_world(spec: Any) -> Any:
    """A world of tests/reference.py."""
    import reference

    people = [
        reference.Character(c.name, c.success, c.pushes, c.goals, dict(c.attitudes))
        for c in spec.characters
    ]
    tiles = {tile.name: tile.cells[0] for tile in spec.tiles}
    s = spec.settings
    return reference.World(
        spec.rows, tiles, people, gamma=s.gamma, beta=s.beta, forgetting=s.forgetting
    )


def plain_state(world: Any, state: int) -> Any:
    at = world.dynamics.coordinates[world.dynamics.cells[state]]
    return tuple((int(x), int(y)) for x, y in at)


def _numpy_sweeps(a: Arrays, values: Any) -> tuple[list[float], float]:
    """Seconds for a sweep of each block in NumPy."""
    import peer_numpy

    weak, strong = values
    policy = peer_numpy.softmax(a, peer_numpy.q_weak(a, weak))
    sweeps = [(peer_numpy.weak_sweep(a), weak)]
    for facing, problems in a.blocks:
        sweep = peer_numpy.strong_sweep(a, policy, facing, problems)
        sweeps.append((sweep, np.ascontiguousarray(strong[:, problems])))
    seconds = []
    for sweep, v in sweeps:
        clock = Clock(partial(sweep, v))
        for _ in range(3):
            clock.run()
        seconds.append(clock.times.cpu)
    return seconds, 0.0


# ---- The audience --------------------------------------------------------------------------------


def beliefs(report: Report, given: Given, policies: Any, small: bool) -> dict[str, np.ndarray]:
    """P(rho > 0 | script[:t]) at all t, of one script and of all of them."""
    import peer_jax
    import peer_numpy

    import i2pdsl

    a, a32, (weak, strong), (weak32, strong32) = given.arrays, *policies
    starts, turns = given.turns
    first, count = given.scripts[0], len(starts)
    one = (starts[:1], turns[:1])

    def by_hand(*scripts: np.ndarray) -> np.ndarray:
        return np.asarray(peer_jax.posterior(a32, weak32, strong32, *scripts))

    works = {
        OURS: lambda: first.query(QUESTION),
        HAND: lambda: by_hand(*one),
        NUMPY: lambda: peer_numpy.posterior(a, weak, strong, *one),
    }
    if small:
        world = plain_world(given.world.spec)
        works[PLAIN] = partial(_believed_plainly, world, given, first)
    clocks = clocked(works, 20)
    report.add_all("beliefs, a script", clocks)
    found = {who: np.asarray(clock.result).reshape(-1) for who, clock in clocks.items()}
    _check_beliefs(report, "a script", found)
    works = {
        OURS: lambda: i2pdsl.query(given.scripts, QUESTION).value.reshape(count, -1),
        HAND: lambda: by_hand(starts, turns),
        NUMPY: lambda: peer_numpy.posterior(a, weak, strong, starts, turns),
    }
    clocks = clocked(works, 5)
    report.add_all(f"beliefs, {count:,} scripts", clocks)
    many = {who: np.asarray(clock.result) for who, clock in clocks.items()}
    _check_beliefs(report, f"{count:,} scripts", many)
    return {"one": found[OURS], "many": many[OURS]}


def _believed_plainly(world: Any, given: Given, script: Any) -> list[float]:
    import reference

    told = {
        "start": script.record.start,
        "frames": [{**frame, "event": None} for frame in script.record.frames],
    }
    world._filtered.clear()
    return [reference.P(world, told, t, reference.HELPS) for t in range(given.length + 1)]


def _check_beliefs(report: Report, what: str, found: dict[str, np.ndarray]) -> None:
    far = {who: float(np.abs(x - found[OURS]).max()) for who, x in found.items() if who != OURS}
    assert max(far.values()) < 1e-3, far
    told = ", ".join(f"{who} {x:.0e}" for who, x in far.items())
    report.check(f"Beliefs of {what}: the largest difference to ours is {told}.")


# ---- The search ----------------------------------------------------------------------------------


def searches(report: Report, given: Given, policies: Any, small: bool) -> None:
    import peer_jax
    import peer_numpy

    from i2pdsl.computing import computing
    from i2pdsl.objective.terms import story_objective
    from i2pdsl.search.beam import beam_search

    a, a32, (weak, strong), (weak32, strong32) = given.arrays, *policies
    objective = story_objective(given.story.typed, given.world)
    starts, length = given.starts, given.length
    doubles = Doubles(given, objective)

    def ours(width: int) -> Any:
        with computing():
            found = beam_search(given.world, objective, length, starts, width, ())
        order = np.empty(len(given.arrays.weak_next[0]), int)
        order[found.starts] = np.arange(len(found.starts))
        return found.scores[order[starts]], found.actions[order[starts]]

    def in_numpy(width: int) -> Any:
        size = max(1, 256 // width)
        parts = [
            peer_numpy.search(a, weak, strong, starts[i : i + size], length, width, given.offspring)
            for i in range(0, len(starts), size)
        ]
        return tuple(np.concatenate(part) for part in zip(*parts, strict=True))

    for width in (1, 10):
        size = (length, width, given.offspring)
        works = {
            OURS: partial(ours, width),
            HAND: partial(peer_jax.search, a32, weak32, strong32, starts, *size),
            NUMPY: partial(in_numpy, width),
        }
        work = f"search, {'greedy' if width == 1 else f'beam of {width}'}"
        clocks = clocked(works, 5 if width == 1 else 3)
        report.add_all(work, clocks)
        found = {who: clock.result for who, clock in clocks.items()}
        if small and width == 1:
            some = starts[::4]
            world = plain_world(given.world.spec)
            _believed_plainly(world, given, given.scripts[0])  # all is planned
            clock = Clock(partial(_searched_plainly, world, given, some))
            clock.run()
            t = clock.times
            scaled = Times(t.cpu * len(starts) / len(some), t.wall * len(starts) / len(some), 0, 0)
            report.add(work, PLAIN, scaled, f"{len(some)} of {len(starts)} starts, in proportion")
            far = np.abs(clock.result - found[NUMPY][0][::4]).max()
            report.check(
                f"Greedy search in plain Python, from {len(some)} starts: scores differ from those "
                f"of NumPy by at most {far:.0e}."
            )
        check_scripts(report, given, policies, work, found)
        doubles.check(report, policies, width)
    report.add("search, as by default", OURS, _default(given), "wider beams, 12 times the work")


def check_scripts(
    report: Report, given: Given, policies: Any, work: str, found: dict[str, Any]
) -> None:
    """How the scripts of timed runs, in single precision, compare once scored in doubles."""
    import peer_numpy

    a, _, (weak, strong), _ = given.arrays, *policies
    score = {
        who: peer_numpy.scores(a, weak, strong, given.starts, np.asarray(actions))
        for who, (_, actions) in found.items()
    }
    told = []
    for who, (_, actions) in found.items():
        if who != OURS:
            same = (np.asarray(actions) == found[OURS][1]).all(1).mean()
            far = np.abs(score[who].max() - score[OURS].max())
            told.append(f"{who} {same:.0%} the same scripts, best score {far:.0e} apart")
    text = "; ".join(told)
    report.check(f"{work.capitalize()}, as timed (ours and JAX in single precision): {text}.")


class Doubles:
    """Our search in doubles, which it never is for users: to compare it with others exactly."""

    STARTS = 40

    def __init__(self, given: Given, objective: Any) -> None:
        import jax

        from i2pdsl.search.beam import _search
        from i2pdsl.worlds.grid.arrays import padded
        from i2pdsl.worlds.world import double_precision

        self.given, self.starts = given, given.starts[: self.STARTS].astype(np.int32)
        trees = (padded(given.world.tables), objective.params)
        self.arguments = jax.tree.map(double_precision, trees)
        self.run = jax.jit(partial(_search, given.world, objective, given.length, ()))

    def scores(self, width: int) -> np.ndarray:
        from i2pdsl.search.pool import Rule

        places = np.resize(np.repeat(self.starts, width), 10 * len(self.starts))
        rule = Rule(np.int32(width), np.int32(width), np.bool_(False))
        found = np.asarray(self.run(*self.arguments, places, rule)[0])
        return found[: len(self.starts) * width].reshape(-1, width).max(1)

    def check(self, report: Report, policies: Any, width: int) -> None:
        import peer_jax
        import peer_numpy

        a, (weak, strong) = self.given.arrays, policies[1]
        some = (a, weak, strong, self.starts, self.given.length, width, self.given.offspring)
        ours, told = self.scores(width), []
        for who, scores in (
            (HAND, peer_jax.search(*some)[0]),
            (NUMPY, peer_numpy.search(*some)[0]),
        ):
            same = np.abs(scores - ours) < 1e-6
            told.append(f"{who} {same.sum()}")
            if not same.all():
                told[-1] += f" (else up to {np.abs(scores - ours).max():.1g})"
        report.check(
            f"Width {width} in doubles, from {len(ours)} starts: within 1e-6 of our score are "
            f"{', '.join(told)}."
        )


def _searched_plainly(world: Any, given: Given, starts: np.ndarray) -> np.ndarray:
    import reference

    def score(world: Any, script: Any) -> float:
        found: float = reference.depict(world, script, reference.HELPS)
        return found + reference.rationality(world, script) + reference.plausibility(world, script)

    placed = [plain_state(given.world, int(s)) for s in starts]
    return np.array([reference.beam(world, [s], given.length, score)[0] for s in placed])


def _default(given: Given) -> Times:
    """The search as a story has it that says nothing of it, but for the weights."""
    from dataclasses import replace

    from i2pdsl.search.searches import SEARCHES
    from i2pdsl.search.task import Task as Asked
    from i2pdsl.worlds.kind import Watch

    typed = given.story.typed
    polish = type(typed.search)().polish
    typed = replace(typed, search=replace(typed.search, polish=polish))
    clock = Clock(lambda: SEARCHES["beam"].solve(Asked(typed, given.world, Watch()), 0, 1))
    clock.run()
    clock.run()
    return clock.times


# ---- memo ----------------------------------------------------------------------------------------


def with_memo(
    report: Report, given: Given, policies: Any, interpreter: str, values: Any, ours: Any
) -> None:
    import peer_numpy

    a, _, (weak, strong), _ = given.arrays, *policies
    starts, turns = given.turns
    widths = (1, 10)
    task = Task(len(weak), TOLERANCE, given.length, widths, given.offspring)
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        a.save(folder / "arrays.npz")
        (folder / "task.json").write_text(json.dumps(asdict(task)))
        np.savez(
            folder / "given.npz",
            weak=weak,
            strong=strong,
            weak_values=values[0],
            strong_values=values[1],
            starts=starts,
            turns=turns,
            search=given.starts,
        )
        done = subprocess.run(
            [interpreter, str(ROOT / "benchmarks" / "peer_memo.py"), place],
            env={k: v for k, v in os.environ.items() if k != "PYTHONPATH"},
            capture_output=True,
            text=True,
        )
        if done.returncode:
            report.check(f"memo did not run: {done.stderr.strip().splitlines()[-1]}")
            print(done.stderr[-3000:], file=sys.stderr)
            return
        rows = json.loads((folder / "memo.json").read_text())
        results = dict(np.load(folder / "memo.npz"))
    report.check(f"memo: {rows.pop('versions')}.")
    names = {
        "plan": "planning",
        "one": "beliefs, a script",
        "many": f"beliefs, {len(starts):,} scripts",
    }
    names |= {"search 1": "search, greedy", "search 10": "search, beam of 10"}
    for row, times in rows.items():
        what, _, style = row.rpartition(" ")
        who = NATURAL if style == "natural" else FASTEST
        if what == "sweep":
            report.check(
                f"memo, fastest: one sweep of all problems takes {times['cpu']:.2f} s, and "
                f"finds our values settled to {float(results[row + ' 0']):.1e}."
            )
            continue
        report.add(names[what], who, Times(**times))
        if what == "plan":
            found = (results[f"{row} 0"], results[f"{row} 1"])
            worst = max(peer_numpy.residuals(a, *found))
            assert worst <= 3 * TOLERANCE, worst
            report.check(f"Planning in {who}: residual {worst:.1e}.")
        elif what in ("one", "many"):
            far = np.abs(results[f"{row} 0"] - ours[what]).max()
            report.check(f"{names[what].capitalize()}, {who}: {far:.0e} from ours.")
        else:
            actions = results[f"{row} 1"]
            scores = peer_numpy.scores(a, weak, strong, given.starts, actions)
            report.check(
                f"{names[what].capitalize()}, {who}: the best score is {scores.max():.6f}."
            )


# ---- Worlds --------------------------------------------------------------------------------------


def measure(name: str, length: int, count: int, scripts: int, folder: Path, memo: str) -> Report:
    import jax
    import peer_jax
    import peer_numpy

    from i2pdsl.computing import computing
    from i2pdsl.objective.starts import allowed_starts
    from i2pdsl.pipeline import load
    from i2pdsl.search.task import draw_starts

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

    ours_made = lambda: jax.block_until_ready(with_policies(on_device(padded(world.tables))))
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
    """The kitchen's story of the tables above, from nothing."""
    report = Report("Whole processes: the kitchen's greedy search, from nothing")
    story, out = folder / "kitchen.story", folder / "out"
    ours = [sys.executable, "-m", "i2pdsl", "run", str(story), "--out", str(out)]
    ours += ["--choose", "score", "--format", "png"]
    os.environ["I2PDSL_CACHE"] = str(folder / "nothing")
    process(report, "nothing in any cache", OURS, ours, "and a script file, a comic, curves")
    from i2pdsl.pipeline import load

    arrays_of(load(story).world())[0].save(folder / "arrays.npz")
    hand = [sys.executable, __file__, "--by-hand", str(folder / "arrays.npz")]
    process(report, "nothing in any cache", HAND, hand, "actions only; states come from a file")
    process(report, "the world planned, programs compiled", OURS, ours)
    return report


def by_hand(path: Path) -> None:
    """All of it in JAX by hand, as a program that does nothing else."""
    import jax
    import peer_jax

    jax.config.update("jax_enable_x64", True)
    a = Arrays.load(path)
    weak, strong, _ = peer_jax.planned(a, TOLERANCE)
    weak, strong = peer_jax.policies(a, weak, strong)
    single = lambda x: x.astype(np.float32) if x.dtype.kind == "f" else x
    states = a.weak_next.shape[1]
    starts = np.random.default_rng(0).choice(states, size=500, replace=False)
    given = jax.device_put((jax.tree.map(single, a), weak, strong))
    scores, actions = peer_jax.search(*given, starts, 15, 1, 8)
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
    parser.add_argument("--world", choices=("small", "kitchen"))
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--by-hand", type=Path, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.by_hand:
        by_hand(given.by_hand)
        return
    sys.path[:0] = [str(ROOT / "tests")]
    from search_objectives import NOOK

    reports = []
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        os.environ["I2PDSL_CACHE"] = str(folder / "cache")
        (folder / "nook.world").write_text(NOOK, encoding="utf-8")
        if given.world != "kitchen":
            reports.append(measure("nook", 8, 56, 1000, folder, given.memo))
        if given.world != "small":
            reports.append(measure("kitchen", 15, 500, 1000, folder, given.memo))
            reports.append(processes(folder))
    text = "\n".join([machine(), "", *(report.markdown() for report in reports)])
    if not given.memo:
        text += "\nmemo was not measured: no interpreter that has it was named.\n"
    if given.write:
        document = DOCUMENT.read_text(encoding="utf-8")
        put = lambda _: f"<!-- measured: peers -->\n{text}<!-- end -->"
        document = re.sub(r"<!-- measured: peers -->\n.*?<!-- end -->", put, document, flags=re.S)
        DOCUMENT.write_text(document, encoding="utf-8")
    else:
        print(text)


if __name__ == "__main__":
    main()
