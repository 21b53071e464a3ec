"""How the characters of a grid world plan: exactly, or additively (additive.py)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial

from i2pdsl.errors import Diagnostic, error, whole_file
from i2pdsl.sizes import memory_limit
from i2pdsl.worlds.grid import cost
from i2pdsl.worlds.grid.additive import SubWorld, sub_worlds, summed
from i2pdsl.worlds.grid.dynamics import Dynamics, build_dynamics
from i2pdsl.worlds.grid.packed import States, computed, number_count
from i2pdsl.worlds.grid.planning import (
    LARGEST_INDEX,
    SMALLER,
    Keys,
    Plan,
    Report,
    check_memory,
    check_numbers,
    estimated_bytes,
    is_plain,
    load_or_plan,
    problem_keys,
)
from i2pdsl.worlds.grid.reduced import reduced
from i2pdsl.worlds.grid.spec import GridSpec
from i2pdsl.worlds.kind import Approximation

PATIENCE_TO_JUDGE = 120.0  # seconds of planning to judge scripts by
FEW = 10_000  # states for which plans are exact however many problems there are
BRIEF = 8.0  # seconds of exact planning on a small copy
MANY = 1_000_000  # states that are not listed where plans need no list

EXACTLY = {"method": "exact", "states": "auto"}


def at_once(spec: GridSpec) -> int | None:
    """How many entities are planned for together; None where all are, exactly."""
    method, most = spec.settings.method, spec.settings.at_once
    if not is_plain(spec) or method == "exact" or spec.marks:
        return None
    if method == "additive":
        return most if most < len(spec.entities) else None
    if cost.is_brief(spec, sum(map(len, problem_keys(spec)))):
        return None
    fewer = range(min(most, len(spec.entities) - 1), 1, -1)
    return next((n for n in fewer if _fits(spec, n)), None)


def _fits(spec: GridSpec, most: int) -> bool:
    """Whether an additive plan takes little enough memory and time."""
    seconds = sum(estimated_seconds(part.spec, part.keys) for part in _parts(spec, most))
    return additive_bytes(spec, most) <= memory_limit() and seconds <= cost.PATIENCE


def is_computed(spec: GridSpec) -> bool:
    """Whether additive planning leaves a world's states to be computed."""
    asked = spec.settings.states
    if asked == "auto":
        return spec.state_count > MANY and number_count(spec) <= LARGEST_INDEX
    return asked == "computed"


def states_of(spec: GridSpec) -> States:
    """The states of a world, listed or computed."""
    if at_once(spec) is not None and is_computed(spec):
        return computed(spec)
    return build_dynamics(spec)


def estimated_seconds(spec: GridSpec, keys: Keys | None = None) -> float:
    """How long exact planning takes, roughly."""
    return cost.planning_seconds(spec, sum(map(len, keys or problem_keys(spec))))


def additive_bytes(spec: GridSpec, most: int) -> int:
    """Memory that additive planning takes at its peak: the states and moves, where they are listed,
    with their copies for a search (measured); the values of all sub-worlds; and the largest one's
    planning."""
    parts, listed = _parts(spec, most), 0
    if not is_computed(spec):
        listed = spec.state_count * (60 * len(spec.characters) + 6 * len(spec.entities) + 40)
        listed += 12 * cost.listed_arrangements(spec)
    kept = sum(
        16 * part.spec.place_count ** len(part.spec.entities) * sum(map(len, part.keys))
        for part in parts
    )
    return listed + kept + max(estimated_bytes(part.spec, part.keys) for part in parts)


def check_size(spec: GridSpec) -> None:
    """Refuses a world that would not fit as it is planned, or cannot be planned so, before any
    work. Raises StoryError."""
    whole, most = whole_file(f"{spec.name}.world"), at_once(spec)
    is_wanted = spec.settings.method == "additive" or spec.settings.states == "computed"
    if is_wanted and (spec.marks or not is_plain(spec)):
        what = "the characters act together" if spec.together else "there is a `horizon`"
        what = "somebody wants to go `via` a place" if spec.marks else what
        message, hint = f"planning cannot be additive where {what}", "`method = exact`"
        if spec.settings.states == "computed":
            message, hint = f"{message}, and states not computed", "`states = listed`"
        raise error("planning", message, whole, hint)
    if spec.settings.states == "computed" and most is None:
        message = "states can be computed only where planning is additive"
        why = "with all of them at once plans are exact, and those list the states"
        hint = "`method = additive`, with fewer characters and objects `at_once` than there are"
        raise error("planning", f"{message}: {why}", whole, hint)
    if most is None:
        check_memory(spec, _what_fits(spec, spec.settings.at_once))
        return
    needed, available = additive_bytes(spec, most), memory_limit()
    if needed > available:
        message = (
            f"the world has {spec.state_count:,} states; additive planning of {most} at once would "
            f"take {needed / 2**30:.1f} GiB of memory, {available / 2**30:.1f} GiB are there"
        )
        raise error("too-large", message, whole, _what_fits(spec, most - 1) or SMALLER)
    if not is_computed(spec):
        check_numbers(spec)
    elif number_count(spec) > LARGEST_INDEX:
        message = (
            f"the places of its characters and objects make {number_count(spec):,} numbers, more "
            f"than can be computed with ({LARGEST_INDEX:,})"
        )
        raise error("too-large", message, whole, SMALLER)


def _what_fits(spec: GridSpec, most: int) -> str | None:
    """An additive plan that would fit, with at most so many at once; None where there is none."""
    too_many = not is_computed(spec) and cost.listed_arrangements(spec) > LARGEST_INDEX
    if not is_plain(spec) or spec.marks or too_many:
        return None
    for fewer in range(min(most, len(spec.entities) - 1), 1, -1):
        needed = additive_bytes(spec, fewer)
        if needed <= memory_limit():
            told = f"`method = additive` with `at_once = {fewer}` would take"
            return f"{told} {needed / 2**30:.1f} GiB, and be approximate"
    return None


def method_warnings(spec: GridSpec, where: str) -> tuple[Diagnostic, ...]:
    """A warning where plans are approximate though nobody asked for that.

    Args:
        where: the world's file.
    """
    if spec.settings.method != "auto" or spec.state_count <= FEW:
        return ()
    most = at_once(spec)
    if most is None:
        return ()
    message = f"with {spec.state_count:,} states its characters plan additively, {most} at once: "
    message += "beliefs are approximate"
    gigabytes, minutes = estimated_bytes(spec) / 2**30, estimated_seconds(spec) / 60
    hint = f"exact plans would take {gigabytes:.1f} GiB and {minutes:.0f} minutes; "
    hint += f"`i2p plan {spec.name}` says how far off beliefs are in a copy"
    return (Diagnostic("approximate", message, whole_file(where), hint, severity="warning"),)


def planned(
    spec: GridSpec,
    dynamics: States,
    report: Report | None = None,
    say: Callable[[str], None] | None = None,
) -> Plan:
    """The plan of a world by its method, from the cache or made now. Raises StoryError."""
    most = at_once(spec)
    if most is None:
        assert isinstance(dynamics, Dynamics)
        return load_or_plan(spec, partial(_same, dynamics), report, say)
    keys = problem_keys(spec)
    parts = sub_worlds(spec, keys, most)
    plans: dict[SubWorld, tuple[Dynamics, Plan]] = {}
    for part in _parts(spec, most):
        theirs = build_dynamics(part.spec)
        plan = load_or_plan(part.spec, partial(_same, theirs), report, say, part.keys)
        plans[part] = theirs, plan
    values = {part: (states, plan.continuation) for part, (states, plan) in plans.items()}
    tables, terms = zip(*summed(spec, most, values, parts), strict=True)
    each = [plan for _, plan in plans.values()]
    seconds = sum(plan.seconds for plan in each)
    return Plan(keys, tables, max(p.residual for p in each), math.nan, seconds, terms)


def _same(dynamics: Dynamics) -> Dynamics:
    return dynamics


def _parts(spec: GridSpec, most: int) -> list[SubWorld]:
    """The sub-worlds to be planned, like ones once, from the largest to the smallest."""
    every = sub_worlds(spec, problem_keys(spec), most).values()
    distinct = dict.fromkeys(replace(part, entities=()) for part in every)
    return sorted(distinct, key=lambda part: -part.spec.state_count)


def approximation(spec: GridSpec) -> Approximation | None:
    """How a world is planned that is not planned exactly: against the next number at once, if that
    fits, and against exact plans on a small map."""
    most = at_once(spec)
    if most is None:
        return None
    closer, told = _next(spec, most)
    small = reduced(spec, lambda each: estimated_seconds(each) <= BRIEF)
    copy, size = None, ""
    if small is not None:
        named = replace(small, name=f"a copy of {spec.name}")
        additive = named.with_settings({"method": "additive", "at_once": most})
        copy = additive, named.with_settings(EXACTLY)
        size = f"a copy with {len(small.free_cells)} of {len(spec.free_cells)} cells"
    return Approximation(f"additive, {most} at once", closer, told, copy, size)


def _next(spec: GridSpec, most: int) -> tuple[GridSpec | None, str]:
    """A world with more planned for at once, and that in words; or why there is none."""
    more = most + 1
    if more >= len(spec.entities):
        told, closer = "exact plans", spec.with_settings(EXACTLY)
        needed, seconds = estimated_bytes(spec), estimated_seconds(spec)
    else:
        told, closer = (
            f"{more} at once",
            spec.with_settings({"method": "additive", "at_once": more}),
        )
        needed = additive_bytes(spec, more)
        seconds = sum(estimated_seconds(part.spec, part.keys) for part in _parts(spec, more))
    if needed > memory_limit():
        return None, f"{told} would take {needed / 2**30:.1f} GiB of memory"
    if seconds > PATIENCE_TO_JUDGE:
        return None, f"{told} would take about {seconds / 60:.0f} minutes"
    return closer, told
