"""What viewers believe, by all of them; called by `peers.py`."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from peer_arrays import clocked
from peer_plain import plain_world
from peer_report import HAND, NUMPY, OURS, PLAIN, Given, Report

QUESTION = "P(rho > 0 | script[:t])"


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
        OURS: lambda: i2pdsl.query(first, QUESTION).value,
        HAND: lambda: by_hand(*one),
        NUMPY: lambda: peer_numpy.posterior(a, weak, strong, *one),
    }
    if small:
        world = plain_world(given.world.spec)
        works[PLAIN] = partial(believed_plainly, world, given, first)
    clocks = clocked(works, 20)
    report.add_all("beliefs, a script", clocks)
    found = {who: np.asarray(clock.result).reshape(-1) for who, clock in clocks.items()}
    _check_beliefs(report, "a script", found)
    again = clocked({OURS: lambda: first.query(QUESTION)}, 20)[OURS]
    report.add("beliefs, a script that was read", OURS, again.times, "only the question is new")
    works = {
        OURS: lambda: i2pdsl.query(given.scripts, QUESTION).value.reshape(count, -1),
        HAND: lambda: by_hand(starts, turns),
        NUMPY: lambda: peer_numpy.posterior(a, weak, strong, starts, turns),
    }
    clocks = clocked(works, 5)
    report.add_all(f"beliefs, {count:,} scripts", clocks)
    new = clocked({OURS: partial(asked_first, given)}, 5)[OURS]
    work = f"beliefs, {count:,} scripts, first asked"
    report.add(work, OURS, new.times, "places' policies are not known yet")
    many = {who: np.asarray(clock.result) for who, clock in clocks.items()}
    _check_beliefs(report, f"{count:,} scripts", many)
    return {"one": found[OURS], "many": many[OURS]}


def asked_first(given: Given) -> None:
    """Ours, in a world of which nobody has asked anything."""
    import i2pdsl

    given.world.__dict__.pop("_known", None)  # what it keeps of where scripts passed
    i2pdsl.query(given.scripts, QUESTION)


def believed_plainly(world: Any, given: Given, script: Any) -> list[float]:
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
