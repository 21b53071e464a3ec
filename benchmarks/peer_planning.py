"""Planning, by all of them; called by `peers.py`."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from peer_arrays import Arrays, Clock, Times, clocked
from peer_plain import plain_state, plain_world
from peer_report import HAND, NUMPY, OURS, PLAIN, TOLERANCE, Given, Report, values_of


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
